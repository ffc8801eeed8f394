//! Flat sheets and discs of triangles with a given edge.

use crate::scene::{Disc, Pattern, Sheet, Uvs};
use crate::topology::shapes::grid_surface;
use crate::topology::{Csr, Edges, NONE, Surface};
use std::f64::consts::TAU;

/// Nodes by row from −z to +z, each from −x to +x.
pub(crate) fn sheet(sheet: Sheet) -> Surface {
    let [along, rows] = sheet.counts().map(|count| count as u32);
    let mut surface = match sheet.pattern {
        Pattern::Grid => grid_surface(rows + 1, along + 1, sheet.size),
        Pattern::Equilateral => equilateral(along, rows, sheet.size),
    };
    let ends = |axis: usize| {
        let half = 0.5 * sheet.size[axis / 2];
        [-half, half].map(|end| {
            let at_end = |node: &usize| surface.nodes[*node][axis] == end;
            (0..surface.nodes.len()).filter(at_end).map(|node| node as u32).collect::<Vec<_>>()
        })
    };
    let ([left, right], [back, front]) = (ends(0), ends(2));
    surface.groups = [("left", left), ("right", right), ("back", back), ("front", front)]
        .map(|(n, l)| (n.into(), l))
        .into();
    surface.uvs = Some(metres(&surface));
    surface
}

/// Texture coordinates [m]: u along x, v along z.
fn metres(surface: &Surface) -> Uvs {
    let coords = surface.vertices.iter().map(|[x, _, z]| [*x as f32, *z as f32]).collect();
    Uvs { coords, corners: surface.polygons.corners.clone() }
}

/// Rows of triangles, every other one shifted by half an edge and with a half triangle at either end.
fn equilateral(along: u32, rows: u32, [width, depth]: [f64; 2]) -> Surface {
    // The same halves as the groups have, to the last bit.
    let place = |share: f64, size: f64| (share - 0.5) * size;
    let mut nodes = Vec::new();
    for row in 0..=rows {
        let z = place(f64::from(row) / f64::from(rows), depth);
        let shifted = row % 2 == 1;
        let inner = |i: u32| (f64::from(i) - if shifted { 0.5 } else { 0.0 }) / f64::from(along);
        let last = if shifted { along + 1 } else { along };
        nodes.extend((0..=last).map(|i| [place(inner(i).clamp(0.0, 1.0), width), 0.0, z]));
    }
    let mut triangles = Vec::new();
    let mut first = 0;
    for row in 0..rows {
        let shifted = row % 2 == 1;
        let here = along + 1 + u32::from(shifted);
        // Of each strip one side has one node more: the long one, whose ends have the half triangles.
        let [short, long] = if shifted { [first + here, first] } else { [first, first + here] };
        for i in 0..=along {
            let mut pair = vec![[long + i, long + i + 1, short + i]];
            if i < along {
                pair.push([short + i, long + i + 1, short + i + 1]);
            }
            // Upward: from −z to +z, then along x.
            triangles.extend(pair.into_iter().map(|[a, b, c]| if shifted { [a, c, b] } else { [a, b, c] }));
        }
        first += here;
    }
    Surface::of_triangles(nodes, triangles)
}

/// Nodes of the pattern by row from −z to +z, then those of the border, right-handed from +x.
pub(crate) fn disc(disc: Disc) -> Surface {
    let mut mesh = Flat::core(disc);
    let core = mesh.nodes.len();
    mesh.add_rim(disc);
    mesh.relax(disc, core);
    let nodes: Vec<_> = mesh.nodes.iter().map(|[x, z]| [x * disc.edge, 0.0, z * disc.edge]).collect();
    let mut surface = Surface::of_triangles(nodes, mesh.triangles);
    surface.uvs = Some(metres(&surface));
    surface
}

/// A flat mesh, in edges: places by x and z, triangles that look to +y.
struct Flat {
    nodes: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, z] = [b[0] - a[0], b[1] - a[1]];
    (x * x + z * z).sqrt()
}

impl Flat {
    /// The even pattern inside a disc.
    fn core(disc: Disc) -> Self {
        let rows = disc.rows();
        let mut nodes = Vec::new();
        let mut triangles = Vec::new();
        // The row before: its first node and how many.
        let mut before: Option<[u64; 2]> = None;
        for row in -rows..=rows {
            let [first, count] = [nodes.len() as u64, disc.in_row(row)];
            let left = 0.5 - 0.5 * count as f64;
            let z = row as f64 * disc.pattern.height();
            nodes.extend((0..count).map(|i| [left + i as f64, z]));
            if let Some(before) = before.filter(|before| before[1].min(count) > 0) {
                strip(disc.pattern, before, [first, count], &mut triangles);
            }
            before = Some([first, count]);
        }
        Self { nodes, triangles }
    }

    /// The ring of the border, joined to the pattern by triangles.
    fn add_rim(&mut self, disc: Disc) {
        let (core, rim) = (self.nodes.len(), disc.rim() as u32);
        let edges = Edges::new(core, &self.triangles, &[]);
        let angle = |[x, z]: [f64; 2]| {
            let angle = libm::atan2(-z, x);
            if angle < 0.0 { angle + TAU } else { angle }
        };
        // The pattern's border has each angle once.
        let mut inner = edges.boundary_nodes();
        inner.sort_by(|a, b| angle(self.nodes[*a as usize]).total_cmp(&angle(self.nodes[*b as usize])));
        let radius = disc.radius / disc.edge;
        self.nodes.extend((0..rim).map(|i| {
            let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(rim));
            [radius * cos, -radius * sin]
        }));
        let (mut i, mut j) = (0, 0);
        while i < inner.len() || j < rim as usize {
            let within = |i: usize| inner[i % inner.len()];
            let outside = |j: usize| core as u32 + (j % rim as usize) as u32;
            let [a, b, next_a, next_b] = [within(i), outside(j), within(i + 1), outside(j + 1)];
            let length = |a: u32, b: u32| apart(self.nodes[a as usize], self.nodes[b as usize]);
            // The shorter of both diagonals.
            let inward = j >= rim as usize || (i < inner.len() && length(next_a, b) <= length(a, next_b));
            self.triangles.push([a, b, if inward { next_a } else { next_b }]);
            if inward { i += 1 } else { j += 1 }
        }
    }

    /// Moves the nodes near the border apart, as springs between them that are a little too long would, and turns edges so that
    /// the triangles are those of Delaunay (Persson and Strang, A simple mesh generator in MATLAB, 2004).
    fn relax(&mut self, disc: Disc, core: usize) {
        let radius = disc.radius / disc.edge;
        let within = |node: [f64; 2], by: f64| apart(node, [0.0; 2]) <= radius - by;
        let moves: Vec<bool> =
            (0..self.nodes.len()).map(|i| i < core && !within(self.nodes[i], 3.0)).collect();
        // Triangles that a node which moves may have; the others stay as they are.
        let (inner, mut outer): (Vec<_>, Vec<_>) = std::mem::take(&mut self.triangles)
            .into_iter()
            .partition(|triangle| triangle.iter().all(|&node| within(self.nodes[node as usize], 5.0)));
        for _ in 0..30 {
            self.turn_edges(&mut outer);
            self.push_apart(&outer, &moves);
        }
        while self.turn_edges(&mut outer) {}
        self.triangles = inner;
        self.triangles.append(&mut outer);
    }

    /// Moves each node that may by the sum of its neighbours' pushes.
    fn push_apart(&mut self, triangles: &[[u32; 3]], moves: &[bool]) {
        const WISH: f64 = 1.3;
        let ends = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        // An edge inside is met from both of its triangles; those at the border do not move.
        let around = Csr::new(self.nodes.len(), ends.map(|[a, b]| (a, b)));
        let pushed = |node: usize| {
            let here = self.nodes[node];
            let push = |sum: [f64; 2], &other: &u32| {
                let there = self.nodes[other as usize];
                let length = apart(here, there);
                let share = 0.2 * (WISH - length).max(0.0) / length;
                [sum[0] + share * (here[0] - there[0]), sum[1] + share * (here[1] - there[1])]
            };
            around.row(node).iter().fold(here, push)
        };
        self.nodes =
            (0..self.nodes.len()).map(|i| if moves[i] { pushed(i) } else { self.nodes[i] }).collect();
    }

    /// Turns edges whose opposite angles are more than a half turn together, at most one a triangle. Whether there was any.
    fn turn_edges(&self, triangles: &mut [[u32; 3]]) -> bool {
        let edges = Edges::new(self.nodes.len(), triangles, &[]);
        let mut touched = vec![false; triangles.len()];
        for (&[a, b], sides) in edges.pairs.iter().zip(&edges.triangles) {
            if sides.iter().any(|&t| t == NONE || touched[t as usize]) {
                continue;
            }
            let [t, u] = sides.map(|t| t as usize);
            let [left, right] = [t, u].map(|t| third(triangles[t], [a, b]));
            if self.is_turned([a, b, left, right]) {
                // The first triangle runs from a to b.
                (triangles[t], triangles[u]) = ([left, a, right], [right, b, left]);
                (touched[t], touched[u]) = (true, true);
            }
        }
        touched.contains(&true)
    }

    /// Whether the angles at `left` and `right` over the edge from a to b are more than a half turn together: the sine of their sum
    /// is negative.
    fn is_turned(&self, nodes: [u32; 4]) -> bool {
        let [a, b, left, right] = nodes.map(|node| self.nodes[node as usize]);
        let parts = |tip: [f64; 2]| {
            let [p, q] = [a, b].map(|end| [end[0] - tip[0], end[1] - tip[1]]);
            ((p[0] * q[1] - p[1] * q[0]).abs(), p[0] * q[0] + p[1] * q[1])
        };
        let ((sin, cos), (other_sin, other_cos)) = (parts(left), parts(right));
        sin * other_cos + cos * other_sin < -1e-6
    }
}

/// The corner that is no end of an edge.
fn third(triangle: [u32; 3], ends: [u32; 2]) -> u32 {
    triangle.into_iter().find(|corner| !ends.contains(corner)).unwrap_or(triangle[0])
}

/// Triangles between two rows that lie symmetrically about one middle.
fn strip(pattern: Pattern, low: [u64; 2], high: [u64; 2], triangles: &mut Vec<[u32; 3]>) {
    // Twice the place of a node along x, and the node there.
    let at = |[first, count]: [u64; 2], twice: i64| {
        let index = twice + count as i64 - 1;
        let inside = index >= 0 && index / 2 < count as i64;
        inside.then(|| (first as i64 + index / 2) as u32)
    };
    let mut add = |corners: [Option<u32>; 3]| {
        if let [Some(a), Some(b), Some(c)] = corners {
            triangles.push([a, b, c]);
        }
    };
    let ends = |[_, count]: [u64; 2]| (1 - count as i64..=count as i64 - 1).step_by(2);
    match pattern {
        Pattern::Grid => {
            for x in ends(low) {
                let (next, above, both) = (at(low, x + 2), at(high, x), at(high, x + 2));
                if both.is_some() {
                    add([at(low, x), above, next]);
                    add([next, above, both]);
                }
            }
        }
        Pattern::Equilateral => {
            ends(low).for_each(|x| add([at(low, x), at(high, x + 1), at(low, x + 2)]));
            ends(high).for_each(|x| add([at(high, x), at(high, x + 2), at(low, x + 1)]));
        }
    }
}

#[cfg(test)]
mod tests;
