//! Errata of S1 but for its constraints: threads, springs, contact, normals, counts.

use super::Erratum;
use super::finding::{Finding, NONE, found};
use super::vector::{
    Chance, STEPS, Vector, add, cross, dot, norm, normalize, scale, sheet_springs, sub, sum,
};
use crate::papers::paper::Paper;
use std::collections::BTreeSet;
use taffeta::springs::{GridCounts, grid_counts};
use taffeta::topology::shapes::grid_surface;

pub fn errata() -> Vec<Erratum> {
    vec![
        LINKS,
        EQ_1,
        SMALL_STEP,
        THREAD_ID,
        WORKGROUPS,
        ALGORITHM_1,
        ALGORITHM_4,
        ALGORITHM_5,
        UNITY_CLOTH,
        SPRINGS_3906,
        NODES_1440,
    ]
}

const LINKS: Erratum = Erratum {
    id: "s1-links",
    paper: Paper::S1,
    place: "section 2.1",
    printed: "\"General nodes can have 12 links except corner nodes and side nodes\"",
    corrected: "nodes next to a side have fewer than 12 as well: bend springs reach two nodes far",
    why: "That is so if side nodes are those on the border. In the second row one bend spring is missing, \
          next to a corner two. Algorithm 1 reads beyond the sheet for these nodes, too, if it asks for the \
          border only.",
    setting: "Nodes of 32 × 32 that have 12 springs, counted from the list of 5,826. Exact: (R − 4)(C − 4).",
    model: "[springs of a grid](models/springs.md#springs-of-a-grid)",
    experiment: || {
        let mut links = vec![0; 32 * 32];
        sheet_springs(32, 32, &STEPS).iter().flatten().for_each(|node| links[*node] += 1);
        let all = links.iter().filter(|count| **count == 12).count();
        vec![found("nodes with 12 links", f64::from(30 * 30), all as f64, f64::from(28 * 28))]
    },
};

const EQ_1: Erratum = Erratum {
    id: "s1-eq1",
    paper: Paper::S1,
    place: "eq. 1; S3, eq. 4",
    printed: "`[k_s (|p2 − p1| − L0) + k_d ((v2 − v1)·(p2 − p1))/|p2 − p1|] (p2 − p1)/|p2 − p1|`",
    corrected: "the same, with |p₂ − p₁|² not below a smallest number where it divides",
    why: "The formula is right wherever it has a value. Where both ends come to one place, as in a fold \
          that contact presses flat, it is 0/0, and a single node that is not a number spreads by its \
          springs to the whole sheet.",
    setting: "Two nodes at one place, k = 100 N/m, rest length 0.1 m; and 1 m apart.",
    model: "[springs](models/springs.md#formula), l → 0",
    experiment: || {
        let force = |l: f64, least: f64| 100.0 * (l - 0.1) * (l / l.max(least));
        let row = |name: &str, l: f64, exact: f64| found(name, force(l, 0.0), force(l, 1e-100), exact);
        vec![row("force at a distance of 0 [N]", 0.0, 0.0), row("force at a distance of 1 m [N]", 1.0, 90.0)]
    },
};

const SMALL_STEP: Erratum = Erratum {
    id: "s1-small-step",
    paper: Paper::S1,
    place: "abstract and section 1; S2, \"Calculation\"; S3, section III-A2",
    printed: "a mass–spring system \"requires a small integration time-step to use a large stiffness \
              coefficient\"",
    corrected: "a flat sheet at rest with all three kinds of springs holds while k h² + 2 d h < 4 m/10.125; 8 \
             in place of 10.125 without bend springs, 16.3 at most however it is folded",
    why: "All three papers say so, and none says how small. The largest eigenvalue of the springs' \
          stiffness by mass decides: for equal springs and masses it is known, for others it is found by \
          iteration. Damping makes the step smaller, not larger.",
    setting: "A flat sheet of 16 × 16 free nodes, all springs alike, without damping, each node moved by up \
              to a billionth of the distance of two along each axis by chance; 600 steps, or until a node \
              is that distance off. Printed: a step 6 % above the limit; corrected: 6 % below.",
    model: "[the largest stable step](models/integration.md#the-largest-stable-step)",
    experiment: || {
        let steps = [1.06, 0.94].map(|share| share * (4.0f64 / 10.125).sqrt());
        let [printed, corrected] = steps.map(shaken);
        vec![
            found("k h²/m", steps[0] * steps[0], steps[1] * steps[1], NONE),
            found("steps until a node is off by the distance of two", printed.1, corrected.1, NONE),
            found("largest way over that at the start", printed.0, corrected.0, NONE),
        ]
    },
};

/// The largest way of a node from its place over the largest at the start, in a sheet of unit masses, springs and
/// distances, and after how many steps it was as long as a distance, if ever.
fn shaken(h: f64) -> (f64, Option<f64>) {
    let n = 16;
    let place = |i: usize| [(i % n) as f64, (i / n) as f64, 0.0];
    let springs: Vec<([usize; 2], f64)> = sheet_springs(n, n, &STEPS)
        .into_iter()
        .map(|[a, b]| ([a, b], norm(sub(place(b), place(a)))))
        .collect();
    let mut chance = Chance(2);
    let push = 1e-9;
    let mut x: Vec<Vector> = (0..n * n)
        .map(|i| add(place(i), scale(push, [chance.next(), chance.next(), chance.next()])))
        .collect();
    let mut v = vec![[0.0; 3]; n * n];
    let way = |x: &[Vector]| x.iter().enumerate().map(|(i, x)| norm(sub(*x, place(i)))).fold(0.0, f64::max);
    let [start, mut largest] = [way(&x), 0.0f64];
    for step in 1..=600 {
        for ([a, b], rest) in &springs {
            let d = sub(x[*b], x[*a]);
            let pull = scale(h * (1.0 - rest / norm(d)), d);
            v[*a] = add(v[*a], pull);
            v[*b] = sub(v[*b], pull);
        }
        x.iter_mut().zip(&v).for_each(|(x, v)| *x = add(*x, scale(h, *v)));
        largest = largest.max(way(&x));
        if largest > 1.0 {
            return (largest / start, Some(f64::from(step)));
        }
    }
    (largest / start, NONE)
}

const THREAD_ID: Erratum = Erratum {
    id: "s1-thread-id",
    paper: Paper::S1,
    place: "section 3.1",
    printed: "ThreadID = `GroupID × ThreadGroupSize + GroupThreadID`, where \"*ThreadGroupSize* is the \
              total number of how many workgroups there are in the compute space\"",
    corrected: "ThreadGroupSize is the number of threads in a workgroup",
    why: "Counted in workgroups, threads of different groups have one number, and most of the sheet has no \
          thread. The formula itself is that of DirectCompute; only the explanation is off.",
    setting: "A sheet of 64 × 64 nodes, in 2 × 2 workgroups of 32 × 32 threads.",
    model: "[GPU baselines](models/gpu-baselines.md)",
    experiment: thread_id,
};

fn thread_id() -> Vec<Finding> {
    let [groups, threads] = [2, 32];
    let reached = |size: usize| {
        let ids: BTreeSet<usize> =
            (0..groups).flat_map(|g| (0..threads).map(move |t| g * size + t)).collect();
        ids.len()
    };
    let [printed, corrected] = [groups, threads].map(|size| reached(size) as f64);
    vec![
        found("different places along an axis", printed, corrected, 64.0),
        found("nodes that have a thread", printed * printed, corrected * corrected, 4096.0),
    ]
}

const WORKGROUPS: Erratum = Erratum {
    id: "s1-workgroups",
    paper: Paper::S1,
    place: "section 3.1",
    printed: "workgroups `(x = ⌈Row/32⌉, y = ⌈Column/32⌉, z = 1)` with the place `jth × Column + ith`, \
              where ith is along X",
    corrected: "`(x = ⌈Column/32⌉, y = ⌈Row/32⌉, z = 1)`",
    why: "In `j × Column + i` the index i counts columns, so X has to run along the columns. On square \
          sheets, which are those of the paper, it makes no difference.",
    setting: "Sheets of 32 rows and 64 columns, and of 64 and 64.",
    model: "[GPU baselines](models/gpu-baselines.md#what-the-papers-print-and-what-we-changed), where x \
            runs along the columns",
    experiment: workgroups,
};

/// How many nodes have a thread, and how many threads are beyond the buffer.
fn reached(rows: usize, columns: usize, [along_x, along_y]: [usize; 2]) -> [f64; 2] {
    let threads = |count: usize| count.div_ceil(32) * 32;
    let [nx, ny] = [threads(along_x), threads(along_y)];
    let places: Vec<usize> = (0..ny).flat_map(|j| (0..nx).map(move |i| j * columns + i)).collect();
    let inside: BTreeSet<usize> = places.iter().copied().filter(|place| *place < rows * columns).collect();
    [inside.len(), places.iter().filter(|place| **place >= rows * columns).count()].map(|n| n as f64)
}

fn workgroups() -> Vec<Finding> {
    let printed = reached(32, 64, [32, 64]);
    let corrected = reached(32, 64, [64, 32]);
    let square = reached(64, 64, [64, 64])[0];
    vec![
        found("32 × 64: nodes that have a thread", printed[0], corrected[0], 2048.0),
        found("32 × 64: threads beyond the buffer", printed[1], corrected[1], 0.0),
        found("64 × 64: nodes that have a thread", square, square, 4096.0),
    ]
}

const ALGORITHM_1: Erratum = Erratum {
    id: "s1-algorithm1",
    paper: Paper::S1,
    place: "algorithm 1",
    printed: "`Force[index] ← ComputeSpringForce(…)`, twelve times",
    corrected: "`Force[index] ← Force[index] + ComputeSpringForce(…)`, for those neighbours that exist, from 0",
    why: "An assignment keeps the last spring only. The text above the algorithm says \"accumulate\", and \
          is right. At a border neighbours are missing, which the algorithm does not ask for.",
    setting: "A sheet of 8 × 8 nodes, 0.1 m apart, all springs of 100 N/m, pulled to 1.1 times its length \
              along i. Missing neighbours are left out.",
    model: "[springs](models/springs.md#what-the-papers-print-and-what-we-changed)",
    experiment: algorithm_1,
};

/// The force on each node of a sheet of n × n, by what becomes of the sum with each further spring.
fn forces(
    n: isize,
    place: impl Fn([isize; 2]) -> Vector,
    store: fn(Vector, Vector) -> Vector,
) -> Vec<Vector> {
    let order = [
        [0, 1],
        [0, -1],
        [1, 0],
        [-1, 0],
        [1, 1],
        [1, -1],
        [-1, -1],
        [-1, 1],
        [0, 2],
        [0, -2],
        [2, 0],
        [-2, 0],
    ];
    let force = |i: isize, j: isize| {
        let near = order.iter().map(|[di, dj]| [i + di, j + dj]);
        let there = near.filter(|[i, j]| (0..n).contains(i) && (0..n).contains(j));
        there.fold([0.0; 3], |force, other| {
            let rest = 0.1 * (((other[0] - i).pow(2) + (other[1] - j).pow(2)) as f64).sqrt();
            let d = sub(place(other), place([i, j]));
            store(force, scale(100.0 * (norm(d) - rest) / norm(d), d))
        })
    };
    (0..n).flat_map(|j| (0..n).map(move |i| [i, j])).map(|[i, j]| force(i, j)).collect()
}

fn algorithm_1() -> Vec<Finding> {
    let stretched = |[i, j]: [isize; 2]| [0.11 * i as f64, 0.1 * j as f64, 0.0];
    let printed = forces(8, stretched, |_, one| one);
    let corrected = forces(8, stretched, add);
    let inner = 3 * 8 + 3;
    let net = |forces: &[Vector]| norm(sum(forces.iter().copied()));
    vec![
        found("force on an inner node [N]", norm(printed[inner]), norm(corrected[inner]), 0.0),
        found("force on the whole sheet, which nothing holds [N]", net(&printed), net(&corrected), 0.0),
    ]
}

const ALGORITHM_4: Erratum = Erratum {
    id: "s1-algorithm4",
    paper: Paper::S1,
    place: "algorithm 4",
    printed: "`If distance(p'-O) < r`: `distance ← p0 - O`, `p1 ← O + normalize(distance) × (r + offset)`, \
              `v1 ← normalize(distance) + normalize(v0)`",
    corrected: "if |p' − O| < r + offset: n = (p' − O)/|p' − O|, p₁ = O + n (r + offset), v₁ = v' − min(n·v', \
             0) n; friction and restitution act on the two parts of v'",
    why: "Unit vectors are no velocities: v₁ has no unit, and a length between 0 and 2 whatever the speed \
          was. Of a node at rest it is not a number, in a shader as here. The new place lies above the old \
          one, so the way along the surface is lost; and the test asks for r where the answer puts the node \
          to r + offset.",
    setting: "A ball of 0.5 m, offset 10 mm. A node 1 mm above it comes in at 45° and is a millimetre deep \
              after the step.",
    model: "[colliders](models/collision.md#s1-and-s2-compared)",
    experiment: algorithm_4,
};

const RADIUS: f64 = 0.5;
const OFFSET: f64 = 0.01;

/// Place and velocity after contact, as printed.
fn contact_printed(before: Vector, _: Vector, v: Vector) -> [Vector; 2] {
    let out = normalize(before);
    [scale(RADIUS + OFFSET, out), add(out, normalize(v))]
}

/// The same, corrected, without friction and restitution.
fn contact_corrected(_: Vector, after: Vector, v: Vector) -> [Vector; 2] {
    let n = normalize(after);
    [scale(RADIUS + OFFSET, n), sub(v, scale(dot(n, v).min(0.0), n))]
}

fn algorithm_4() -> Vec<Finding> {
    let start = [0.0, RADIUS + 0.001, 0.0];
    let way = [0.002, -0.002, 0.0];
    let end = add(start, way);
    let both = |speed: f64| {
        let v = scale(speed, normalize(way));
        [contact_printed, contact_corrected].map(|contact| contact(start, end, v))
    };
    let mut findings: Vec<Finding> = [1.0, 10.0]
        .map(|speed| {
            let [printed, corrected] = both(speed).map(|[_, v]| norm(v));
            let along = speed * norm(cross(normalize(end), normalize(way)));
            found(format!("speed after contact of a node at {speed} m/s [m/s]"), printed, corrected, along)
        })
        .into();
    let [printed, corrected] = both(1.0).map(|[x, _]| 1000.0 * x[0]);
    findings.push(found(
        "way along the surface [mm]",
        printed,
        corrected,
        1000.0 * 0.51 * end[0] / norm(end),
    ));
    let still = [contact_printed, contact_corrected].map(|contact| norm(contact(start, end, [0.0; 3])[1]));
    findings.push(found("speed of a node that has none [m/s]", still[0], still[1], 0.0));
    findings
}

const ALGORITHM_5: Erratum = Erratum {
    id: "s1-algorithm5",
    paper: Paper::S1,
    place: "algorithm 5 and section 3.5",
    printed: "`i ← ThreadID.x`, `i ← ThreadID.y`; normals of the four quadrants called n₁, n₃, n₄, n₅, and \
              `n ← Σ n_i` with i = 1 to 4; \"a single vertex is connected with 8 triangles\"",
    corrected: "`j ← ThreadID.y`; n₁ to n₄ and their sum; as many triangles as the mesh has at the node, 6 \
             where all cells are cut alike",
    why: "By these names the sum has nothing under n₂ and leaves the fourth quadrant out, which tilts every \
          normal. Eight triangles meet where a cell is cut along both diagonals, or at every other node if \
          cuts go by turns.",
    setting: "The top of a ball of 1 m, nodes 0.1 m apart; a quadrant's normal is that of its two \
              triangles, which meet along the diagonal through the node. Beside it, an inner node of \
              taffeta's sheets.",
    model: "[normals](models/diagnostics.md#normals)",
    experiment: algorithm_5,
};

/// The normals of the four quadrants at the top of a ball.
fn quadrants() -> [Vector; 4] {
    let place = |i: f64, j: f64| [0.1 * i, 0.1 * j, (1.0 - 0.01 * (i * i + j * j)).sqrt()];
    let top = place(0.0, 0.0);
    let corners = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    [0, 1, 2, 3].map(|q| {
        let [first, last] = [corners[q], corners[(q + 1) % 4]];
        let middle = [first[0] + last[0], first[1] + last[1]];
        let [a, b, c] = [first, middle, last].map(|[i, j]| sub(place(i, j), top));
        add(cross(a, b), cross(b, c))
    })
}

fn algorithm_5() -> Vec<Finding> {
    let aside = |normals: &[Vector]| {
        let n = normalize(sum(normals.iter().copied()));
        n[0].hypot(n[1]).asin().to_degrees()
    };
    let all = quadrants();
    let surface = grid_surface(5, 5, [1.0, 1.0]);
    let at_middle = surface.triangles.iter().filter(|triangle| triangle.contains(&12)).count();
    vec![
        found("angle between the normal and the radius [°]", aside(&all[..3]), aside(&all), 0.0),
        found("triangles at an inner node", 8.0, at_middle as f64, 6.0),
    ]
}

const UNITY_CLOTH: Erratum = Erratum {
    id: "s1-65636",
    paper: Paper::S1,
    place: "section 4.3",
    printed: "\"Unity's cloth object can achieve 65,636 nodes with 44.08 fps\"",
    corrected: "65,536 nodes",
    why: "The next sentence has the limit of such a mesh, 65,536, which is 256². A digit slipped.",
    setting: "The square of a sheet of 256 nodes a side.",
    model: "[springs](models/springs.md#what-the-papers-print-and-what-we-changed)",
    experiment: || vec![found("nodes of Unity's cloth", 65_636.0, f64::from(256 * 256), 65_536.0)],
};

/// Structural and shear springs of a sheet, by its formula and by counting.
fn without_bend(rows: u32, columns: u32) -> [f64; 2] {
    let GridCounts { structural, shear, .. } = grid_counts(rows, columns);
    let listed = sheet_springs(rows as usize, columns as usize, &STEPS[..4]);
    [(structural + shear) as f64, listed.len() as f64]
}

/// How many sheets have so many nodes and so many structural and shear springs.
fn sheets(nodes: u32, springs: f64) -> f64 {
    let rows = (1..=nodes).filter(|rows| nodes.is_multiple_of(*rows) && rows * rows <= nodes);
    rows.filter(|rows| without_bend(*rows, nodes / rows)[0] == springs).count() as f64
}

const SPRINGS_3906: Erratum = Erratum {
    id: "s1-3906",
    paper: Paper::S1,
    place: "section 4.3",
    printed: "1156 nodes and 6598 springs; \"By reducing the level of spring to 3906, the performance \
              achieves 66.06 fps on average for the same cloth model\"",
    corrected: "3906 springs are structural and shear springs of 32 × 32 = 1,024 nodes; 34 × 34 = 1,156 nodes \
             have 4,422",
    why: "S1's fig. 1 gives R(C−1) + C(R−1) structural and 2(R−1)(C−1) shear springs. So the two speeds are \
          of two sheets, and not only of springs with and without bending.",
    setting: "Springs of a sheet by the formula, and listed one by one; sheets of all sides.",
    model: "[springs](models/springs.md#what-the-papers-print-and-what-we-changed)",
    experiment: || {
        let [larger, smaller] = [without_bend(34, 34), without_bend(32, 32)];
        vec![
            found("structural and shear springs of 1,156 nodes", 3906.0, larger[0], larger[1]),
            found("structural and shear springs of 1,024 nodes", NONE, smaller[0], smaller[1]),
            found("sheets of 1,156 nodes, of any sides, with 3,906 springs", 1.0, sheets(1156, 3906.0), 0.0),
        ]
    },
};

const NODES_1440: Erratum = Erratum {
    id: "s1-1440",
    paper: Paper::S1,
    place: "section 4.3",
    printed: "\"the cloth with 1440 nodes and 5550 springs\"",
    corrected: "1,444 nodes",
    why: "5,550 are the structural and shear springs of 38 × 38 = 1,444 nodes. No rectangle of 1,440 nodes \
          has as many.",
    setting: "As before.",
    model: "[springs](models/springs.md#what-the-papers-print-and-what-we-changed)",
    experiment: || {
        let [springs, listed] = without_bend(38, 38);
        vec![
            found("nodes of the square sheet with 5,550 springs", 1440.0, f64::from(38 * 38), 1444.0),
            found("structural and shear springs of 38 × 38", 5550.0, springs, listed),
            found("sheets of 1,440 nodes, of any sides, with 5,550 springs", 1.0, sheets(1440, 5550.0), 0.0),
        ]
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use taffeta::scene::{Body, Mass, Mesh, Scene};
    use taffeta::{Options, Simulation};

    #[test]
    fn nodes_with_all_links_are_two_from_each_side() {
        assert_eq!((LINKS.experiment)()[0].corrected, Some(784.0));
    }

    #[test]
    fn a_spring_without_length_has_no_force() {
        let [none, some] = (EQ_1.experiment)().try_into().unwrap();
        assert!(none.printed.unwrap().is_nan() && none.corrected.map(f64::abs) == Some(0.0));
        assert_eq!(some.printed, some.corrected);
    }

    #[test]
    fn the_limit_of_the_step_is_where_a_sheet_bursts_and_what_the_engine_finds() {
        let [_, steps, way] = (SMALL_STEP.experiment)().try_into().unwrap();
        assert!(steps.printed.unwrap() < 100.0 && steps.corrected.is_none(), "{steps:?}");
        assert!(way.corrected.unwrap() < 10.0, "{way:?}");
        let sheet = Body::cloth("sheet", Mesh::grid(34, 34, [3.3, 3.3])).with_mass(Mass::Node(0.15));
        let sheet = sheet.structural(200.0, 0.0).shear(200.0, 0.0).bend(200.0, 0.0);
        let scene = Scene::new("at rest").time(0.01, 0.01).body(sheet);
        let options = Options { find_largest_steps: true, ..Options::default() };
        let found = Simulation::new(&scene, &options).unwrap().largest_stable_step();
        assert!((found / (4.0 * 0.15 / 10.125 / 200.0f64).sqrt() - 1.0).abs() < 0.02, "{found}");
    }

    #[test]
    fn threads_counted_in_workgroups_reach_a_part_of_the_sheet() {
        assert_eq!(thread_id()[1].printed, Some(34.0 * 34.0));
        assert_eq!(workgroups()[0].printed, Some(1024.0));
        assert_eq!(workgroups()[1].printed, Some(1024.0));
    }

    #[test]
    fn an_assigned_force_is_the_last_spring_and_pulls_the_whole_sheet_along() {
        let [inner, net] = algorithm_1().try_into().unwrap();
        // The last spring goes two nodes back: 100 N/m · 20 mm. 48 nodes have one, 16 have that ahead in its place.
        assert!((inner.printed.unwrap() - 2.0).abs() < 1e-12);
        assert!((net.printed.unwrap() - (48.0 - 16.0) * 2.0).abs() < 1e-9);
        assert!(inner.corrected.unwrap() < 1e-12 && net.corrected.unwrap() < 1e-12);
    }

    #[test]
    fn nodes_at_any_speed_leave_alike() {
        let [slow, fast, way, still] = algorithm_4().try_into().unwrap();
        assert_eq!(slow.printed, fast.printed);
        assert!((slow.printed.unwrap() - (2.0 - 2f64.sqrt()).sqrt()).abs() < 1e-12);
        assert!((fast.corrected.unwrap() - 10.0 * slow.corrected.unwrap()).abs() < 1e-12);
        assert!((slow.corrected.unwrap() - slow.exact.unwrap()).abs() < 1e-12);
        assert_eq!(way.printed, Some(0.0));
        assert!(still.printed.unwrap().is_nan() && still.corrected == Some(0.0));
    }

    #[test]
    fn three_quadrants_of_four_tilt_the_normal() {
        let tilt = algorithm_5()[0].clone();
        assert!(tilt.printed.unwrap() > 1.0 && tilt.corrected.unwrap() < 1e-9);
        assert_eq!(algorithm_5()[1].corrected, Some(6.0));
    }

    #[test]
    fn counts_are_those_of_square_sheets() {
        assert_eq!(without_bend(38, 38), [5550.0; 2]);
        assert_eq!(without_bend(32, 32), [3906.0; 2]);
        assert_eq!(without_bend(34, 34), [4422.0; 2]);
        assert_eq!(sheets(1444, 5550.0), 1.0);
        assert_eq!(sheets(1440, 5550.0) + sheets(1156, 3906.0), 0.0);
    }
}
