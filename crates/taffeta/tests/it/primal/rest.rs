//! What hangs settles where springs would, whatever the step, the number of Newton steps, and however few iterations.

use super::{accurate, chain};
use crate::common::settled::{self, G, settle};
use crate::common::{farthest, near, positions, turned};
use taffeta::scene::{Body, Ice, Keyframe, Mass, Mesh, Select};

/// Settings that must not matter.
fn ways() -> [(f64, Ice); 4] {
    let few = |newton_steps| Ice { max_iterations: 3, ..accurate(newton_steps) };
    [(0.004, accurate(1)), (0.016, accurate(2)), (0.004, few(1)), (0.016, few(1))]
}

#[test]
fn each_link_of_a_hanging_chain_pulls_with_the_weight_below() {
    settled::chain_by_its_weight(&ways());
}

#[test]
fn a_sheet_that_hangs_by_two_corners_balances_as_springs_do() {
    settled::sheet_in_balance(&ways());
}

#[test]
fn a_sheet_of_structural_springs_hangs_as_long_as_its_weight_makes_it_at_any_step() {
    // 34 rows at a step at which the form by springs is torn apart.
    let (mass, k) = (0.01, 1e5);
    let mut body = Body::cloth("sheet", Mesh::grid(34, 5, [4.0 / 33.0, 1.0])).with_mass(Mass::Node(mass));
    body = body.structural(k, 0.0).pin(Select::rows(0, 0));
    body.place = turned([1.0, 0.0, 0.0], 90.0, [0.0; 3]);
    for h in [0.004, 0.008, 0.016] {
        let x = positions(&settle(&body, h, accurate(1)));
        for (row, col) in (0..33).flat_map(|row| (0..5).map(move |col| (row, col))) {
            let stretch = x[5 * row + col][1] - x[5 * row + col + 5][1] - 1.0 / 33.0;
            near("pull", k * stretch, mass * G * (33.0 - row as f64), 1e-9);
        }
    }
}

/// Lowest point [m] below its ends, 0.8 m apart, of an elastic line of 1 m, 0.5 kg and a stiffness of 40 N.
fn sag() -> f64 {
    // Irvine, "Cable Structures", 1981, equations 2.24 and 2.25, with both ends at one height.
    let (weight, stiff, span) = (0.5 * G, 40.0, 0.8);
    let width = |pull: f64| pull / stiff + 2.0 * pull / weight * (weight / (2.0 * pull)).asinh();
    let [mut low, mut high] = [1e-6, 100.0];
    for _ in 0..200 {
        let pull = 0.5 * (low + high);
        *(if width(pull) < span { &mut low } else { &mut high }) = pull;
    }
    let pull: f64 = low;
    weight / (8.0 * stiff) + pull / weight * ((1.0 + (weight / (2.0 * pull)).powi(2)).sqrt() - 1.0)
}

#[test]
fn chains_of_more_and_more_links_come_to_the_elastic_catenary() {
    let off = [10_u32, 20, 40].map(|links| {
        let n = f64::from(links);
        let ends = vec![Keyframe::translate(0.2, [-0.2, 0.0, 0.0])];
        let body = chain(links, 1.0, 0.5 / n, [40.0 * n, 0.1]).pin(Select::nodes([0]));
        let body = body.pin_moving(Select::nodes([links]), ends);
        let x = positions(&settle(&body, 0.02, accurate(1)));
        near("span", x[links as usize][0] - x[0][0], 0.8, 1e-12);
        x[0][1] - x[links as usize / 2][1] - sag()
    });
    assert!(off[2].abs() < 1e-3, "{off:?}");
    // Masses at nodes are a sum by trapezoids: second order.
    near("order", (off[0] / off[1]).log2(), 2.0, 0.2);
    near("order", (off[1] / off[2]).log2(), 2.0, 0.2);
}

#[test]
fn newton_steps_change_nothing_at_rest() {
    let mut body = chain(30, 1.0, 0.01, [500.0, 0.1]).pin(Select::nodes([0, 30]));
    body.place = turned([0.0, 0.0, 1.0], 10.0, [0.0; 3]);
    let [one, three] = [1, 3].map(|steps| positions(&settle(&body, 0.016, accurate(steps))));
    let apart = farthest(&one, &three);
    assert!(apart < 1e-9, "{apart:e} m");
}
