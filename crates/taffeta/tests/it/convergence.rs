//! Results converge with the step, and 32 bits stay near 64.

use crate::common::{V, build, build_as, farthest, positions, run, turned};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Scene, Select};

fn flag() -> Body {
    let mut body = Body::cloth("flag", Mesh::grid(6, 8, [0.7, 0.5]))
        .with_mass(Mass::Node(0.02))
        .structural(40.0, 0.02)
        .shear(20.0, 0.01)
        .bend(10.0, 0.01)
        .hinge(2e-3, 1e-5);
    body.place = turned([1.0, 0.2, 0.1], 70.0, [0.0; 3]);
    body.pin_moving(
        Select::nodes([0, 7]),
        vec![Keyframe::rotate(0.2, [0.0, 1.0, 0.0], 40.0, [0.1, 0.0, 0.0])],
    )
}

fn ball() -> Body {
    Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 1 }))
        .with_mass(Mass::Node(0.02))
        .structural(40.0, 0.02)
        .bend(20.0, 0.01)
        .pin(Select::nodes([0]))
}

fn after_a_fifth_second(body: Body, step: f64) -> Vec<V> {
    let mut scene = Scene::new("converge").time(0.05, step).body(body);
    scene.world.drag = 0.01;
    let mut simulation = build(&scene);
    simulation.disturb(0.01, 5);
    run(&mut simulation, 4);
    positions(&simulation)
}

#[test]
fn halving_the_step_halves_the_error() {
    for body in [flag(), ball()] {
        let exact = after_a_fifth_second(body.clone(), 1e-3 / 512.0);
        let errors: Vec<f64> = [1.0, 2.0, 4.0, 8.0]
            .map(|n| farthest(&after_a_fifth_second(body.clone(), 1e-3 / n), &exact))
            .to_vec();
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((0.9..1.1).contains(&order), "{}: order {order}, errors {errors:?}", body.name);
        }
    }
}

#[test]
fn a_chain_converges_on_the_string_with_its_number_of_links() {
    // A string of 1 m that hangs straight stretches by M g/(2 K) = 0.1 m where the whole has K = k/links; a chain of
    // n links of mass M/n, the held node aside, by 0.1 (1 + 1/n).
    for links in [5, 10, 20, 40] {
        let n = f64::from(links);
        let mut body = Body::cloth("chain", Mesh::chain(links, 1.0)).with_mass(Mass::Node(0.2 / n));
        body.place = turned([0.0, 0.0, 1.0], -90.0, [0.0, -0.5, 0.0]);
        body = body.structural(9.81 * n, 0.02).pin(Select::nodes([0]));
        let mut scene = Scene::new("string").time(0.5, 5e-4).body(body);
        scene.world.drag = 2.0 / n;
        let mut simulation = build(&scene);
        run(&mut simulation, 30);
        let end = positions(&simulation)[links as usize][1];
        crate::common::near("end", end, -1.0 - 0.1 * (1.0 + 1.0 / n), 1e-9);
    }
}

#[test]
fn in_32_bits_positions_are_those_of_64_within_a_ten_thousandth_of_the_size() {
    let slope = Collider::plane([0.0, -0.3, 0.0], [0.2, 1.0, 0.1]).friction(0.3);
    for body in [flag(), ball()] {
        let mut scene = Scene::new("precision").time(0.01, 1e-3).body(body.clone()).collider(slope.clone());
        scene.world.drag = 0.01;
        let [a, b] = [Precision::F32, Precision::F64].map(|precision| {
            let mut simulation = build_as(&scene, precision, 1);
            run(&mut simulation, 50);
            (positions(&simulation), simulation.report().clone())
        });
        let apart = farthest(&a.0, &b.0);
        assert!(apart > 0.0 && apart < 7e-5, "{}: {apart:e} m", body.name);
        crate::common::near("energy", a.1.energy(), b.1.energy(), 1e-4 * b.1.energy().abs());
        assert_eq!(a.1.contacts, b.1.contacts);
    }
}
