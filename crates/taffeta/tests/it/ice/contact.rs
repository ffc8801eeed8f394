//! Constraints and surfaces.

use super::{accurate, state, with_acad, with_ice};
use crate::common::{build, dot, near, norm, positions, run, sub, turned};
use taffeta::scene::{Acad, Body, Collider, Ice, Mass, Mesh, Scene};

const G: f64 = 9.81;

fn sheet(n: u32, size: f64, k: f64) -> Body {
    let body = Body::cloth("sheet", Mesh::grid(n, n, [size, size])).with_mass(Mass::Node(0.15));
    body.structural(k, 0.1).shear(k, 0.1).bend(k, 0.1)
}

#[test]
fn no_node_is_inside_of_a_ball_or_below_a_floor_after_a_step() {
    let scene = |k| {
        Scene::new("drop")
            .time(0.016, 0.016)
            .body(sheet(20, 1.6, k).at([0.1, 0.55, 0.0]))
            .collider(Collider::sphere([0.0; 3], 0.5).offset(0.01).friction(0.3))
            .collider(Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]).offset(0.0).friction(0.3))
    };
    for scene in
        [with_ice(scene(2000.0), Ice::default()), with_acad(scene(150.0), Acad::default(), Ice::default())]
    {
        let mut simulation = build(&scene);
        let mut most = 0;
        for _ in 0..120 {
            run(&mut simulation, 1);
            for x in positions(&simulation) {
                let [from_ball, above_floor] = [norm(x) - 0.51, x[1] + 0.5];
                assert!(from_ball > -1e-14 && above_floor > -1e-14, "{from_ball:e} {above_floor:e}");
            }
            most = most.max(simulation.report().contacts);
        }
        assert!(most > 100, "{most}");
    }
}

/// The way [m] along a slope of 20° that the middle of a stiff sheet has slid after a second, and its speed [m/s].
fn slid(friction: f64, ice: Ice) -> [f64; 2] {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let (normal, down) = ([-sin, cos, 0.0], [-cos, -sin, 0.0]);
    let mut body = sheet(8, 0.7, 1e5);
    body.place = turned([0.0, 0.0, 1.0], 20.0, [0.0; 3]);
    let slope = Collider::plane([0.0; 3], normal).offset(0.0).friction(friction);
    let mut simulation =
        build(&with_ice(Scene::new("slope").time(0.01, 0.01).body(body).collider(slope), ice));
    let start = positions(&simulation);
    run(&mut simulation, 100);
    let (x, v) = state(&simulation);
    let mean = |along: Vec<f64>| along.iter().sum::<f64>() / along.len() as f64;
    assert!((simulation.report().max_stretch - 1.0).abs() < 1e-6, "nothing stretches it");
    let way = mean(x.iter().zip(&start).map(|(&x, &y)| dot(sub(x, y), down)).collect());
    [way, mean(v.iter().map(|&v| dot(v, down)).collect())]
}

#[test]
fn a_stiff_sheet_sticks_to_a_slope_or_slides_as_coulomb_has_it() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    for ice in [Ice::default(), accurate(), Ice { warm_start: false, ..Ice::default() }] {
        let [way, speed] = slid(0.5, ice.clone());
        near("it sticks", way, 0.0, 1e-9);
        near("and stands", speed, 0.0, 1e-9);
        let a = G * (sin - 0.2 * cos);
        let [way, speed] = slid(0.2, ice);
        near("speed", speed, a, 1e-9);
        // A step goes with the speed at its end.
        near("way", way, 0.5 * a * 1.01, 1e-9);
    }
}
