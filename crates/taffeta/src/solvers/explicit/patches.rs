//! How bodies are cut into patches that fit the memory of a workgroup.

use crate::contact::collider_mesh::tree::WALK_TURNS;
use crate::elements::spring::gpu::SpringTables;
use crate::elements::spring::gpu_layout::{Grid, NOT_A_MESH, ResidentMesh, Run};
use crate::gpu::layout::{GROUP, SUBSTEPS_SEEN};
use crate::solvers::explicit::gpu_layout::{OWN, PATCH_NODE_BYTES, Part, Patch};
use crate::step::Parts;
use taffeta_gpu::wgpu::Limits;

/// Side of the square of a grid that a patch with a rim writes [nodes].
const INNER: i32 = 16;
/// Sub-steps that a patch with a rim takes at once: with its rim it is 24 × 24.
const RIMMED_STEPS: u32 = 2;

/// Patches of a segment, and the sub-steps that they take at once.
#[derive(Default)]
pub struct Patches {
    pub grids: Vec<Patch>,
    pub meshes: Vec<ResidentMesh>,
    pub steps: u32,
}

/// Nodes that a patch has room for on a device.
pub fn room(limits: &Limits) -> u32 {
    (limits.max_compute_workgroup_storage_size / PATCH_NODE_BYTES).min((OWN * GROUP) as u32)
}

/// Memory of a workgroup that a square with its rim takes [bytes].
pub fn rimmed_bytes() -> u32 {
    let side = INNER as u32 + 4 * RIMMED_STEPS;
    side * side * PATCH_NODE_BYTES
}

/// Turns of all its loops that an invocation may take: Mesa's software driver ends it after 65,536, without a word.
pub const MOST_TURNS: usize = 60_000;
/// Turns that contact takes for each collider: each is met, entered in twelve steps and two looks, and a wedge is left in twelve
/// rounds.
pub const COLLIDER_TURNS: usize = 27;
/// Turns that it takes for each mesh beside walks: each acts in five rounds, or is looked at once more, and is looked at in the rounds
/// in which wedges are left; a look has three walks and an end.
const MESH_TURNS: usize = 6 + 6 * 4 + 12 * 4;

/// Turns that contact with colliders takes at most, walks through the triangles of meshes included.
pub fn collider_turns(colliders: usize, meshes: usize) -> usize {
    COLLIDER_TURNS * colliders + MESH_TURNS * meshes + 8 * WALK_TURNS as usize * meshes.min(1)
}

/// Sub-steps that an invocation can take at once.
fn steps(tables: &SpringTables, colliders: usize) -> usize {
    let kinds = tables.kinds.max(1);
    let row = |runs: &[Run]| {
        runs.iter().map(|run| if run.count == NOT_A_MESH { 0 } else { run.count as usize }).sum()
    };
    let springs: usize = tables.runs.chunks(kinds).map(row).max().unwrap_or(0);
    let turns = OWN * (COLLIDER_TURNS * colliders + springs + kinds + 2);
    (MOST_TURNS / turns).min(SUBSTEPS_SEEN)
}

impl Patches {
    /// Each body whole, if all have room, for as many sub-steps as can be taken at once; `None` where that is one,
    /// or where bodies have more than springs: sums over a body, and other bodies, are no part of a patch.
    pub fn whole(tables: &SpringTables, parts: &Parts, room: u32, colliders: usize) -> Option<Self> {
        if !parts.are_local() {
            return None;
        }
        let nodes = |grid: &Grid| (grid.rows * grid.cols) as u32;
        let fits = tables.grids.iter().all(|grid| nodes(grid) <= room)
            && tables.meshes.iter().all(|mesh| mesh.count <= room);
        let whole = |(grid, shape): (u32, &Grid)| {
            let all = Part { first_row: 0, first_col: 0, end_row: shape.rows, end_col: shape.cols };
            Patch { grid, all, inner: all }
        };
        let steps = steps(tables, colliders) as u32;
        (fits && steps > 1).then(|| Self {
            grids: (0..).zip(&tables.grids).map(whole).collect(),
            meshes: tables.meshes.clone(),
            steps,
        })
    }

    /// Squares of grids with a rim, if there are only grids, and none that touch.
    pub fn rimmed(tables: &SpringTables, parts: &Parts, room: u32) -> Option<Self> {
        let rim = 2 * RIMMED_STEPS as i32;
        let fits = tables.meshes.is_empty() && parts.are_local() && rimmed_bytes() <= room * PATCH_NODE_BYTES;
        fits.then(|| Self {
            grids: Self::squares(&tables.grids, rim),
            meshes: Vec::new(),
            steps: RIMMED_STEPS,
        })
    }
}

impl Patches {
    /// All grids in squares with a rim.
    pub fn squares(grids: &[Grid], rim: i32) -> Vec<Patch> {
        (0..).zip(grids).flat_map(|(grid, shape)| squares(grid, shape.rows, shape.cols, rim)).collect()
    }
}

fn squares(grid: u32, rows: i32, cols: i32, rim: i32) -> Vec<Patch> {
    let starts = |end: i32| (0..end).step_by(INNER as usize);
    let square = |row: i32, col: i32| {
        let (end_row, end_col) = (rows.min(row + INNER), cols.min(col + INNER));
        let all = Part {
            first_row: (row - rim).max(0),
            first_col: (col - rim).max(0),
            end_row: (end_row + rim).min(rows),
            end_col: (end_col + rim).min(cols),
        };
        Patch { grid, all, inner: Part { first_row: row, first_col: col, end_row, end_col } }
    };
    starts(rows).flat_map(|row| starts(cols).map(move |col| square(row, col))).collect()
}
