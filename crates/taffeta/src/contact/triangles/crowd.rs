//! Bounds the work of contact between triangles before it starts: how many pairs the lists of the start would hold, counted without a
//! look at each of them.

use crate::assembly::Assembly;
use crate::contact::triangles::impulse::KEEPS;
use crate::contact::triangles::leaves::Leaf;
use crate::contact::triangles::surfaces::Surfaces;
use crate::scene::{Scene, SceneError};
use crate::topology::boxes::{Bounds, around, join};
use std::ops::Range;

/// Most pairs of leaves that are listed at the start, for each leaf and besides: some hundred bytes each.
const LEAF_PAIRS: [u64; 2] = [256, 1 << 20];

/// Most pairs of triangles of two surfaces that are in contact at the start: some hundred bytes each, too. In a dense pile a triangle
/// has some dozens.
const TRIANGLE_PAIRS: [u64; 2] = [128, 1 << 20];

/// Something in a box that is near others when the distance of the boxes is less than their reaches [m] together. Only things of two
/// groups make a pair.
#[derive(Clone, Copy)]
struct Thing {
    bounds: Bounds,
    reach: f64,
    group: u32,
    weight: u64,
}

/// Things that follow each other.
struct Branch {
    things: Range<usize>,
    bounds: Bounds,
    reach: [f64; 2],
    groups: [u32; 2],
    weight: u64,
    halves: Option<[usize; 2]>,
}

/// A tree over things, which come group after group and near each other.
struct Crowd(Vec<Branch>);

impl Crowd {
    fn new(things: &[Thing]) -> Self {
        let mut tree = Self(Vec::with_capacity(2 * things.len()));
        if !things.is_empty() {
            tree.grow(things, 0..things.len());
        }
        tree
    }

    /// Adds the branch of some things. Returns its number.
    fn grow(&mut self, all: &[Thing], range: Range<usize>) -> usize {
        let number = self.0.len();
        let Thing { bounds, reach, group, weight } = all[range.start];
        let (reach, groups) = ([reach; 2], [group; 2]);
        self.0.push(Branch { things: range.clone(), bounds, reach, groups, weight, halves: None });
        if range.len() > 1 {
            let middle = range.start + range.len() / 2;
            let halves = [self.grow(all, range.start..middle), self.grow(all, middle..range.end)];
            let [a, b] = halves.map(|half| &self.0[half]);
            self.0[number] = Branch {
                things: range,
                bounds: join(a.bounds, b.bounds),
                reach: [a.reach[0].min(b.reach[0]), a.reach[1].max(b.reach[1])],
                groups: [a.groups[0], b.groups[1]],
                weight: a.weight + b.weight,
                halves: Some(halves),
            };
        }
        number
    }

    /// The weight of all pairs, of those found until it is more than `most`.
    fn pairs(&self, most: u64) -> u64 {
        let (mut found, mut stack) = (0, Vec::new());
        if !self.0.is_empty() {
            stack.push([0, 0]);
        }
        while let Some(pair) = stack.pop() {
            let [a, b] = pair.map(|number| &self.0[number]);
            if a.groups[0] == b.groups[1] && a.groups[1] == b.groups[0] {
                continue;
            }
            if pair[0] == pair[1] {
                if let Some([first, second]) = a.halves {
                    stack.extend([[first, first], [first, second], [second, second]]);
                }
                continue;
            }
            let [least, furthest] = distances(&a.bounds, &b.bounds);
            if least >= a.reach[1] + b.reach[1] {
                continue;
            }
            let is_apart = a.groups[1] < b.groups[0] || b.groups[1] < a.groups[0];
            match (a.halves, b.halves) {
                _ if is_apart && furthest < a.reach[0] + b.reach[0] => found += a.weight * b.weight,
                (None, None) => found += a.weight * b.weight,
                (_, Some(halves)) if a.halves.is_none() || a.things.len() < b.things.len() => {
                    stack.extend(halves.map(|half| [pair[0], half]));
                }
                (halves, _) => stack.extend(halves.into_iter().flatten().map(|half| [half, pair[1]])),
            }
            if found > most {
                break;
            }
        }
        found
    }
}

/// The least and the largest distance of points of two boxes [m].
fn distances(a: &Bounds, b: &Bounds) -> [f64; 2] {
    let along = |axis: usize| {
        let apart = (b[0][axis] - a[1][axis]).max(a[0][axis] - b[1][axis]).max(0.0);
        let across = (b[1][axis] - a[0][axis]).max(a[1][axis] - b[0][axis]);
        [apart, across]
    };
    let axes = [0, 1, 2].map(along);
    [0, 1].map(|which| axes.iter().map(|one| one[which] * one[which]).sum::<f64>().sqrt())
}

impl Surfaces {
    /// Whether lists of pairs would be too long at the start. Bodies that do not touch each other, as the scene says, count as if they
    /// did, and a body and a collider as if they kept half of the one's thickness and of the other's offset.
    fn is_crowded(&self) -> bool {
        let bounds = |leaf: &Leaf| around(leaf.own().iter().map(|&place| self.start[place as usize]));
        let most = |[each, more]: [u64; 2], count: usize| more + each * count as u64;
        let leaves = |reach: &dyn Fn(&Leaf) -> f64, group: &dyn Fn(usize, &Leaf) -> u32, weighs: bool| {
            let thing = |(number, leaf): (usize, &Leaf)| Thing {
                bounds: bounds(leaf),
                reach: reach(leaf),
                group: group(number, leaf),
                weight: if weighs { leaf.counts[0] as u64 } else { 1 },
            };
            Crowd::new(&self.leaves.iter().enumerate().map(thing).collect::<Vec<_>>())
        };
        let listed = most(LEAF_PAIRS, self.leaves.len());
        let half = 0.5 * KEEPS * self.thickest;
        // Leaves of colliders are one group, as they do not touch each other.
        let of_body = |leaf: &Leaf| self.surface_of[leaf.nodes[0] as usize] < self.soft as u32;
        let number =
            |number: usize, leaf: &Leaf| if of_body(leaf) { number as u32 } else { self.leaves.len() as u32 };
        if leaves(&|_| half, &number, false).pairs(listed) > listed {
            return true;
        }
        let near = most(TRIANGLE_PAIRS, self.triangles.len());
        let reach = |material: u32| 0.5 * KEEPS * self.materials[material as usize][0];
        let group = |leaf: &Leaf| self.surface_of[leaf.nodes[0] as usize].min(self.soft as u32);
        // Leaves as wholes are an upper bound, which mostly does.
        if leaves(&|leaf| reach(leaf.material), &|_, leaf| group(leaf), true).pairs(near) <= near {
            return false;
        }
        let triangles = self.leaves.iter().flat_map(|leaf| {
            let own = &self.triangles[leaf.first[0] as usize..leaf.first[0] as usize + leaf.counts[0]];
            own.iter().map(move |triangle| Thing {
                bounds: around(triangle.map(|place| self.start[place as usize])),
                reach: reach(leaf.material),
                group: group(leaf),
                weight: 1,
            })
        });
        Crowd::new(&triangles.collect::<Vec<_>>()).pairs(near) > near
    }
}

impl Assembly {
    /// Refuses a thickness at which lists of contacts between triangles would be too long at the start.
    pub(crate) fn check_surface_crowd(&self, scene: &Scene) -> Result<(), SceneError> {
        let Some(surfaces) = self.surfaces() else { return Ok(()) };
        if surfaces.is_crowded() {
            return Err(self.too_crowded(scene, |body| Some(body.surface_contact()?.thickest()), true));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::order::locality_order;
    use crate::topology::random::SplitMix64;

    /// Boxes of all sizes in four groups.
    fn things(seed: u64) -> Vec<Thing> {
        let mut random = SplitMix64::new(seed);
        let mut all = Vec::new();
        for group in 0..4 {
            let size = 10.0_f64.powi(-(group as i32));
            let points: Vec<[f64; 3]> = (0..70).map(|_| [0; 3].map(|_| size * random.unit())).collect();
            for number in locality_order(&points) {
                let x = points[number as usize];
                let bounds = [x, x.map(|c| c + 0.1 * size * random.unit())];
                let weight = 1 + number as u64 % 3;
                all.push(Thing { bounds, reach: size * random.unit(), group, weight });
            }
        }
        all
    }

    #[test]
    fn pairs_are_counted_as_one_by_one() {
        for seed in 0..20 {
            let all = things(seed);
            let mut wanted = 0;
            for (i, a) in all.iter().enumerate() {
                for b in all[..i].iter().filter(|b| b.group != a.group) {
                    let near = distances(&a.bounds, &b.bounds)[0] < a.reach + b.reach;
                    wanted += if near { a.weight * b.weight } else { 0 };
                }
            }
            assert!(wanted > 2000, "{wanted}");
            assert_eq!(Crowd::new(&all).pairs(u64::MAX), wanted);
            assert!(Crowd::new(&all).pairs(100) > 100);
        }
        assert_eq!(Crowd::new(&[]).pairs(9), 0);
    }
}
