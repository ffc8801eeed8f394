//! Elements: what acts between a few neighbouring nodes, or on a node alone.

pub mod aero;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hinge;
pub mod load;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod spring;

use crate::build::Assembly;
use crate::real::Real;
use aero::cpu::AirPanels;
use cpu::ElementSet;
use hinge::cpu::Hinges;

/// All kinds of elements of a scene whose forces are found one by one, in the order in which nodes add them up.
pub fn sets<T: Real>(assembly: &Assembly) -> Vec<Box<dyn ElementSet<T>>> {
    fn boxed<T: Real>(set: impl ElementSet<T>) -> Box<dyn ElementSet<T>> {
        Box::new(set)
    }
    [Hinges::new(assembly).map(boxed), AirPanels::new(assembly).map(boxed)].into_iter().flatten().collect()
}
