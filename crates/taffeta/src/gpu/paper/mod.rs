//! The kernels of the papers as they print them, to compare ours with: same scene, same formulas, their structure.

mod constraint;
mod node_centric;
mod spring_centric;
#[cfg(test)]
mod tests;
mod volume;

use crate::build::Assembly;
use crate::build::body::{BodyAssembly, BodySprings};
use crate::diagnostics::FrameSums;
use crate::elements::load::gpu::Loads;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Grid, Solving, Substep};
use crate::gpu::options::{GpuKernels, GpuOptions};
use crate::gpu::schedule::Fused;
use crate::scene::{ConstraintForm, Method};
use crate::step::{Op, Stage};
pub use constraint::ConstraintProduct;
use constraint::{Constraints, MOST_PRINTED};
use node_centric::Sheets;
use spring_centric::SpringLists;
use taffeta_gpu::{Bindable, Gpu, GpuError, wgpu};

/// Invocations of each workgroup, in both papers.
const GROUP: usize = 1024;

/// What the kernels of a paper work on beside the state.
enum Printed {
    NodeCentric(Sheets),
    SpringCentric(Box<SpringLists>),
    Constraints(Box<Constraints>),
}

/// The file that has an entry point, if it is one of these.
pub fn sources(entry: &str) -> &'static [&'static str] {
    match entry {
        "node_centric_forces" | "node_centric_update" => &[include_str!("node_centric.wgsl")],
        "spring_centric_forces"
        | "spring_centric_update"
        | "compute_volume"
        | "compute_jacobian"
        | "build_system"
        | "accumulate_force" => &[include_str!("spring_centric.wgsl"), include_str!("volume.wgsl")],
        _ => constraint::sources(entry),
    }
}

/// Says why a paper's kernels, if they are asked for, cannot run a scene on a device.
pub fn check(options: &GpuOptions, assembly: &Assembly) -> Result<(), String> {
    let which = match options.kernels {
        GpuKernels::NodeCentric => "the node-centric kernels of 2021",
        GpuKernels::SpringCentric => "the spring-centric kernels of 2023",
        GpuKernels::Constraints(_) => "the constraint kernels of 2021",
        _ => return Ok(()),
    };
    if options.from != Stage::Elements {
        return Err(format!(
            "{which} do whole sub-steps and cannot start at stage `{}`",
            options.from.name()
        ));
    }
    fits(which, options.gpu.limits())?;
    let (most, beyond) = match options.kernels {
        GpuKernels::NodeCentric => ("are for grids without hinges and loads", beyond_grids(assembly)),
        GpuKernels::Constraints(product) => {
            ("have springs alone as constraints", beyond_springs(assembly, product))
        }
        _ => ("keep volumes by forces alone, everywhere alike", beyond_forces(assembly)),
    };
    let of_mesh = || {
        let index = assembly.colliders.iter().position(|collider| collider.mesh().is_some())?;
        Some(format!("collider[{index}] is a mesh"))
    };
    beyond
        .or_else(of_mesh)
        .map_or(Ok(()), |what| Err(format!("{which} {most}, and {what}; the plain kernels would do")))
}

/// What a scene has that the volume constraint of 2023 has not.
fn beyond_forces(assembly: &Assembly) -> Option<String> {
    assembly.volumes().find_map(|(body, kept)| match &kept.weights {
        Some(_) => Some(format!("body `{}` has weights", body.name)),
        None => kept.projects.then(|| format!("body `{}` is projected", body.name)),
    })
}

/// What a scene has that the constraints of 2021 have not.
fn beyond_springs(assembly: &Assembly, product: ConstraintProduct) -> Option<String> {
    let kept = assembly.volumes().next().map(|(body, _)| format!("body `{}` keeps its volume", body.name));
    let count = assembly.constraints.len();
    let many = product == ConstraintProduct::Printed && count > MOST_PRINTED;
    let square = || {
        format!(
            "the scene has {count} springs: SpMM() starts a thread for each two, {} in each step, and {MOST_PRINTED} \
             springs ({} threads) are the limit",
            count * count,
            MOST_PRINTED * MOST_PRINTED
        )
    };
    let solver = &assembly.solver;
    let other = solver.method != Method::Ice || solver.ice.form != ConstraintForm::Printed;
    let other = other.then(|| {
        "the scene has not `solver.method = \"ice\"` with `solver.ice.form = \"printed\"`".to_owned()
    });
    other.or(kept).or_else(|| many.then(square))
}

fn fits(which: &str, limits: &wgpu::Limits) -> Result<(), String> {
    let most = limits.max_compute_invocations_per_workgroup.min(limits.max_compute_workgroup_size_x);
    if (most as usize) < GROUP {
        return Err(format!(
            "{which} take workgroups of {GROUP} invocations, and this GPU allows {most}; the plain kernels would do"
        ));
    }
    Ok(())
}

/// What a scene has that the method of 2021 has not.
fn beyond_grids(assembly: &Assembly) -> Option<String> {
    let of_body = |body: &BodyAssembly| match &body.springs {
        BodySprings::Mesh(_) => Some(format!("body `{}` is a mesh", body.name)),
        BodySprings::Grid(_) if !body.hinges.is_empty() => Some(format!("body `{}` has hinges", body.name)),
        BodySprings::Grid(_) => None,
    };
    let loads = (!assembly.loads.is_empty()).then(|| "the scene has loads".to_owned());
    assembly.bodies.iter().find_map(of_body).or(loads).or_else(|| beyond_still(assembly))
}

/// Air, which none of the papers has.
fn beyond_still(assembly: &Assembly) -> Option<String> {
    (assembly.panels.len() > 0).then(|| "the scene has air".to_owned())
}

/// The chosen kernels for some bodies, if they are a paper's.
pub fn feature(
    gpu: &Gpu,
    kernels: GpuKernels,
    bodies: &Bodies<'_>,
    grids: &[Grid],
) -> Result<Option<Box<dyn Feature>>, GpuError> {
    let kernels = match kernels {
        GpuKernels::NodeCentric => Printed::NodeCentric(Sheets::new(gpu, grids, bodies.len())?),
        GpuKernels::SpringCentric => Printed::SpringCentric(Box::new(SpringLists::new(gpu, bodies)?)),
        GpuKernels::Constraints(product) => {
            Printed::Constraints(Box::new(Constraints::new(gpu, product, bodies)?))
        }
        _ => return Ok(None),
    };
    let groups = bodies.len().div_ceil(GROUP);
    Ok(Some(Box::new(Paper { kernels, groups, solving: Solving::of(&bodies.assembly.solver) })))
}

/// A paper's kernels, which do what all others do from forces to contact.
pub struct Paper {
    kernels: Printed,
    /// Workgroups for an invocation a place.
    groups: usize,
    solving: Solving,
}

impl Feature for Paper {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        match &self.kernels {
            Printed::NodeCentric(sheets) => sheets.buffers(),
            Printed::SpringCentric(lists) => lists.buffers(),
            Printed::Constraints(constraints) => constraints.buffers(),
        }
    }

    /// Loads that are summed up over elements come before, and moving pins after, as with our own.
    fn kernels<'f>(&'f self, features: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let given = features.get::<Loads>().is_some_and(|loads| loads.are_given(features));
        let all = [Op::Loads, Op::Springs, Op::Integrate, Op::Contact];
        let operations = if given { &all[1..] } else { &all };
        let (label, commands) = match &self.kernels {
            Printed::NodeCentric(sheets) => ("springs", sheets.commands(given)),
            Printed::SpringCentric(lists) => ("springs", lists.commands(self.groups, given)),
            Printed::Constraints(constraints) => ("system", constraints.commands(given)),
        };
        vec![Fused::new(operations, commands).named(label)]
    }

    fn upload(&mut self, _: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        records.iter_mut().for_each(|record| record.solving = self.solving);
        Ok(false)
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        match &self.kernels {
            Printed::Constraints(constraints) => constraints.report(gpu, &mut sums.solver),
            Printed::NodeCentric(_) | Printed::SpringCentric(_) => Ok(()),
        }
    }
}

/// A kernel that takes loads from where they were summed up, or finds them itself.
fn with_loads(entry: &'static str, loads_given: bool) -> Name {
    Name { loads_given, ..Name::new(entry) }
}

/// What the next kernels write is the state that those before have read.
fn go_on_in_place<'f>() -> [Command<'f>; 2] {
    [Command::SwapStates, Command::Label("integrate")]
}
