//! Colliders on the GPU.

use crate::assembly::Assembly;
use crate::backend::SolverState;
use crate::contact::collider_mesh::gpu::{ColliderMeshes, Words};
use crate::contact::collider_mesh::tree::WALK_TURNS;
use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::colliders::lift::Lift;
use crate::contact::colliders::met::Differ;
use crate::gpu::feature::{Command, Feature, Features, Seen, Upload};
use crate::gpu::kernels::{Choice, Name, Overrides};
use crate::gpu::layout::{GROUP, NONE, Substep};
use crate::gpu::partition::fill;
use crate::gpu::schedule::Fused;
use crate::step::{Op, Stage};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "contact/colliders",
    [
        "contact.wgsl",
        "met.wgsl",
        "predicted_contact.wgsl",
        "response.wgsl",
        "shape.wgsl",
        "resolve_contact.wgsl",
        "resolve_contact_again.wgsl",
        "defer_contact.wgsl"
    ]
);

/// Nodes for which four words have a bit each.
const BITS: usize = 128;

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

/// An override of met.wgsl: how lists of bodies differ.
pub const LISTS_DIFFER: &str = "LISTS_DIFFER";

/// Colliders on the device.
pub struct Colliders {
    colliders: Buffer<Collider>,
    meshes: ColliderMeshes,
    mesh_data: Buffer<Words>,
    /// Its places among those of the scene; workgroups, with one invocation for each.
    places: Range<usize>,
    groups: usize,
    /// Where it stands in `mesh_data` which nodes are led out of colliders, if some may be. Whether some are; then it is looked for
    /// before each frame.
    led_out_at: Option<usize>,
    is_lifting: bool,
    lists_differ: Differ,
}

impl Colliders {
    /// Uploads the meshes among the colliders.
    pub fn new(
        gpu: &Gpu,
        (meshes, data): (&ColliderMeshes, &[Words]),
        assembly: &Assembly,
        places: Range<usize>,
    ) -> Result<Self, GpuError> {
        let leads_out = assembly.leads_out();
        let bits = if leads_out { places.len().div_ceil(BITS) } else { 0 };
        let data = [data, &vec![[0; 4]; bits]].concat();
        Ok(Self {
            colliders: gpu.buffer("colliders", 1)?,
            meshes: meshes.clone(),
            mesh_data: gpu.buffer_from("meshes of colliders", &data)?,
            groups: places.len().div_ceil(GROUP),
            places,
            led_out_at: leads_out.then_some(data.len() - bits),
            is_lifting: leads_out,
            lists_differ: assembly.lists_differ(),
        })
    }

    /// Whether some colliders are meshes.
    pub fn has_meshes(&self) -> bool {
        self.meshes.any()
    }

    /// Whether contact is a kernel of its own: some colliders are meshes, or do not act on all nodes.
    fn is_apart(&self) -> bool {
        self.has_meshes() || self.led_out_at.is_some()
    }

    /// How kernels without a buffer for triangles handle colliders.
    pub fn fused(&self) -> Contact {
        if self.is_apart() { Contact::Later } else { Contact::Solids }
    }

    /// How kernels with a buffer for triangles handle colliders.
    pub fn whole(&self) -> Contact {
        if self.is_apart() { Contact::Meshes } else { Contact::Solids }
    }

    /// Which of its nodes are led out, a bit each.
    fn bits(&self, lifts: &[Lift]) -> Vec<Words> {
        let mut bits = vec![[0; 4]; self.places.len().div_ceil(BITS)];
        for node in lifts.iter().map(|lift| lift.node as usize).filter(|node| self.places.contains(node)) {
            let place = node - self.places.start;
            bits[place / BITS][place % BITS / 32] |= 1 << (place % 32);
        }
        bits
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
        overrides.insert(LISTS_DIFFER, f64::from(self.lists_differ as u32));
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let name = Name::new("contact_all").with(self.whole().choices());
        let commands = vec![Command::run(name, self.groups)];
        vec![Fused { writes_state: true, ..Fused::new(&[Op::Contact], commands) }]
    }

    fn bytes(&self, assembly: &Assembly) -> usize {
        let [in_lists, ranges] = assembly.sizes_of_lists();
        let records = assembly.colliders().len() + in_lists + 2 * ranges;
        if assembly.colliders_move() { records * size_of::<Collider>() } else { 0 }
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        let led_out = self.led_out_at.filter(|_| self.is_lifting).map_or(NONE, |at| at as u32);
        records.iter_mut().for_each(|record| record.led_out = led_out);
        let is_still = !upload.assembly.colliders_move();
        let (mut all, mut ranges): (Vec<Collider>, u32) = (Vec::new(), 0);
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            let met = substep.met_colliders();
            record.colliders = met.all().len() as u32;
            record.collider_ranges = ranges;
            if is_still && !all.is_empty() {
                continue;
            }
            record.first_collider = all.len() as u32;
            let (of_substep, count) = self.meshes.records(met, &self.places);
            all.extend(of_substep);
            (record.collider_ranges, ranges) = (count, count);
        }
        fill(upload.gpu, "colliders", &mut self.colliders, &all)
    }

    fn relocate(&mut self) {
        self.is_lifting = self.led_out_at.is_some();
    }

    fn looks(&self, before: bool) -> bool {
        before && self.is_lifting
    }

    fn see(&mut self, seen: &mut Seen<'_>) -> Result<bool, GpuError> {
        let (Some(time), Some(at)) = (seen.time, self.led_out_at) else { return Ok(false) };
        if seen.found.get::<Vec<Lift>>().is_none() {
            // Those of the whole scene: other partitions need not look for them again.
            let x = |node: usize| {
                let [x, y, z, _] = seen.position[node];
                [x, y, z].map(f64::from)
            };
            let lifts = seen.assembly.lifts(time, &x);
            seen.found.insert(lifts);
        }
        let lifts = seen.found.list::<Lift>();
        self.mesh_data.write(seen.gpu, at, &self.bits(lifts));
        self.is_lifting = !lifts.is_empty();
        Ok(false)
    }

    fn save(&self, _: &Gpu, state: &mut SolverState) {
        state.is_tangled |= self.is_lifting;
    }

    fn load(&mut self, _: &Gpu, state: &SolverState) -> bool {
        self.is_lifting = state.is_tangled && self.led_out_at.is_some();
        false
    }
}
