//! Symplectic Euler on the GPU: alone, or in one kernel with springs, loads and colliders.

use crate::contact::colliders::gpu::{Contact, contact_of};
use crate::elements::load::gpu::{GIVEN, Loads};
use crate::elements::spring::gpu::Springs;
use crate::elements::spring::gpu_layout::ResidentMesh;
use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::{Name, Overrides};
use crate::gpu::layout::GROUP;
use crate::gpu::schedule::Fused;
use crate::motion::gpu::Pins;
use crate::solvers::explicit::gpu_layout::{PATCH_NODE_BYTES, Patch};
use crate::solvers::explicit::patches::{self, Patches};
use crate::step::{Marks, Op, Stage};
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "solvers/explicit",
    [
        "euler.wgsl",
        "grid_patches.wgsl",
        "grid_stages.wgsl",
        "mesh_patches.wgsl",
        "mesh_stages.wgsl",
        "node.wgsl",
        "reach_patch.wgsl",
        "stages.wgsl"
    ]
);

/// Kernels that move particles.
pub struct Particles {
    /// Sub-steps that are taken at once on patches; 0: there are none.
    steps: u32,
    patches: Buffer<Patch>,
    resident_meshes: Buffer<ResidentMesh>,
    /// Workgroups for one invocation a place.
    groups: usize,
}

impl Particles {
    /// For so many places, which are cut into patches if there are any.
    pub fn new(gpu: &Gpu, patches: Option<&Patches>, places: usize) -> Result<Self, GpuError> {
        let none = Patches::default();
        let all = patches.unwrap_or(&none);
        Ok(Self {
            steps: all.steps,
            patches: gpu.buffer_from("patches of grids", &all.grids)?,
            resident_meshes: gpu.buffer_from("small meshes", &all.meshes)?,
            groups: places.div_ceil(GROUP),
        })
    }

    /// Whether it takes several sub-steps at once.
    pub fn has_patches(&self) -> bool {
        self.steps > 0
    }

    /// All that bodies without volumes need, in one kernel for grids and one for meshes.
    fn whole<'f>(&'f self, features: &Features) -> Fused<'f> {
        let given = features.get::<Loads>().is_some_and(|loads| loads.are_given(features));
        let [contact, _] = contact_of(features);
        let [tiles, meshes] = features.get::<Springs>().map_or([0; 2], Springs::groups);
        let name = |entry| Name::new(entry).with(if given { GIVEN } else { &[] }).with(contact.choices());
        let mut operations = vec![Op::Loads, Op::Springs, Op::Integrate, Op::Contact];
        if given {
            operations.remove(0);
        }
        if contact == Contact::Later {
            operations.pop();
        }
        let commands =
            vec![Command::run(name("grid_particles"), tiles), Command::run(name("mesh_particles"), meshes)];
        Fused::new(&operations, commands)
            .on(Marks::NONE, Marks::VOLUME.and(Marks::SOLVED).and(Marks::IMPLICIT))
            .named("particles")
    }

    /// The same for several sub-steps, where nothing but springs, wind and colliders acts.
    fn ahead<'f>(&'f self, features: &Features) -> Option<Fused<'f>> {
        let given = features.get::<Loads>().is_some_and(|loads| loads.are_given(features));
        let pinned = features.get::<Pins>().is_some_and(Pins::any);
        (self.has_patches() && !given && !pinned).then(|| {
            let commands = vec![
                Command::run(Name::new("grid_patches"), self.patches.len()),
                Command::run(Name::new("mesh_patches"), self.resident_meshes.len()),
            ];
            let all = [Op::Loads, Op::Springs, Op::Integrate, Op::Pins, Op::Contact];
            Fused { steps: self.steps, ..Fused::new(&all, commands).named("particles") }
        })
    }
}

impl Feature for Particles {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("patches", &self.patches), ("resident_meshes", &self.resident_meshes)]
    }

    fn overrides(&self, gpu: &Gpu, overrides: &mut Overrides) {
        overrides.insert("STEPS", self.steps.max(1).into());
        overrides.insert("ROOM", (patches::room(gpu.limits()) * PATCH_NODE_BYTES / 4).into());
    }

    fn kernels<'f>(&'f self, features: &'f Features, from: Stage) -> Vec<Fused<'f>> {
        let integrate = vec![Command::run(Name::new("integrate_all"), self.groups)];
        let alone = Fused { writes_state: true, ..Fused::new(&[Op::Integrate], integrate) };
        let mut all = vec![alone];
        if from == Stage::Elements {
            all.push(self.whole(features));
            all.extend(self.ahead(features));
        }
        all
    }
}
