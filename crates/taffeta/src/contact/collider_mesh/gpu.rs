//! Meshes as colliders on the GPU, in one array of four words each: triangles, nodes of each pose, and boxes, as on
//! the CPU.

use crate::assembly::Assembly;
use crate::contact::collider_mesh::surface::MeshShape;
use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::colliders::moving::{ColliderNow, MetColliders};
use bytemuck::Zeroable;
use std::ops::Range;
use std::sync::Arc;
use taffeta_gpu::{Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] =
    shaders!("contact/collider_mesh", ["no_mesh.wgsl", "stages.wgsl", "surface.wgsl", "triangle.wgsl"]);

/// Four words.
pub type Words = [u32; 4];

/// Corner of an empty box [m]: a number whose square is 1.
const NOWHERE: f32 = 1e18;

/// Where the meshes of a scene are in the array.
#[derive(Clone, Debug, Default)]
pub struct ColliderMeshes {
    /// By mesh, by interval between poses: the offset of its header.
    parts: Arc<Vec<Vec<u32>>>,
}

impl ColliderMeshes {
    /// The meshes of a scene, and the array.
    pub fn new(assembly: &Assembly) -> (Self, Vec<Words>) {
        let mut data = Vec::new();
        let meshes = assembly.colliders().iter().filter_map(|collider| collider.mesh());
        let parts = meshes.map(|mesh| add(&mut data, mesh)).collect();
        (Self { parts: Arc::new(parts) }, data)
    }

    /// Whether there are any.
    pub fn any(&self) -> bool {
        !self.parts.is_empty()
    }

    /// The records of a sub-step's colliders as the nodes of some places meet them: `met_by` of met.wgsl.
    pub fn records(&self, met: MetColliders<'_, f32>, places: &Range<usize>) -> Vec<Collider> {
        let mut all: Vec<Collider> = met.all().iter().map(|now| self.record(now)).collect();
        for own in met.apart() {
            let [first, end] = [own.places.start, own.places.end]
                .map(|place| (place.clamp(places.start, places.end) - places.start) as u32);
            all.push(Collider { kind: first, mesh: end - first, ..Collider::zeroed() });
            all.extend(own.colliders.iter().map(|now| self.record(now)));
        }
        all
    }

    /// The record of a collider.
    fn record(&self, now: &ColliderNow<f32>) -> Collider {
        let mut record = Collider::from(now);
        if let Some(mesh) = now.shape.mesh() {
            let parts = &self.parts[mesh.index as usize];
            record.mesh = parts[(mesh.pose as usize).min(parts.len() - 1)];
        }
        record
    }
}

/// Adds a mesh. Returns the offset of each interval's header.
fn add(data: &mut Vec<Words>, mesh: &MeshShape) -> Vec<u32> {
    let surface = mesh.surface::<f32>();
    let place = |[x, y, z]: [f32; 3]| [x, y, z, 0.0].map(f32::to_bits);
    let corner = |x: [f32; 3]| place(x.map(|c| c.clamp(-NOWHERE, NOWHERE)));
    let triangles = data.len() as u32;
    data.extend(surface.triangles.iter().map(|&[a, b, c]| [a, b, c, 0]));
    let poses: Vec<u32> = mesh
        .poses
        .iter()
        .map(|pose| {
            let start = data.len() as u32;
            data.extend(pose.iter().map(|x| place(x.map(|c| c as f32))));
            start
        })
        .collect();
    let mut parts = Vec::new();
    for (interval, tree) in surface.trees.iter().enumerate() {
        let (start, end) = (poses[interval], poses[(interval + 1).min(poses.len() - 1)]);
        let boxes = data.len() as u32;
        data.extend(tree.boxes.iter().flat_map(|&[lo, hi]| [corner(lo), corner(hi)]));
        parts.push(data.len() as u32);
        data.push([triangles, start, end, boxes]);
        let (count, width) = (surface.triangles.len() as u32, tree.boxes.len() as u32 / 2);
        data.push([count, width, surface.solid.into(), tree.rounding.to_bits()]);
        data.push([poses[interval.saturating_sub(1)], 0, 0, 0]);
    }
    parts
}
