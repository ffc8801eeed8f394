//! Fabrics that are sewn to each other: closed seams make one point of their nodes.

use super::{accurate, newton, with};
use crate::common::alike::SHAKEN;
use crate::common::state::state;
use crate::common::{V, build, build_as, near, norm, positions, run, sub, turned, weightless};
use taffeta::scene::{Body, Collider, Keyframe, Mass, Material, Mesh, Scene, Seam, SeamSide, Select};
use taffeta::{Precision, Simulation};

/// Nodes along each side of a panel, and how far they are from each other [m].
const SIDE: u32 = 13;
const APART: f64 = 0.025;

/// A sheet of cotton whose first row is its upper edge, at this height.
fn cotton(name: &str, rows: u32, top: f64) -> Body {
    let size = [f64::from(SIDE - 1) * APART, f64::from(rows - 1) * APART];
    let body = Body::cloth(name, Mesh::grid(rows, SIDE, size)).with_material(Material::preset("cotton"));
    Body { place: turned([1.0, 0.0, 0.0], 90.0, [0.0, top - size[1] / 2.0, 0.0]), ..body }
}

/// The last row of one, and the first of the other.
fn hem(upper: &str, lower: &str) -> Seam {
    let row = |name: &str, row| SeamSide::new(name, Select::rows(row, row));
    Seam::new(row(upper, SIDE - 1), row(lower, 0)).closing(0.0, 0.02, 0.0)
}

/// Two panels, one of which hangs on the other.
fn hanging(step: f64) -> Scene {
    let height = f64::from(SIDE - 1) * APART;
    let mut scene = Scene::new("hanging")
        .time(1.0 / 60.0, step)
        .body(cotton("upper", SIDE, 0.0).pin(Select::rows(0, 0)))
        .body(cotton("lower", SIDE, -height))
        .seam(hem("upper", "lower"));
    scene.world.drag = 1e-4;
    scene
}

/// The same as one sheet.
fn in_one_piece() -> Scene {
    let whole = cotton("whole", 2 * SIDE - 1, 0.0).pin(Select::rows(0, 0));
    Scene { bodies: vec![whole], seams: Vec::new(), ..hanging(1.0 / 60.0) }
}

/// The largest distance between sewn nodes [m].
fn gap(x: &[V]) -> f64 {
    let (side, all) = (SIDE as usize, (SIDE * SIDE) as usize);
    (0..side).map(|col| norm(sub(x[all - side + col], x[all + col]))).fold(0.0, f64::max)
}

#[test]
fn two_panels_that_are_sewn_hang_as_one_sheet() {
    let (scene, whole) = (hanging(1.0 / 60.0), in_one_piece());
    let settled = |scene: Scene| {
        let mut simulation = build(&with(scene, accurate(2)));
        run(&mut simulation, 240);
        positions(&simulation)
    };
    let (sewn, whole) = (settled(scene), settled(whole));
    assert!(gap(&sewn) < 1e-9, "{:e}", gap(&sewn));
    let side = SIDE as usize;
    let above = side * side;
    for (place, x) in whole.iter().enumerate() {
        let other = if place < above { sewn[place] } else { sewn[place + side] };
        assert!(norm(sub(*x, other)) < 1e-6, "{place}: {x:?} {other:?}");
    }
    // It is stretched by its weight.
    assert!(whole[whole.len() - 1][1] < -2.0 * 12.0 * APART - 1e-4);
}

#[test]
fn a_seam_bears_a_fabric_in_long_steps() {
    let [sewn, whole] = [hanging(1.0 / 60.0), in_one_piece()].map(|scene| {
        let mut simulation = build(&with(scene, newton(1)));
        run(&mut simulation, 10);
        let (mut most, mut iterations) = (0.0_f64, 0);
        for _ in 0..50 {
            run(&mut simulation, 1);
            most = most.max(simulation.report().max_stretch);
            iterations += simulation.report().solver.iterations;
        }
        assert!(gap(&positions(&simulation)) < 1e-9 || simulation.bodies().len() == 1);
        (most, iterations)
    });
    // A seam that acted after the solver stretched them to three times their length.
    near("by their weight alone", sewn.0, whole.0, 1e-3);
    assert!(sewn.1 < 3 * whole.1, "coarser levels know of the seam: {} iterations and {}", sewn.1, whole.1);
}

#[test]
fn sewn_panels_keep_momentum_where_nothing_holds_them() {
    let mut scene = weightless("free", 1.0 / 60.0, 1.0 / 60.0);
    let [upper, lower] = [cotton("upper", SIDE, 0.0), cotton("lower", SIDE, -12.0 * APART)];
    scene = scene.body(upper).body(lower).seam(hem("upper", "lower"));
    let mut simulation = build(&with(scene, newton(1)));
    run(&mut simulation, 5);
    let lower = simulation.body("lower").unwrap();
    for vertex in [160, 165] {
        simulation.apply_force(lower, vertex, [2e-4, 1e-4, 3e-3]).unwrap();
    }
    run(&mut simulation, 1);
    let before = simulation.report().momentum;
    assert!(norm(before) > 1e-5, "{before:?}");
    for _ in 0..60 {
        run(&mut simulation, 1);
        let now = simulation.report().momentum;
        assert!(norm(sub(now, before)) < 1e-10 * norm(before), "{now:?} {before:?}");
    }
    let moves = state(&simulation).1[..(SIDE * SIDE) as usize].iter().map(|v| norm(*v)).fold(0.0, f64::max);
    assert!(
        moves > 1e-3 && gap(&positions(&simulation)) < 1e-9,
        "the seam draws the other panel along: {moves}"
    );
}

/// Two panels that fall with their seam onto a ball and hang by a pin, a third one beside them, of springs, and nodes of all of
/// them in one point; seams that are closed one after the other.
fn workshop() -> Scene {
    let flat = |name, at| Body { place: turned([1.0, 0.0, 0.0], 0.0, at), ..cotton(name, SIDE, 0.0) };
    let column = |name: &str, col| SeamSide::new(name, Select::cols(col, col));
    let springs = Body::cloth("springs", Mesh::grid(SIDE, SIDE, [0.3, 0.3]))
        .with_mass(Mass::Area(0.1))
        .structural(200.0, 0.01)
        .shear(50.0, 0.01);
    Scene::new("workshop")
        .time(1.0 / 60.0, 1.0 / 120.0)
        .body(flat("upper", [0.0, 0.0, -0.15]))
        .body(flat("lower", [0.0, 0.002, 0.152]).pin(Select::nodes([12])))
        .body(springs.at([0.302, 0.0, -0.15]))
        .seam(hem("upper", "lower"))
        .seam(Seam::new(column("upper", SIDE - 1), column("springs", 0)).closing(0.0, 0.05, 0.0))
        .seam(Seam::pairs("springs", "lower", [[157, 25]]).closing(0.0, 0.08, 0.0))
        .collider(Collider::sphere([0.02, -0.155, 0.01], 0.15))
}

fn workshops() -> [Scene; 2] {
    let second = taffeta::scene::Ice { order: 2, ..newton(2) };
    [newton(1), second].map(|ice| with(workshop(), ice))
}

/// Panels so large that several workers have a part in coarser levels.
fn large() -> Scene {
    let panel = |name: &str, at: f64| {
        let body =
            Body::cloth(name, Mesh::grid(51, 51, [1.0, 1.0])).with_material(Material::preset("cotton"));
        body.at([at, 0.0, 0.0])
    };
    let column = |name: &str, col| SeamSide::new(name, Select::cols(col, col));
    Scene::new("large")
        .time(1.0 / 60.0, 1.0 / 60.0)
        .body(panel("left", -0.5).pin(Select::nodes([0])))
        .body(panel("right", 0.502))
        .seam(Seam::new(column("left", 50), column("right", 0)).closing(0.0, 0.02, 0.0))
}

#[test]
fn any_number_of_threads_sews_with_the_same_bits() {
    let trial = crate::common::alike::Trial { frames: 9, ..SHAKEN };
    trial.with_any_threads(&workshops(), |report| report.solver.iterations > 2 && report.contacts > 0);
    let trial = crate::common::alike::Trial { frames: 4, ..SHAKEN };
    trial.with_any_threads(&[with(large(), newton(0))], |report| report.solver.iterations > 2);
}

#[test]
fn what_is_sewn_moves_as_if_other_bodies_were_not_there() {
    let alone = with(hanging(1.0 / 60.0), newton(1));
    // It needs more iterations, and as many levels.
    let other = cotton("other", SIDE, 0.0).pin(Select::nodes([0])).at([3.0, 0.0, 0.0]);
    let both = alone.clone().body(other);
    let [alone, both] = [alone, both].map(|scene| {
        let mut simulation = build_as(&scene, Precision::F32, 1);
        simulation.disturb(0.002, 11);
        run(&mut simulation, 12);
        positions(&simulation)[..2 * (SIDE * SIDE) as usize].to_vec()
    });
    assert!(alone == both);
}

#[test]
fn a_restored_simulation_sews_on_bit_by_bit() {
    // From before the last seam is closed.
    crate::common::alike::Trial { frames: 8, ..SHAKEN }.restored(&workshops());
}

/// Two panels that lie on a table, sewn to each other, and the same in one piece; the edge of one is raised.
pub fn raised(friction: f64) -> [Scene; 2] {
    let up = vec![Keyframe::translate(0.2, [0.0; 3]), Keyframe::translate(1.0, [0.0, 0.4, 0.2])];
    let table = Collider { friction, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let flat = |name, rows, z| Body {
        place: turned([1.0, 0.0, 0.0], 0.0, [0.0, 1e-5, z]),
        ..cotton(name, rows, 0.0)
    };
    let half = f64::from(SIDE - 1) * APART / 2.0;
    let scene = Scene::new("table").time(1.0 / 60.0, 1.0 / 120.0).collider(table);
    let edge = |body: Body| body.pin_moving(Select::rows(0, 0), up.clone());
    let sewn = scene.clone().body(edge(flat("upper", SIDE, -half))).body(flat("lower", SIDE, half));
    [sewn.seam(hem("upper", "lower")), scene.body(edge(flat("whole", 2 * SIDE - 1, 0.0)))]
}

#[test]
fn a_seam_is_raised_from_a_table_as_a_sheet_in_one_piece() {
    for friction in [0.0, 0.4] {
        let [sewn, whole] = raised(friction).map(|scene| {
            let mut simulation = build(&with(scene, newton(2)));
            let mut most: f64 = 0.0;
            for frame in 0..75 {
                run(&mut simulation, 1);
                most = most.max(if frame > 5 { simulation.report().max_stretch } else { 0.0 });
            }
            (positions(&simulation), most)
        });
        let side = SIDE as usize;
        let above = side * side;
        let apart = (0..whole.0.len()).map(|place| {
            let other = if place < above { place } else { place + side };
            norm(sub(whole.0[place], sewn.0[other]))
        });
        let apart = apart.fold(0.0, f64::max);
        let height = whole.0[above - side][1];
        // A seam has no bending of its own.
        assert!(apart < 0.02, "{friction}: {apart} m");
        near("stretched alike", sewn.1, whole.1, 2e-3);
        assert!(height > 0.05, "the middle is off the table: {height}");
    }
}

#[test]
fn a_pin_bears_what_is_sewn_to_it() {
    // The seam is that of the pinned edge.
    let mut scene = hanging(1.0 / 60.0);
    scene.seams[0].from = SeamSide::new("upper", Select::rows(0, 0));
    scene.bodies[1] = cotton("lower", SIDE, 0.0);
    let mut simulation = build(&with(scene, accurate(2)));
    run(&mut simulation, 200);
    let pin = simulation.pin(simulation.body("upper").unwrap(), 0).unwrap();
    let borne = simulation.reaction(pin).unwrap().unwrap().y;
    let weight: f64 = 9.81 * simulation.bodies().iter().map(|body| body.mass).sum::<f64>();
    near("both panels", borne.abs(), weight, 0.02 * weight);
}

#[test]
fn sewn_nodes_stay_together_on_a_ball_and_by_a_pin() {
    for scene in workshops() {
        let mut simulation = build_as(&scene, Precision::F64, 2);
        for frame in 0..60 {
            run(&mut simulation, 1);
            let x = positions(&simulation);
            let all = (SIDE * SIDE) as usize;
            if frame > 6 {
                assert!(gap(&x) < 1e-9, "{:e}", gap(&x));
                let closed = norm(sub(x[2 * all + 157], x[all + 25]));
                assert!(closed < 1e-9, "{closed:e}");
            }
            let depth = x.iter().map(|x| 0.15 - norm(sub(*x, [0.02, -0.155, 0.01]))).fold(0.0, f64::max);
            assert!(depth < 1e-6, "frame {frame}: {depth}");
            assert!(simulation.report().solver.residual < 0.01, "{:?}", simulation.report().solver);
        }
        assert!(simulation.report().max_stretch < 1.1, "{}", simulation.report().max_stretch);
        assert!(simulation.report().contacts > 10);
    }
}

#[test]
fn a_pin_set_by_hand_holds_both_sides_of_a_seam() {
    let mut scene = hanging(1.0 / 60.0);
    scene.bodies[0].pins.clear();
    let mut simulation: Simulation = build(&with(scene, newton(1)));
    run(&mut simulation, 4);
    let lower = simulation.body("lower").unwrap();
    let held = positions(&simulation)[(SIDE * SIDE) as usize + 6];
    let other = (SIDE * SIDE - SIDE) as usize + 6;
    simulation.pin_vertex(lower, 6, held).unwrap();
    run(&mut simulation, 20);
    // With the seam after the solver the other panel hung by it 16 times as long.
    assert!(simulation.report().max_stretch < 1.02, "{}", simulation.report().max_stretch);
    near("the other side stays", norm(sub(positions(&simulation)[other], held)), 0.0, 1e-9);
    simulation.unpin_vertex(lower, 6).unwrap();
    run(&mut simulation, 20);
    assert!(positions(&simulation)[other][1] < held[1] - 0.3, "it falls");
    near("together", gap(&positions(&simulation)), 0.0, 1e-9);
}
