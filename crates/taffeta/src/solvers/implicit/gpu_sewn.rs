//! What seams make of the systems of springs on the GPU: points of nodes, and levels once all of them are closed.

use crate::gpu::bodies::Bodies;
use crate::gpu::feature::Command;
use crate::gpu::kernels::Name;
use crate::solvers::implicit::gpu_layout::{Parents, Weight, WeightedIndex};
use crate::solvers::implicit::gpu_tables::{CouplingWords, MultigridTables};
use crate::solvers::implicit::sewn::SewnPoints;
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError};

/// What nodes of each level follow on the next coarser one, and blocks of elements, whose place that tells.
pub struct Followers {
    parents: Buffer<Parents>,
    children: Buffer<WeightedIndex>,
    couplings: Option<CouplingBuffers>,
}

/// Blocks of elements, and what they are made of.
struct CouplingBuffers {
    blocks: Buffer<[u32; 4]>,
    sources: Buffer<[u32; 2]>,
}

impl Followers {
    pub fn new(gpu: &Gpu, multigrid: &MultigridTables) -> Result<Self, GpuError> {
        let couplings = |words: &CouplingWords| -> Result<_, GpuError> {
            Ok(CouplingBuffers {
                blocks: gpu.buffer_from("blocks of elements", &words.words)?,
                sources: gpu.buffer_from("sources of blocks", &words.sources)?,
            })
        };
        Ok(Self {
            parents: gpu.buffer_from("coarser nodes", &multigrid.parents)?,
            children: gpu.buffer_from("finer nodes", &multigrid.children)?,
            couplings: multigrid.couplings.as_ref().map(couplings).transpose()?,
        })
    }

    /// Whether other elements than springs are solved for.
    pub fn has_elements(&self) -> bool {
        self.couplings.is_some()
    }

    /// Its buffers by their names in the shaders.
    pub fn buffers(&self) -> Vec<(&'static str, &dyn Bindable)> {
        let mut all: Vec<(&'static str, &dyn Bindable)> =
            vec![("parents", &self.parents), ("children", &self.children)];
        if let Some(CouplingBuffers { blocks, sources }) = &self.couplings {
            let both: [(&'static str, &dyn Bindable); 2] =
                [("couplings", blocks), ("coupling_sources", sources)];
            all.extend(both);
        }
        all
    }
}

/// Points that seams make of some bodies' nodes.
#[derive(Default)]
pub struct SewnLists {
    /// Where the nodes of each begin, and where the last one's end.
    pub starts: Vec<u32>,
    pub nodes: Vec<u32>,
    /// Systems that they join, two by two.
    pub links: Vec<[u32; 2]>,
}

impl SewnLists {
    /// Those of some bodies, if they have any.
    pub fn new(bodies: &Bodies<'_>, points: &SewnPoints) -> Option<Self> {
        let assembly = bodies.assembly;
        let mut all = Self { starts: vec![0], ..Self::default() };
        for point in (0..points.nodes.rows()).map(|point| points.nodes.row(point)) {
            // Bodies that are sewn to each other are on the device together.
            if point.iter().all(|&node| bodies.has(node)) {
                all.nodes.extend(point.iter().map(|&node| bodies.local(node as usize)));
                all.starts.push(all.nodes.len() as u32);
            }
        }
        let is_solved = |body: &usize| assembly.is_solved_for(*body);
        let system = |body: u32| (bodies.range.start..body as usize).filter(is_solved).count() as u32;
        let links = points.links.iter().filter(|link| bodies.range.contains(&(link[0] as usize)));
        all.links = links.map(|link| link.map(system)).collect();
        (!all.nodes.is_empty()).then_some(all)
    }
}

/// The same on the device.
pub struct Sewn {
    starts: Buffer<u32>,
    nodes: Buffer<u32>,
    links: Buffer<[u32; 2]>,
    /// How many systems they join, two by two.
    count: usize,
    /// Whether all seams are closed.
    is_closed: bool,
    /// By node of points: the weight of those before it.
    weights: Buffer<Weight>,
    /// Workgroups of a kernel for each point.
    groups: usize,
}

impl Sewn {
    /// Those of some bodies, if they have any.
    pub fn new(gpu: &Gpu, multigrid: &MultigridTables) -> Result<Option<Self>, GpuError> {
        let Some(lists) = &multigrid.sewn else { return Ok(None) };
        Ok(Some(Self {
            starts: gpu.buffer_from("points of seams", &lists.starts)?,
            nodes: gpu.buffer_from("sewn nodes", &lists.nodes)?,
            links: gpu.buffer_from("sewn systems", &lists.links)?,
            count: lists.links.len(),
            is_closed: false,
            weights: gpu.buffer("weights of sewn nodes", lists.nodes.len())?,
            groups: multigrid.point_groups() as usize,
        }))
    }

    /// Notes whether all seams are closed. Returns whether that is another answer than before.
    pub fn close(&mut self, is_closed: bool) -> bool {
        std::mem::replace(&mut self.is_closed, is_closed) != is_closed
    }

    /// Whether all seams are closed.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Whether they ever join systems.
    pub fn may_join(&self) -> bool {
        self.count > 0
    }

    /// How many systems are joined now, two by two.
    pub fn links(&self) -> usize {
        if self.is_closed { self.count } else { 0 }
    }

    /// A kernel for each point, where seams are closed.
    pub fn command(&self, entry: Name) -> Option<Command<'_>> {
        self.is_closed.then(|| Command::run(entry, self.groups))
    }

    /// Its buffers by their names in the shaders.
    pub fn buffers(&self) -> [(&'static str, &dyn Bindable); 4] {
        [
            ("sewn_starts", &self.starts),
            ("sewn_nodes", &self.nodes),
            ("sewn_links", &self.links),
            ("sewn_weights", &self.weights),
        ]
    }
}
