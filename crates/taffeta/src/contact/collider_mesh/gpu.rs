//! Meshes as colliders on the GPU, in one array of four words each: triangles, nodes of each pose, and boxes, as on
//! the CPU.

use crate::assembly::Assembly;
use crate::contact::collider_mesh::surface::MeshShape;
use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::colliders::met::MetColliders;
use crate::contact::colliders::moving::ColliderNow;
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

    /// The records of a sub-step's colliders as the nodes of some places meet them, and how many ranges of places have a list: `met_by`
    /// of met.wgsl.
    pub fn records(&self, met: MetColliders<'_, f32>, places: &Range<usize>) -> (Vec<Collider>, u32) {
        let mut all: Vec<Collider> = met.all().iter().map(|now| self.record(now)).collect();
        let ends = met.ranges().iter().skip(1).map(|&(first, _)| first).chain([usize::MAX]);
        let ranges = met.ranges().iter().zip(ends);
        let ranges: Vec<(usize, Option<usize>)> = ranges
            .filter(|&(&(first, _), end)| first < places.end && end > places.start)
            .map(|(&(first, list), _)| (first.saturating_sub(places.start), list))
            .collect();
        let heads = all.len();
        all.extend(ranges.iter().map(|&(first, _)| Collider { kind: first as u32, ..Collider::zeroed() }));
        let mut begins = vec![0; met.lists().len()];
        for (range, &(_, list)) in ranges.iter().enumerate() {
            let Some(list) = list else { continue };
            if begins[list] == 0 {
                let own = &met.lists()[list];
                all.push(Collider { mesh: own.len() as u32, ..Collider::zeroed() });
                begins[list] = all.len() as u32;
                all.extend(own.iter().map(|now| self.record(now)));
            }
            all[heads + range].mesh = begins[list];
        }
        (all, ranges.len() as u32)
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
