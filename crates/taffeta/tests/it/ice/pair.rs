//! Two nodes and one constraint, against what a step of it is by hand.

use super::{accurate, chain, set, state, with_ice};
use crate::common::{build, dot, near, norm, run, scale, sub, weightless};
use taffeta::Simulation;
use taffeta::scene::{ConstraintForm, Ice};

/// Two nodes of 0.1 kg joined by a constraint of 1 m, at a distance.
fn pair(apart: f64, h: f64, [k, d]: [f64; 2], ice: Ice) -> Simulation {
    let scene = weightless("pair", h, h).body(chain(1, 1.0, 0.1, [k, d]));
    let mut simulation = build(&with_ice(scene, ice));
    let along = scale([2.0, -1.0, 2.0], apart / 6.0);
    set(&mut simulation, &[scale(along, -1.0), along], &[[0.0; 3]; 2]);
    simulation
}

/// Distance [m] and its rate [m/s].
fn length(simulation: &Simulation) -> [f64; 2] {
    let (x, v) = state(simulation);
    let apart = sub(x[1], x[0]);
    [norm(apart), dot(apart, sub(v[1], v[0])) / norm(apart)]
}

#[test]
fn the_printed_form_goes_half_way_to_the_square_of_the_length() {
    // (l + L²/l)/2, whatever step and stiffness are: 1.01667 m from 1.2 m.
    for (apart, h, k) in [(1.2, 0.01, 5.0), (1.2, 0.1, 1e6), (0.9, 0.01, 5.0), (3.0, 0.001, 1.0)] {
        let mut pair = pair(apart, h, [k, 0.7], Ice { form: ConstraintForm::Printed, ..accurate() });
        run(&mut pair, 1);
        near("length", length(&pair)[0], 0.5 * (apart + 1.0 / apart), 1e-14);
        assert!(norm(pair.report().momentum) < 1e-15);
    }
}

#[test]
fn a_compliant_constraint_closes_the_gap_that_its_stiffness_leaves() {
    // From rest the gap shrinks by the share w/(w + D), for w of both ends and D = 1/(k h²) + ε w.
    let (h, w) = (0.01, 20.0);
    for apart in [1.2, 0.7] {
        for k in [1.0, 1e3, 1e6, 1e14] {
            for epsilon in [0.0, 0.3] {
                let mut pair = pair(apart, h, [k, 0.0], Ice { epsilon, ..accurate() });
                run(&mut pair, 1);
                let by = 1.0 / (k * h * h) + epsilon * w;
                near("length", length(&pair)[0], 1.0 + (apart - 1.0) * by / (w + by), 1e-14);
                assert!(norm(pair.report().momentum) < 1e-15);
            }
        }
    }
}

#[test]
fn stiffness_and_damping_act_as_backward_euler_has_them() {
    // u' = (u − w h k (l − L)) / (1 + w h (h k + d)), l' = l + h u'.
    let (h, w) = (0.01, 20.0);
    for k in [0.0, 100.0, 1e6] {
        for d in [0.0, 0.1, 10.0, 1e9] {
            let mut pair = pair(1.2, h, [k, d], accurate());
            let [mut l, mut u, mut energy] = [1.2, 0.0, f64::INFINITY];
            for step in 0..200 {
                if step == 3 {
                    // A knock, so that damping alone has something to do.
                    let (x, mut v) = state(&pair);
                    v[1] = scale(x[1], 1.0 / norm(x[1]));
                    u += dot(v[1], x[1]) / norm(x[1]) - dot(state(&pair).1[1], x[1]) / norm(x[1]);
                    set(&mut pair, &x, &v);
                    energy = f64::INFINITY;
                }
                run(&mut pair, 1);
                if k + d > 0.0 {
                    u = (u - w * h * k * (l - 1.0)) / (1.0 + w * h * (h * k + d));
                }
                l += h * u;
                let [length, rate] = length(&pair);
                near("length", length, l, 1e-11);
                near("rate", rate, u, 1e-10);
                let now = pair.report().energy();
                assert!(now <= energy * (1.0 + 1e-12), "k {k}, d {d}: {now} J after {energy} J");
                energy = now;
            }
        }
    }
}
