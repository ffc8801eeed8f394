//! What a frame never changes, by segment: some whole bodies, as many as one binding can hold.

use crate::attachments::gpu::{self as attached, Attached};
use crate::build::Assembly;
use crate::build::body::{BodyAssembly, BodySprings, GridDirections};
use crate::contact::nodes::gpu as touching;
use crate::elements::load::build::LoadKind;
use crate::elements::spring::lists::SpringKind;
use crate::gpu::layout::{
    Along, Chunk, Entry, FORCE, Four, GROUP, Grid, Hinge, IS_LOAD, IS_RING, Load, NOT_A_MESH, Panel, Pin,
    RESTORED, Run, Small, Surface, TILE, TORQUE, Tile, VolumeGroup, WEIGHTED,
};
use crate::solvers::dual::gpu_tables::{self as linked, Linked};
use crate::solvers::implicit::gpu_layout::VECTORS;
use crate::solvers::implicit::gpu_tables::{self as levelled, Levelled};
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// Triangles that one workgroup sums up.
const CHUNK: usize = 4096;

/// A segment on the host. All indices are counted from its first place.
#[derive(Default)]
pub struct Tables {
    /// Its places among those of the scene.
    pub places: Range<usize>,
    pub position: Vec<Four>,
    pub velocity: Vec<Four>,
    pub grids: Vec<Grid>,
    pub tiles: Vec<Tile>,
    /// Meshes that keep no volume.
    pub meshes: Vec<Small>,
    /// Kinds of springs that a slice has at most; 0: no mesh.
    pub kinds: usize,
    pub runs: Vec<Run>,
    pub entries: Vec<Entry>,
    pub volume_groups: Vec<VolumeGroup>,
    /// Weight of each place of the bodies that keep a volume, one body after the other.
    pub weights: Vec<f32>,
    /// Which of the scene's volumes are theirs.
    pub volume_numbers: Vec<usize>,
    /// Bodies whose nodes touch others.
    pub surfaces: Vec<Surface>,
    /// Which places are theirs, and which of their nodes do not touch.
    pub apart: Vec<u32>,
    /// Springs that are constraints, or may become some.
    pub linked: Linked,
    /// Springs that are solved for by nodes.
    pub levelled: Levelled,
    pub hinges: Vec<Hinge>,
    /// Triangles that air acts on.
    pub panels: Vec<Panel>,
    pub loads: Vec<Load>,
    pub load_nodes: Vec<u32>,
    /// Loads, then hinges' corners, then panels of each place; without rows where there are neither.
    pub elements: Csr,
    /// Which of the scene's loads `loads` are.
    pub load_numbers: Vec<usize>,
    pub pins: Vec<Pin>,
    /// Joints and tethers.
    pub attached: Attached,
    pub chunks: Vec<Chunk>,
    /// The body of each chunk.
    pub chunk_bodies: Vec<usize>,
    pub corners: Vec<u32>,
}

/// Bytes of the largest array that a body needs, and what it holds.
fn largest_array(
    body: &BodyAssembly,
    constraints: usize,
    levels: Option<usize>,
    panels: usize,
) -> (u64, &'static str) {
    let springs = match &body.springs {
        BodySprings::Grid(_) => 0,
        // Slices are as long as their longest row; a quarter more is what meshes were seen to need.
        BodySprings::Mesh(lists) => lists.iter().map(|list| list.pairs.len() as u64 * 5 / 2).sum(),
    };
    let kept = if body.volume.is_some() { body.places() as u64 } else { 0 };
    let by_nodes = levels.is_some();
    // Slots of a slice are as many as its longest node has.
    let blocks = if by_nodes { constraints * size_of::<Four>() * 5 / 2 } else { 0 };
    let vectors = levels.map_or(0, |coarser| (body.places() + coarser) * VECTORS * size_of::<Four>());
    let constraints = if by_nodes { 0 } else { constraints };
    let arrays = [
        (vectors as u64, "vectors of springs"),
        (blocks as u64, "blocks of springs"),
        ((body.places() * size_of::<Four>()) as u64, "positions"),
        (kept * 2 * size_of::<Four>() as u64, "forces and gradients"),
        (springs * size_of::<Entry>() as u64, "springs"),
        (constraints as u64 * linked::ROW_BYTES, "constraints"),
        (((body.hinges.len() * 4 + panels) * size_of::<Four>()) as u64, "forces of hinges and panels"),
        ((body.closed_triangles.len() * 12) as u64, "triangles"),
    ];
    arrays.into_iter().chain(touching::arrays(body)).max_by_key(|array| array.0).unwrap_or_default()
}

/// Bodies that go together, so that none of their arrays is larger than `limit` bytes; the error names the body that
/// does not fit even alone.
pub fn segments(assembly: &Assembly, limit: u64) -> Result<Vec<Range<usize>>, String> {
    let mut segments: Vec<Range<usize>> = Vec::new();
    let mut taken = 0;
    for (index, body) in assembly.bodies.iter().enumerate() {
        let constraints = assembly.constraints.bodies.get(index).map_or(0, Range::len);
        let levels = assembly.solver.is_primal().then(|| levelled::coarser_nodes(assembly, index));
        let panels = if assembly.panels.len() > 0 { body.triangles() } else { 0 };
        let (bytes, what) = largest_array(body, constraints, levels, panels);
        if bytes > limit {
            return Err(format!(
                "body `{}` needs {bytes} bytes in one piece for its {what}, and the GPU gives a kernel {limit} at most; \
                 --backend cpu or a coarser mesh would do",
                body.name
            ));
        }
        match segments.last_mut() {
            Some(last) if taken + bytes <= limit => {
                last.end = index + 1;
                taken += bytes;
            }
            _ => {
                segments.push(index..index + 1);
                taken = bytes;
            }
        }
    }
    touching::check_together(assembly, &segments, limit)?;
    attached::check_together(assembly, &segments, limit)?;
    Ok(segments)
}

impl Tables {
    /// The tables of some bodies.
    pub fn new(assembly: &Assembly, bodies: Range<usize>) -> Result<Self, String> {
        let chosen = &assembly.bodies[bodies.clone()];
        let first = chosen.first().map_or(0, |body| body.first);
        let end = chosen.last().map_or(0, |body| body.first + body.places());
        let mut tables = Self { places: first..end, ..Self::default() };
        tables.kinds = chosen.iter().map(kinds).max().unwrap_or(0);
        for (index, body) in bodies.clone().zip(chosen) {
            tables.add_nodes(body);
            match &body.springs {
                BodySprings::Grid(along) => tables.add_grid(body, along),
                BodySprings::Mesh(_) => tables.add_mesh(body)?,
            }
            tables.add_hinges(body);
            tables.add_volume(index, body);
        }
        tables.keep_volumes(assembly, chosen);
        tables.add_surfaces(chosen)?;
        tables.add_constraints(assembly, bodies.clone())?;
        tables.add_levels(assembly, bodies)?;
        tables.add_panels(assembly);
        tables.add_loads(assembly);
        tables.add_pins(assembly);
        tables.add_attached(assembly);
        tables.list_elements();
        Ok(tables)
    }

    /// Number of places.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// A place's number in the segment.
    pub(crate) fn local(&self, node: usize) -> u32 {
        (node - self.places.start) as u32
    }

    fn add_nodes(&mut self, body: &BodyAssembly) {
        for ((place, &mass), &free) in body.start.iter().zip(&body.mass).zip(&body.free) {
            let [x, y, z] = place.map(|c| c as f32);
            self.position.push([x, y, z, if free { (1.0 / mass) as f32 } else { 0.0 }]);
            self.velocity.push([0.0, 0.0, 0.0, mass as f32]);
        }
        let end = self.local(body.first + body.places()) as usize;
        self.position.resize(end, [0.0; 4]);
        self.velocity.resize(end, [0.0; 4]);
    }

    fn add_grid(&mut self, body: &BodyAssembly, along: &GridDirections) {
        let Some([rows, cols]) = body.grid_layout else { return };
        let grid = self.grids.len() as u32;
        let direction = |along: Option<[f64; 3]>| {
            along.map_or_else(Along::default, |numbers| {
                let [k, damping, rest_length] = numbers.map(|number| number as f32);
                Along { k, damping, rest_length, there: 1 }
            })
        };
        self.grids.push(Grid {
            first: self.local(body.first),
            rows: rows as i32,
            cols: cols as i32,
            along: along.map(direction),
        });
        for row in (0..rows).step_by(TILE[0]) {
            let tile = |col: usize| Tile { grid, row: row as i32, col: col as i32 };
            self.tiles.extend((0..cols).step_by(TILE[1]).map(tile));
        }
        let no_run = Run { start: 0, count: NOT_A_MESH, k: 0.0, damping: 0.0 };
        self.runs.resize(self.runs.len() + body.places() / LANES * self.kinds, no_run);
    }

    /// Lays out a mesh's springs, and gives back their lengths in the assembly's lists.
    fn add_mesh(&mut self, body: &BodyAssembly) -> Result<(), String> {
        let (first, slices) = (self.local(body.first), body.places() / LANES);
        let base = self.runs.len();
        let none = Run { start: 0, count: 0, k: 0.0, damping: 0.0 };
        self.runs.resize(base + slices * self.kinds, none);
        let is_kept = body.volume.is_some();
        if !is_kept {
            self.meshes.push(Small { first, count: body.places() as u32 });
        }
        for (kind, (k, damping, gather)) in body.gathered()?.into_iter().enumerate() {
            let start =
                u32::try_from(self.entries.len()).map_err(|_| "too many springs for 32 bits".to_owned())?;
            for (slice, ends) in gather.slice_starts.windows(2).enumerate() {
                let mark = if is_kept && kind == 0 { IS_RING } else { 0 };
                self.runs[base + slice * self.kinds + kind] = Run {
                    start: start + ends[0],
                    count: ((ends[1] - ends[0]) / LANES as u32) | mark,
                    k: k as f32,
                    damping: damping as f32,
                };
            }
            let entry = |(&neighbour, &rest): (&u32, &f64)| Entry {
                neighbour: first + neighbour,
                rest_length: rest as f32,
            };
            self.entries.extend(gather.neighbour.iter().zip(&gather.rest).map(entry));
        }
        Ok(())
    }

    fn add_hinges(&mut self, body: &BodyAssembly) {
        let first = self.local(body.first);
        self.hinges.extend(body.hinges.iter().zip(&body.hinge_rest).map(|(corners, rest)| Hinge {
            corners: corners.map(|node| node + first),
            rest_angle: rest.angle as f32,
            rest_steepness: rest.steepness as f32,
            k: body.hinge.k as f32,
            damping: body.hinge.d as f32,
        }));
    }

    fn add_panels(&mut self, assembly: &Assembly) {
        let all = assembly.panels.corners.iter().zip(&assembly.panels.lightness);
        let inside = all.filter(|(corners, _)| self.places.contains(&(corners[0] as usize)));
        let panel = |(corners, &lightness): (&[u32; 3], &f64)| {
            let [a, b, c] = corners.map(|node| self.local(node as usize));
            Panel { a, b, c, lightness: lightness as f32 }
        };
        self.panels = inside.map(panel).collect();
    }

    /// Where the forces of panels begin among those of elements.
    pub fn first_panel_force(&self) -> usize {
        4 * self.hinges.len()
    }

    fn add_volume(&mut self, index: usize, body: &BodyAssembly) {
        let origin = self.local(body.first);
        let (first, count) = (self.corners.len() / 3, body.closed_triangles.len());
        for start in (0..count).step_by(CHUNK) {
            let count = CHUNK.min(count - start) as u32;
            self.chunks.push(Chunk { origin, first: (first + start) as u32, count });
            self.chunk_bodies.push(index);
        }
        self.corners.extend(body.closed_triangles.as_flattened().iter().map(|node| node + origin));
    }

    /// Cuts the bodies that keep a volume into groups, in the order of [`Assembly::volumes`].
    fn keep_volumes(&mut self, assembly: &Assembly, chosen: &[BodyAssembly]) {
        let inside = |body: &BodyAssembly| chosen.iter().any(|one| one.first == body.first);
        let all = assembly.volumes().enumerate().filter(|(_, (body, _))| inside(body));
        for (goal, (number, (body, kept))) in (0..).zip(all) {
            let (first, first_group) = (self.local(body.first), self.volume_groups.len() as u32);
            let gradients = (self.len() + self.weights.len()) as u32;
            let flag = |is: bool, flag: u32| if is { flag } else { 0 };
            let flags = flag(kept.weights.is_some(), WEIGHTED) | flag(kept.projects, RESTORED);
            self.volume_groups.extend((0..body.nodes).step_by(GROUP).map(|start| VolumeGroup {
                first: first + start as u32,
                count: GROUP.min(body.nodes - start) as u32,
                gradients: gradients + start as u32,
                origin: first,
                first_group,
                groups: body.nodes.div_ceil(GROUP) as u32,
                goal,
                form: kept.form as u32,
                flags,
            }));
            let weight = |node: usize| kept.weights.as_ref().map_or(1.0, |weights| weights[node] as f32);
            self.weights.extend((0..body.nodes).map(weight));
            self.weights.resize(self.weights.len().next_multiple_of(LANES), 0.0);
            self.volume_numbers.push(number);
        }
    }

    /// Room for forces by place and, behind them, gradients with weights.
    pub fn forces(&self) -> Vec<Four> {
        let gradients = self.weights.iter().map(|&weight| [0.0, 0.0, 0.0, weight]);
        std::iter::repeat_n([0.0; 4], self.len()).chain(gradients).collect()
    }

    fn add_loads(&mut self, assembly: &Assembly) {
        for (number, load) in assembly.loads.iter().enumerate() {
            // A load is on one body.
            if !load.nodes.first().is_some_and(|&node| self.places.contains(&(node as usize))) {
                continue;
            }
            let (kind, vector, about, torque) = match load.kind {
                LoadKind::Force(force) => (FORCE, force, [0.0; 3], 0.0),
                LoadKind::Torque { axis, value, about } => (TORQUE, axis, about, value),
            };
            self.load_numbers.push(number);
            self.loads.push(Load {
                vector: vector.map(|c| c as f32),
                kind,
                about: about.map(|c| c as f32),
                torque: torque as f32,
                first: self.load_nodes.len() as u32,
                count: load.nodes.len() as u32,
                factor: 0.0,
                padding: 0,
            });
            let nodes: Vec<u32> = load.nodes.iter().map(|&node| self.local(node as usize)).collect();
            self.load_nodes.extend(nodes);
        }
    }

    fn add_pins(&mut self, assembly: &Assembly) {
        let inside = assembly.moving_pins.iter().filter(|pin| self.places.contains(&(pin.node as usize)));
        self.pins = inside
            .map(|pin| Pin {
                start: pin.start.map(|c| c as f32),
                node: self.local(pin.node as usize),
                goal: [0.0; 3],
                track: pin.track,
            })
            .collect();
    }

    /// Loads come first in a node's row, in the scene's order.
    fn list_elements(&mut self) {
        let of_load = |(load, number): (&Load, u32)| {
            let range = load.first as usize..(load.first + load.count) as usize;
            self.load_nodes[range].iter().map(move |&node| (node, number | IS_LOAD))
        };
        let loads = self.loads.iter().zip(0..).flat_map(of_load);
        let hinges = self.hinges.iter().flat_map(|hinge| hinge.corners).zip(0..);
        let first = self.first_panel_force() as u32;
        let of_panel = |(panel, force): (&Panel, u32)| [panel.a, panel.b, panel.c].map(|node| (node, force));
        let panels = self.panels.iter().zip(first..).flat_map(of_panel);
        self.elements = Csr::new(self.len(), loads.chain(hinges).chain(panels));
    }

    /// Whether anything but wind and drag acts on nodes beside springs.
    pub fn has_elements(&self) -> bool {
        !self.loads.is_empty() || !self.hinges.is_empty() || !self.panels.is_empty()
    }

    /// Workgroups for one invocation a place.
    pub fn place_groups(&self) -> usize {
        self.len().div_ceil(GROUP)
    }
}

fn kinds(body: &BodyAssembly) -> usize {
    match &body.springs {
        BodySprings::Grid(_) => 0,
        // A mesh without springs still has places: an empty kind.
        BodySprings::Mesh(lists) => {
            let structural = lists.first().is_some_and(|list| list.kind == SpringKind::Structural);
            // A volume needs rings, with springs or without.
            (lists.len() + usize::from(body.volume.is_some() && !structural)).max(1)
        }
    }
}
