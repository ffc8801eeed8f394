//! Which places sixteen lanes read at a time.

use crate::real::Real;
use crate::topology::LANES;

/// Groups of [`LANES`] places. Of places that follow each other only the first is kept: lists of places would otherwise be most of
/// what passes over elements read.
#[derive(Default)]
pub struct Groups {
    groups: Vec<Group>,
    lists: Vec<[u32; LANES]>,
}

/// A group: its first place, or which list has its places.
#[derive(Clone, Copy)]
struct Group {
    is_run: bool,
    at: u32,
}

/// The places of a group.
#[derive(Clone, Copy)]
pub enum Places<'a> {
    /// From this one on.
    Run(usize),
    /// These.
    List(&'a [u32; LANES]),
}

impl Groups {
    /// Adds a group.
    pub fn push(&mut self, places: [u32; LANES]) {
        let is_run = places.windows(2).all(|pair| pair[0].checked_add(1) == Some(pair[1]));
        let at = if is_run { places[0] } else { self.lists.len() as u32 };
        self.groups.push(Group { is_run, at });
        if !is_run {
            self.lists.push(places);
        }
    }

    /// The places of a group.
    #[inline(always)]
    pub fn places(&self, group: usize) -> Places<'_> {
        let Group { is_run, at } = self.groups[group];
        if is_run { Places::Run(at as usize) } else { Places::List(&self.lists[at as usize]) }
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.groups[..]) + size_of_val(&self.lists[..])
    }
}

impl Places<'_> {
    /// What a column has there.
    #[inline(always)]
    pub fn fetch<T: Real>(self, column: &[T], lanes: &mut [T; LANES]) {
        match self {
            Self::Run(first) => lanes.copy_from_slice(&column[first..first + LANES]),
            Self::List(places) => {
                for (lane, &place) in lanes.iter_mut().zip(places) {
                    *lane = column[place as usize];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_get_what_is_at_their_places_whether_these_follow_each_other_or_not() {
        let column: Vec<f64> = (0..40).map(f64::from).collect();
        let (run, mut list): ([u32; LANES], _) = (std::array::from_fn(|lane| 7 + lane as u32), [3; LANES]);
        list[5] = 39;
        let mut groups = Groups::default();
        [run, list, run].into_iter().for_each(|places| groups.push(places));
        let fetched = |group: usize| {
            let mut lanes = [0.0; LANES];
            groups.places(group).fetch(&column, &mut lanes);
            lanes
        };
        assert_eq!(
            (fetched(0), fetched(1), fetched(2)),
            (run.map(f64::from), list.map(f64::from), fetched(0))
        );
        assert_eq!((groups.len(), groups.bytes()), (3, 3 * 8 + 4 * LANES));
    }
}
