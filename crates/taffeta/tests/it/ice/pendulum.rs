//! A pendulum that one constraint as printed holds.

use super::{accurate, chain, state, with_ice};
use crate::common::{build, dot, near, norm, run};
use taffeta::Simulation;
use taffeta::scene::{ConstraintForm, Ice, Scene, Select};

/// A node on a constraint of 1 m, let go level with what holds it.
fn pendulum(h: f64) -> Simulation {
    let body = chain(1, 1.0, 0.3, [100.0, 0.0]).at([0.5, 0.0, 0.0]).pin(Select::nodes([0]));
    let scene = Scene::new("pendulum").time(h, h).body(body);
    build(&with_ice(scene, Ice { form: ConstraintForm::Printed, ..accurate() }))
}

#[test]
fn the_length_squared_exceeds_that_of_rest_by_the_square_of_a_steps_way() {
    let h = 0.01;
    let mut pendulum = pendulum(h);
    for _ in 0..500 {
        run(&mut pendulum, 1);
        let (x, v) = state(&pendulum);
        near("length squared", dot(x[1], x[1]), 1.0 + h * h * dot(v[1], v[1]), 1e-13);
    }
    assert!(norm(state(&pendulum).1[1]) > 0.1, "it swings");
}

/// Four times the time [s] from level to the lowest place.
fn period(h: f64) -> f64 {
    let mut pendulum = pendulum(h);
    let mut before = state(&pendulum);
    loop {
        run(&mut pendulum, 1);
        let (x, v) = state(&pendulum);
        if x[1][0] <= 0.0 {
            // Where the cubic through places and velocities at both ends of the step is zero.
            let [p, q, a, b] = [before.0[1][0], x[1][0], h * before.1[1][0], h * v[1][0]];
            let at = |s: f64| {
                let [s2, s3] = [s * s, s * s * s];
                p * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + a * (s3 - 2.0 * s2 + s)
                    + q * (3.0 * s2 - 2.0 * s3)
                    + b * (s3 - s2)
            };
            let [mut low, mut high] = [0.0, 1.0];
            for _ in 0..60 {
                let s = 0.5 * (low + high);
                *(if at(s) > 0.0 { &mut low } else { &mut high }) = s;
            }
            return 4.0 * (pendulum.report().time - h + low * h);
        }
        before = (x, v);
    }
}

#[test]
fn the_period_tends_to_that_of_a_pendulum_let_go_at_90_degrees_at_first_order() {
    // 2π √(L/g) times K(sin² 45°) · 2/π.
    let exact = 2.367_842;
    let [coarse, middle, fine] = [4e-3, 2e-3, 1e-3].map(period);
    let order = (coarse - exact) / (middle - exact);
    near("how much the error shrinks with half the step", order, 2.0, 0.1);
    // What is left of the first and second power of the step is taken out.
    near("period", (8.0 * fine - 6.0 * middle + coarse) / 3.0, exact, 1e-6);
}
