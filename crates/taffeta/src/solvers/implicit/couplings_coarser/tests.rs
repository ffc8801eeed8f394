//! Coarser blocks are Galerkin products, whatever the modes, and Jacobi's iteration of them converges.

use super::*;
use crate::real::{Symmetric, times};
use crate::scene::{Body, ConstraintForm, Icosphere, Mass, Mesh, Method, Scene};
use crate::solvers::implicit::couplings::*;
use crate::solvers::implicit::couplings_twin::add_mode;
use crate::solvers::implicit::implicit::{add_weighted, inverse};
use crate::topology::random::SplitMix64;

/// A matrix, row by row; three rows for each place.
type Dense = Vec<Vec<f64>>;

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// A ball of springs, and one of springs and hinges, whose springs have directions at random, and whose hinges hardly differ
/// in theirs, as those of a sheet.
struct Balls {
    assembly: Assembly,
    slots: Slots,
    tables: Tables,
    directions: Vec<[f64; 3]>,
    /// Blocks by slot of springs.
    springs: Vec<Block<f64>>,
}

impl Balls {
    fn new() -> Self {
        let ball = |name: &str| {
            let mesh = Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 2 });
            Body::cloth(name, mesh).with_mass(Mass::Node(0.1)).structural(9.0, 0.0)
        };
        let scene = Scene::new("").method(Method::Ice).body(ball("springs"));
        let mut scene = scene.body(ball("hinges").hinge(1.0, 0.0));
        scene.solver.ice.form = ConstraintForm::Primal;
        let assembly = Assembly::new(&scene).unwrap();
        let ends = &assembly.constraints().ends;
        let nodes: Vec<_> = assembly.bodies.iter().map(|body| (body.solver_range(), false)).collect();
        let slots = Slots::new(assembly.places, ends, &nodes);
        let tables = Tables::new(&assembly, assembly.levels(), &(0..2), &slots).unwrap();
        let mut random = SplitMix64::new(7);
        let mut vector = || std::array::from_fn(|_| 0.2 * random.unit() - 0.1);
        let springs: Vec<[f64; 3]> = ends.iter().map(|_| vector()).collect();
        // A hinge pushes its edge one way, and the other two nodes the other way.
        let mode = |_| {
            let bend: [f64; 3] = vector();
            [-1.0, -1.0, 1.0, 1.0].map(|sign| [0, 1, 2].map(|axis| sign * (bend[axis] + UP[axis])))
        };
        let directions = (0..tables.counts()[1] / 4).flat_map(mode).collect();
        let block = |&edge: &u32| match edge {
            NO_EDGE => [0.0; 9],
            edge => {
                let [x, y, z] = springs[edge as usize];
                add_mode([0.0; 9], [x, y, z, 0.0], [-x, -y, -z, 0.0])
            }
        };
        let springs = slots.edge.iter().map(block).collect();
        Self { assembly, slots, tables, directions, springs }
    }

    /// Blocks of the finest level's slots, whose sums are those of all blocks, then those of springs.
    fn finest(&self) -> Vec<Block<f64>> {
        let finest = &self.tables.finest;
        let mode = |sum, one: &[u32; 2]| {
            let [here, there] = one.map(|at| {
                let [x, y, z] = self.directions[at as usize];
                [x, y, z, 0.0]
            });
            add_mode(sum, here, there)
        };
        let mut blocks = blocks(finest, |sources| sources.iter().fold([0.0; 9], mode));
        for node in nodes_of(finest) {
            let sum = &mut blocks[finest.sum_of(node)];
            for (slot, _) in spring_row(&self.slots, node) {
                *sum = std::array::from_fn(|one| sum[one] + self.springs[slot][one]);
            }
        }
        blocks.extend(&self.springs);
        blocks
    }

    /// The system of the finest level.
    fn system(&self) -> Dense {
        let blocks = self.finest();
        dense(self.assembly.places, |node| {
            let springs = spring_row(&self.slots, node).map(|(slot, other)| (self.springs[slot], other));
            let elements = self.tables.finest.row(node).map(|(slot, other)| (blocks[slot], other));
            elements.chain(springs).collect()
        })
    }
}

/// Nodes that have slots.
fn nodes_of<S: Copy>(level: &Couplings<S>) -> impl Iterator<Item = usize> {
    let slices = (0..level.starts.len() - 1).filter(|&slice| !level.groups(slice).is_empty());
    slices.flat_map(|slice| LANES * slice..LANES * (slice + 1))
}

/// Blocks of all slots, from their sources; those for sums are the sums.
fn blocks<S: Copy>(level: &Couplings<S>, block: impl Fn(&[S]) -> Block<f64>) -> Vec<Block<f64>> {
    let mut blocks: Vec<Block<f64>> = (0..level.len()).map(|slot| block(level.sources(slot))).collect();
    for node in nodes_of(level) {
        let all = level.row(node).map(|(slot, _)| symmetric_part(&blocks[slot]));
        blocks[level.sum_of(node)] = whole(&all.fold([0.0; 6], |sum, one| add_weighted(sum, 1.0, one)));
    }
    blocks
}

/// The blocks of a coarser level, from those of the finer one.
fn coarser(level: &Couplings<(u32, f32)>, finer: &[Block<f64>]) -> Vec<Block<f64>> {
    let add = |sum: Block<f64>, &(slot, weight): &(u32, f32)| {
        std::array::from_fn(|one| sum[one] + f64::from(weight) * finer[slot as usize][one])
    };
    blocks(level, |sources| sources.iter().fold([0.0; 9], add))
}

/// The matrix that rows of blocks mean: Σ B (u_i − u_j).
fn dense(places: usize, rows: impl Fn(usize) -> Vec<(Block<f64>, usize)>) -> Dense {
    let mut matrix = vec![vec![0.0; 3 * places]; 3 * places];
    for node in 0..places {
        for (block, other) in rows(node) {
            for (row, column) in (0..9).map(|one| (one / 3, one % 3)) {
                matrix[3 * node + row][3 * node + column] += block[3 * row + column];
                matrix[3 * node + row][3 * other + column] -= block[3 * row + column];
            }
        }
    }
    matrix
}

/// Pᵀ A P.
fn galerkin(fine: &Dense, parents: &Weighted, places: usize) -> Dense {
    let mut product = vec![vec![0.0; 3 * places]; 3 * places];
    let shares = |row: usize| {
        let parents = parents.row(row / 3).iter();
        parents.map(move |&(node, weight)| (3 * node as usize + row % 3, f64::from(weight)))
    };
    for (row, numbers) in fine.iter().enumerate() {
        for (column, number) in numbers.iter().enumerate().filter(|one| *one.1 != 0.0) {
            for (i, a) in shares(row) {
                shares(column).for_each(|(j, b)| product[i][j] += a * b * number);
            }
        }
    }
    product
}

/// The largest eigenvalue of inverses of the diagonal times the matrix, by power iteration.
fn largest_eigenvalue(matrix: &Dense, inverses: &[Symmetric<f64>]) -> f64 {
    let mut random = SplitMix64::new(1);
    let mut v: Vec<f64> = matrix.iter().map(|_| random.unit() - 0.5).collect();
    let mut value = 0.0;
    for _ in 0..300 {
        let product = matrix.iter().map(|row| row.iter().zip(&v).map(|(a, b)| a * b).sum());
        let product: Vec<f64> = product.collect();
        let nodes = inverses.iter().zip(product.chunks(3));
        let next: Vec<f64> = nodes.flat_map(|(inverse, r)| times(inverse, [r[0], r[1], r[2]])).collect();
        value = next.iter().map(|one| one * one).sum::<f64>().sqrt();
        v = next.iter().map(|one| one / value).collect();
    }
    value
}

#[test]
fn coarser_blocks_are_galerkin_products() {
    let balls = Balls::new();
    let (mut blocks, mut system) = (balls.finest(), balls.system());
    for (level, couplings) in balls.assembly.levels().iter().zip(&balls.tables.coarser) {
        blocks = coarser(couplings, &blocks);
        system = galerkin(&system, &level.parents, level.places);
        let row = |node| couplings.row(node).map(|(slot, other)| (blocks[slot], other)).collect();
        let found = dense(level.places, row);
        // The coarser springs of a body without other elements are those of a coarser graph.
        let body = &level.bodies[1];
        for row in 3 * body.start..3 * body.end {
            // Parents' weights are rounded, and add up to 1 but for that.
            let far = found[row].iter().zip(&system[row]).position(|(a, b)| (a - b).abs() > 1e-5);
            assert_eq!(far, None, "row {row} of {} places", level.places);
        }
    }
    assert!(balls.tables.coarser.len() > 1);
}

#[test]
fn jacobi_converges_on_coarser_levels_with_its_factor_and_would_not_without() {
    let balls = Balls::new();
    let (mut blocks, mut largest) = (balls.finest(), 0.0_f64);
    for (level, couplings) in balls.assembly.levels().iter().zip(&balls.tables.coarser) {
        blocks = coarser(couplings, &blocks);
        let row = |node: usize| -> Vec<_> {
            couplings.row(node).map(|(slot, other)| (blocks[slot], other)).collect()
        };
        let diagonal = |node: usize| {
            let all = row(node).into_iter().map(|one| symmetric_part(&one.0));
            inverse(&all.fold([0.0; 6], |sum, one| add_weighted(sum, 1.0, one)))
        };
        let inverses: Vec<Symmetric<f64>> = (0..level.places).map(diagonal).collect();
        let bounded = (0..level.places).map(|node| {
            let couplings =
                row(node).into_iter().map(|(b, other)| coupling(&inverses[node], &b, &inverses[other]));
            let factor = jacobi_factor::<f64>(couplings.sum());
            inverses[node].map(|one| factor * one)
        });
        let system = dense(level.places, row);
        let bounded = largest_eigenvalue(&system, &bounded.collect::<Vec<_>>());
        assert!(bounded < 2.0, "{bounded} at {} places", level.places);
        largest = largest.max(largest_eigenvalue(&system, &inverses));
    }
    assert!(largest > 2.0, "{largest}: the factor is not needed here");
}
