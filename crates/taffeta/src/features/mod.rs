//! All features: which of them a scene has, and in which order they act.

mod cpu;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "gpu")]
mod parity;
#[cfg(feature = "gpu")]
mod refusals;

use crate::build::Assembly;
use crate::step::Parts;
pub use cpu::on_cpu;
#[cfg(feature = "gpu")]
pub use gpu::{Tables, at_boundary, on_gpu, shaders};
#[cfg(feature = "gpu")]
pub use parity::rows;

/// What a scene has.
pub fn parts(assembly: &Assembly) -> Parts {
    Parts {
        elements: assembly.elements.iter().any(|list| !list.is_empty() && !list.implicit),
        solved: (0..assembly.bodies.len()).any(|body| assembly.is_solved_for(body)),
        volumes: assembly.volumes().next().is_some(),
        restored: assembly.volumes().any(|(_, kept)| kept.projects),
        attachments: !assembly.attachments.is_empty(),
        self_contact: assembly.self_colliding().next().is_some(),
    }
}
