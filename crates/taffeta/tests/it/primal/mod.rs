//! Springs that are solved at once by nodes: Newton's steps of backward Euler.

mod bits;
mod contact;
mod elements;
mod energy;
mod forms;
mod iterations;
mod momentum;
mod newton;
mod oracle;
mod reference;
mod rest;
mod second_order;
pub mod sewn;
mod sheet;

use crate::common::alike::{chain, with_ice as with};
use crate::common::state::{any, noise};
use taffeta::scene::{ConstraintForm, Ice};

/// Settings of the primal form with a number of Newton steps.
fn newton(newton_steps: u32) -> Ice {
    Ice { form: ConstraintForm::Primal, newton_steps, ..Ice::default() }
}

/// Iterates until nothing is left but roundings.
fn accurate(newton_steps: u32) -> Ice {
    Ice { tolerance: 1e-13, max_iterations: 20_000, ..newton(newton_steps) }
}
