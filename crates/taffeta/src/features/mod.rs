//! All features: which of them a scene has, and in which order they act on either backend. A feature has its lines here and
//! nowhere else.

mod assemble;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "gpu")]
mod refusals;

use crate::advice::Refusal;
use crate::assembly::Assembly;
use crate::attachments;
use crate::contact::{colliders, nodes, triangles};
use crate::cpu::CpuBackend;
use crate::cpu::backend::Context;
use crate::cpu::feature::Feature;
use crate::cpu::team::Team;
use crate::diagnostics;
use crate::elements::{self, aero, load, membrane, spring};
use crate::motion;
use crate::plan::Substep;
use crate::real::Real;
use crate::solvers::{dual, explicit, implicit, xpbd};
use crate::step::Parts;
use crate::volume;
#[cfg(feature = "gpu")]
use crate::{
    contact::collider_mesh,
    elements::KINDS,
    gpu::feature as device,
    gpu::{bodies::Bodies, kernels, layout::Four, options::GpuOptions},
    motion::gpu_layout::Pin,
};
#[cfg(feature = "gpu")]
pub use gpu::{at_boundary, on_gpu};
#[cfg(feature = "gpu")]
use std::ops::Range;
#[cfg(feature = "gpu")]
use taffeta_gpu::{GpuError, Shaders};

/// What a scene has.
pub fn parts(assembly: &Assembly) -> Parts {
    Parts {
        elements: assembly.elements().iter().any(|list| !list.is_empty() && !list.implicit),
        solved: (0..assembly.bodies.len()).any(|body| assembly.is_solved_for(body)),
        positions: assembly.position_constraints().iter().any(Option::is_some),
        volumes: assembly.volumes().next().is_some(),
        restored: assembly.volumes().any(|(_, kept)| kept.projects),
        attachments: !assembly.attachments().is_empty(),
        self_contact: assembly.self_colliding().next().is_some(),
        surface_contact: assembly.surfaces().is_some(),
        held: !assembly.held().is_empty(),
    }
}

/// What features tell a sub-step.
pub fn parameters<T: Real>(assembly: &Assembly, span: [f64; 2], substep: &mut Substep<T>) {
    load::build::parameters(assembly, span, substep);
    aero::build::parameters(assembly, span, substep);
    motion::moving::parameters(assembly, span, substep);
    colliders::moving::parameters(assembly, span, substep);
    triangles::surfaces::parameters(assembly, span, substep);
    volume::constraint::parameters(assembly, span, substep);
    attachments::constraints::parameters(assembly, span, substep);
    implicit::scheme::parameters(assembly, span, substep);
    implicit::sewn::parameters(assembly, substep);
}

/// A scene on the CPU.
pub fn on_cpu<T: Real>(assembly: Assembly, team: Team) -> Result<CpuBackend<T>, Refusal> {
    let parts = parts(&assembly);
    Ok(CpuBackend::new(assembly, &parts, parameters, team, of_cpu)?)
}

/// The features of a scene on the CPU.
fn of_cpu<T: Real>(context: &mut Context<'_, T>) -> Result<Vec<Box<dyn Feature<T>>>, String> {
    fn boxed<T: Real>(feature: impl Feature<T>) -> Option<Box<dyn Feature<T>>> {
        Some(Box::new(feature))
    }
    let springs = spring::cpu::Springs::new(context)?;
    Ok([
        boxed(load::cpu::Loads::new(context.assembly.loads(), context.workers())),
        elements::sets::Elements::new(context).and_then(boxed),
        membrane::strain::Strains::new(context).and_then(boxed),
        boxed(springs),
        boxed(motion::cpu::Pins::new(context.assembly.moving_pins())),
        motion::held_cpu::HeldForces::new(context.assembly).and_then(boxed),
        boxed(explicit::cpu::Euler),
        boxed(colliders::cpu::Colliders::new(context)),
        volume::cpu::Volumes::new(context).and_then(boxed),
        implicit::cpu::Implicit::new(context).and_then(boxed),
        dual::cpu::Dual::new(context).and_then(boxed),
        xpbd::cpu::PositionConstraints::new(context).and_then(boxed),
        attachments::cpu::Attachments::new(context).and_then(boxed),
        nodes::cpu::NodeContact::new(context).and_then(boxed),
        triangles::cpu::TriangleContact::new(context).and_then(boxed),
        boxed(diagnostics::cpu::Measures::new(context)),
    ]
    .into_iter()
    .flatten()
    .collect())
}

/// Everything that some bodies need on the device, on the host.
#[cfg(feature = "gpu")]
#[derive(Default)]
pub struct Tables {
    /// Position [m] and inverse mass [1/kg], velocity [m/s] and mass [kg], by place.
    pub position: Vec<Four>,
    pub velocity: Vec<Four>,
    pub springs: spring::gpu::SpringTables,
    pub elements: elements::gpu::ElementTables,
    pub loads: load::gpu::LoadTables,
    pub pins: Vec<Pin>,
    pub held: motion::held_gpu::HeldTables,
    pub volumes: volume::gpu::VolumeTables,
    /// Springs that are constraints, or may become some.
    pub constraints: dual::gpu_tables::ConstraintTables,
    /// Springs that are solved for by nodes.
    pub multigrid: implicit::gpu_tables::MultigridTables,
    pub attachments: attachments::gpu::AttachmentTables,
    pub self_collision: nodes::gpu::SelfCollisionTables,
    pub surfaces: triangles::gpu_tables::SurfaceTables,
}

#[cfg(feature = "gpu")]
impl Tables {
    /// Those of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Result<Self, String> {
        let [position, velocity] = bodies.state();
        let (elements, volumes) =
            (elements::gpu::ElementTables::new(bodies), volume::gpu::VolumeTables::new(bodies));
        Ok(Self {
            position,
            velocity,
            springs: spring::gpu::SpringTables::new(bodies)?,
            loads: load::gpu::LoadTables::new(bodies, &elements),
            pins: motion::gpu::pins(bodies),
            held: motion::held_gpu::HeldTables::new(bodies),
            constraints: dual::gpu_tables::ConstraintTables::new(bodies)?,
            multigrid: implicit::gpu_tables::MultigridTables::new(bodies, &elements)?,
            attachments: attachments::gpu::AttachmentTables::new(bodies, volumes.numbers.len()),
            self_collision: nodes::gpu::SelfCollisionTables::new(bodies)?,
            surfaces: triangles::gpu_tables::SurfaceTables::new(bodies),
            elements,
            volumes,
        })
    }

    /// What the bodies have.
    pub fn parts(&self) -> Parts {
        Parts {
            elements: self.elements.any_explicit(),
            solved: !self.constraints.is_empty() || !self.multigrid.is_empty(),
            positions: false,
            volumes: !self.volumes.groups.is_empty(),
            restored: self.volumes.restores(),
            attachments: !self.attachments.lists.is_empty(),
            self_contact: !self.self_collision.surfaces.is_empty(),
            surface_contact: !self.surfaces.is_empty(),
            held: !self.held.nodes.is_empty(),
        }
    }

    /// Number of places.
    pub fn len(&self) -> usize {
        self.position.len()
    }
}

/// The shaders of all features.
#[cfg(feature = "gpu")]
pub fn shaders() -> Shaders {
    let all = [
        kernels::SHADERS,
        kernels::DEFAULTS,
        load::gpu::DEFAULTS,
        colliders::gpu::DEFAULTS,
        implicit::gpu::DEFAULTS,
        spring::gpu::SHADERS,
        elements::gpu::SHADERS,
        load::gpu::SHADERS,
        motion::gpu::SHADERS,
        explicit::gpu::SHADERS,
        colliders::gpu::SHADERS,
        collider_mesh::gpu::SHADERS,
        volume::gpu::SHADERS,
        implicit::gpu::SHADERS,
        dual::gpu::SHADERS,
        attachments::gpu::SHADERS,
        nodes::gpu::SHADERS,
        triangles::gpu::SHADERS,
        diagnostics::gpu::SHADERS,
    ];
    let of_kinds = KINDS.iter().map(|kind| kind.shaders);
    Shaders::new(all.into_iter().chain(of_kinds).flatten().copied())
}

/// The files that may stand for what kernels of a file import by a name, as scenes have them together; none first.
#[cfg(all(feature = "gpu", feature = "extend"))]
pub fn choices(file: &str) -> Vec<Vec<kernels::Choice>> {
    use colliders::gpu::Contact;
    use implicit::gpu::{CONTACTS, COUPLED, MOVED};
    let contact = [Contact::Solids, Contact::Later, Contact::Meshes].map(|one| one.choices().to_vec());
    let given = [Contact::Solids, Contact::Later].map(|one| [load::gpu::GIVEN, one.choices()].concat());
    let implicit = [vec![COUPLED], vec![CONTACTS], vec![COUPLED, CONTACTS]];
    // A Newton step asks for forces and directions of elements elsewhere than where the sub-step began.
    let is_of_kind = KINDS.iter().any(|kind| kind.shaders.iter().any(|shader| shader.0 == file));
    let moved = is_of_kind.then(|| vec![MOVED]);
    contact.into_iter().chain(given).chain(implicit).chain(moved).collect()
}

/// Bytes of the arrays that a body needs on the device, and what they hold.
#[cfg(feature = "gpu")]
fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let state = (assembly.bodies[body].places() * size_of::<Four>()) as u64;
    [
        vec![(state, "positions")],
        spring::gpu::arrays(assembly, body),
        elements::gpu::arrays(assembly, body),
        volume::gpu::arrays(assembly, body),
        dual::gpu_tables::arrays(assembly, body),
        implicit::gpu_tables::arrays(assembly, body),
        nodes::gpu::arrays(assembly, body),
        triangles::gpu::arrays(assembly, body),
    ]
    .concat()
}

/// Refuses bodies that act on each other but do not go to the device together.
#[cfg(feature = "gpu")]
fn check_together(assembly: &Assembly, partitions: &[Range<usize>], limit: u64) -> Result<(), Refusal> {
    nodes::gpu::check_together(assembly, partitions, limit)?;
    triangles::gpu::check_together(assembly, partitions, limit)?;
    attachments::gpu::check_together(assembly, partitions, limit)
}

/// The features of some bodies on the device.
#[cfg(feature = "gpu")]
fn of_gpu(
    options: &GpuOptions,
    bodies: &Bodies<'_>,
    tables: &Tables,
    parts: &Parts,
    (meshes, data): (&collider_mesh::gpu::ColliderMeshes, &[collider_mesh::gpu::Words]),
) -> Result<device::Features, GpuError> {
    fn boxed(feature: impl device::Feature) -> Option<Box<dyn device::Feature>> {
        Some(Box::new(feature))
    }
    let (gpu, assembly, places) = (&options.gpu, bodies.assembly, bodies.len());
    let patches = || gpu::patches(options, assembly, tables, parts);
    let (particles, solvers) = match &options.particles {
        Some(other) => (Some(other.feature(gpu, bodies)?), [None, None]),
        None => (
            boxed(explicit::gpu::Particles::new(gpu, patches().as_ref(), places)?),
            [
                implicit::gpu::Implicit::new(
                    gpu,
                    assembly,
                    (&tables.multigrid, !tables.surfaces.is_empty()),
                    bodies.places.clone(),
                )?
                .and_then(boxed),
                dual::gpu::Dual::new(gpu, assembly, &tables.constraints, places)?.and_then(boxed),
            ],
        ),
    };
    let all = [
        boxed(load::gpu::Loads::new(gpu, &tables.loads, places)?),
        boxed(elements::gpu::Elements::new(gpu, &tables.elements)?),
        membrane::gpu::Strains::new(gpu, &tables.elements)?.and_then(boxed),
        boxed(aero::gpu::AirOfSubsteps),
        boxed(spring::gpu::Springs::new(gpu, &tables.springs, places)?),
        boxed(motion::gpu::Pins::new(gpu, &tables.pins)?),
        particles,
        boxed(colliders::gpu::Colliders::new(gpu, (meshes, data), assembly, bodies.places.clone())?),
        boxed(volume::gpu::Volumes::new(gpu, &tables.volumes)?),
    ];
    let after = [
        attachments::gpu::Attachments::new(gpu, assembly, &tables.attachments, places)?.and_then(boxed),
        nodes::gpu::NodeContact::new(gpu, &tables.self_collision)?.and_then(boxed),
        triangles::gpu::TriangleContact::new(gpu, &tables.surfaces)?.and_then(boxed),
        motion::held_gpu::HeldForces::new(gpu, &tables.held)?.filter(|_| parts.held).and_then(boxed),
        boxed(diagnostics::gpu::Measures::new(gpu, places)?),
    ];
    Ok(device::Features::new(all.into_iter().chain(solvers).chain(after).flatten().collect()))
}
