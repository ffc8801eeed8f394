//! Bodies and colliders that layers keep from each other.

use crate::common::{build_as, positions, run, sub, turned, warnings};
use crate::gpu::on_gpu;
use taffeta::scene::{
    Body, Collider, ConstraintForm, ContactForm, Icosphere, Keyframe, Layers, Mass, Mesh, Method, Scene,
    SelfCollision, Sleep,
};
use taffeta::{Precision, Simulation};

/// Layers of these numbers.
fn layers<const M: usize, const F: usize>(memberships: [u32; M], filter: [u32; F]) -> Layers {
    Layers::new(memberships, filter)
}

fn ball(radius: f64, subdivisions: u32) -> Mesh {
    Mesh::Icosphere(Icosphere { radius, subdivisions })
}

fn sheet(name: &str, height: f64) -> Body {
    Body::cloth(name, Mesh::grid(21, 23, [0.6, 0.6]))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .shear(20.0, 0.02)
        .at([0.01, height, 0.02])
}

fn puff(name: &str, height: f64) -> Body {
    let body = Body::cloth(name, ball(0.15, 2)).with_mass(Mass::Node(0.01)).structural(60.0, 0.02);
    body.at([-0.03, height, 0.04])
}

/// A sheet that falls on a ball, another that falls past it on a turning box, and a puff for which there is nothing but a mesh and
/// itself; a floor for all. All are where the others are.
fn crowd() -> Scene {
    let turning = Keyframe::rotate(0.5, [0.1, 0.9, 0.2], 70.0, [0.0; 3]);
    Scene::new("crowd")
        .body(sheet("first", 0.262).collide_nodes(0.02).layers(layers([1], [1, 4])))
        .body(sheet("second", 0.27).collide_nodes(0.02).layers(layers([2], [2, 4])))
        .body(puff("third", 0.285).collide_nodes(0.03).layers(layers([3], [3, 4])))
        .collider(Collider::sphere([0.0, 0.1, 0.0], 0.15).friction(0.4).layers(layers([1], [1])))
        .collider(
            Collider::cuboid([0.0, -0.1, 0.0], [0.2, 0.05, 0.1]).layers(layers([2], [2])).keyframe(turning),
        )
        .collider(Collider::mesh(ball(0.12, 2)).layers(layers([3], [3])))
        .collider(Collider::plane([0.0, -0.2, 0.0], [0.05, 1.0, 0.0]).layers(layers([4], [1, 2, 3])))
        .friction_between("second", "collider3", 0.05)
        .time(0.01, 1e-3)
}

/// A scene with one of its bodies alone, and the colliders that this meets.
fn alone(scene: &Scene, body: usize) -> Scene {
    let one = &scene.bodies[body];
    let mut scene = Scene { bodies: vec![one.clone()], ..scene.clone() };
    let names: Vec<String> = (0..scene.colliders.len()).map(|index| scene.collider_name(index)).collect();
    for (collider, name) in scene.colliders.iter_mut().zip(names) {
        collider.name = name;
    }
    scene.colliders.retain(|collider| one.layers.meets(&collider.layers));
    scene.frictions.retain(|pair| pair.between.contains(&one.name));
    scene.bodies[0].layers = Layers::default();
    scene.colliders.iter_mut().for_each(|collider| collider.layers = Layers::default());
    scene
}

/// Places and velocities of each body.
fn states(simulation: &Simulation) -> Vec<[Vec<[f64; 3]>; 2]> {
    let (all, mut velocities) = (positions(simulation), Vec::<[f64; 3]>::new());
    simulation.velocities_f64(&mut velocities);
    let mut first = 0;
    let of_body = |count: usize| {
        let range = first..first + count;
        first += count;
        [all[range.clone()].to_vec(), velocities[range].to_vec()]
    };
    simulation.bodies().iter().map(|body| body.vertices).map(of_body).collect()
}

/// Whether each body of a scene moves bit by bit as it does alone. Returns how many nodes touched colliders at most.
fn is_as_alone(scene: &Scene, frames: u32, start: impl Fn(&Scene) -> Simulation) -> u64 {
    let mut all = start(scene);
    let mut each: Vec<Simulation> = (0..scene.bodies.len()).map(|body| start(&alone(scene, body))).collect();
    let mut most = 0;
    for frame in 1..=frames {
        run(&mut all, 1);
        each.iter_mut().for_each(|one| run(one, 1));
        most = most.max(all.report().contacts);
        let contacts: u64 = each.iter().map(|one| one.report().contacts).sum();
        assert_eq!(all.report().contacts, contacts, "frame {frame}");
        let of_all = states(&all);
        for ((body, one), of_one) in scene.bodies.iter().zip(of_all).zip(&each) {
            assert!(one == states(of_one)[0], "`{}` of {}, frame {frame}", body.name, scene.title);
        }
    }
    most
}

#[test]
fn who_does_not_meet_moves_as_if_the_other_were_not_there() {
    for (precision, threads) in [(Precision::F32, 1), (Precision::F32, 3), (Precision::F64, 2)] {
        let most = is_as_alone(&crowd(), 25, |scene| build_as(scene, precision, threads));
        assert!(most > 100, "{most}");
    }
    let most = is_as_alone(&crowd(), 8, on_gpu);
    assert!(most > 20, "{most}");
}

#[test]
fn the_same_where_springs_are_constraints() {
    // Who meets nothing falls through all.
    for form in [Some(ConstraintForm::Compliant), Some(ConstraintForm::Primal), None] {
        let method = if form.is_some() { Method::Ice } else { Method::Xpbd };
        let mut scene = crowd().method(method).time(0.01, 2.5e-3);
        scene.solver.ice.form = form.unwrap_or_default();
        scene.bodies.iter_mut().for_each(|body| body.self_collision = None);
        let most = is_as_alone(&scene, 15, |scene| build_as(scene, Precision::F64, 2));
        assert!(most > 50, "{form:?}: {most}");
        if form.is_some() {
            let most = is_as_alone(&scene, 8, on_gpu);
            assert!(most > 20, "{form:?}: {most}");
        }
    }
}

/// Two sheets at rest in the air, one just above the other.
fn stacked(lower: Layers, upper: Layers, form: ContactForm) -> Scene {
    let wish = SelfCollision { form, thickness: 0.02, ..SelfCollision::default() };
    let touching = |name, height, layers| {
        Body { self_collision: Some(wish.clone()), ..sheet(name, height) }.layers(layers)
    };
    Scene::new("stacked")
        .body(touching("lower", 0.0, lower))
        .body(touching("upper", 0.015, upper))
        .time(0.01, 1e-3)
}

#[test]
fn two_bodies_meet_if_each_is_in_a_layer_that_the_other_meets() {
    let all = Layers::default();
    let (one, other) = (layers([0], [0]), layers([5], [5]));
    for form in [ContactForm::Nodes, ContactForm::Triangles] {
        for (lower, upper, meet) in [
            (all, all, true),
            (one, one, true),
            (all, other, true),
            (one, other, false),
            (layers([0], [5]), other, false),
            (layers([0], [5]), layers([5], [0]), true),
            (layers([], [0]), all, false),
            (all, layers([0], []), false),
        ] {
            let scene = stacked(lower, upper, form);
            // Devices are given the lists alone.
            let device = (upper == other).then(|| on_gpu(&scene));
            for mut simulation in [Some(build_as(&scene, Precision::F64, 2)), device].into_iter().flatten() {
                run(&mut simulation, 2);
                let all = positions(&simulation);
                let gap = sub(all[all.len() / 2 + 200], all[200])[1];
                assert_eq!((gap - 0.015).abs() > 1e-5, meet, "{form:?}, {lower:?}, {upper:?}: {gap}");
            }
        }
    }
}

/// Sheets whose triangles touch: one falls through a table and another sheet that lies there on a table of its own.
fn through() -> Scene {
    let wish = SelfCollision { thickness: 0.005, ..SelfCollision::default() };
    let touching = |name, height| Body { self_collision: Some(wish.clone()), ..sheet(name, height) };
    let below = turned([0.0, 1.0, 0.0], 20.0, [0.1, -0.08, 0.1]);
    let table = || Collider::cuboid([0.0; 3], [0.1, 0.03, 0.1]).offset(0.004);
    Scene::new("through")
        .body(touching("falls", 0.075).moving([0.0, -2.0, 0.0]).layers(layers([0], [0])))
        .body(touching("lies", 0.05).layers(layers([1], [1])))
        .collider(table().layers(layers([1], [1])))
        .collider(Collider::mesh(ball(0.05, 2)).placed(below).layers(layers([1], [1])))
        .time(0.01, 1e-3)
}

#[test]
fn triangles_go_through_those_of_what_they_do_not_meet() {
    let free = Scene { bodies: vec![through().bodies[0].clone()], colliders: Vec::new(), ..through() };
    let starts: [fn(&Scene) -> Simulation; 2] = [|scene| build_as(scene, Precision::F64, 2), on_gpu];
    for start in starts {
        let (mut both, mut alone) = (start(&through()), start(&free));
        for _ in 0..10 {
            run(&mut both, 1);
            run(&mut alone, 1);
            assert!(states(&both)[0] == states(&alone)[0]);
            assert_eq!(both.intersections().pairs, 0, "{:?}", both.intersections().first);
        }
        let [fell, lies] = [0, 1].map(|body| states(&both)[body][0][11 * 23 + 11][1]);
        assert!(fell < -0.14 && lies > 0.03, "{fell} {lies}");
    }
    // They do pass through each other.
    let mut scene = through();
    scene.bodies[0].layers = Layers::default();
    scene.bodies[0].place = turned([1.0, 0.0, 0.0], 40.0, [0.0, 0.05, 0.0]);
    assert!(build_as(&scene, Precision::F64, 1).intersections().pairs > 0);
    scene.bodies[0].layers = layers([0], [0]);
    let apart = build_as(&scene, Precision::F64, 1);
    assert_eq!(apart.intersections().pairs, 0);
    assert!(warnings(&apart).is_empty(), "{:?}", warnings(&apart));
}

#[test]
fn a_start_within_what_is_not_met_is_no_reason_to_warn() {
    let within = |layers| {
        let scene = Scene::new("within").time(0.01, 1e-3);
        let scene = scene
            .body(sheet("sheet", 0.0).layers(layers))
            .collider(Collider::sphere([0.0; 3], 0.2).layers(Layers::new([3], [3])));
        let simulation = build_as(&scene, Precision::F64, 1);
        let mut distances = Vec::new();
        simulation.collider_distances(1.0, &mut distances);
        (warnings(&simulation).is_empty(), distances[11 * 23 + 11] < 0.0)
    };
    assert_eq!(within(Layers::default()), (false, true));
    assert_eq!(within(layers([0, 1, 2], [0])), (true, false));
}

#[test]
fn who_sleeps_is_not_woken_by_what_it_does_not_meet() {
    let asleep = |passing: Layers| {
        let lies = Body::cloth("lies", Mesh::grid(5, 5, [0.2, 0.2])).with_mass(Mass::Node(0.01));
        let lies = lies.structural(50.0, 0.2).collide_nodes(0.03).at([0.0, 0.01, 0.0]);
        let falls = Body { name: "falls".into(), ..lies.clone() }.at([0.0, 1.5, 0.0]);
        let sweeps = Keyframe::translate(1.0, [2.0, 0.0, 0.0]);
        let mut scene = Scene::new("asleep")
            .body(lies.layers(layers([0], [0])))
            .body(falls.layers(passing))
            .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
            .collider(Collider::sphere([-1.0, 0.0, 0.0], 0.05).keyframe(sweeps).layers(passing))
            .time(0.01, 1e-3);
        scene.sleep = Some(Sleep { speed: 0.01, after: 0.1 });
        let mut simulation = build_as(&scene, Precision::F64, 1);
        let body = simulation.bodies()[0].handle;
        let mut woken = 0;
        for frame in 0..80 {
            run(&mut simulation, 1);
            woken += u32::from(frame > 30 && !simulation.is_asleep(body).unwrap());
        }
        woken
    };
    assert_eq!(asleep(layers([1], [1, 2])), 0);
    assert!(asleep(Layers::default()) > 5);
}

#[test]
fn a_restored_run_keeps_its_layers() {
    let starts: [fn(&Scene) -> Simulation; 2] = [|scene| build_as(scene, Precision::F32, 2), on_gpu];
    let mut hashes = Vec::new();
    for start in starts {
        let mut whole = start(&crowd());
        run(&mut whole, 12);
        let snapshot = whole.snapshot();
        run(&mut whole, 12);
        let mut again = start(&crowd());
        again.restore(&snapshot).unwrap();
        run(&mut again, 12);
        assert_eq!(again.state_hash(), whole.state_hash());
        hashes.push(whole.state_hash());
    }
    assert_eq!(hashes[0], hashes[1], "on both backends");
}

#[test]
fn layers_that_separate_nothing_change_no_bit() {
    let mut scene = crowd();
    scene.bodies.iter_mut().for_each(|body| body.layers = Layers::default());
    scene.colliders.iter_mut().for_each(|collider| collider.layers = Layers::default());
    let mut same = scene.clone();
    same.bodies.iter_mut().for_each(|body| body.layers = layers([7, 9], [7]));
    same.colliders.iter_mut().for_each(|collider| collider.layers = layers([7, 31], [9]));
    for start in [|scene: &Scene| build_as(scene, Precision::F32, 2), on_gpu] {
        let [mut scene, mut same] = [&scene, &same].map(start);
        run(&mut scene, 10);
        run(&mut same, 10);
        assert_eq!(scene.state_hash(), same.state_hash());
    }
}
