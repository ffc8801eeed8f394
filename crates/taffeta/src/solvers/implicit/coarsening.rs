//! Coarser graphs, for multigrid.
//!
//! A coarser graph stands for a finer one in fields that are linear over the places at rest: each finer edge gives its
//! block to some coarse edges, with positive weights that keep its energy in such fields. On grids that is the operator
//! discretised again (Trottenberg, Oosterlee, Schüller, "Multigrid", 2001, §2.3); on meshes coarse nodes are a maximal
//! independent set of neighbours (Luby 1986; here in order, so that it is the same every time).

use std::cmp::Ordering;

/// Most coarse nodes that a node of a mesh follows.
const PARENTS: usize = 3;
/// Rows or columns that are not halved any more.
const FEW: usize = 3;

/// Nodes, and edges between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    /// Places at rest [m].
    pub places: Vec<[f64; 3]>,
    /// Ends of each edge, ascending.
    pub edges: Vec<[u32; 2]>,
    /// Whether the ends of an edge are neighbours.
    pub near: Vec<bool>,
    /// Other pairs of neighbours, of a mesh.
    pub links: Vec<[u32; 2]>,
    /// Rows and columns, of a grid.
    pub grid: Option<[usize; 2]>,
}

/// Rows of numbers, each with a weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighted {
    /// Where each row starts; one more than there are rows.
    pub offsets: Vec<u32>,
    /// Rows one after the other.
    pub items: Vec<(u32, f32)>,
}

/// A graph, and how it comes from a finer one.
#[derive(Clone, Debug, PartialEq)]
pub struct Coarser {
    /// The coarser graph.
    pub graph: Graph,
    /// For each finer node the nodes that it follows, by weights whose sum is 1.
    pub parents: Weighted,
    /// For each edge the finer edges that it stands for.
    pub sources: Weighted,
}

impl Default for Weighted {
    fn default() -> Self {
        Self { offsets: vec![0], items: Vec::new() }
    }
}

impl Weighted {
    /// Items of a row.
    pub fn row(&self, row: usize) -> &[(u32, f32)] {
        &self.items[self.offsets[row] as usize..self.offsets[row + 1] as usize]
    }

    /// Adds a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = (u32, f32)>) {
        self.items.extend(row);
        self.offsets.push(self.items.len() as u32);
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// The same the other way round, `columns` rows.
    pub fn transposed(&self, columns: usize) -> Self {
        let mut offsets = vec![0u32; columns + 1];
        for &(column, _) in &self.items {
            offsets[column as usize + 1] += 1;
        }
        for column in 0..columns {
            offsets[column + 1] += offsets[column];
        }
        let (mut next, mut items) = (offsets.clone(), vec![(0, 0.0); self.items.len()]);
        for row in 0..self.rows() {
            for &(column, weight) in self.row(row) {
                items[next[column as usize] as usize] = (row as u32, weight);
                next[column as usize] += 1;
            }
        }
        Self { offsets, items }
    }
}

impl Graph {
    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.grid.map_or(self.places.len(), |[rows, cols]| rows * cols)
    }

    /// A coarser graph; `None` where there is none with clearly fewer nodes.
    pub fn coarser(&self) -> Option<Coarser> {
        match self.grid {
            Some(grid) => coarser_grid(self, grid),
            None => coarser_mesh(self),
        }
    }

    /// The same graph again.
    pub fn same(&self) -> Coarser {
        let each = |count: usize| {
            let mut all = Weighted::default();
            (0..count as u32).for_each(|one| all.push([(one, 1.0)]));
            all
        };
        Coarser { graph: self.clone(), parents: each(self.nodes()), sources: each(self.edges.len()) }
    }
}

/// One direction of a grid.
#[derive(Clone, Copy)]
struct Axis {
    count: usize,
    halved: bool,
}

impl Axis {
    fn new(count: usize) -> Self {
        Self { count: if count > FEW { count / 2 + 1 } else { count }, halved: count > FEW }
    }

    /// What a node follows.
    fn parents(self, i: usize) -> ([(usize, f32); 2], usize) {
        match (self.halved, i % 2) {
            (false, _) => ([(i, 1.0); 2], 1),
            (true, 0) => ([(i / 2, 1.0); 2], 1),
            (true, _) => ([(i / 2, 0.5), (i / 2 + 1, 0.5)], 2),
        }
    }

    /// Coarse steps of one that stand for a step of `length` from `i`.
    fn steps(self, i: usize, length: usize) -> ([(usize, f32); 2], usize) {
        match (self.halved, length, i % 2) {
            (false, 1, _) => ([(i, 1.0); 2], 1),
            (false, ..) => ([(i, 2.0), (i + 1, 2.0)], 2),
            (true, 1, _) => ([(i / 2, 0.25); 2], 1),
            (true, _, 0) => ([(i / 2, 1.0); 2], 1),
            (true, ..) => ([(i / 2, 0.5), (i / 2 + 1, 0.5)], 2),
        }
    }

    /// Where the coarse step of a diagonal starts that goes from `i`, up or down.
    fn cell(self, i: usize) -> usize {
        if self.halved { i / 2 } else { i }
    }
}

/// Steps in rows and columns from a node of a coarse grid to those whose edges with it it owns.
const OWNED: [(usize, isize); 4] = [(0, 1), (1, -1), (1, 0), (1, 1)];

fn coarser_grid(fine: &Graph, [rows, cols]: [usize; 2]) -> Option<Coarser> {
    let (down, across) = (Axis::new(rows), Axis::new(cols));
    if !(down.halved || across.halved) {
        return None;
    }
    let nodes = down.count * across.count;
    let mut parents = Weighted::default();
    for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
        let ((r, rs), (c, cs)) = (down.parents(row), across.parents(col));
        let pairs = r[..rs].iter().flat_map(|&(r, wr)| c[..cs].iter().map(move |&(c, wc)| (r, c, wr * wc)));
        parents.push(pairs.map(|(r, c, weight)| ((r * across.count + c) as u32, weight)));
    }
    // By 4·node + direction: in two passes, for there are many.
    let each = |sink: &mut dyn FnMut(usize, u32, f32)| {
        for (edge, &[a, b]) in fine.edges.iter().enumerate() {
            let at = |node: u32| (node as usize / cols, node as usize % cols);
            let ((row, col), (to_row, to_col)) = (at(a), at(b));
            grid_sources(
                (down, across),
                (row, col),
                (to_row - row, to_col as isize - col as isize),
                |r, c, direction, weight| {
                    sink(4 * (r * across.count + c) + direction, edge as u32, weight);
                },
            );
        }
    };
    let mut offsets = vec![0u32; 4 * nodes + 1];
    each(&mut |row, _, _| offsets[row + 1] += 1);
    for row in 0..4 * nodes {
        offsets[row + 1] += offsets[row];
    }
    let (mut next, mut items) = (offsets.clone(), vec![(0, 0.0); offsets[4 * nodes] as usize]);
    each(&mut |row, edge, weight| {
        items[next[row] as usize] = (edge, weight);
        next[row] += 1;
    });
    let mut graph = Graph { grid: Some([down.count, across.count]), ..Graph::default() };
    let mut ends = vec![0u32];
    for row in (0..4 * nodes).filter(|&row| offsets[row] < offsets[row + 1]) {
        let (node, (step_down, step_across)) = (row / 4, OWNED[row % 4]);
        let there = (node + step_down * across.count).checked_add_signed(step_across).unwrap_or(node);
        graph.edges.push([node as u32, there as u32]);
        ends.push(offsets[row + 1]);
    }
    graph.near = vec![true; graph.edges.len()];
    Some(Coarser { graph, parents, sources: Weighted { offsets: ends, items } })
}

/// The coarse edges that a spring of a grid goes to: row, column and direction of each, and the weight.
fn grid_sources(
    (down, across): (Axis, Axis),
    (row, col): (usize, usize),
    step: (usize, isize),
    mut sink: impl FnMut(usize, usize, usize, f32),
) {
    match step {
        (0, length) => {
            let ((r, rs), (c, cs)) = (down.parents(row), across.steps(col, length.unsigned_abs()));
            for &(r, wr) in &r[..rs] {
                c[..cs].iter().for_each(|&(c, wc)| sink(r, c, 0, wr * wc));
            }
        }
        (length, 0) => {
            let ((r, rs), (c, cs)) = (down.steps(row, length), across.parents(col));
            for &(c, wc) in &c[..cs] {
                r[..rs].iter().for_each(|&(r, wr)| sink(r, c, 2, wr * wc));
            }
        }
        (_, side) => {
            let weight = |axis: Axis| if axis.halved { 0.5 } else { 1.0 };
            let weight = weight(down) * weight(across);
            let r = down.cell(row);
            if side > 0 {
                sink(r, across.cell(col), 3, weight);
            } else {
                sink(r, across.cell(col - 1) + 1, 1, weight);
            }
        }
    }
}

fn coarser_mesh(fine: &Graph) -> Option<Coarser> {
    let nodes = fine.places.len();
    let near = fine.edges.iter().zip(&fine.near).filter(|(_, near)| **near).map(|(edge, _)| edge);
    let near: Vec<[u32; 2]> = near.chain(&fine.links).copied().collect();
    let around = crate::topology::Csr::corners(nodes, &near);
    let neighbours =
        |node: usize| around.row(node).iter().map(|&end| near[end as usize / 2][1 - end as usize % 2]);
    let mut taken = vec![false; nodes];
    let mut coarse = Vec::new();
    let mut number = vec![u32::MAX; nodes];
    for node in 0..nodes {
        if !taken[node] {
            taken[node] = true;
            neighbours(node).for_each(|other| taken[other as usize] = true);
            number[node] = coarse.len() as u32;
            coarse.push(fine.places[node]);
        }
    }
    if 5 * coarse.len() > 4 * nodes {
        return None;
    }
    let mut parents = Weighted::default();
    for node in 0..nodes {
        parents.push(follows(node, fine, &number, neighbours(node)));
    }
    let (mut graph, sources) = coarse_edges(fine, &parents, &coarse);
    (graph.places, graph.links) = (coarse, coarse_links(&fine.links, &parents));
    Some(Coarser { graph, parents, sources })
}

/// The coarse neighbours of a node, the nearest few, by inverse distance; a coarse node follows itself.
fn follows(
    node: usize,
    fine: &Graph,
    number: &[u32],
    neighbours: impl Iterator<Item = u32>,
) -> Vec<(u32, f32)> {
    if number[node] != u32::MAX {
        return vec![(number[node], 1.0)];
    }
    let mut near: Vec<(f64, u32)> = neighbours
        .filter(|&other| number[other as usize] != u32::MAX)
        .map(|other| (distance(fine.places[node], fine.places[other as usize]), number[other as usize]))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.dedup_by_key(|one| one.1);
    near.truncate(PARENTS);
    let least = near.first().map_or(0.0, |one| one.0);
    // Where places coincide, the nearest alone.
    let weight = |d: f64| if least > 0.0 { least / d } else { f64::from(u8::from(d <= 0.0)) };
    let sum: f64 = near.iter().map(|one| weight(one.0)).sum();
    near.sort_by_key(|one| one.1);
    near.iter().map(|&(d, parent)| (parent, (weight(d) / sum) as f32)).collect()
}

/// Edges between coarse nodes, and which finer ones each stands for.
fn coarse_edges(fine: &Graph, parents: &Weighted, places: &[[f64; 3]]) -> (Graph, Weighted) {
    // A coarse edge, the finer one, the weight.
    let mut given: Vec<([u32; 2], u32, f32)> = Vec::new();
    for (edge, (&[a, b], &near)) in fine.edges.iter().zip(&fine.near).enumerate() {
        let [from, to] = [a, b].map(|node| parents.row(node as usize));
        let (from, to) = if near { (from, to) } else { (main(from), main(to)) };
        let pairs: Vec<([u32; 2], f64)> = from
            .iter()
            .flat_map(|&(i, wi)| to.iter().map(move |&(j, wj)| (i, j, f64::from(wi) * f64::from(wj))))
            .filter(|(i, j, _)| i != j)
            .map(|(i, j, weight)| {
                // A far edge is one between its main parents.
                ([i.min(j), i.max(j)], if near { weight } else { 1.0 })
            })
            .collect();
        let squared = |[i, j]: [u32; 2]| distance(places[i as usize], places[j as usize]).powi(2);
        let kept: f64 = pairs.iter().map(|&(pair, weight)| weight * squared(pair)).sum();
        let own = distance(fine.places[a as usize], fine.places[b as usize]).powi(2);
        let share = if kept > 0.0 { own / kept } else { 0.0 };
        let share = if near { share } else { share.min(1.0) };
        given.extend(pairs.iter().map(|&(pair, weight)| (pair, edge as u32, (share * weight) as f32)));
    }
    given.retain(|one| one.2 > 0.0);
    given.sort_by(|a, b| {
        a.0.cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.partial_cmp(&b.2).unwrap_or(Ordering::Equal))
    });
    let (mut graph, mut sources) = (Graph::default(), Weighted::default());
    for group in given.chunk_by(|a, b| a.0 == b.0) {
        graph.edges.push(group[0].0);
        graph.near.push(group.iter().any(|one| fine.near[one.1 as usize]));
        sources.push(group.iter().map(|&(_, edge, weight)| (edge, weight)));
    }
    (graph, sources)
}

/// Pairs of coarse nodes that neighbours follow.
fn coarse_links(links: &[[u32; 2]], parents: &Weighted) -> Vec<[u32; 2]> {
    let ends = |link: &[u32; 2]| {
        let [a, b] = link.map(|node| main(parents.row(node as usize)).first().map(|one| one.0));
        Some([a?.min(b?), a?.max(b?)])
    };
    let mut coarse: Vec<[u32; 2]> = links.iter().filter_map(ends).filter(|[a, b]| a != b).collect();
    coarse.sort_unstable();
    coarse.dedup();
    coarse
}

/// The parent of most weight.
fn main(parents: &[(u32, f32)]) -> &[(u32, f32)] {
    let mut most = 0;
    for (index, parent) in parents.iter().enumerate() {
        if parent.1 > parents[most].1 {
            most = index;
        }
    }
    parents.get(most..=most).unwrap_or(&[])
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    crate::real::norm(crate::real::sub(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::spring::stencil::GRID_STEPS;

    /// All springs of a grid, unit spacing.
    fn grid(rows: usize, cols: usize) -> Graph {
        let mut graph = Graph { grid: Some([rows, cols]), ..Graph::default() };
        for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
            graph.places.push([col as f64, 0.0, row as f64]);
            for (down, across) in GRID_STEPS {
                let (to, there) = (row + down, col as isize + across);
                if to < rows && (0..cols as isize).contains(&there) {
                    graph.edges.push([(row * cols + col) as u32, (to * cols) as u32 + there as u32]);
                }
            }
        }
        graph.near = vec![true; graph.edges.len()];
        graph
    }

    /// Energy Σ w (u_a − u_b)² of a field.
    fn energy(edges: &[[u32; 2]], weight: impl Fn(usize) -> f64, field: &[f64]) -> f64 {
        let square = |[a, b]: [u32; 2]| (field[a as usize] - field[b as usize]).powi(2);
        edges.iter().enumerate().map(|(edge, &ends)| weight(edge) * square(ends)).sum()
    }

    #[test]
    fn linear_fields_keep_their_energy_on_coarser_grids() {
        for (rows, cols) in [(9, 17), (8, 8), (2, 33), (1, 12), (5, 3)] {
            let fine = grid(rows, cols);
            let coarser = fine.coarser().unwrap();
            let Some([_, across]) = coarser.graph.grid else { panic!("a grid") };
            let nodes = coarser.parents.items.iter().map(|item| item.0).max().unwrap() as usize + 1;
            // Coarse nodes lie at each second place, where that direction is halved.
            let [dr, dc] = [rows, cols].map(|count| if count > FEW { 2.0 } else { 1.0 });
            for (a, b) in [(1.0, 0.0), (0.0, 1.0)] {
                let field = |row: f64, col: f64| a * row + b * col;
                let on_fine: Vec<f64> =
                    (0..rows * cols).map(|n| field((n / cols) as f64, (n % cols) as f64)).collect();
                let on_coarse: Vec<f64> =
                    (0..nodes).map(|n| field(dr * (n / across) as f64, dc * (n % across) as f64)).collect();
                // The field on the fine grid is that which the coarse one stands for.
                for (node, &here) in on_fine.iter().enumerate() {
                    let found: f64 = coarser
                        .parents
                        .row(node)
                        .iter()
                        .map(|&(n, w)| f64::from(w) * on_coarse[n as usize])
                        .sum();
                    assert!((found - here).abs() < 1e-12);
                }
                let weight =
                    |edge: usize| coarser.sources.row(edge).iter().map(|item| f64::from(item.1)).sum::<f64>();
                let (before, after) = (
                    energy(&fine.edges, |_| 1.0, &on_fine),
                    energy(&coarser.graph.edges, weight, &on_coarse),
                );
                // Diagonals of a direction that is not halved are an approximation.
                let exact = dr == dc;
                assert!(
                    (after - before).abs() <= if exact { 1e-9 } else { before },
                    "{rows}x{cols}: {before} {after}"
                );
            }
        }
    }

    #[test]
    fn every_node_of_a_mesh_follows_coarse_ones_with_weights_of_one() {
        let mut graph = grid(9, 11);
        graph.grid = None;
        // Springs two apart are far ones.
        graph.near = graph.edges.iter().map(|[a, b]| b - a != 2 && b - a != 22).collect();
        let coarser = graph.coarser().unwrap();
        assert!(coarser.graph.places.len() * 3 < graph.places.len());
        for node in 0..graph.places.len() {
            let sum: f32 = coarser.parents.row(node).iter().map(|item| item.1).sum();
            assert!((sum - 1.0).abs() < 1e-6 && !coarser.parents.row(node).is_empty());
        }
        assert!(coarser.graph.edges.iter().all(|[a, b]| a < b) && coarser.graph.edges.is_sorted());
        assert!(coarser.sources.items.iter().all(|item| item.1 > 0.0));
    }

    #[test]
    fn nodes_without_neighbours_are_no_reason_to_coarsen() {
        let graph = Graph { places: vec![[0.0; 3]; 5], ..Graph::default() };
        assert!(graph.coarser().is_none());
        assert!(grid(3, 3).coarser().is_none());
    }

    #[test]
    fn turned_over_twice_it_is_the_same() {
        let coarser = grid(6, 7).coarser().unwrap();
        let nodes = coarser.parents.items.iter().map(|item| item.0).max().unwrap() as usize + 1;
        let turned = coarser.parents.transposed(nodes);
        assert_eq!(turned.transposed(42), coarser.parents);
    }
}
