//! Levels of meshes: on each, nodes of the finer one of which no two are neighbours.

use crate::assembly::body::BodyAssembly;
use crate::real::{cross, dot, norm, sub};
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::xpbd::levels::{Coloured, Level, Nodes};
use crate::topology::Csr;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Nodes from which on there is no coarser level.
const FEW: usize = 24;

/// Most neighbours of the nearest node that a node lies between.
const NEIGHBOURS: usize = 9;

/// How far the mean of those that follow a node may be from it, relative to the distance of another, where cloth is flat.
const FLAT: f64 = 0.15;

/// Cosine of the angle from which on a border has a corner.
const STRAIGHT: f64 = 0.7;

/// A mesh's straight pieces, and its coarser graphs.
struct Surface {
    pieces: Vec<([u32; 2], f64)>,
    by_node: Csr,
}

/// Levels of a body, at most `most`. Limits are `slack` times as long as the cloth.
pub fn levels(body: &BodyAssembly, (most, slack): (usize, f64)) -> Vec<Level> {
    let pieces = body.surface_pieces();
    let pairs: Vec<[u32; 2]> = pieces.iter().map(|(pair, _)| *pair).collect();
    let surface = Surface { by_node: Csr::corners(body.nodes, &pairs), pieces };
    let (ranks, borders) = ranks(body);
    let (mut all, mut level) = (Vec::new(), Nodes::of(body));
    // Nodes of the finer level by their numbers in the body, and its edges.
    let mut finer: Vec<u32> = (0..body.nodes as u32).collect();
    let mut edges: Vec<[u32; 2]> = body.edges.iter().flat_map(|edges| &edges.pairs).copied().collect();
    edges.iter_mut().flatten().for_each(|node| *node = body.solver_local(*node as usize) as u32);
    while all.len() < most && finer.len() > FEW {
        let own = independent(&finer, &edges, &ranks);
        if 5 * own.len() > 4 * finer.len() {
            break;
        }
        let nodes: Vec<u32> = own.iter().map(|&node| finer[node as usize]).collect();
        let limits = surface.between(&nodes);
        edges = limits.keys().copied().collect();
        let parents = parents(&body.start, (&finer, &nodes), &surface.nearest(&nodes).0, &edges);
        level = level.coarser(&own, &parents);
        let flat = Flat { start: &body.start, nodes: &nodes, means: &level.position, borders: &borders };
        let limits: Vec<_> =
            limits.into_iter().map(|(ends, along)| (ends, slack * flat.length(ends, along), 0)).collect();
        all.push(Level { own, parents, limits: Coloured::new(nodes.len(), limits.into_iter()) });
        finer = nodes;
    }
    all
}

/// Nodes of a level and their means, at the start.
struct Flat<'a> {
    start: &'a [[f64; 3]],
    nodes: &'a [u32],
    means: &'a [[f64; 3]],
    borders: &'a [bool],
}

impl Flat<'_> {
    /// How far the means of two nodes may be apart [m], between which the cloth is `along` long. Where it starts flat, as far as they are
    /// then; where it starts folded, means are nearer than the cloth will let them be.
    fn length(&self, [a, b]: [u32; 2], along: f64) -> f64 {
        let node = |one: u32| self.start[self.nodes[one as usize] as usize];
        let [means, straight] =
            [sub(self.means[b as usize], self.means[a as usize]), sub(node(b), node(a))].map(norm);
        // On a border the mean is inside of the node, in a fold as well.
        let is_flat = |one: u32| {
            let border = self.borders[self.nodes[one as usize] as usize];
            border || norm(sub(self.means[one as usize], node(one))) < FLAT * along
        };
        let near = straight > 0.5 * along && is_flat(a) && is_flat(b);
        if near { means * along / straight } else { along.max(means) }
    }
}

/// Which nodes are chosen for coarser levels first: those that pins hold, so that no level forgets a pin; then corners of borders, and borders,
/// so that the others lie between nodes that are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    Held,
    Corner,
    Border,
    Inside,
}

/// The rank of each node, and whether it is on a border.
fn ranks(body: &BodyAssembly) -> (Vec<Rank>, Vec<bool>) {
    let mut all = vec![Rank::Inside; body.nodes];
    let Some(edges) = &body.edges else { return (all, vec![false; body.nodes]) };
    let local = |node: u32| body.solver_local(node as usize);
    edges.boundary_nodes().into_iter().for_each(|node| all[local(node)] = Rank::Border);
    for border in edges.borders().loops {
        for at in 0..border.len() {
            let [before, node, after] =
                [0, 1, 2].map(|step| body.start[local(border[(at + step) % border.len()])]);
            let (come, go) = (sub(node, before), sub(after, node));
            if dot(come, go) < STRAIGHT * norm(come) * norm(go) {
                all[local(border[(at + 1) % border.len()])] = Rank::Corner;
            }
        }
    }
    let borders = all.iter().map(|&rank| rank != Rank::Inside).collect();
    for (rank, free) in all.iter_mut().zip(&body.free) {
        *rank = if *free { *rank } else { Rank::Held };
    }
    (all, borders)
}

/// Nodes of a level of which no two are neighbours, and of which every other node has one (Luby 1986; here in order, so that it is
/// the same every time).
fn independent(nodes: &[u32], edges: &[[u32; 2]], ranks: &[Rank]) -> Vec<u32> {
    let by_node = Csr::corners(nodes.len(), edges);
    let mut order: Vec<u32> = (0..nodes.len() as u32).collect();
    order.sort_by_key(|&node| ranks[nodes[node as usize] as usize]);
    let (mut taken, mut chosen) = (vec![false; nodes.len()], Vec::new());
    for node in order {
        if !taken[node as usize] {
            taken[node as usize] = true;
            chosen.push(node);
            let ends = by_node.row(node as usize).iter();
            ends.for_each(|&end| taken[edges[end as usize / 2][1 - end as usize % 2] as usize] = true);
        }
    }
    chosen.sort_unstable();
    chosen
}

impl Surface {
    /// For each node of the mesh the nearest of some along the surface, and how far that is [m] (Dijkstra 1959, from all of them at
    /// once); `u32::MAX` where none can be reached.
    fn nearest(&self, nodes: &[u32]) -> (Vec<u32>, Vec<f64>) {
        let count = self.by_node.rows();
        let (mut nearest, mut far) = (vec![u32::MAX; count], vec![f64::INFINITY; count]);
        let mut queue: BinaryHeap<_> =
            (0..).zip(nodes).map(|(number, &node)| Reverse((0_u64, number, node))).collect();
        while let Some(Reverse((bits, number, node))) = queue.pop() {
            if nearest[node as usize] != u32::MAX {
                continue;
            }
            // Bits of positive numbers have the order of the numbers.
            let length = f64::from_bits(bits);
            (nearest[node as usize], far[node as usize]) = (number, length);
            for &end in self.by_node.row(node as usize) {
                let (pair, piece) = self.pieces[end as usize / 2];
                let other = pair[1 - end as usize % 2];
                if nearest[other as usize] == u32::MAX {
                    queue.push(Reverse(((length + piece).to_bits(), number, other)));
                }
            }
        }
        (nearest, far)
    }

    /// Limits between some nodes: of those whose surroundings touch, the shortest path between them that stays in these.
    fn between(&self, nodes: &[u32]) -> BTreeMap<[u32; 2], f64> {
        let (nearest, far) = self.nearest(nodes);
        let mut all = BTreeMap::new();
        for &([a, b], piece) in &self.pieces {
            let [from, to] = [a, b].map(|node| nearest[node as usize]);
            if from != to && from != u32::MAX && to != u32::MAX {
                let length = far[a as usize] + piece + far[b as usize];
                let shortest: &mut f64 = all.entry([from.min(to), from.max(to)]).or_insert(f64::INFINITY);
                *shortest = shortest.min(length);
            }
        }
        all
    }
}

/// Which nodes of a level those of the finer one follow: the corners of a triangle of neighbours that they lie in, else the nearest.
fn parents(
    places: &[[f64; 3]],
    (finer, nodes): (&[u32], &[u32]),
    nearest: &[u32],
    edges: &[[u32; 2]],
) -> Weighted {
    let by_node = Csr::corners(nodes.len(), edges);
    let place = |number: u32| places[nodes[number as usize] as usize];
    let mut all = Weighted::default();
    for &node in finer {
        let first = nearest[node as usize];
        if first == u32::MAX || nodes[first as usize] == node {
            all.push((first != u32::MAX).then_some((first, 1.0)));
            continue;
        }
        let mut around: Vec<u32> = by_node
            .row(first as usize)
            .iter()
            .map(|&end| edges[end as usize / 2][1 - end as usize % 2])
            .collect();
        // A hub has many neighbours, of which the nearest do.
        let far = |other: &u32| norm(sub(place(*other), places[node as usize]));
        around.sort_by(|a, b| far(a).total_cmp(&far(b)).then(a.cmp(b)));
        around.truncate(NEIGHBOURS);
        all.push(weights(places[node as usize], first, &around, place));
    }
    all
}

/// The weights of a node at `at`: of three of the nearest one, `first`, and its neighbours, between which it lies.
fn weights(at: [f64; 3], first: u32, around: &[u32], place: impl Fn(u32) -> [f64; 3]) -> Vec<(u32, f32)> {
    let near: Vec<u32> = std::iter::once(first).chain(around.iter().copied()).collect();
    let mut best: (f64, Vec<(u32, f64)>) = (f64::INFINITY, Vec::new());
    for (i, &a) in near.iter().enumerate() {
        for (j, &b) in near.iter().enumerate().skip(i + 1) {
            for &c in &near[j + 1..] {
                let size =
                    [[a, b], [b, c], [c, a]].map(|[from, to]| norm(sub(place(from), place(to)))).iter().sum();
                if size < best.0
                    && let Some(shares) = shares(at, [a, b, c].map(&place))
                {
                    best = (size, [a, b, c].into_iter().zip(shares).collect());
                }
            }
        }
    }
    if best.0.is_infinite() {
        best.1 = along(at, first, around, place);
    }
    let sum: f64 = best.1.iter().map(|one| one.1).sum();
    let mut all: Vec<(u32, f32)> =
        best.1.into_iter().map(|(one, share)| (one, (share / sum) as f32)).collect();
    all.retain(|one| one.1 > 0.0);
    all
}

/// Barycentric coordinates of a point above a triangle, if it is above it.
fn shares(at: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> Option<[f64; 3]> {
    let (u, v, p) = (sub(b, a), sub(c, a), sub(at, a));
    let normal = cross(u, v);
    let square = dot(normal, normal);
    // Three in a line say nothing across it.
    if square < 1e-6 * dot(u, u) * dot(v, v) {
        return None;
    }
    let (second, third) = (dot(cross(p, v), normal) / square, dot(cross(u, p), normal) / square);
    let all = [1.0 - second - third, second, third];
    all.iter().all(|&share| share > -1e-6).then(|| all.map(|share| share.max(0.0)))
}

/// The same of a node that lies in no triangle, as at a border: between the nearest one and one of its neighbours.
fn along(at: [f64; 3], first: u32, around: &[u32], place: impl Fn(u32) -> [f64; 3]) -> Vec<(u32, f64)> {
    let p = sub(at, place(first));
    let mut best = (dot(p, p), vec![(first, 1.0)]);
    for &other in around {
        let u = sub(place(other), place(first));
        let share = (dot(p, u) / dot(u, u)).clamp(0.0, 1.0);
        let off = [0, 1, 2].map(|axis| p[axis] - share * u[axis]);
        if dot(off, off) < best.0 && share > 0.0 {
            best = (dot(off, off), vec![(first, 1.0 - share), (other, share)]);
        }
    }
    best.1
}
