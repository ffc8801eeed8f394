//! The corners that can lie within an ear, in a tree of boxes: reflex and straight ones.

use super::plane::Point;
use super::{FLAT, longest};

/// No leaf.
const NONE: u32 = u32::MAX;
/// Lowest and highest coordinates; nothing inside.
const EMPTY: [f64; 4] = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];

/// Effort [box] of a corner that touches an ear and does not block it. Only few do unless a polygon crosses itself.
const TOUCH: u64 = 64;

/// A binary tree over the corners in Morton order (Morton, A Computer Oriented Geodetic Data Base, 1966). The boxes
/// shrink when corners leave.
#[derive(Default)]
pub(super) struct Blunt {
    /// The root is 1, the children of `i` are `2i` and `2i + 1`, the leaves the last half.
    boxes: Vec<[f64; 4]>,
    /// Corner of each leaf.
    corners: Vec<u32>,
    /// Leaf of each corner, or [`NONE`].
    leaf: Vec<u32>,
    order: Vec<(u64, u32)>,
}

impl Blunt {
    /// Holds `corners` of `points` from now on.
    pub fn hold(&mut self, points: &[Point], corners: impl Iterator<Item = u32> + Clone) {
        self.leaf.clear();
        self.leaf.resize(points.len(), NONE);
        let bounds =
            corners.clone().fold(EMPTY, |bounds, corner| join(bounds, point_box(points[corner as usize])));
        self.order.clear();
        self.order.extend(corners.map(|corner| (morton(points[corner as usize], bounds), corner)));
        self.order.sort_unstable();
        let leaves = self.order.len().next_power_of_two();
        self.boxes.clear();
        self.boxes.resize(2 * leaves, EMPTY);
        self.corners.clear();
        for (leaf, &(_, corner)) in self.order.iter().enumerate() {
            self.boxes[leaves + leaf] = point_box(points[corner as usize]);
            self.corners.push(corner);
            self.leaf[corner as usize] = leaf as u32;
        }
        for node in (1..leaves).rev() {
            self.boxes[node] = join(self.boxes[2 * node], self.boxes[2 * node + 1]);
        }
    }

    pub fn holds(&self, corner: u32) -> bool {
        self.leaf[corner as usize] != NONE
    }

    pub fn remove(&mut self, corner: u32) {
        let leaf = std::mem::replace(&mut self.leaf[corner as usize], NONE);
        let mut node = self.boxes.len() / 2 + leaf as usize;
        self.boxes[node] = EMPTY;
        while node > 1 {
            node /= 2;
            self.boxes[node] = join(self.boxes[2 * node], self.boxes[2 * node + 1]);
        }
    }

    /// A corner for which `blocks` holds, among those within the triangle. `seed` decides which: where the choice is as
    /// good as random, the triangle will have to be tried again only a logarithm of times. Each box that is looked at
    /// takes one off `effort`; without any, nothing is found.
    pub fn find(
        &self,
        triangle: [Point; 3],
        seed: u32,
        effort: &mut u64,
        blocks: impl Fn(u32) -> bool,
    ) -> Option<u32> {
        let within = Within::new(triangle);
        let leaves = self.boxes.len() / 2;
        // Two nodes a level at most.
        let mut stack = [0_usize; 64];
        let mut height = usize::from(!self.corners.is_empty());
        stack[0] = 1;
        while height > 0 && *effort > 0 {
            *effort -= 1;
            height -= 1;
            let node = stack[height];
            if within.misses(self.boxes[node]) {
                continue;
            }
            if node < leaves {
                let last = (seed >> (node.ilog2() & 31)) as usize & 1;
                stack[height] = 2 * node + (1 - last);
                stack[height + 1] = 2 * node + last;
                height += 2;
            } else if blocks(self.corners[node - leaves]) {
                return Some(self.corners[node - leaves]);
            } else {
                *effort = effort.saturating_sub(TOUCH);
            }
        }
        None
    }
}

/// The quick test of boxes against a triangle.
struct Within {
    corners: [Point; 3],
    bounds: [f64; 4],
    margin: f64,
}

impl Within {
    fn new(corners: [Point; 3]) -> Self {
        let [a, b, c] = corners;
        let square = longest(a, b, c);
        let reach = 2.0 * FLAT * square.sqrt();
        let [x0, y0, x1, y1] = join(point_box(a), join(point_box(b), point_box(c)));
        Self {
            corners,
            bounds: [x0 - reach, y0 - reach, x1 + reach, y1 + reach],
            margin: 4.0 * FLAT * square,
        }
    }

    /// Whether nothing in the box can block. It may say no where the exact test would say yes.
    fn misses(&self, [x0, y0, x1, y1]: [f64; 4]) -> bool {
        let [a, b, c] = self.corners;
        let within = &self.bounds;
        // Any number of corners may lie at an end of the diagonal; they do not block.
        let at = |p: Point| [x0, y0] == p && [x1, y1] == p;
        if x0 > within[2] || x1 < within[0] || y0 > within[3] || y1 < within[1] || at(a) || at(c) {
            return true;
        }
        let (x0, y0) = (x0.max(within[0]), y0.max(within[1]));
        let (x1, y1) = (x1.min(within[2]), y1.min(within[3]));
        [(a, b), (b, c), (c, a)].iter().any(|(p, q)| {
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            // The corner of the box that lies furthest to the left of the edge.
            let x = if dy > 0.0 { x0 } else { x1 };
            let y = if dx > 0.0 { y1 } else { y0 };
            dx * (y - p[1]) - dy * (x - p[0]) < -self.margin
        })
    }
}

fn point_box([x, y]: Point) -> [f64; 4] {
    [x, y, x, y]
}

fn join(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

/// The bits of both coordinates in turn, so that what is near in this order is near in the plane.
fn morton([x, y]: Point, [x0, y0, x1, y1]: [f64; 4]) -> u64 {
    let steps =
        |at: f64, low: f64, high: f64| spread(((at - low) / (high - low) * f64::from(u32::MAX)) as u32);
    steps(x, x0, x1) << 1 | steps(y, y0, y1)
}

/// Puts a zero in front of each bit.
fn spread(bits: u32) -> u64 {
    [
        (16, 0x0000_FFFF_0000_FFFF),
        (8, 0x00FF_00FF_00FF_00FF),
        (4, 0x0F0F_0F0F_0F0F_0F0F),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ]
    .iter()
    .fold(u64::from(bits), |bits, (shift, mask)| (bits | bits << shift) & mask)
}
