//! Friction on shapes that are flat somewhere: slopes, belts, turning tables.

use super::depth::data;
use super::reference::{Faces, turn};
use crate::common::{V, add, build, build_as, farthest, near, norm, positions, run, scale, sub, turned};
use taffeta::scene::{
    Body, Collider, ConstraintForm, Cube, Force, Ice, Keyframe, Mass, Mesh, Method, Place, Scene, Select,
    Solver,
};
use taffeta::{Precision, Simulation};

const G: f64 = 9.81;
const OFFSET: f64 = 0.01;

/// Shapes with a flat face at y = 0, 6 m wide; where they are put first, and what they are.
fn flats() -> Vec<(&'static str, V, Collider)> {
    let cube = || Mesh::Cube(Cube { size: 6.0, divisions: 4 });
    let flat = vec![vec![0.0; 5]; 6];
    vec![
        ("box", [0.0; 3], Collider::cuboid([0.0, -0.5, 0.0], [3.0, 0.5, 3.0])),
        ("cylinder", [0.0; 3], Collider::cylinder([0.0, -1.0, 0.0], [0.0; 3], 3.0)),
        ("sheet", [0.0; 3], Collider::mesh(Mesh::grid(9, 12, [6.0, 6.0]))),
        ("height field", [0.0; 3], Collider::heightfield([6.0, 6.0], flat)),
        ("cube of triangles", [0.0, -3.0, 0.0], Collider::mesh(cube())),
        ("hull", [0.0, -3.0, 0.0], Collider::convex(cube())),
    ]
}

fn patch(place: Place) -> Body {
    let body = Body::cloth("patch", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Node(0.03));
    Body { place, ..body.structural(100.0, 0.1).shear(60.0, 0.1) }
}

const AXIS: V = [0.0, 0.0, 1.0];

/// A patch on a slope of 20°, down along +x, one metre up from its middle.
fn incline((first, collider): (V, Collider), friction: f64) -> Scene {
    let at = |x: V| turn(AXIS, -20.0, x);
    let slope = collider.placed(turned(AXIS, -20.0, at(first))).offset(OFFSET).friction(friction);
    let patch = patch(turned(AXIS, -20.0, at([-1.03, OFFSET, 0.02])));
    Scene::new("incline").time(0.01, 0.001).body(patch).collider(slope)
}

#[test]
fn half_the_normal_force_as_friction_sticks_on_20_degrees() {
    for (name, first, collider) in flats() {
        for (precision, tolerance) in [(Precision::F64, 1e-11), (Precision::F32, 2e-5)] {
            let mut simulation = build_as(&incline((first, collider.clone()), 0.5), precision, 1);
            let start = positions(&simulation);
            run(&mut simulation, 150);
            let moved = farthest(&positions(&simulation), &start);
            assert!(moved < tolerance, "{name}, {precision}: {moved:e} m in 1.5 s");
            assert!(simulation.report().contacts > 0, "{name}");
        }
    }
}

#[test]
fn a_fifth_of_it_slides_with_g_sine_less_mu_cosine() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let a = G * (sin - 0.2 * cos);
    let way = a * 1e-6 * 1000.0 * 1001.0 / 2.0;
    for (name, first, collider) in flats() {
        for (precision, tolerance) in [(Precision::F64, 1e-9), (Precision::F32, 2e-3)] {
            let mut simulation = build_as(&incline((first, collider.clone()), 0.2), precision, 1);
            let start = positions(&simulation);
            run(&mut simulation, 100);
            for (from, to) in start.iter().zip(positions(&simulation)) {
                let moved = turn(AXIS, 20.0, sub(to, *from));
                near(&format!("{name}, {precision}: way"), moved[0], way, tolerance);
                near(&format!("{name}, {precision}: off the slope"), moved[1], 0.0, tolerance * 1e-2);
            }
            near(name, norm(simulation.report().momentum) / 0.6, a, tolerance.max(1e-8) * 10.0);
        }
    }
}

#[test]
fn cloth_sticks_to_turning_tables() {
    for (name, first, collider) in flats() {
        let place = Place { position: first, ..Place::default() };
        let table = collider.placed(place).offset(OFFSET).friction(0.9);
        let table = table.keyframe(Keyframe::rotate(2.0, [0.0, 1.0, 0.0], 180.0, [0.0; 3]));
        let patch = patch(Place { position: [0.02, OFFSET, 0.03], ..Place::default() });
        let mut simulation = build(&Scene::new(name).time(0.01, 5e-4).body(patch).collider(table));
        let own = |simulation: &_, t: f64| -> Vec<V> {
            positions(simulation).into_iter().map(|x| turn([0.0, 1.0, 0.0], -90.0 * t, x)).collect()
        };
        let start = positions(&simulation);
        run(&mut simulation, 30);
        let caught = own(&simulation, 0.3);
        // From rest it slips until it has ω r = 0.4 m/s, and lags by v²/(2 μ g) = 11 mm at most.
        let lag = farthest(&start, &caught);
        run(&mut simulation, 170);
        let crept = farthest(&caught, &own(&simulation, 2.0));
        println!("{name}: {lag:e} {crept:e}");
        assert!(lag < 0.011 && crept < 2e-5, "{name}: lags by {lag:e} m, then by {crept:e} m");
    }
}

fn mean(simulation: &Simulation) -> f64 {
    let all = positions(simulation);
    all.iter().map(|x| x[0]).sum::<f64>() / all.len() as f64
}

/// A patch on a belt that goes at 1 m/s along x.
fn rides(name: &str, belt: Collider) {
    let patch = patch(Place { position: [-1.0, OFFSET, 0.0], ..Place::default() });
    let mut simulation = build(&Scene::new(name).time(0.01, 1e-3).body(patch).collider(belt));
    run(&mut simulation, 10);
    near(&format!("{name}: speed"), simulation.report().momentum[0] / 0.6, 0.5 * G * 0.1, 1e-8);
    run(&mut simulation, 40);
    near(&format!("{name}: speed"), simulation.report().momentum[0] / 0.6, 1.0, 1e-8);
    near(&format!("{name}: lag"), 0.5 - 1.0 - mean(&simulation), 1.0 / (2.0 * 0.5 * G), 1e-3);
    let before = positions(&simulation);
    run(&mut simulation, 100);
    let carried: Vec<V> = before.iter().map(|x| add(*x, [1.0, 0.0, 0.0])).collect();
    let apart = farthest(&carried, &positions(&simulation));
    assert!(apart < 1e-8, "{name}: {apart:e} m");
}

#[test]
fn belts_drag_cloth_with_mu_g_until_it_moves_along() {
    for (name, first, collider) in flats() {
        let place = Place { position: first, ..Place::default() };
        let belt = collider.placed(place).offset(OFFSET).friction(0.5);
        rides(name, belt.keyframe(Keyframe::translate(2.0, [2.0, 0.0, 0.0])));
    }
}

#[test]
fn a_belt_may_move_by_poses() {
    let faces = Faces::of(&Mesh::grid(9, 12, [6.0, 6.0]));
    // The time between poses is no multiple of a sub-step.
    let poses = (0..8).map(|i| {
        faces.nodes.iter().map(|x| add(*x, scale([1.0, 0.0, 0.0], 0.3007 * f64::from(i)))).collect()
    });
    let belt = Collider::mesh(data(faces.nodes.clone(), faces.triangles.clone()));
    rides("poses", belt.posed(0.3007, poses.collect()).offset(OFFSET).friction(0.5));
}

/// Methods that solve for springs, in both forms.
fn implicit() -> [Solver; 2] {
    [ConstraintForm::Compliant, ConstraintForm::Primal].map(|form| Solver {
        method: Method::Ice,
        ice: Ice { form, ..Ice::default() },
        ..Solver::default()
    })
}

#[test]
fn stiff_cloth_that_is_drawn_at_its_edge_slides_whatever_the_step() {
    let (node, rows, pull) = (3e-4, 8_u32, 0.2);
    let mass = node * f64::from(rows * rows);
    let cloth = Body::cloth("cloth", Mesh::grid(rows, rows, [0.3, 0.3]))
        .with_mass(Mass::Node(node))
        .structural(300.0, 0.02)
        .shear(150.0, 0.02)
        .at([0.0, OFFSET, 0.0]);
    let edge: Vec<u32> = (0..rows).map(|row| row * rows + rows - 1).collect();
    let draws = Force {
        body: "cloth".into(),
        select: Select::nodes(edge),
        force: Some([pull / f64::from(rows), 0.0, 0.0]),
        ..Force::default()
    };
    // Friction bears 0.056 N of the 0.2 N; of a quarter of that, all.
    let a = pull / mass - 0.3 * G;
    for solver in implicit() {
        for h in [1.0 / 60.0, 1.0 / 240.0, 1e-3] {
            let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(OFFSET).friction(0.3);
            let scene = Scene { solver: solver.clone(), ..Scene::new("drawn").time(h, h) };
            let scene = scene.body(cloth.clone()).collider(floor);
            // It takes some steps until all of it has come loose.
            let gained = |draws: Force| {
                let mut simulation = build(&scene.clone().force(draws));
                let speed = |simulation: &Simulation| simulation.report().momentum[0] / mass;
                run(&mut simulation, (0.5 / h) as u32);
                let before = speed(&simulation);
                run(&mut simulation, (0.5 / h) as u32);
                (speed(&simulation) - before) / 0.5
            };
            near(&format!("{:?}, {h} s", solver.ice.form), gained(draws.clone()), a, 0.02 * a);
            let little = draws.force.map(|force| scale(force, 0.25 * 0.056 / pull));
            let gains = gained(Force { force: little, ..draws.clone() });
            assert!(gains.abs() < 1e-3, "{:?}, {h} s: {gains} m/s²", solver.ice.form);
        }
    }
}

#[test]
fn a_belt_that_moves_by_poses_takes_along_cloth_whose_springs_are_solved_for() {
    let faces = Faces::of(&Mesh::grid(9, 12, [6.0, 6.0]));
    let at = |i: i32| faces.nodes.iter().map(|x| add(*x, [0.3 * f64::from(i), 0.0, 0.0])).collect();
    let belt = Collider::mesh(data(faces.nodes.clone(), faces.triangles.clone()));
    let belt = belt.posed(0.3, (0..8).map(at).collect()).offset(OFFSET).friction(0.5);
    for solver in implicit() {
        for h in [1.0 / 60.0, 1e-3] {
            let patch = patch(Place { position: [-1.0, OFFSET, 0.0], ..Place::default() });
            let scene = Scene { solver: solver.clone(), ..Scene::new("belt").time(h, h) };
            let mut simulation = build(&scene.body(patch).collider(belt.clone()));
            run(&mut simulation, (1.0 / h) as u32);
            // 1 m/s, less the way in which it came to that.
            let wanted = 1.0 - 1.0 / (2.0 * 0.5 * G);
            near(&format!("{:?}, {h} s", solver.ice.form), mean(&simulation) + 1.0, wanted, 0.01);
        }
    }
}
