//! The kernels of the papers as they print them, to compare ours with: same scene, same formulas, their structure.

mod constraint;
mod node_centric;
mod spring_centric;
#[cfg(test)]
mod tests;
mod volume;

use crate::build::Assembly;
use crate::build::body::{BodyAssembly, BodySprings};
use crate::diagnostics::SolverReport;
use crate::gpu::kernels::Name;
use crate::gpu::options::{GpuKernels, GpuOptions};
use crate::gpu::recorder::Recorder;
use crate::gpu::tables::Tables;
use crate::scene::{ConstraintForm, Method};
use crate::step::Stage;
pub use constraint::ConstraintProduct;
use constraint::{Constraints, MOST_PRINTED};
use node_centric::{Plane, Sheets};
use spring_centric::SpringLists;
use std::ops::Range;
use taffeta_gpu::{Bindable, Gpu, GpuError, wgpu};

/// Invocations of each workgroup, in both papers.
const GROUP: usize = 1024;

/// What the kernels of a paper work on beside the state.
pub enum Paper {
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

impl Paper {
    /// What the chosen kernels need for the bodies of a segment; `None` where they are ours.
    pub fn new(
        gpu: &Gpu,
        kernels: GpuKernels,
        assembly: &Assembly,
        bodies: Range<usize>,
        tables: &Tables,
    ) -> Result<Option<Self>, GpuError> {
        Ok(match kernels {
            GpuKernels::NodeCentric => Some(Self::NodeCentric(Sheets::new(gpu, tables)?)),
            GpuKernels::SpringCentric => {
                Some(Self::SpringCentric(Box::new(SpringLists::new(gpu, &assembly.bodies[bodies], tables)?)))
            }
            GpuKernels::Constraints(product) => {
                let constraints = Constraints::new(gpu, product, assembly, bodies, tables)?;
                Some(Self::Constraints(Box::new(constraints)))
            }
            _ => None,
        })
    }

    /// Adds what it found of constraints.
    pub fn report(&self, gpu: &Gpu, report: &mut SolverReport) -> Result<(), GpuError> {
        match self {
            Self::Constraints(constraints) => constraints.report(gpu, report),
            Self::NodeCentric(_) | Self::SpringCentric(_) => Ok(()),
        }
    }

    /// Its buffers by their names in the sources.
    pub fn buffers(&self) -> Vec<(&'static str, &dyn Bindable)> {
        match self {
            Self::NodeCentric(sheets) => sheets.buffers(),
            Self::SpringCentric(lists) => lists.buffers(),
            Self::Constraints(constraints) => constraints.buffers(),
        }
    }
}

impl Recorder<'_> {
    /// All particle stages by a paper's kernels. Loads that are summed up over elements come before, and moving pins
    /// after, as with our own.
    pub fn as_printed(&mut self, substep: usize) {
        let loads_given = self.loads_given();
        if loads_given {
            self.alone(Stage::Loads, substep);
        }
        match &self.segment.paper {
            Some(Paper::NodeCentric(sheets)) => {
                let planes = sheets.planes.clone();
                self.node_centric(&planes, substep, loads_given);
            }
            Some(Paper::SpringCentric(lists)) => self.spring_centric(lists.counts(), substep, loads_given),
            Some(Paper::Constraints(constraints)) => {
                self.constraints(constraints.shape(), substep, loads_given)
            }
            None => {}
        }
        self.alone(Stage::Pins, substep);
    }

    fn node_centric(&mut self, planes: &[Plane], substep: usize, loads_given: bool) {
        self.list.stage("springs");
        self.over_planes(Name::new("node_centric_forces"), planes, substep);
        self.go_on_in_place();
        self.over_planes(Name { loads_given, ..Name::new("node_centric_update") }, planes, substep);
    }

    fn spring_centric(&mut self, [springs, triangles]: [usize; 2], substep: usize, loads_given: bool) {
        let nodes = self.segment.tables.len();
        self.list.stage("springs");
        self.dispatch_kernel(Name::new("spring_centric_forces"), substep, springs.div_ceil(GROUP));
        if triangles > 0 {
            self.list.stage("volumes");
            self.dispatch_kernel(Name::new("compute_volume"), substep, triangles.div_ceil(GROUP));
            let build = Name { loads_given, ..Name::new("build_system") };
            for name in [Name::new("compute_jacobian"), build, Name::new("accumulate_force")] {
                self.dispatch_kernel(name, substep, nodes.div_ceil(GROUP));
            }
        }
        self.go_on_in_place();
        let update = Name { loads_given, ..Name::new("spring_centric_update") };
        self.dispatch_kernel(update, substep, nodes.div_ceil(GROUP));
    }

    /// What the next kernels write is the state that those before have read.
    fn go_on_in_place(&mut self) {
        self.segment.current = 1 - self.segment.current;
        self.list.stage("integrate");
    }

    /// One dispatch for each grid.
    fn over_planes(&mut self, name: Name, planes: &[Plane], substep: usize) {
        if self.fault.is_err() {
            return;
        }
        match self.segment.bound(self.kernels, (name, 0), substep) {
            Ok((bound, told)) => planes.iter().for_each(|plane| {
                let offsets = [&told[..], &[plane.offset]].concat();
                self.list.dispatch_plane(&bound, &offsets, plane.groups);
            }),
            Err(error) => self.fault = Err(error),
        }
    }

    /// One dispatch of a plane of workgroups.
    fn over_plane(&mut self, name: Name, groups: [u32; 2], substep: usize) {
        if self.fault.is_err() {
            return;
        }
        match self.segment.bound(self.kernels, (name, 0), substep) {
            Ok((bound, told)) => self.list.dispatch_plane(&bound, &told, groups),
            Err(error) => self.fault = Err(error),
        }
    }
}
