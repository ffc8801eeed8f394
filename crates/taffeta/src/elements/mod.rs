//! Elements: what acts between a few neighbouring nodes, or on a node alone.

pub mod aero;
pub mod cpu;
pub mod element;
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
use cpu::{ByElement, ElementSet};
use element::{Kind, List};
use hinge::hinge::Bending;

/// All kinds of elements whose forces are found one by one, in the order in which nodes add them up.
pub const KINDS: [&Kind; 2] = [&hinge::KIND, &aero::KIND];

/// The elements of a scene on the CPU, a set for each kind that it has.
pub fn sets<T: Real>(assembly: &Assembly) -> Vec<Box<dyn ElementSet<T>>> {
    let places = assembly.places;
    let set = |list: &List| -> Box<dyn ElementSet<T>> {
        match list.kind.name {
            hinge::NAME => Box::new(ByElement::<T, Bending, 4, 4>::new(list, places)),
            aero::NAME => Box::new(AirPanels::new(list, places)),
            other => unreachable!("`{other}` is not among the kinds of elements"),
        }
    };
    assembly.elements.iter().filter(|list| !list.is_empty()).map(set).collect()
}
