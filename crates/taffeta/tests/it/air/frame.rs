//! Air beside everything else that a frame does.

use super::{AIR, GUSTY, blown, loose};
use crate::common::alike::{SHAKEN, moving};
use crate::common::{build, build_as, positions, run};
use taffeta::Precision;
use taffeta::scene::{
    Air, Body, Collider, ConstraintForm, Gust, Ice, Mass, Mesh, Method, Scene, Select, Solver, VolumeForm,
};

/// Sheets, a ball that keeps its volume, a chain; with a method.
fn scene(method: Method, form: ConstraintForm) -> Scene {
    let [sheet, mut ball, chain, free] = moving();
    ball = ball.keep_volume(VolumeForm::Corrected);
    let mut scene = Scene::new("all").body(sheet).body(ball).body(chain).body(free);
    scene.solver = Solver { method, ice: Ice { form, ..Ice::default() }, ..Solver::default() };
    scene.world.air = Some(GUSTY);
    scene.collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0])).time(0.01, 0.0025)
}

#[test]
fn air_acts_with_every_method_and_the_bits_do_not_depend_on_threads() {
    for (method, form) in [
        (Method::Springs, ConstraintForm::Compliant),
        (Method::Ice, ConstraintForm::Compliant),
        (Method::Ice, ConstraintForm::Primal),
        (Method::Acad, ConstraintForm::Compliant),
    ] {
        let windy = scene(method, form);
        SHAKEN.with_any_threads(std::slice::from_ref(&windy), |report| report.contacts > 0);
        let mut calm = windy.clone();
        calm.world.air = None;
        let [a, b] = [windy, calm].map(|scene| {
            let mut simulation = build_as(&scene, Precision::F32, 2);
            run(&mut simulation, 3);
            positions(&simulation)
        });
        // The chain alone has no triangles.
        let (first, links) = (24 * 21 + 642, 301);
        let differ = a.iter().zip(&b).map(|(a, b)| a != b).collect::<Vec<_>>();
        assert!(differ[first..first + links].iter().all(|differ| !differ), "{method:?}");
        assert!(
            differ[..first].iter().chain(&differ[first + links..]).filter(|differ| **differ).count() > 1500
        );
    }
}

#[test]
fn a_body_without_triangles_feels_no_air() {
    for mesh in [Mesh::chain(9, 1.0), Mesh::grid(1, 9, [1.0, 0.0])] {
        let body = Body::cloth("line", mesh).with_mass(Mass::Node(0.01)).structural(10.0, 0.0);
        let mut simulation = build(&blown(body, AIR, 0.01));
        run(&mut simulation, 10);
        assert_eq!(simulation.report().kinetic, 0.0);
    }
}

#[test]
fn pinned_nodes_stay_and_the_others_go() {
    let body = loose(5, 6).structural(50.0, 0.1).shear(20.0, 0.1).pin(Select::cols(0, 0));
    let mut simulation = build(&blown(body, AIR, 1e-3));
    let before = positions(&simulation);
    run(&mut simulation, 200);
    for (node, (a, b)) in positions(&simulation).iter().zip(&before).enumerate() {
        assert_eq!(a == b, node % 6 == 0, "{node}");
    }
}

#[test]
fn the_step_may_change_where_gusts_are_met_by_little_alone() {
    let end = |h: f64| {
        let mut simulation = build(&blown(loose(3, 4).structural(20.0, 0.05).shear(9.0, 0.05), GUSTY, h));
        run(&mut simulation, (0.5 / h).round() as u32);
        positions(&simulation)
    };
    let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| crate::common::farthest(a, b);
    let (coarse, middle, fine) = (end(2e-3), end(1e-3), end(5e-4));
    let ratio = apart(&coarse, &middle) / apart(&middle, &fine);
    assert!((1.7..2.4).contains(&ratio), "{ratio}");
}

#[test]
fn gusts_go_by_speed_length_period_and_seed() {
    let end = |gust| {
        let mut simulation = build(&blown(loose(5, 6), Air { gust, ..AIR }, 0.01));
        run(&mut simulation, 10);
        simulation.state_hash()
    };
    let base = Gust { speed: 2.0, length: 0.3, period: 0.2, seed: 3 };
    let gusts = [
        base,
        Gust { speed: 2.1, ..base },
        Gust { length: 0.31, ..base },
        Gust { period: 0.21, ..base },
        Gust { seed: 4, ..base },
    ];
    let mut hashes: Vec<u64> = gusts.map(Some).map(end).to_vec();
    hashes.push(end(None));
    assert!((0..6).all(|i| (0..i).all(|j| hashes[i] != hashes[j])), "{hashes:?}");
    assert_eq!(end(Some(Gust { speed: 0.0, ..base })), end(None));
}
