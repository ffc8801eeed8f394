//! What hangs by constraints settles where springs would, whatever the step and however few iterations it gets.

use super::accurate;
use crate::common::settled;
use taffeta::scene::Ice;

/// Settings that must not matter.
fn ways() -> [(f64, Ice); 4] {
    let few = |max_iterations| Ice { max_iterations, ..accurate() };
    [(0.004, accurate()), (0.016, accurate()), (0.004, few(6)), (0.016, few(6))]
}

#[test]
fn each_link_of_a_hanging_chain_pulls_with_the_weight_below() {
    settled::chain_by_its_weight(&ways());
}

#[test]
fn a_sheet_that_hangs_by_two_corners_balances_as_springs_do() {
    settled::sheet_in_balance(&ways());
}
