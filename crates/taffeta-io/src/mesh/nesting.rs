//! Which closed parts lie inside which.

use super::box_tree::{BUDGET, BoxTree, Where, bounds};

/// Triangles of a part whose corner and middle are asked where they are.
const SAMPLES: usize = 4;

/// A closed part.
pub(super) struct Solid<'a> {
    /// Its triangles.
    pub members: &'a [u32],
    /// Its volume [m³], negative if it is inside out.
    pub volume: f64,
}

/// For each solid the largest one around it, if any. A solid is inside another if its box is inside the other's and none
/// of some points of its surface is outside. Points on the other's surface, where the two touch, do not count. `None`: the boxes
/// overlap too much to find out.
pub(super) fn containers(
    solids: &[Solid],
    triangles: &[[u32; 3]],
    nodes: &[[f64; 3]],
) -> Option<Vec<Option<usize>>> {
    let corners = |&triangle: &u32| triangles[triangle as usize].map(|node| nodes[node as usize]);
    let boxes: Vec<_> = solids.iter().map(|solid| bounds(solid.members.iter().flat_map(corners))).collect();
    let listed = solids.iter().zip(0..).flat_map(|(solid, i)| solid.members.iter().map(move |t| (*t, i)));
    let tree = BoxTree::new(triangles, nodes, listed, |solid| solids[solid as usize].volume.abs(), BUDGET);
    let boxed = |inner: usize, outer: usize| {
        let ([low, high], [from, to]) = (boxes[inner], boxes[outer]);
        (0..3).all(|i| from[i] <= low[i] && high[i] <= to[i])
    };
    let container = |inner: usize| {
        let size = solids[inner].volume.abs();
        let may = |outer: u32| solids[outer as usize].volume.abs() > size && boxed(inner, outer as usize);
        let around = around(&tree, samples(solids[inner].members, corners), size, may)?;
        let volume = |outer: &usize| solids[*outer].volume.abs();
        Some(around.into_iter().min_by(|a, b| volume(b).total_cmp(&volume(a))))
    };
    (0..solids.len()).map(container).collect()
}

/// Solids larger than `size` that at least one of the points is inside of, and none outside.
fn around(
    tree: &BoxTree,
    points: impl Iterator<Item = [f64; 3]>,
    size: f64,
    may: impl Fn(u32) -> bool,
) -> Option<Vec<usize>> {
    let mut found: Option<Vec<(u32, Where)>> = None;
    for point in points {
        let here = tree.around(point, size, &may)?;
        let both = |&(solid, place): &(u32, Where)| {
            let at = here.binary_search_by_key(&solid, |found| found.0).ok()?;
            Some((solid, place.min(here[at].1)))
        };
        let left: Vec<_> = match &found {
            None => here,
            Some(before) => before.iter().filter_map(both).collect(),
        };
        if left.is_empty() {
            return Some(Vec::new());
        }
        found = Some(left);
    }
    let inside = found.into_iter().flatten().filter(|(_, place)| *place == Where::Inside);
    Some(inside.map(|(solid, _)| solid as usize).collect())
}

/// Points spread over a surface: corners and middles of triangles.
fn samples<'a>(
    members: &'a [u32],
    corners: impl Fn(&u32) -> [[f64; 3]; 3] + 'a,
) -> impl Iterator<Item = [f64; 3]> + 'a {
    let step = members.len().div_ceil(SAMPLES).max(1);
    members.iter().step_by(step).flat_map(move |triangle| {
        let [a, b, c] = corners(triangle);
        [a, [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0)]
    })
}
