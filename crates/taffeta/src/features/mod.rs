//! All features: which of them a scene has, and in which order they act on the CPU; `gpu` has those of a GPU.

#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "gpu")]
mod refusals;

use crate::advice::Refusal;
use crate::attachments::cpu::Attachments;
use crate::build::Assembly;
use crate::contact::colliders::cpu::Colliders;
use crate::contact::nodes::cpu::NodeContact;
use crate::cpu::CpuBackend;
use crate::cpu::backend::Context;
use crate::cpu::feature::Feature;
use crate::diagnostics::cpu::Measures;
use crate::elements::load::cpu::Loads;
use crate::elements::sets::Elements;
use crate::elements::spring::cpu::Springs;
use crate::motion::cpu::Pins;
use crate::real::Real;
use crate::solvers::dual::cpu::Dual;
use crate::solvers::explicit::cpu::Euler;
use crate::solvers::implicit::cpu::Implicit;
use crate::step::Parts;
use crate::volume::cpu::Volumes;
#[cfg(feature = "gpu")]
pub use gpu::{Tables, at_boundary, on_gpu, rows, shaders};

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

/// A scene on the CPU.
pub fn on_cpu<T: Real>(assembly: Assembly, threads: usize) -> Result<CpuBackend<T>, Refusal> {
    let parts = parts(&assembly);
    Ok(CpuBackend::new(assembly, &parts, threads, of_cpu)?)
}

/// The features of a scene on the CPU.
fn of_cpu<T: Real>(context: &mut Context<'_, T>) -> Result<Vec<Box<dyn Feature<T>>>, String> {
    fn boxed<T: Real>(feature: impl Feature<T>) -> Option<Box<dyn Feature<T>>> {
        Some(Box::new(feature))
    }
    let springs = Springs::new(context)?;
    Ok([
        boxed(Loads::new(&context.assembly.loads, context.workers())),
        Elements::new(context).and_then(boxed),
        boxed(springs),
        boxed(Pins::new(&context.assembly.moving_pins)),
        boxed(Euler),
        boxed(Colliders::new(context)),
        Volumes::new(context).and_then(boxed),
        Implicit::new(context).and_then(boxed),
        Dual::new(context).and_then(boxed),
        Attachments::new(context).and_then(boxed),
        NodeContact::new(context).and_then(boxed),
        boxed(Measures::new(context)),
    ]
    .into_iter()
    .flatten()
    .collect())
}
