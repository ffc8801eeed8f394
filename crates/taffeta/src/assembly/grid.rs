//! A grid by solver index. What follows from its rows, columns and extent is not written out.

use crate::advice::Advice;
use crate::assembly::body::at;
use crate::assembly::body::{BodyAssembly, BodySprings, GridDirections};
use crate::extensions::Extensions;
use crate::scene::{Body, Grid, Kind, SceneError, Spring};
use crate::topology::{Placement, mass};

/// Columns beyond which a grid is kept with rows and columns exchanged, if that makes its rows shorter: the last rows
/// of a sweep must stay in the second-level cache.
const LONG_ROW: usize = 2048;

/// A grid by solver index.
pub(crate) fn build(body: &Body, grid: Grid) -> Result<BodyAssembly, SceneError> {
    if body.kind == Kind::Soft {
        let message = "a soft body needs a closed surface, and a grid is open; a cloth would do";
        return Err(SceneError::new("kind", message).advise(Advice::Cloth));
    }
    let (rows, cols) = (grid.rows as usize, grid.cols as usize);
    let exchanged = cols > LONG_ROW && rows < cols;
    let [x, z] = grid.size.map(|s| s / 2.0);
    let placement = at(Placement::new(&body.place, &[[-x, 0.0, -z], [x, 0.0, z]]))?;
    let size = grid.size.map(|s| s * placement.factor);
    let mass = body.mass_given().ok_or_else(|| SceneError::new("", "has no mass"))?;
    let mut mass = mass::grid_lump(grid.rows, grid.cols, size, mass).map_err(|m| SceneError::new("", m))?;
    let place = |row, col| placement.apply(place_of(grid, row, col));
    let nodes = rows * cols;
    let mut springs = directions(body, grid, size)?;
    let (start, solver_of_node) = if exchanged {
        springs.swap(0, 2);
        springs.swap(1, 3);
        mass = (0..nodes).map(|n| mass[n % rows * cols + n / rows]).collect();
        let solver_of_node = (0..nodes).map(|n| (n % cols * rows + n / cols) as u32).collect();
        ((0..nodes).map(|n| place(n % rows, n / rows)).collect(), Some(solver_of_node))
    } else {
        ((0..nodes).map(|n| place(n / cols, n % cols)).collect(), None)
    };
    Ok(BodyAssembly {
        name: String::new(),
        first: 0,
        nodes,
        grid: Some(grid),
        grid_layout: Some(if exchanged { [cols, rows] } else { [rows, cols] }),
        surface: None,
        placement,
        solver_of_node,
        free: vec![true; nodes],
        mass,
        springs: BodySprings::Grid(springs),
        closed_triangles: Vec::new(),
        rest_volume: None,
        extensions: Extensions::default(),
        warnings: Vec::new(),
        edges: None,
        split: Vec::new(),
        start_velocity: Vec::new(),
        start,
    })
}

/// A grid's node before placement [m].
fn place_of(grid: Grid, row: usize, col: usize) -> [f64; 3] {
    let along = |index: usize, count: u32, extent: f64| {
        if count > 1 { (index as f64 / f64::from(count - 1) - 0.5) * extent } else { 0.0 }
    };
    [along(col, grid.cols, grid.size[0]), 0.0, along(row, grid.rows, grid.size[1])]
}

/// Springs of a grid by direction; rest lengths follow from its spacing.
fn directions(body: &Body, grid: Grid, size: [f64; 2]) -> Result<GridDirections, SceneError> {
    if body.springs.internal.as_ref().is_some_and(|i| i.count > 0 || i.pairs.is_some()) {
        return Err(SceneError::new(
            "springs.internal",
            "a grid has no inside; struts are for closed meshes",
        ));
    }
    let step = |extent: f64, nodes: u32| if nodes > 1 { extent / f64::from(nodes - 1) } else { 0.0 };
    let (dx, dz) = (step(size[0], grid.cols), step(size[1], grid.rows));
    let diagonal = (dx * dx + dz * dz).sqrt();
    let make = |spring: Option<Spring>, length: f64| spring.map(|s| [s.k, s.d, length]);
    let s = &body.springs;
    Ok([
        make(s.structural, dx),
        make(s.bend, 2.0 * dx),
        make(s.structural, dz),
        make(s.bend, 2.0 * dz),
        make(s.shear, diagonal),
        make(s.shear, diagonal),
    ])
}
