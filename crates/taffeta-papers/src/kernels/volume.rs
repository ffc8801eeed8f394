//! What volume.wgsl works on: triangles, and sums of each body.

use taffeta::extension::Bodies;
use taffeta::taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta::taffeta_gpu::{Bindable, Buffer, Gpu, GpuError};
use taffeta::topology::Csr;

/// `KeptTriangle` of volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
pub struct KeptTriangle {
    pub corners: [u32; 3],
    pub body: u32,
}

/// `KeptBody` of volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
pub struct KeptBody {
    pub origin: u32,
    pub form: u32,
}

/// A node of no body that keeps its volume.
const NOT_KEPT: u32 = u32::MAX;

/// Bodies that keep their volume, on the device.
pub struct KeptVolumes {
    triangles: Buffer<KeptTriangle>,
    bodies: Buffer<KeptBody>,
    of_node: Buffer<u32>,
    starts: Buffer<u32>,
    of_nodes: Buffer<u32>,
    /// Three numbers a place.
    jacobians: Buffer<f32>,
    /// Three numbers a body.
    sums: Buffer<u32>,
}

impl KeptVolumes {
    /// Those of some bodies, or of none of them.
    pub fn new(gpu: &Gpu, bodies: &Bodies<'_>, any: bool) -> Result<Self, GpuError> {
        let (mut kept, mut triangles) = (Vec::new(), Vec::new());
        let mut of_node = vec![NOT_KEPT; bodies.len()];
        for (_, body) in bodies.iter().filter(|_| any) {
            let Some(volume) = body.volume() else { continue };
            let (number, first) = (kept.len() as u32, bodies.local(body.first) as usize);
            let corners = body.closed_triangles.iter().map(|t| t.map(|node| first as u32 + node));
            triangles.extend(corners.map(|corners| KeptTriangle { corners, body: number }));
            of_node[first..first + body.nodes].fill(number);
            kept.push(KeptBody { origin: first as u32, form: volume.form as u32 });
        }
        let corners: Vec<u32> = triangles.iter().flat_map(|triangle| triangle.corners).collect();
        let by_node = Csr::new(bodies.len(), corners.into_iter().zip((0..).map(|corner: u32| corner / 3)));
        let places = if kept.is_empty() { 0 } else { bodies.len() };
        Ok(Self {
            triangles: gpu.buffer_from("triangles of volumes", &triangles)?,
            bodies: gpu.buffer_from("bodies with volumes", &kept)?,
            of_node: gpu.buffer_from("bodies by node", &of_node)?,
            starts: gpu.buffer_from("rows of triangles", &by_node.offsets)?,
            of_nodes: gpu.buffer_from("triangles by node", &by_node.items)?,
            jacobians: gpu.buffer("jacobians", 3 * places)?,
            sums: gpu.buffer("volumes and both sides", 3 * kept.len())?,
        })
    }

    /// Number of triangles.
    pub fn count(&self) -> usize {
        self.triangles.len()
    }

    pub fn buffers(&self) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("kept_triangles", &self.triangles),
            ("kept_bodies", &self.bodies),
            ("kept_of_node", &self.of_node),
            ("triangle_starts", &self.starts),
            ("triangles_of_node", &self.of_nodes),
            ("jacobians", &self.jacobians),
            ("kept_bits", &self.sums),
            ("kept_numbers", &self.sums),
        ]
    }
}
