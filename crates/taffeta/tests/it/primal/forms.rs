//! The forms by nodes and by springs: where they are one, and where they part.

use super::{accurate, chain, newton, with};
use crate::common::compare::cloth;
use crate::common::state::{noise, set, state};
use crate::common::{build, dot, farthest, near, norm, positions, run, scene_error, sub, turned, weightless};
use taffeta::scene::{ConstraintForm, Ice, Keyframe, Method, Scene, Select};

/// The same by springs.
fn dual() -> Ice {
    Ice { form: ConstraintForm::Compliant, ..accurate(1) }
}

#[test]
fn what_moves_along_a_line_moves_alike_by_nodes_and_by_springs() {
    // Nothing goes across, so what springs resist there does not show, however long they get.
    let pull = vec![Keyframe::translate(0.3, [0.0, -0.2, 0.0])];
    let mut body =
        chain(20, 2.0, 0.05, [700.0, 0.3]).pin(Select::nodes([0])).pin_moving(Select::nodes([12]), pull);
    body.place = turned([0.0, 0.0, 1.0], -90.0, [0.0; 3]);
    let scene = Scene::new("line").time(0.01, 0.01).body(body);
    let places = |ice: Ice| {
        let (mut simulation, mut random) = (build(&with(scene.clone(), ice)), noise(2));
        let (mut x, mut v) = state(&simulation);
        for n in (1..21).filter(|&n| n != 12) {
            (x[n][0], x[n][1], x[n][2]) = (0.0, x[n][1] + 0.04 * random(), 0.0);
            v[n][1] = random();
        }
        (x[0][0], x[12][0]) = (0.0, 0.0);
        set(&mut simulation, &x, &v);
        run(&mut simulation, 50);
        assert!(simulation.report().max_stretch > 1.1, "{}", simulation.report().max_stretch);
        positions(&simulation)
    };
    let by_springs = places(dual());
    for newton_steps in [1, 2, 3] {
        let apart = farthest(&places(accurate(newton_steps)), &by_springs);
        assert!(apart < 1e-10, "{newton_steps}: {apart:e} m");
    }
}

/// Where a sheet that swings is after a quarter of a second, in steps of `h` [s].
fn swung(h: f64, change: impl Fn(&mut Scene)) -> Vec<[f64; 3]> {
    let mut scene = Scene::new("swing").time(0.25, h).body(cloth(5, 6, [0.5, 0.4]).pin(Select::rows(0, 0)));
    change(&mut scene);
    let mut simulation = build(&scene);
    simulation.disturb(0.005, 3);
    run(&mut simulation, 1);
    positions(&simulation)
}

#[test]
fn both_forms_come_to_explicit_springs_at_first_order_in_the_step() {
    let truth = swung(2.5e-6, |scene| scene.solver.method = Method::Springs);
    let off = |ice: &Ice, h| farthest(&truth, &swung(h, |scene| *scene = with(scene.clone(), ice.clone())));
    for ice in [accurate(1), accurate(2), dual()] {
        let [coarse, fine, finest] = [5e-4, 2.5e-4, 1.25e-4].map(|h| off(&ice, h));
        assert!(finest < 0.01 && coarse > 1e-4, "{ice:?}: {coarse:e} {fine:e} {finest:e} m");
        near("order", (coarse / fine).log2(), 1.0, 0.1);
        near("order", (fine / finest).log2(), 1.0, 0.1);
    }
}

/// Two nodes of 0.1 kg that turn about each other with `rate` [rad/s], stretched as that takes; then the rate after each
/// of some steps of `h` [s].
fn turning(k: f64, rate: f64, h: f64, ice: Ice, steps: usize) -> Vec<f64> {
    let mut pair = build(&with(weightless("pair", h, h).body(chain(1, 1.0, 0.1, [k, 0.0])), ice));
    // k (l − L) = m ω² l/2.
    let length = k / (k - 0.05 * rate * rate);
    let (x, v) = (0.5 * length, 0.5 * length * rate);
    set(&mut pair, &[[-x, 0.0, 0.0], [x, 0.0, 0.0]], &[[0.0, 0.0, v], [0.0, 0.0, -v]]);
    let mut rates = Vec::new();
    for _ in 0..steps {
        run(&mut pair, 1);
        let report = pair.report();
        assert!(norm(report.momentum) < 1e-14);
        let x = positions(&pair);
        let apart = sub(x[1], x[0]);
        rates.push(report.angular_momentum[1] / (0.05 * dot(apart, apart)));
    }
    rates
}

#[test]
fn what_spins_slows_down_as_backward_euler_has_it() {
    // A stiff pair loses the share h² ω² of its angular momentum in a step: 1/ω² = 1/ω₀² + 2 h t.
    let rate = 3.0;
    for newton_steps in [1, 2, 3] {
        for h in [0.01, 0.005] {
            let rates = turning(1e6, rate, h, accurate(newton_steps), 200);
            let expected = (1.0 / (rate * rate) + 2.0 * h * h * 200.0).sqrt().recip();
            near("rate", rates[199], expected, 0.01 * expected);
        }
    }
    // By springs, pulls have no moment.
    let kept = turning(1e6, rate, 0.01, dual(), 200);
    near("angular momentum by springs", kept[199] / kept[0], 1.0, 0.01);
}

#[test]
fn settings_of_the_form_are_refused_by_their_names() {
    let refused = |ice: Ice, method: Method| {
        let mut scene = with(Scene::new("").body(cloth(3, 3, [1.0, 1.0])), ice);
        scene.solver.method = method;
        scene_error(taffeta::Simulation::new(&scene, &taffeta::Options::default())).path
    };
    assert_eq!(refused(newton(101), Method::Ice), "solver.ice.newton_steps");
    assert_eq!(refused(Ice { epsilon: 0.1, ..newton(1) }, Method::Ice), "solver.ice.epsilon");
    assert_eq!(refused(Ice { order: 3, ..newton(1) }, Method::Ice), "solver.ice.order");
    assert_eq!(refused(Ice { order: 2, ..newton(1) }, Method::Acad), "solver.ice.order");
    let by_springs = Ice { form: ConstraintForm::Compliant, ..newton(2) };
    assert_eq!(refused(by_springs, Method::Ice), "solver.ice.newton_steps");
    let mut adaptive = with(Scene::new("").body(cloth(3, 3, [1.0, 1.0])), Ice::default());
    (adaptive.solver.method, adaptive.solver.acad.form) = (Method::Acad, ConstraintForm::Primal);
    let error = scene_error(taffeta::Simulation::new(&adaptive, &taffeta::Options::default()));
    assert_eq!(error.path, "solver.acad.form");
}
