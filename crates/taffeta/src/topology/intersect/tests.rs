//! The count against all pairs, by another method: on whole coordinates, separating axes in integers.

use crate::topology::intersect::*;
use crate::topology::random::SplitMix64;

type Whole = [i128; 3];

fn minus(a: Whole, b: Whole) -> Whole {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn cross(a: Whole, b: Whole) -> Whole {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Whole, b: Whole) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Whether two convex sets of corners, triangles or segments, have a point in common: no plane keeps them apart. The
/// planes that could are along a face, along an edge of each, or, for sets in one plane, upright on an edge.
fn convex_meet(a: &[Whole], b: &[Whole]) -> bool {
    let edges = |of: &[Whole]| -> Vec<Whole> {
        (0..of.len()).map(|i| minus(of[(i + 1) % of.len()], of[i])).collect()
    };
    let (ea, eb) = (edges(a), edges(b));
    let normals = [cross(ea[0], ea[1]), cross(eb[0], eb[1])];
    let mut axes = normals.to_vec();
    for e in ea.iter().chain(&eb) {
        axes.extend(normals.map(|n| cross(n, *e)));
        axes.extend(ea.iter().map(|f| cross(*e, *f)));
    }
    let apart = |axis: &Whole| {
        let range = |of: &[Whole]| {
            let along = || of.iter().map(|p| dot(*axis, *p));
            [along().min().unwrap(), along().max().unwrap()]
        };
        let ([a0, a1], [b0, b1]) = (range(a), range(b));
        a1 < b0 || b1 < a0
    };
    !axes.iter().any(apart)
}

/// Pairs that cross, and pairs that are folded, among all pairs.
fn reference(nodes: &[Whole], triangles: &[[u32; 3]]) -> Intersections {
    let mut all = Intersections { complete: true, ..Default::default() };
    let at = |node: u32| nodes[node as usize];
    for (j, b) in (0..).zip(triangles) {
        for (i, a) in (0..j).zip(triangles) {
            let split = |of: &[u32; 3], with: &[u32; 3]| -> (Vec<u32>, Vec<u32>) {
                of.iter().partition(|n| with.contains(n))
            };
            let ((shared, own), (_, others)) = (split(a, b), split(b, a));
            let meet = |x: &[u32], y: &[u32]| {
                let [x, y] = [x, y].map(|of| of.iter().map(|n| at(*n)).collect::<Vec<_>>());
                convex_meet(&x, &y)
            };
            let folded = match *shared {
                [] => {
                    if meet(a, b) {
                        all.crossing += 1;
                        all.first.push([i, j]);
                    }
                    false
                }
                [_] => meet(&own, b) || meet(&others, a),
                [p, q] => {
                    let [c, d] = [own[0], others[0]].map(|n| cross(minus(at(q), at(p)), minus(at(n), at(p))));
                    cross(c, d) == [0; 3] && dot(c, d) > 0
                }
                _ => true,
            };
            if folded {
                all.folded += 1;
                all.first.push([i, j]);
            }
        }
    }
    all.first.sort_unstable();
    all.first.truncate(NAMED);
    all
}

fn compare(nodes: &[Whole], triangles: &[[u32; 3]]) -> Intersections {
    let places: Vec<Point> = nodes.iter().map(|p| p.map(|x| x as f64)).collect();
    let found = self_intersections(&places, triangles);
    assert_eq!(found, reference(nodes, triangles), "{nodes:?} {triangles:?}");
    found
}

/// The tetrahedron with these corners, from node `first` on.
fn tetrahedron(first: u32) -> [[u32; 3]; 4] {
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|t| t.map(|node| node + first))
}

#[test]
fn tetrahedra_that_interpenetrate_touch_or_keep_apart_are_counted() {
    let corner =
        |x: i128, y: i128, z: i128, s: i128| [[x, y, z], [x + s, y, z], [x, y + s, z], [x, y, z + s]];
    let count = |other: [Whole; 4]| {
        let nodes = [corner(0, 0, 0, 12), other].concat();
        compare(&nodes, &[tetrahedron(0), tetrahedron(4)].concat())
    };
    let through = count(corner(2, 2, 2, 12));
    assert_eq!((through.crossing, through.folded), (3, 0), "three faces of a corner pass the large face");
    assert_eq!(through.first, [[3, 4], [3, 5], [3, 6]]);
    assert_eq!(count(corner(1, 1, 1, 3)).crossing, 0, "inside");
    assert_eq!(count(corner(4, 4, 4, 12)).crossing, 3, "three faces have the corner that touches");
    assert_eq!(count(corner(5, 5, 5, 12)).crossing, 0, "beyond");
    assert!(count(corner(2, 3, -12, 12)).crossing > 0, "its tip ends on the floor");
    assert!(count(corner(-3, 2, 0, 12)).crossing > 4, "floors in one plane");
}

#[test]
fn parts_that_touch_at_a_corner_do_not_cross_there_whether_it_is_one_node_or_two() {
    let up = [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let down = [[-0.0, 0.0, 0.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]];
    let nodes = [up, down].concat();
    let none = Intersections { complete: true, ..Default::default() };
    assert_eq!(self_intersections(&nodes, &[[0, 1, 2], [3, 4, 5]]), none);
    assert_eq!(self_intersections(&nodes, &[[0, 1, 2], [0, 4, 5]]), none);
}

#[test]
fn sheets_folded_onto_themselves_are_counted() {
    // A strip of four triangles; its last node is laid back onto the first.
    let strip = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];
    let nodes = |last: Whole| [[0, 0, 0], [0, 4, 0], [4, 0, 0], [4, 4, 0], [8, 0, 0], last];
    assert_eq!(compare(&nodes([8, 4, 0]), &strip), Intersections { complete: true, ..Default::default() });
    let laid_back = compare(&nodes([3, 1, 0]), &strip);
    assert_eq!(
        (laid_back.folded, laid_back.crossing),
        (2, 1),
        "onto its neighbours, and its tip onto the first"
    );
    assert_eq!(compare(&nodes([8, 4, 0]), &[[0, 1, 2], [2, 1, 0]]).folded, 1, "the same three nodes");
}

#[test]
fn soups_on_whole_coordinates_have_the_pairs_that_integers_find() {
    let mut random = SplitMix64::new(7);
    let (mut crossing, mut folded) = (0, 0);
    for round in 0..60 {
        // Small ranges make touching, collinear and coplanar cases common; large ones leave the quick filter.
        let range = [2, 3, 5, 9, 40, 1000][round % 6];
        let nodes: Vec<Whole> = (0..24)
            .map(|_| [0; 3].map(|_: i128| random.below(range) as i128 * [1, 1 << 20][round % 2]))
            .collect();
        let mut triangles = Vec::new();
        while triangles.len() < 60 {
            let t = [0; 3].map(|_: i32| random.below(24) as u32);
            let [a, b, c] = t.map(|n| nodes[n as usize]);
            // Places that several nodes have would be one node in a mesh.
            let first = |p: Whole| nodes.iter().position(|q| *q == p).unwrap_or(0) as u32;
            if cross(minus(b, a), minus(c, a)) != [0; 3] {
                triangles.push(t.map(|n| first(nodes[n as usize])));
            }
        }
        let found = compare(&nodes, &triangles);
        crossing += found.crossing;
        folded += found.folded;
    }
    assert!(crossing > 5000 && folded > 5000, "{crossing} {folded}");
}

#[test]
fn a_tangle_is_counted_until_the_budget_is_spent() {
    // Blades that all stand on one axis.
    let n = 600;
    let mut nodes = Vec::new();
    for i in 0..n {
        let (sin, cos) = (f64::from(i) * 0.3 / f64::from(n)).sin_cos();
        nodes.extend([[cos, sin, -1.0], [-cos, -sin, -1.0], [0.0, 0.0, 1.0 + f64::from(i)]]);
    }
    let triangles: Vec<[u32; 3]> = (0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let all = self_intersections(&nodes, &triangles[..200]);
    assert!(all.complete && all.crossing == 200 * 199 / 2, "{all:?}");
    let short = |all, leaf| within(Budget { all, leaf, round: 32 }, &nodes, &triangles);
    let after_a_round = short(1, u64::MAX);
    let of_round = 32 * 4;
    assert_eq!(after_a_round.crossing, (0..of_round).map(|i| n as u64 - 1 - i).sum::<u64>());
    assert!(!after_a_round.complete);
    let of_leaves = short(u64::MAX, 100);
    assert!(!of_leaves.complete && of_leaves.crossing < 120 * n as u64 / 4, "{of_leaves:?}");
}

#[test]
fn a_small_file_cannot_ask_for_much_work() {
    for triangles in [1, 30_000, 1_000_000] {
        let Budget { all, leaf, round } = Budget::of(triangles);
        // The last round may go beyond the budget by all that its leaves may look at.
        assert!(all + leaf * round as u64 <= (1 << 23) + 32 * triangles as u64);
    }
}

#[test]
fn the_answer_is_the_same_for_any_number_of_threads() {
    let mut random = SplitMix64::new(3);
    let nodes: Vec<Point> = (0..3000).map(|_| [0.0; 3].map(|_: f64| random.unit())).collect();
    let triangles: Vec<[u32; 3]> = (0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let budget = Budget { all: 10_000, leaf: 700, round: 8 };
        pool.install(|| [self_intersections(&nodes, &triangles), within(budget, &nodes, &triangles)])
    };
    let one = with(1);
    assert!(one[0].complete && one[0].crossing > 10_000 && !one[1].complete);
    assert!([2, 3, 8].into_iter().all(|threads| with(threads) == one));
}
