//! Colliders as nodes meet them: a body may have a friction of its own with some, and meet others not at all. met.wgsl is the twin.

use crate::assembly::Assembly;
use crate::contact::colliders::moving::ColliderNow;
use crate::plan::Substep;
use crate::real::Real;
use std::collections::HashMap;
use std::sync::Arc;

/// A collider by its number in the scene, and the friction that a body has with it, if that is not the collider's own.
type Meeting = (usize, Option<f64>);

/// Which colliders bodies meet that do not meet all in the same way.
#[derive(Clone, Debug, Default)]
struct OwnLists {
    /// Places from each on have a list, or meet all as they are, up to the next. Ascending; the first is 0.
    ranges: Arc<Vec<(usize, Option<usize>)>>,
    /// Each once.
    lists: Vec<Vec<Meeting>>,
    /// Whether lists have all colliders, and differ by friction alone.
    differ_by_friction: bool,
}

/// How lists of bodies differ from that of all colliders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Differ {
    /// There are none.
    #[default]
    No,
    /// By friction alone.
    ByFriction,
    /// Some colliders are not among them.
    ByColliders,
}

impl Assembly {
    /// Notes which bodies, all of which are known, have lists of their own.
    pub(crate) fn add_own_lists(&mut self) {
        let (frictions, meetings) = (self.frictions(), self.meetings());
        let named = frictions.bodies_with_colliders();
        if self.colliders().is_empty() || (named.is_empty() && meetings.all_meet()) {
            return;
        }
        let count = self.colliders().len();
        let mut own = OwnLists { differ_by_friction: true, ..OwnLists::default() };
        let mut numbers: HashMap<Vec<(usize, Option<u64>)>, usize> = HashMap::new();
        let mut ranges: Vec<(usize, Option<usize>)> = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            let met = (0..count).filter(|&collider| meetings.collider(index, collider));
            let list: Vec<Meeting> =
                met.map(|collider| (collider, frictions.of_collider(index, collider))).collect();
            let is_own = list.len() < count || named.binary_search(&index).is_ok();
            let number = is_own.then(|| {
                own.differ_by_friction &= list.len() == count;
                let key =
                    list.iter().map(|&(number, friction)| (number, friction.map(f64::to_bits))).collect();
                *numbers.entry(key).or_insert_with(|| {
                    own.lists.push(list);
                    own.lists.len() - 1
                })
            });
            if ranges.last().is_none_or(|&(_, last)| last != number) {
                ranges.push((body.first, number));
            }
        }
        if !own.lists.is_empty() {
            own.ranges = Arc::new(ranges);
            self.extensions.insert(own);
        }
    }

    /// How lists of bodies differ from that of all colliders.
    pub fn lists_differ(&self) -> Differ {
        self.extensions.get::<OwnLists>().map_or(Differ::No, |own| match own.differ_by_friction {
            true => Differ::ByFriction,
            false => Differ::ByColliders,
        })
    }

    /// Colliders in lists of bodies, and ranges of places that have one.
    pub fn sizes_of_lists(&self) -> [usize; 2] {
        self.extensions
            .get::<OwnLists>()
            .map_or([0; 2], |own| [own.lists.iter().map(Vec::len).sum(), own.ranges.len()])
    }
}

/// Lists of bodies in a sub-step.
#[derive(Default)]
pub struct ListsNow<T> {
    ranges: Arc<Vec<(usize, Option<usize>)>>,
    lists: Vec<Vec<ColliderNow<T>>>,
}

/// As bodies meet these colliders; `None` where they all meet them alike.
pub fn lists_now<T: Real>(assembly: &Assembly, all: &[ColliderNow<T>]) -> Option<ListsNow<T>> {
    let own = assembly.extensions.get::<OwnLists>()?;
    let now = |&(index, friction): &Meeting| {
        let mut collider = all[index];
        collider.surface.friction = friction.map_or(collider.surface.friction, T::from_f64);
        collider
    };
    let lists = own.lists.iter().map(|list| list.iter().map(now).collect()).collect();
    Some(ListsNow { ranges: own.ranges.clone(), lists })
}

/// Colliders as nodes meet them.
#[derive(Clone, Copy)]
pub struct MetColliders<'s, T> {
    all: &'s [ColliderNow<T>],
    own: Option<&'s ListsNow<T>>,
}

impl<'s, T> MetColliders<'s, T> {
    /// None.
    pub const NONE: Self = Self { all: &[], own: None };

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// All of them.
    #[cfg(feature = "gpu")]
    pub fn all(&self) -> &'s [ColliderNow<T>] {
        self.all
    }

    /// Where lists begin among the places, ascending from 0 on, and which; `None`: all colliders.
    #[cfg(feature = "gpu")]
    pub fn ranges(&self) -> &'s [(usize, Option<usize>)] {
        self.own.map_or(&[], |own| &own.ranges)
    }

    /// The lists.
    #[cfg(feature = "gpu")]
    pub fn lists(&self) -> &'s [Vec<ColliderNow<T>>] {
        self.own.map_or(&[], |own| &own.lists)
    }

    /// As the node at a place meets them.
    pub fn at(&self, place: usize) -> &'s [ColliderNow<T>] {
        let Some(own) = self.own else { return self.all };
        let after = own.ranges.partition_point(|&(first, _)| first <= place);
        let list = after.checked_sub(1).and_then(|range| own.ranges[range].1);
        list.map_or(self.all, |list| &own.lists[list])
    }
}

impl<T: Real> Substep<T> {
    /// Colliders at its end, as each node meets them.
    pub fn met_colliders(&self) -> MetColliders<'_, T> {
        MetColliders { all: self.colliders(), own: self.extensions.get() }
    }

    /// Changes them, in each way that they are met.
    #[cfg(feature = "gpu")]
    pub fn edit_colliders(&mut self, edit: impl Fn(&mut Vec<ColliderNow<T>>)) {
        edit(self.extensions.get_mut());
        self.extensions.get_mut::<ListsNow<T>>().lists.iter_mut().for_each(edit);
    }
}
