//! Contact between triangles: what starts apart never passes through, in any form of solver and at any speed.

use crate::common::{V, build_as, levels, positions, run, turned};
use crate::pairs::{set_velocities, velocities};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use taffeta::scene::{
    Body, Collider, ConstraintForm, ContactForm, ContactZone, Cuboid, Cylinder, Keyframe, Mass, Material,
    Mesh, Method, Pin, Scene, Select, SelfCollision, Torus,
};
use taffeta::{Precision, Simulation};

const THICK: f64 = 0.005;

pub fn touching(body: Body, friction: f64) -> Body {
    let touch = SelfCollision {
        form: ContactForm::Triangles,
        thickness: THICK,
        friction,
        ..SelfCollision::default()
    };
    Body { self_collision: Some(touch), ..body }
}

/// A sheet of nodes every 2 cm, 8 g each square metre and tenth.
pub fn sheet(name: &str, nodes: [u32; 2], at: V, friction: f64) -> Body {
    let size = nodes.map(|n| f64::from(n - 1) * 0.02);
    let body = Body::cloth(name, Mesh::grid(nodes[0], nodes[1], size)).with_mass(Mass::Node(8e-5)).at(at);
    touching(body.structural(40.0, 0.004).shear(20.0, 0.004).bend(2.0, 1e-3), friction)
}

/// The same as a fabric, solved for implicitly.
pub fn fabric(name: &str, nodes: [u32; 2], at: V) -> Body {
    let size = nodes.map(|n| f64::from(n - 1) * 0.02);
    touching(
        Body::cloth(name, Mesh::grid(nodes[0], nodes[1], size))
            .with_material(Material::preset("silk"))
            .at(at),
        0.3,
    )
}

pub fn implicit(mut scene: Scene, step: f64) -> Scene {
    scene = scene.method(Method::Ice).time(1.0 / 60.0, step);
    scene.solver.ice.form = ConstraintForm::Primal;
    scene
}

fn build(scene: &Scene) -> Simulation {
    build_as(scene, Precision::F32, 2)
}

/// Runs frames, and has none with an intersection.
pub fn run_free(simulation: &mut Simulation, frames: u32, what: &str) {
    for _ in 0..frames {
        run(simulation, 1);
        let found = simulation.intersections();
        assert_eq!(found.pairs, 0, "{what}, frame {}: {:?}", simulation.frame(), found.first);
    }
}

/// Has each node of a scene fly towards the middle, and in some places faster than in others [m/s].
fn implode(simulation: &mut Simulation, middle: V, speed: f64) {
    let places = positions(simulation);
    let given: Vec<V> = places
        .iter()
        .map(|x| {
            std::array::from_fn(|axis| {
                (middle[axis] - x[axis]) * speed * (2.0 + (x[0] * 90.0 + x[2] * 70.0).sin())
            })
        })
        .collect();
    set_velocities(simulation, &given);
}

#[test]
fn cloth_that_is_thrown_together_never_passes_through_itself() {
    let crossed = || {
        let mut other = sheet("other", [12, 12], [0.0, 0.02, 0.0], 0.3);
        other.place = turned([0.0, 1.0, 0.0], 40.0, [0.01, 0.03, 0.0]);
        Scene::new("springs").body(sheet("one", [12, 12], [0.0; 3], 0.3)).body(other)
    };
    let mut springs = build(&crossed().time(1.0 / 60.0, 5e-4));
    implode(&mut springs, [0.0, 0.015, 0.0], 12.0);
    let mut touched = 0;
    for _ in 0..30 {
        run_free(&mut springs, 1, "springs");
        touched += springs.report().pairs;
    }
    assert!(touched > 15, "{touched}");
}

#[test]
fn implicit_steps_of_any_length_keep_cloth_apart() {
    for step in [1.0 / 60.0, 1.0 / 240.0] {
        let scene = Scene::new("fabric").body(fabric("one", [12, 12], [0.0; 3])).body(fabric(
            "other",
            [10, 10],
            [0.01, 0.02, 0.0],
        ));
        let mut simulation = build(&implicit(scene, step));
        implode(&mut simulation, [0.0, 0.01, 0.0], 10.0);
        run_free(&mut simulation, 20, &format!("steps of {step} s"));
    }
}

#[test]
fn a_weight_lies_in_a_hammock_that_is_solved_for() {
    let mut hammock = fabric("hammock", [13, 13], [0.0; 3]);
    hammock = hammock.pin(Select::rows(0, 0)).pin(Select::rows(12, 12));
    let mut weight = fabric("weight", [4, 4], [0.003, 0.006, 0.002]);
    weight.material.as_mut().expect("a fabric").density = Some(20.0);
    let mut scene = implicit(Scene::new("hammock").body(hammock).body(weight), 1.0 / 240.0);
    scene.world.drag = 5e-4;
    let mut simulation = build(&scene);
    let mut most = 0.0_f64;
    for _ in 0..90 {
        run_free(&mut simulation, 1, "hammock");
        most = most.max(simulation.report().max_stretch);
    }
    // Where the solver knows nothing of what lies on it, impulses after it stretch the fabric to more than twice its length.
    assert!(most < 1.1, "{most}");
    let fastest = velocities(&simulation).iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!(fastest < 5e-3, "{fastest}");
    let lowest = positions(&simulation)[169..].iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    assert!(lowest > -0.1, "the hammock holds it: {lowest}");
}

#[test]
fn layers_over_a_rail_are_solved_for_in_few_iterations() {
    let towel = |name: &str, y: f64, z: f64| {
        let cloth =
            Body::cloth(name, Mesh::grid(25, 17, [0.5, 0.34])).with_material(Material::preset("cotton"));
        touching(cloth.at([0.0, y, z]), 0.3)
    };
    let scene = Scene::new("towels").body(towel("lower", 0.04, 0.03)).body(towel("upper", 0.06, -0.03));
    let rail = Collider::capsule([-0.4, 0.0, 0.0], [0.4, 0.0, 0.0], 0.02);
    let mut simulation = build(&implicit(scene.collider(rail), 1.0 / 240.0));
    let mut iterations = 0;
    for frame in 1..=15 {
        run_free(&mut simulation, 1, "towels");
        let solver = simulation.report().solver;
        assert_eq!(solver.capped, 0, "frame {frame}: {solver:?}");
        iterations += solver.iterations;
    }
    // Where coarser levels know nothing of contacts, most frames end at the 200 that are allowed.
    assert!(iterations < 15 * 120, "{iterations}");
}

#[test]
fn a_fine_sheet_does_not_slip_through_the_triangles_of_a_coarse_one() {
    // Corners of the fine one come down in the middle of triangles, and the coarse one's nodes between its own.
    let mut coarse = Body::cloth("coarse", Mesh::grid(3, 3, [0.4, 0.4])).with_mass(Mass::Node(2e-3));
    coarse = touching(coarse.structural(60.0, 0.05).shear(30.0, 0.05), 0.3);
    let coarse = coarse.pin(Select::nodes([0, 2, 6, 8]));
    let mut fine = sheet("fine", [14, 14], [0.0; 3], 0.3);
    fine.place = turned([1.0, 0.2, 0.3], 75.0, [0.013, 0.18, 0.02]);
    let mut simulation = build(&Scene::new("").time(1.0 / 60.0, 5e-4).body(coarse).body(fine));
    run_free(&mut simulation, 60, "coarse and fine");
    let lowest = positions(&simulation)[9..].iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    assert!(lowest > -0.25, "it lies on the coarse one: {lowest}");
}

#[test]
fn a_stack_comes_to_rest_in_its_order() {
    let mut scene =
        Scene::new("").time(1.0 / 60.0, 5e-4).collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
    let layers = 5;
    for layer in 0..layers {
        let up = f64::from(layer);
        let mut body = sheet(&format!("sheet{layer}"), [8, 8], [0.0; 3], 0.3);
        body.place = turned([0.0, 1.0, 0.0], 9.0 * up, [0.003 * up, 0.012 + 0.007 * up, 0.002 * up]);
        scene = scene.body(body);
    }
    // Springs alone do not damp a flat sheet that swings out of its plane.
    scene.world.drag = 1e-3;
    let mut simulation = build(&scene);
    run_free(&mut simulation, 90, "a stack");
    let fastest = velocities(&simulation).iter().flatten().fold(0.0, |most: f64, v| most.max(v.abs()));
    assert!(fastest < 1e-3, "{fastest} m/s");
    let heights: Vec<f64> =
        positions(&simulation).chunks(64).map(|x| x.iter().map(|x| x[1]).sum::<f64>() / 64.0).collect();
    for two in heights.windows(2) {
        let between = (two[1] - two[0]) / THICK;
        assert!((0.85..1.1).contains(&between), "{heights:?}");
    }
}

#[test]
fn a_collision_keeps_momentum_and_wins_no_energy() {
    let mut high = sheet("high", [8, 8], [0.0; 3], 0.4);
    high.place = turned([0.3, 1.0, 0.2], 25.0, [0.02, 0.05, 0.01]);
    let mut scene =
        Scene::new("").time(1.0 / 60.0, 5e-4).body(sheet("low", [8, 8], [0.0; 3], 0.4)).body(high);
    scene.world.gravity = [0.0; 3];
    let mut simulation = build_as(&scene, Precision::F64, 1);
    let given: Vec<V> =
        (0..128).map(|node| if node < 64 { [0.1, 0.0, 0.0] } else { [-0.2, -1.5, 0.1] }).collect();
    set_velocities(&mut simulation, &given);
    let momentum: V = std::array::from_fn(|axis| 8e-5 * given.iter().map(|v| v[axis]).sum::<f64>());
    let mut energy = 4e-5 * given.iter().flatten().map(|v| v * v).sum::<f64>();
    let mut touched = 0;
    for _ in 0..20 {
        run(&mut simulation, 1);
        let report = simulation.report();
        touched += report.pairs;
        for axis in 0..3 {
            assert!(
                (report.momentum[axis] - momentum[axis]).abs() < 1e-12,
                "{:?} {momentum:?}",
                report.momentum
            );
        }
        assert!(report.energy() < energy * (1.0 + 1e-6), "{} after {energy}", report.energy());
        energy = report.energy();
    }
    assert!(touched > 20, "{touched}");
    assert_eq!(simulation.intersections().pairs, 0);
}

#[test]
fn a_collision_that_is_solved_for_keeps_momentum_and_wins_no_energy() {
    let mut high = fabric("high", [8, 8], [0.0; 3]);
    high.place = turned([0.3, 1.0, 0.2], 25.0, [0.02, 0.02, 0.01]);
    let mut scene = implicit(Scene::new("").body(fabric("low", [8, 8], [0.0; 3])).body(high), 1.0 / 240.0);
    scene.world.gravity = [0.0; 3];
    let mut simulation = build_as(&scene, Precision::F64, 2);
    let given: Vec<V> =
        (0..128).map(|node| if node < 64 { [0.1, 0.0, 0.0] } else { [-0.2, -0.8, 0.1] }).collect();
    set_velocities(&mut simulation, &given);
    let mut first = None;
    let (mut touched, mut least) = (0, f64::INFINITY);
    for _ in 0..20 {
        run(&mut simulation, 1);
        let report = simulation.report();
        touched += report.pairs;
        let (before, energy) = *first.get_or_insert((report.momentum, report.energy()));
        let off = (0..3).map(|axis| (report.momentum[axis] - before[axis]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{:?} {before:?}", report.momentum);
        // Impulses after the solver stretch a little what they move.
        assert!(report.energy() < least + 0.01 * energy, "{} after {least}", report.energy());
        least = least.min(report.energy());
    }
    assert!(touched > 20, "{touched}");
    assert_eq!(simulation.intersections().pairs, 0);
}

#[test]
fn friction_holds_on_a_gentle_slope_and_slides_on_a_steep_one() {
    // Gravity is turned instead of the sheets.
    let slide = |degrees: f64| {
        let base = sheet("base", [12, 12], [0.0; 3], 0.4).pin(Select::nodes((0..144).collect::<Vec<u32>>()));
        let mut scene = Scene::new("").time(1.0 / 60.0, 5e-4).body(base).body(sheet(
            "top",
            [4, 4],
            [0.0, THICK, 0.0],
            0.4,
        ));
        let angle = degrees / 360.0 * TAU;
        scene.world.gravity = [9.81 * angle.sin(), -9.81 * angle.cos(), 0.0];
        let mut simulation = build(&scene);
        run(&mut simulation, 15);
        positions(&simulation)[144..].iter().map(|x| x[0]).sum::<f64>() / 16.0
    };
    // tan 20° < 0.4 < tan 30°.
    assert!(slide(20.0).abs() < 2e-4, "{}", slide(20.0));
    let (angle, t) = (TAU / 12.0, 0.25);
    let free: f64 = 0.5 * 9.81 * (angle.sin() - 0.4 * angle.cos()) * t * t;
    assert!((slide(30.0) / free - 1.0).abs() < 0.1, "{} {free}", slide(30.0));
}

#[test]
fn fast_cloth_flies_freely_and_still_stops_at_what_is_in_its_way() {
    let mut scene = Scene::new("").time(1.0 / 60.0, 1.0 / 60.0).body(sheet("flies", [6, 6], [0.0; 3], 0.3));
    scene.world.gravity = [0.0; 3];
    let mut simulation = build(&scene);
    set_velocities(&mut simulation, &[[0.0, 0.0, -60.0]; 36]);
    run(&mut simulation, 1);
    for (x, v) in positions(&simulation).iter().zip(velocities(&simulation)) {
        assert!((x[2].abs() - 1.0).abs() < 0.06 && (v[2] + 60.0).abs() < 1e-3, "{x:?} {v:?}");
    }
    // Three centimetres a step, at a sheet half a metre away: beyond it half a frame later, if nothing held it.
    let mut held = sheet("held", [20, 20], [0.0; 3], 0.3).pin(Select::nodes([0, 19, 380, 399]));
    held.place = turned([1.0, 0.0, 0.0], 90.0, [0.0, 0.0, -0.5]);
    let mut flies = sheet("flies", [6, 6], [0.0; 3], 0.3);
    flies.place = turned([1.0, 0.0, 0.0], 60.0, [0.0; 3]);
    let mut scene = Scene::new("").time(1.0 / 60.0, 5e-4).body(held).body(flies);
    scene.world.gravity = [0.0; 3];
    let mut simulation = build(&scene);
    let mut given = vec![[0.0; 3]; 400];
    given.extend([[0.0, 0.0, -60.0]; 36]);
    set_velocities(&mut simulation, &given);
    for _ in 0..2 {
        simulation.step().unwrap();
        assert_eq!(simulation.intersections().pairs, 0);
    }
    let fastest = velocities(&simulation)[400..].iter().map(|v| -v[2]).fold(0.0, f64::max);
    assert!(fastest < 50.0, "it is caught: {fastest}");
}

/// A box that stands on a corner, below the middle of a sheet; `rise` is where it has gone after half a second [m].
fn corner(rise: f64) -> Scene {
    let mut spike = Collider {
        cuboid: Some(Cuboid { center: [0.0; 3], half: [0.1; 3] }),
        offset: 0.004,
        ..Collider::default()
    };
    spike.place = turned([1.0, 0.0, -0.8], 50.0, [0.0, -0.19, 0.0]);
    if rise > 0.0 {
        spike.motion = vec![Keyframe::translate(0.5, [0.0, rise, 0.0])];
    }
    // No node is above the corner.
    Scene::new("corner")
        .time(1.0 / 60.0, 5e-4)
        .body(sheet("sheet", [16, 16], [0.009, 0.0, 0.012], 0.3))
        .collider(spike)
}

#[test]
fn the_corner_of_a_box_does_not_poke_through_between_nodes() {
    let mut simulation = build(&corner(0.0));
    run_free(&mut simulation, 40, "falling on it");
    let mut scene = corner(0.15);
    scene.bodies[0].pins = vec![Pin { select: Select::nodes([0, 15, 240, 255]), ..Pin::default() }];
    let mut simulation = build(&scene);
    run_free(&mut simulation, 40, "held, while it rises");
    let highest = positions(&simulation).iter().map(|x| x[1]).fold(0.0, f64::max);
    assert!(highest > 0.05, "it is lifted: {highest}");
}

#[test]
fn a_needle_stays_between_the_nodes_of_a_sheet_and_below_it() {
    let needle = Mesh::Cylinder(Cylinder { radius: 0.001, height: 0.3, segments: 6, rings: 1, capped: true });
    let needle = Collider::mesh(needle);
    let needle =
        Collider { place: turned([0.0, 0.0, 1.0], 0.0, [0.009, -0.16, 0.012]), offset: 0.003, ..needle };
    let mut scene = Scene::new("needle").time(1.0 / 60.0, 5e-4).collider(needle);
    scene = scene.body(sheet("sheet", [10, 10], [0.001, 0.0, 0.002], 0.3));
    let mut simulation = build(&scene);
    run_free(&mut simulation, 40, "on a needle");
}

/// Cloth on cloth and on a soft ring, some of it at rest and some fast, and a box that pushes its way in.
fn mixed() -> Scene {
    let ring = Mesh::Torus(Torus { major: 0.08, minor: 0.03, rings: 16, segments: 8 });
    let ring =
        Body::soft("ring", ring).with_mass(Mass::Whole(0.1)).structural(100.0, 0.05).at([0.0, 0.05, 0.0]);
    let mut lid = sheet("lid", [16, 18], [0.0; 3], 0.3);
    lid.place = turned([0.2, 1.0, 0.0], 20.0, [0.0, 0.13, 0.0]);
    let cuboid = Some(Cuboid { center: [0.3, 0.05, 0.0], half: [0.03; 3] });
    let turn = Keyframe::rotate(0.15, [0.2, 1.0, 0.4], 70.0, [0.3, 0.05, 0.0]);
    let motion = vec![Keyframe { translate: [-0.25, 0.06, 0.02], ..turn }];
    let pushes = Collider { cuboid, motion, offset: 0.004, ..Collider::default() };
    Scene::new("mixed")
        .time(0.01, 5e-4)
        .collider(pushes)
        .body(touching(ring, 0.5))
        .body(lid)
        .body(sheet("top", [15, 12], [0.01, 0.17, 0.02], 0.2))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
}

/// Fabrics that are solved for: two lie on a third, which is pinned, one flies beside them, and a box pushes its way in.
fn solved() -> Scene {
    let hammock = fabric("hammock", [22, 20], [0.0; 3]).pin(Select::rows(0, 0)).pin(Select::rows(21, 21));
    let cuboid = Some(Cuboid { center: [0.2, 0.05, 0.0], half: [0.03; 3] });
    let turn = Keyframe::rotate(0.15, [0.2, 1.0, 0.4], 70.0, [0.2, 0.05, 0.0]);
    let motion = vec![Keyframe { translate: [-0.2, -0.02, 0.02], ..turn }];
    let pushes = Collider { cuboid, motion, offset: 0.004, ..Collider::default() };
    let scene = Scene::new("solved")
        .body(hammock)
        .body(fabric("low", [6, 5], [0.01, 0.006, 0.02]))
        .body(fabric("high", [4, 4], [0.0, 0.012, 0.01]))
        .body(fabric("beside", [3, 3], [0.4, 0.0, 0.0]))
        .collider(pushes);
    implicit(scene, 1.0 / 120.0)
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for (scene, precision) in [mixed(), solved()]
        .into_iter()
        .flat_map(|scene| [Precision::F32, Precision::F64].map(|precision| (scene.clone(), precision)))
    {
        let hash = |threads| {
            let mut simulation = build_as(&scene, precision, threads);
            run(&mut simulation, 15);
            assert!(simulation.report().pairs > 20, "{}", simulation.report().pairs);
            (simulation.state_hash(), simulation.report().pairs, simulation.report().nearest_pair)
        };
        let one = hash(1);
        for threads in if precision == Precision::F32 { &[2, 3][..] } else { &[8] } {
            assert_eq!(hash(*threads), one, "{}, {precision}, {threads} threads", scene.title);
        }
    }
}

#[test]
fn the_number_of_threads_may_change_between_frames() {
    for scene in [mixed(), solved()] {
        let hash = |counts: &[usize]| {
            let mut simulation = build_as(&scene, Precision::F32, 3);
            for frame in 0..15 {
                simulation.limit_threads(counts[frame % counts.len()]);
                run(&mut simulation, 1);
            }
            (simulation.state_hash(), simulation.report().pairs, simulation.report().nearest_pair)
        };
        assert_eq!(hash(&[1, 3, 3, 2, 2]), hash(&[1]), "{}", scene.title);
    }
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn hashes_of_surfaces() {
    for scene in [mixed(), solved()] {
        for precision in [Precision::F32, Precision::F64] {
            let mut simulation = build_as(&scene, precision, 2);
            run(&mut simulation, 15);
            println!("hash|{:016x}", simulation.state_hash());
        }
    }
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    levels::assert_same("surfaces::hashes_of_surfaces", 4);
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    for scene in [mixed(), solved()] {
        let mut whole = build(&scene);
        run(&mut whole, 14);
        let snapshot = whole.snapshot();
        assert!(snapshot.contacts > 20, "{}", snapshot.contacts);
        run(&mut whole, 6);
        for threads in [1, 3] {
            let mut again = build_as(&scene, Precision::F32, threads);
            again.restore(&snapshot).unwrap();
            assert_eq!(again.snapshot(), snapshot, "what is restored is what was taken");
            run(&mut again, 6);
            assert_eq!(again.state_hash(), whole.state_hash(), "{}, {threads} threads", scene.title);
        }
    }
}

#[test]
fn a_thickness_in_millimetres_is_warned_of() {
    let said = |thickness: f64, zones: BTreeMap<String, ContactZone>| {
        let mut one = sheet("one", [8, 8], [0.0; 3], 0.3);
        one.self_collision.as_mut().expect("it touches").thickness = thickness;
        one.self_collision.as_mut().expect("it touches").zones = zones;
        let words = crate::common::warnings(&build(&Scene::new("").time(0.01, 5e-4).body(one)));
        words.into_iter().find(|words| words.contains("thickness is 3 m") && words.contains("mm are divided"))
    };
    assert!(said(3.0, BTreeMap::new()).is_some());
    assert!(said(0.003, BTreeMap::new()).is_none());
    assert!(
        said(0.003, zone(0..24, 3.0))
            .is_some_and(|words| words.contains("self_collision.zone.hem.thickness"))
    );
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    let refused = |scene: &Scene| match Simulation::new(scene, &taffeta::Options::default()) {
        Ok(_) => panic!("it was accepted"),
        Err(error) => error.to_string(),
    };
    let chain = touching(
        Body::cloth("chain", Mesh::chain(9, 1.0)).with_mass(Mass::Node(0.01)).structural(10.0, 0.1),
        0.3,
    );
    let why = refused(&Scene::new("").body(chain));
    assert!(why.contains("body[0].self_collision.form") && why.contains("\"nodes\" would do"), "{why}");
    let mut bouncing = sheet("bounces", [4, 4], [0.0; 3], 0.3);
    bouncing.self_collision.as_mut().unwrap().restitution = 0.5;
    let why = refused(&Scene::new("").body(bouncing));
    assert!(why.contains("body[0].self_collision.restitution"), "{why}");
}

/// A sheet above another one, and one above both, each as far down as nothing holds it.
fn layers(change: impl Fn(&mut [Body; 3])) -> [f64; 3] {
    let sheet = |name: &str, up: f64| sheet(name, [6, 6], [0.0, up, 0.0], 0.3);
    let mut bodies = [sheet("low", 0.0), sheet("middle", 0.012), sheet("top", 0.024)];
    bodies[0].pins = vec![Pin { select: Select::nodes((0..36).collect::<Vec<_>>()), ..Pin::default() }];
    change(&mut bodies);
    let mut scene = Scene::new("layers").time(1.0 / 60.0, 5e-4);
    scene.bodies = bodies.into();
    let mut simulation = build(&scene);
    run_free(&mut simulation, 20, "layers");
    let x = positions(&simulation);
    [0, 1, 2].map(|layer| x[36 * layer..36 * (layer + 1)].iter().map(|x| x[1]).sum::<f64>() / 36.0)
}

#[test]
fn bodies_touch_those_that_they_are_to_touch() {
    let touch = |body: &mut Body| body.self_collision.take().expect("it touches");
    let name = |name: &str| vec![name.to_string()];
    let [_, middle, top] = layers(|_| ());
    assert!((0.004..0.006).contains(&middle) && (0.008..0.012).contains(&top), "{middle} {top}");
    // The top one falls through the middle one, which its list leaves out, onto the low one: none of that counts as wrong.
    let [_, middle, top] = layers(|bodies| {
        bodies[2].self_collision = Some(SelfCollision { with: name("low"), ..touch(&mut bodies[2]) });
    });
    assert!((0.004..0.006).contains(&middle) && (0.004..0.006).contains(&top), "{middle} {top}");
    // It is enough if one of two does not touch the other.
    let [_, middle, top] = layers(|bodies| {
        bodies[0].self_collision = Some(SelfCollision { without: name("middle"), ..touch(&mut bodies[0]) });
    });
    assert!(middle < -0.1 && (0.004..0.006).contains(&top), "{middle} {top}");
}

/// A zone of triangles whose corners are all of some nodes.
fn zone(nodes: impl IntoIterator<Item = u32>, thickness: f64) -> BTreeMap<String, ContactZone> {
    let select = Select::nodes(nodes.into_iter().collect::<Vec<_>>());
    [("hem".to_owned(), ContactZone { select, thickness })].into()
}

#[test]
fn a_zone_keeps_its_own_distance() {
    let height = |thickness: Option<[f64; 2]>| {
        let mut low = sheet("low", [6, 12], [0.0; 3], 0.3);
        low.pins = vec![Pin { select: Select::nodes((0..72).collect::<Vec<_>>()), ..Pin::default() }];
        let mut top = sheet("top", [6, 12], [0.0, 0.03, 0.0], 0.3);
        // The last four columns of both.
        let hem = || (0..72).filter(|node| node % 12 >= 8);
        for (body, thickness) in [&mut low, &mut top].into_iter().zip(thickness.into_iter().flatten()) {
            body.self_collision.as_mut().expect("it touches").zones = zone(hem(), thickness);
        }
        let mut simulation = build(&Scene::new("hem").time(1.0 / 60.0, 5e-4).body(low).body(top));
        run_free(&mut simulation, 40, "a hem");
        let x = positions(&simulation);
        let mean = |cols: std::ops::Range<usize>| {
            let nodes = (0..72).filter(|node| cols.contains(&(node % 12)));
            nodes.map(|node| x[72 + node][1]).sum::<f64>() / (6 * cols.len()) as f64
        };
        [mean(0..5), mean(9..12)]
    };
    let near = |[plain, hem]: [f64; 2], wanted: [f64; 2]| {
        assert!((plain - wanted[0]).abs() < 0.1 * wanted[0], "{plain} m of {wanted:?}");
        assert!((hem - wanted[1]).abs() < 0.1 * wanted[1], "{hem} m of {wanted:?}");
    };
    near(height(None), [THICK, THICK]);
    // Between two it is the mean of both.
    near(height(Some([0.013, 0.013])), [THICK, 0.013]);
    near(height(Some([0.013, THICK])), [THICK, 0.009]);
}

#[test]
fn zones_of_contact_are_checked() {
    let refused = |change: &dyn Fn(&mut SelfCollision)| {
        let mut one = sheet("one", [4, 4], [0.0; 3], 0.3);
        change(one.self_collision.as_mut().expect("it touches"));
        let scene = Scene::new("").time(0.01, 5e-4).body(one);
        crate::common::scene_error(Simulation::new(&scene, &taffeta::Options::default())).to_string()
    };
    let few = refused(&|touch| touch.zones = zone([0, 1], 0.01));
    assert!(few.contains("self_collision.zone.hem.select") && few.contains("no whole triangle"), "{few}");
    let none = refused(&|touch| touch.zones = zone(0..99, 0.01));
    assert!(none.contains("self_collision.zone.hem.select"), "{none}");
    let thin = refused(&|touch| touch.zones = zone(0..9, 0.0));
    assert!(thin.contains("self_collision.zone.hem.thickness"), "{thin}");
    let nodes = refused(&|touch| (touch.form, touch.zones) = (ContactForm::Nodes, zone(0..9, 0.01)));
    assert!(nodes.contains("self_collision.zone") && nodes.contains("form = \"triangles\""), "{nodes}");
}

#[test]
fn whom_a_body_touches_is_checked() {
    let refused = |change: &dyn Fn(&mut SelfCollision)| {
        let mut one = sheet("one", [4, 4], [0.0; 3], 0.3);
        change(one.self_collision.as_mut().expect("it touches"));
        let other = Body { self_collision: None, ..sheet("other", [4, 4], [0.0, 0.1, 0.0], 0.3) };
        let scene = Scene::new("").time(0.01, 5e-4).body(one).body(other);
        crate::common::scene_error(Simulation::new(&scene, &taffeta::Options::default())).to_string()
    };
    let list = |name: &str| vec![name.to_string()];
    let unknown = refused(&|touch| touch.with = list("otter"));
    assert!(
        unknown.contains("body[0].self_collision.with") && unknown.contains("no body `otter`"),
        "{unknown}"
    );
    assert!(refused(&|touch| touch.without = list("one")).contains("itself"));
    assert!(refused(&|touch| touch.with = list("other")).contains("no contact between triangles"));
    let nodes = refused(&|touch| (touch.form, touch.with) = (ContactForm::Nodes, list("other")));
    assert!(nodes.contains("form = \"triangles\""), "{nodes}");
}
