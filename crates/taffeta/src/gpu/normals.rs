//! Vertex normals on the device, of one body.

use crate::assembly::body::BodyAssembly;
use crate::gpu::kernels::{Kernels, Name, Overrides};
use crate::gpu::layout::{Four, GROUP};
use crate::gpu::partition::Partition;
use crate::topology::Csr;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use taffeta_gpu::{Bound, Buffer, DispatchList, Gpu, GpuError};

/// The kernel, and the bodies whose normals were asked for.
pub struct AllNormals {
    kernels: Kernels,
    bodies: HashMap<usize, Normals>,
}

impl AllNormals {
    /// None yet.
    pub fn new(kernels: Kernels) -> Self {
        Self { kernels, bodies: HashMap::new() }
    }

    /// Those of a body of a partition, made ready if they are not.
    pub fn of(
        &mut self,
        gpu: &Gpu,
        partition: &Partition,
        (index, body): (usize, &BodyAssembly),
    ) -> Result<&Normals, GpuError> {
        Ok(match self.bodies.entry(index) {
            Entry::Occupied(there) => there.into_mut(),
            Entry::Vacant(room) => room.insert(Normals::new(gpu, &self.kernels, partition, body)?),
        })
    }
}

/// Buffers of one body, bound to the kernel.
pub struct Normals {
    /// Unit normals in the first three, by the user's nodes.
    out: Buffer<Four>,
    /// Reading either state.
    bound: [Bound; 2],
}

impl Normals {
    fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        partition: &Partition,
        body: &BodyAssembly,
    ) -> Result<Self, GpuError> {
        let triangles = body.user_surface().triangles;
        let by_node = Csr::corners(body.nodes, &triangles);
        let place = |&node: &u32| (body.solver_index(node as usize) - partition.places.start) as u32;
        let places: Vec<u32> = triangles.as_flattened().iter().map(place).collect();
        let places = gpu.buffer_from("corners of triangles", &places)?;
        let starts = gpu.buffer_from("rows of corners", &by_node.offsets)?;
        let corners = gpu.buffer_from("corners by node", &by_node.items)?;
        let out = gpu.buffer("normals", body.nodes)?;
        let kernel = kernels.get(Name::new("vertex_normals"), &Overrides::new())?;
        let bound = [0, 1].map(|from| {
            kernel.bind(
                gpu,
                &[
                    ("triangle_places", &places),
                    ("corner_starts", &starts),
                    ("node_corners", &corners),
                    ("old_position", &partition.states[from].position),
                    ("normals", &out),
                ],
            )
        });
        Ok(Self { out, bound })
    }

    /// Computes the normals of now, and reads them.
    pub fn read(&self, gpu: &Gpu, partition: &Partition) -> Result<Vec<[f32; 3]>, GpuError> {
        let mut list = DispatchList::new();
        list.stage("normals");
        list.dispatch(&self.bound[partition.current], &[], self.out.len().div_ceil(GROUP) as u32);
        gpu.submit(&list)?;
        Ok(self.out.read(gpu)?.into_iter().map(|[x, y, z, _]| [x, y, z]).collect())
    }
}
