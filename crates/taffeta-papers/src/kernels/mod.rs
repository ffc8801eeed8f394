//! The kernels of the papers as they print them, to compare the engine's with: same scene, same formulas, their structure.

pub mod bench;
mod constraint;
mod node_centric;
mod parts;
mod spring_centric;
#[cfg(test)]
mod tests;
mod volume;

use constraint::{Constraints, MOST_PRINTED};
use node_centric::Sheets;
use parts::GROUP;
pub use parts::Product;
use spring_centric::SpringLists;
use std::sync::Arc;
use taffeta::extension::{
    Assembly, Bodies, BodyAssembly, BodySprings, Feature, Features, FrameSums, Fused, Loads, Op,
    ParticleKernels,
};
use taffeta::scene::{ConstraintForm, Method};
use taffeta::taffeta_gpu::{Bindable, Gpu, GpuError, Shader, shaders, wgpu};
use taffeta::{GpuOptions, Stage};

/// Their shaders; those of the engine are there as well.
const SHADERS: &[Shader] = shaders!(
    "papers",
    [
        "constraint/products.wgsl",
        "constraint/solve.wgsl",
        "constraint/sums.wgsl",
        "constraint/system.wgsl",
        "constraint/tables.wgsl",
        "kept.wgsl",
        "node_centric.wgsl",
        "spring_centric.wgsl",
        "springs.wgsl",
        "volume.wgsl"
    ]
);

/// Which kernels of the papers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaperKernels {
    /// As S1 prints it: a thread a node of a grid, 32 × 32 a group.
    NodeCentric,
    /// As S3 prints it: a thread a spring, forces added by compare and swap.
    SpringCentric,
    /// As S1 prints implicit constraints: eleven kernels, conjugate gradients.
    Constraints(Product),
}

impl PaperKernels {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::NodeCentric,
        Self::SpringCentric,
        Self::Constraints(Product::Printed),
        Self::Constraints(Product::Csr),
        Self::Constraints(Product::Ell),
        Self::Constraints(Product::MatrixFree),
    ];

    /// As the user calls them.
    pub fn name(self) -> &'static str {
        match self {
            Self::NodeCentric => "node-centric",
            Self::SpringCentric => "spring-centric",
            Self::Constraints(Product::Printed) => "printed",
            Self::Constraints(Product::Csr) => "csr",
            Self::Constraints(Product::Ell) => "ell",
            Self::Constraints(Product::MatrixFree) => "matrix-free",
        }
    }

    /// They, on a device.
    pub fn on(self, gpu: Gpu) -> GpuOptions {
        GpuOptions { particles: Some(Arc::new(self)), ..gpu.into() }
    }

    fn title(self) -> &'static str {
        match self {
            Self::NodeCentric => "the node-centric kernels of 2021",
            Self::SpringCentric => "the spring-centric kernels of 2023",
            Self::Constraints(_) => "the constraint kernels of 2021",
        }
    }
}

impl ParticleKernels for PaperKernels {
    fn shaders(&self) -> &'static [Shader] {
        SHADERS
    }

    fn check(&self, gpu: &Gpu, from: Stage, assembly: &Assembly) -> Result<(), String> {
        let which = self.title();
        if from != Stage::Elements {
            return Err(format!("{which} do whole sub-steps and cannot start at stage `{}`", from.name()));
        }
        fits(which, gpu.limits())?;
        let (most, beyond) = match *self {
            Self::NodeCentric => {
                ("are for grids with explicit springs, without hinges and loads", beyond_grids(assembly))
            }
            Self::SpringCentric => (
                "are for explicit springs, and keep volumes by forces alone, everywhere alike",
                beyond_forces(assembly),
            ),
            Self::Constraints(product) => {
                ("have springs alone as constraints", beyond_springs(assembly, product))
            }
        };
        let of_mesh = || {
            let index = assembly.colliders().iter().position(|collider| collider.mesh().is_some())?;
            Some(format!("collider[{index}] is a mesh"))
        };
        beyond
            .or_else(of_mesh)
            .map_or(Ok(()), |what| Err(format!("{which} {most}, and {what}; the engine's kernels would do")))
    }

    fn feature(&self, gpu: &Gpu, bodies: &Bodies<'_>) -> Result<Box<dyn Feature>, GpuError> {
        let kernels = match *self {
            Self::NodeCentric => Printed::NodeCentric(Sheets::new(gpu, bodies)?),
            Self::SpringCentric => Printed::SpringCentric(Box::new(SpringLists::new(gpu, bodies)?)),
            Self::Constraints(product) => {
                Printed::Constraints(Box::new(Constraints::new(gpu, product, bodies)?))
            }
        };
        Ok(Box::new(Paper { kernels, groups: bodies.len().div_ceil(GROUP) }))
    }
}

/// What a scene has that the springs of both papers have not.
fn beyond_explicit(assembly: &Assembly) -> Option<String> {
    let implicit = assembly.solver.method != Method::Springs;
    implicit.then(|| "the scene is solved by the method \"ice\" or \"acad\"".to_owned())
}

/// What a scene has that the volume constraint of 2023 has not.
fn beyond_forces(assembly: &Assembly) -> Option<String> {
    let beyond = assembly.volumes().find_map(|(body, kept)| match &kept.weights {
        Some(_) => Some(format!("body `{}` has weights", body.name)),
        None => kept.projects.then(|| format!("body `{}` is projected", body.name)),
    });
    beyond.or_else(|| beyond_explicit(assembly))
}

/// What a scene has that the constraints of 2021 have not.
fn beyond_springs(assembly: &Assembly, product: Product) -> Option<String> {
    let kept = assembly.volumes().next().map(|(body, _)| format!("body `{}` keeps its volume", body.name));
    let count = assembly.constraints().len();
    let many = product == Product::Printed && count > MOST_PRINTED;
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
    let other =
        other.then(|| "the scene is not solved by the method \"ice\" in its form \"printed\"".to_owned());
    other.or(kept).or_else(|| many.then(square))
}

fn fits(which: &str, limits: &wgpu::Limits) -> Result<(), String> {
    let most = limits.max_compute_invocations_per_workgroup.min(limits.max_compute_workgroup_size_x);
    if (most as usize) < GROUP {
        return Err(format!(
            "{which} take workgroups of {GROUP} invocations, and this GPU allows {most}; the engine's kernels would do"
        ));
    }
    Ok(())
}

/// What a scene has that the method of 2021 has not.
fn beyond_grids(assembly: &Assembly) -> Option<String> {
    let of_body = |(index, body): (usize, &BodyAssembly)| match &body.springs {
        BodySprings::Mesh(_) => Some(format!("body `{}` is a mesh", body.name)),
        BodySprings::Grid(_) => {
            let elements = assembly.elements().iter().find(|list| !list.bodies[index].is_empty())?;
            Some(format!("body `{}` has {}", body.name, elements.kind.name.replace('_', " ")))
        }
    };
    let loads = (!assembly.loads().is_empty()).then(|| "the scene has loads".to_owned());
    assembly.bodies.iter().enumerate().find_map(of_body).or(loads).or_else(|| beyond_explicit(assembly))
}

/// What the kernels of a paper work on beside the state.
enum Printed {
    NodeCentric(Sheets),
    SpringCentric(Box<SpringLists>),
    Constraints(Box<Constraints>),
}

/// A paper's kernels, which do what all others do from forces to contact.
struct Paper {
    kernels: Printed,
    /// Workgroups for an invocation a place.
    groups: usize,
}

/// What they carry out, beside loads that are summed up before where there are some.
fn operations(given: bool) -> &'static [Op] {
    const ALL: &[Op] = &[Op::Loads, Op::Springs, Op::Integrate, Op::Contact];
    if given { &ALL[1..] } else { ALL }
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
        let (label, commands) = match &self.kernels {
            Printed::NodeCentric(sheets) => ("springs", sheets.commands(given)),
            Printed::SpringCentric(lists) => ("springs", lists.commands(self.groups, given)),
            Printed::Constraints(constraints) => ("system", constraints.commands(given)),
        };
        vec![Fused::new(operations(given), commands).named(label)]
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        match &self.kernels {
            Printed::Constraints(constraints) => constraints.report(gpu, &mut sums.solver),
            Printed::NodeCentric(_) | Printed::SpringCentric(_) => Ok(()),
        }
    }
}
