//! Vertices of a body for a renderer on the same device: they go from the state to what it draws, and never to the host.

use crate::assembly::body::BodyAssembly;
use crate::backend::{VertexTarget, View};
use crate::gpu::kernels::{Kernels, Name, Overrides};
use crate::gpu::layout::{Four, GROUP, NONE};
use crate::gpu::partition::Partition;
use crate::topology::Csr;
use std::num::NonZeroU64;
use taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta_gpu::wgpu;
use taffeta_gpu::{Bindable, Bound, Buffer, DispatchList, Gpu, GpuError, Kernel};

/// `Drawing` of drawn.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Drawing {
    pub place_x: Four,
    pub place_y: Four,
    pub place_z: Four,
    pub normal_x: Four,
    pub normal_y: Four,
    pub normal_z: Four,
    pub alpha: f32,
    pub first: u32,
    pub stride: u32,
    pub normal: u32,
}

/// What a target's kernel sees: from a multiple of the device's alignment on.
#[derive(Clone, PartialEq)]
struct Seen {
    buffer: wgpu::Buffer,
    offset: u64,
    bytes: u64,
}

impl Bindable for Seen {
    fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    fn offset(&self) -> u64 {
        self.offset
    }

    fn window(&self) -> Option<NonZeroU64> {
        NonZeroU64::new(self.bytes)
    }
}

/// Buffers of one body, bound to the kernel.
pub struct Drawn {
    kernel: Kernel,
    places: Buffer<u32>,
    starts: Buffer<u32>,
    corners: Buffer<u32>,
    nodes: Buffer<[u32; 2]>,
    parameters: Buffer<Drawing>,
    /// The target that was drawn to last, bound to read either state.
    bound: Option<(Seen, [Bound; 2])>,
}

impl Drawn {
    /// For vertices at the nodes `nodes` of a body, [`NONE`] for one that no node carries.
    pub fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        partition: &Partition,
        body: &BodyAssembly,
        nodes: &[u32],
    ) -> Result<Self, GpuError> {
        let triangles = body.user_surface().triangles;
        let by_node = Csr::corners(body.nodes, &triangles);
        let place = |node: u32| (body.solver_index(node as usize) - partition.places.start) as u32;
        let places: Vec<u32> = triangles.as_flattened().iter().map(|&node| place(node)).collect();
        let drawn = |&node: &u32| if node == NONE { [NONE; 2] } else { [place(node), node] };
        let nodes: Vec<[u32; 2]> = nodes.iter().map(drawn).collect();
        Ok(Self {
            kernel: kernels.get(Name::new("draw_vertices"), &Overrides::new())?,
            places: gpu.buffer_from("corners of drawn triangles", &places)?,
            starts: gpu.buffer_from("rows of drawn corners", &by_node.offsets)?,
            corners: gpu.buffer_from("drawn corners by node", &by_node.items)?,
            nodes: gpu.buffer_from("nodes of drawn vertices", &nodes)?,
            parameters: gpu.buffer("what is drawn", 1)?,
            bound: None,
        })
    }

    /// Their number.
    pub fn vertices(&self) -> usize {
        self.nodes.len()
    }

    /// Writes the vertices to `target`; `before` has the state before the last frame.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        partition: &Partition,
        before: &Buffer<Four>,
        target: &VertexTarget,
        view: &View,
    ) -> Result<(), GpuError> {
        let seen = self.seen(gpu, target)?;
        let bound = match self.bound.take().filter(|(last, _)| *last == seen) {
            Some((_, bound)) => bound,
            None => [0, 1].map(|now| self.bind(gpu, partition, before, &seen, now)),
        };
        let [place_x, place_y, place_z] = view.places;
        let [normal_x, normal_y, normal_z] = view.normals.map(|[x, y, z]| [x, y, z, 0.0]);
        let words = |bytes: u64| (bytes / 4) as u32;
        let parameters = Drawing {
            place_x,
            place_y,
            place_z,
            normal_x,
            normal_y,
            normal_z,
            alpha: view.alpha,
            first: words(target.first - seen.offset),
            stride: words(target.stride),
            normal: words(target.normal),
        };
        self.parameters.write(gpu, 0, &[parameters]);
        let mut list = DispatchList::new();
        list.stage("draw");
        list.dispatch(&bound[partition.current], &[], self.nodes.len().div_ceil(GROUP) as u32);
        self.bound = Some((seen, bound));
        gpu.submit(&list)
    }

    fn seen(&self, gpu: &Gpu, target: &VertexTarget) -> Result<Seen, GpuError> {
        let alignment = u64::from(gpu.limits().min_storage_buffer_offset_alignment);
        let offset = target.first / alignment * alignment;
        let bytes = target.first - offset + target.bytes(self.nodes.len());
        if bytes > gpu.largest_binding() {
            let label = "vertices to draw".to_owned();
            return Err(GpuError::TooLarge { what: "buffer", label, bytes, limit: gpu.largest_binding() });
        }
        Ok(Seen { buffer: target.buffer.clone(), offset, bytes })
    }

    fn bind(
        &self,
        gpu: &Gpu,
        partition: &Partition,
        before: &Buffer<Four>,
        target: &Seen,
        now: usize,
    ) -> Bound {
        self.kernel.bind(
            gpu,
            &[
                ("drawing", &self.parameters),
                ("triangle_places", &self.places),
                ("corner_starts", &self.starts),
                ("node_corners", &self.corners),
                ("drawn_nodes", &self.nodes),
                ("old_position", before),
                ("new_position", &partition.states[now].position),
                ("vertices", target),
            ],
        )
    }
}
