//! Colliders on the GPU.

use crate::assembly::Assembly;
use crate::contact::collider_mesh::gpu::{ColliderMeshes, Words};
use crate::contact::collider_mesh::tree::WALK_TURNS;
use crate::contact::colliders::gpu_layout::Collider;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::{Choice, Name, Overrides};
use crate::gpu::layout::{GROUP, Substep};
use crate::gpu::partition::fill;
use crate::gpu::schedule::Fused;
use crate::step::{Op, Stage};
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "contact/colliders",
    [
        "contact.wgsl",
        "predicted_contact.wgsl",
        "response.wgsl",
        "shape.wgsl",
        "resolve_contact.wgsl",
        "resolve_contact_again.wgsl",
        "defer_contact.wgsl"
    ]
);

/// The default imports of kernels: they resolve contact with solids, and no collider is a mesh.
pub const DEFAULTS: &[Shader] = &[
    ("resolve_contact", "#import contact/colliders/resolve_contact.wgsl\n"),
    ("meshes", "#import contact/collider_mesh/no_mesh.wgsl\n"),
];

/// How a kernel handles colliders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// It resolves contact with solids; no collider is a mesh.
    Solids,
    /// It does not resolve contact. Some colliders are meshes, and contact is a kernel of its own.
    Later,
    /// It resolves contact with solids and meshes.
    Meshes,
}

impl Contact {
    /// The imports for it.
    pub fn choices(self) -> &'static [Choice] {
        match self {
            Self::Solids => &[],
            Self::Later => &[("resolve_contact", "contact/colliders/defer_contact.wgsl")],
            Self::Meshes => &[("meshes", "contact/collider_mesh/surface.wgsl")],
        }
    }
}

/// Colliders on the device.
pub struct Colliders {
    colliders: Buffer<Collider>,
    meshes: ColliderMeshes,
    mesh_data: Buffer<Words>,
    /// Workgroups, with one invocation for each place.
    groups: usize,
}

impl Colliders {
    /// Uploads the meshes among the colliders.
    pub fn new(gpu: &Gpu, meshes: &ColliderMeshes, data: &[Words], places: usize) -> Result<Self, GpuError> {
        Ok(Self {
            colliders: gpu.buffer("colliders", 1)?,
            meshes: meshes.clone(),
            mesh_data: gpu.buffer_from("meshes of colliders", data)?,
            groups: places.div_ceil(GROUP),
        })
    }

    /// Whether some colliders are meshes. Contact is a kernel of its own then.
    pub fn has_meshes(&self) -> bool {
        self.meshes.any()
    }

    /// How kernels without a buffer for triangles handle colliders.
    pub fn fused(&self) -> Contact {
        if self.has_meshes() { Contact::Later } else { Contact::Solids }
    }

    /// How kernels with a buffer for triangles handle colliders.
    pub fn whole(&self) -> Contact {
        if self.has_meshes() { Contact::Meshes } else { Contact::Solids }
    }
}

/// How kernels of a partition without a buffer for triangles handle colliders, and how those with one do.
pub fn contact_of(features: &Features) -> [Contact; 2] {
    features.get::<Colliders>().map_or([Contact::Solids; 2], |all| [all.fused(), all.whole()])
}

impl Feature for Colliders {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("colliders", &self.colliders), ("mesh_data", &self.mesh_data)]
    }

    fn overrides(&self, gpu: &Gpu, overrides: &mut Overrides) {
        if gpu.info().is_software() {
            overrides.insert("TURNS", WALK_TURNS.into());
        }
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let name = Name::new("contact_all").with(self.whole().choices());
        let commands = vec![Command::run(name, self.groups)];
        vec![Fused { writes_state: true, ..Fused::new(&[Op::Contact], commands) }]
    }

    fn bytes(&self, assembly: &Assembly) -> usize {
        if assembly.colliders_move() { assembly.colliders().len() * size_of::<Collider>() } else { 0 }
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        let is_still = !upload.assembly.colliders_move();
        let mut all: Vec<Collider> = Vec::new();
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            record.colliders = substep.colliders().len() as u32;
            if is_still && !all.is_empty() {
                continue;
            }
            record.first_collider = all.len() as u32;
            all.extend(substep.colliders().iter().map(|now| self.meshes.record(now)));
        }
        fill(upload.gpu, "colliders", &mut self.colliders, &all)
    }
}
