//! What spring_centric.wgsl works on: every spring once.

use crate::kernels::parts::{GROUP, go_on_in_place, with_loads};
use crate::kernels::volume::KeptVolumes;
use taffeta::extension::{Bodies, BodyAssembly, BodySprings, Command, GRID_STEPS, Name};
use taffeta::springs::SpringList;
use taffeta::taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta::taffeta_gpu::{Bindable, Buffer, Gpu, GpuError};

/// `Spring` of spring_centric.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
pub struct Spring {
    pub a: u32,
    pub b: u32,
    pub rest_length: f32,
    pub kind: u32,
}

/// Springs of some bodies, kind after kind, so that neighbouring threads read neighbouring nodes.
#[derive(Default)]
struct Listed {
    springs: Vec<Spring>,
    /// Stiffness [N/m], damping [kg/s].
    kinds: Vec<[f32; 2]>,
}

/// Springs on the device, and the forces to which they add.
pub struct SpringLists {
    springs: Buffer<Spring>,
    kinds: Buffer<[f32; 2]>,
    /// Three numbers a node.
    forces: Buffer<u32>,
    volumes: KeptVolumes,
}

impl Listed {
    fn add(&mut self, k: f64, damping: f64, springs: impl Iterator<Item = ([u32; 2], f64)>) {
        let kind = self.kinds.len() as u32;
        self.kinds.push([k as f32, damping as f32]);
        self.springs.extend(springs.map(|([a, b], rest)| Spring { a, b, rest_length: rest as f32, kind }));
    }

    /// Adds a body whose nodes are counted from `first` on.
    fn add_body(&mut self, body: &BodyAssembly, first: u32) {
        match (&body.springs, body.grid_layout) {
            (BodySprings::Mesh(lists), _) => lists.iter().for_each(|list: &SpringList| {
                let ends = list.pairs.iter().map(|pair| pair.map(|node| first + node));
                self.add(list.k, list.d, ends.zip(list.rest.iter().copied()));
            }),
            (BodySprings::Grid(along), Some(sides)) => {
                for (step, numbers) in GRID_STEPS.into_iter().zip(along) {
                    let Some([k, damping, rest]) = *numbers else { continue };
                    let ends = grid_ends(sides, step).map(|pair| pair.map(|node| first + node));
                    self.add(k, damping, ends.map(|ends| (ends, rest)));
                }
            }
            (BodySprings::Grid(_), None) => {}
        }
    }
}

/// Both ends of each spring of one direction of a grid, row by row.
fn grid_ends([rows, cols]: [usize; 2], (down, across): (usize, isize)) -> impl Iterator<Item = [u32; 2]> {
    (0..rows.saturating_sub(down)).flat_map(move |row| {
        (0..cols).filter_map(move |col| {
            let end = col.checked_add_signed(across).filter(|&end| end < cols)?;
            Some([row * cols + col, (row + down) * cols + end].map(|node| node as u32))
        })
    })
}

impl SpringLists {
    pub fn new(gpu: &Gpu, bodies: &Bodies<'_>) -> Result<Self, GpuError> {
        let mut listed = Listed::default();
        for (_, body) in bodies.iter() {
            listed.add_body(body, bodies.local(body.first));
        }
        let volumes = KeptVolumes::new(gpu, bodies, true)?;
        Self::of_springs(gpu, &listed.springs, &listed.kinds, volumes, bodies.len())
    }

    /// Springs that are listed already.
    pub fn of_springs(
        gpu: &Gpu,
        springs: &[Spring],
        kinds: &[[f32; 2]],
        volumes: KeptVolumes,
        places: usize,
    ) -> Result<Self, GpuError> {
        Ok(Self {
            springs: gpu.buffer_from("springs with both ends", springs)?,
            kinds: gpu.buffer_from("kinds of springs", kinds)?,
            forces: gpu.buffer("forces of springs", 3 * places)?,
            volumes,
        })
    }

    /// Number of springs.
    pub fn count(&self) -> usize {
        self.springs.len()
    }

    /// Forces of springs and volumes, then the rest; so many workgroups take all nodes.
    pub fn commands<'f>(&self, nodes: usize, loads_given: bool) -> Vec<Command<'f>> {
        let run = |name, groups| Command::run(name, groups);
        let mut all = vec![run(Name::new("spring_centric_forces"), self.count().div_ceil(GROUP))];
        if self.volumes.count() > 0 {
            all.extend([
                Command::Label("volumes"),
                run(Name::new("compute_volume"), self.volumes.count().div_ceil(GROUP)),
                run(Name::new("compute_jacobian"), nodes),
                run(with_loads("build_system", loads_given), nodes),
                run(Name::new("accumulate_force"), nodes),
            ]);
        }
        all.extend(go_on_in_place());
        all.push(run(with_loads("spring_centric_update", loads_given), nodes));
        all
    }

    pub fn buffers(&self) -> Vec<(&'static str, &dyn Bindable)> {
        let mut buffers: Vec<(&'static str, &dyn Bindable)> = vec![
            ("springs", &self.springs),
            ("spring_kinds", &self.kinds),
            ("force_bits", &self.forces),
            ("force_numbers", &self.forces),
        ];
        buffers.extend(self.volumes.buffers());
        buffers
    }
}
