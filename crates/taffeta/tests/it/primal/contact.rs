//! Springs that are solved by nodes, and surfaces.

use super::{accurate, newton, with};
use crate::common::state::state;
use crate::common::{build, dot, near, norm, positions, run, sub, turned};
use taffeta::scene::{Body, Collider, Ice, Icosphere, Keyframe, Mass, Mesh, Scene, VolumeForm};

const G: f64 = 9.81;

fn sheet(n: u32, size: f64, k: f64) -> Body {
    let body = Body::cloth("sheet", Mesh::grid(n, n, [size, size])).with_mass(Mass::Node(0.15));
    body.structural(k, 0.1).shear(k, 0.1).bend(k, 0.1)
}

#[test]
fn no_node_is_inside_of_a_ball_or_below_a_floor_after_a_step() {
    for newton_steps in [1, 2] {
        let scene = Scene::new("drop")
            .time(0.016, 0.016)
            .body(sheet(20, 1.6, 2000.0).at([0.1, 0.55, 0.0]))
            .collider(Collider::sphere([0.0; 3], 0.5).offset(0.01).friction(0.3))
            .collider(Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]).offset(0.0).friction(0.3));
        let mut simulation = build(&with(scene, newton(newton_steps)));
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
    let mut simulation = build(&with(Scene::new("slope").time(0.01, 0.01).body(body).collider(slope), ice));
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
    for ice in [newton(1), newton(2), accurate(1), Ice { warm_start: false, ..accurate(1) }] {
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

/// A ball of 2 kg that keeps its volume, on a floor, pressed by a plate that comes down to `height` [m].
fn pressed(height: f64, ice: Ice) -> Scene {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
    let ball = Body::soft("ball", mesh).with_mass(Mass::Whole(2.0)).structural(3e3, 0.5);
    let ball = ball.keep_volume(VolumeForm::Corrected).at([0.0, 0.5, 0.0]);
    let rough = |collider: Collider| collider.offset(0.0).friction(0.4);
    let plate = rough(Collider::plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]));
    let down = Keyframe::translate(0.5, [0.0, height - 1.0, 0.0]);
    let scene = Scene::new("pressed").time(0.01, 0.005).body(ball);
    let scene = scene.collider(rough(Collider::plane([0.0; 3], [0.0, 1.0, 0.0])));
    with(scene.collider(plate.keyframe(down)), ice)
}

#[test]
fn a_ball_that_a_plate_presses_stays_between_them_and_keeps_its_volume() {
    for newton_steps in [1, 2] {
        let mut simulation = build(&pressed(0.7, newton(newton_steps)));
        for frame in 1..=100 {
            run(&mut simulation, 1);
            let top = 1.0 - 0.3 * (f64::from(frame) / 50.0).min(1.0);
            for x in positions(&simulation) {
                assert!(x[1] > -1e-14 && x[1] < top + 1e-12, "frame {frame}: {} m", x[1]);
            }
        }
        let report = simulation.report();
        let share = report.volumes[0].expect("closed") / report.volume_targets[0].expect("kept");
        near("volume", share, 1.0, 0.03);
        assert!(report.contacts > 20 && report.max_stretch < 1.5 && report.kinetic < 0.02, "{report:?}");
    }
}

#[test]
fn sheets_that_touch_each_other_stay_apart() {
    let lower = Body::cloth("lower", Mesh::grid(14, 14, [0.65, 0.65])).with_mass(Mass::Node(0.01));
    let stiff = |body: Body| body.structural(5e3, 0.05).shear(5e3, 0.05).bend(500.0, 0.0).collide_nodes(0.05);
    let upper = Body { name: "upper".into(), ..lower.clone() };
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(0.3);
    let scene = Scene::new("stack").time(0.01, 0.002);
    let scene = scene.body(stiff(lower).at([0.0, 0.05, 0.0])).body(stiff(upper).at([0.02, 0.16, 0.01]));
    let mut simulation = build(&with(scene.collider(floor), newton(1)));
    let mut pairs = 0;
    for _ in 0..100 {
        run(&mut simulation, 1);
        pairs = pairs.max(simulation.report().pairs);
    }
    let x = positions(&simulation);
    let lowest = x[196..].iter().map(|x| x[1]).fold(f64::MAX, f64::min);
    assert!(pairs > 50 && lowest > 0.03, "{pairs} pairs, {lowest} m");
}
