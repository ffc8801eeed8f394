//! Whether a shape's numbers make sense.

use crate::scene::validate::path::plain;
use crate::scene::validate::surface::{MESH_NODES, check_surface};
use crate::scene::{Cylinder, Disc, Grid, Mesh, Sheet, Torus};

/// Where in the body, as keys, and what is wrong.
type Refusal = (&'static str, String);

/// Most nodes of a grid, which the engine does not write out.
const GRID_NODES: u64 = 1 << 31;
/// Largest length of a shape [m], and largest extent of a body as placed.
pub(crate) const LARGEST_LENGTH: f64 = 1e6;

/// Checks the sizes of a mesh, or the indices and places of one given as data. The error is (field, message), the
/// field as keys from the body: `mesh.torus.minor`.
pub(crate) fn check_shape(mesh: &Mesh) -> Result<(), Refusal> {
    match mesh {
        Mesh::Grid(grid) => check_grid(grid),
        Mesh::Sheet(sheet) => check_sheet(sheet),
        Mesh::Disc(disc) => check_disc(disc),
        Mesh::File(name) => {
            demand(!name.is_empty(), "mesh.file", || "is empty, the name of a file would do".into())
        }
        Mesh::Icosphere(ball) => {
            positive("mesh.icosphere.radius", ball.radius)?;
            let fine = ball.subdivisions <= 9;
            demand(fine, "mesh.icosphere.subdivisions", || {
                format!("is {}, 0 to 9 would do", ball.subdivisions)
            })
        }
        Mesh::UvSphere(ball) => {
            positive("mesh.uv_sphere.radius", ball.radius)?;
            at_least("mesh.uv_sphere.rings", ball.rings, 2)?;
            at_least("mesh.uv_sphere.segments", ball.segments, 3)?;
            countable("mesh.uv_sphere", [ball.rings, ball.segments], 1, MESH_NODES)
        }
        Mesh::Torus(torus) => check_torus(torus),
        Mesh::Cube(cube) => {
            positive("mesh.cube.size", cube.size)?;
            at_least("mesh.cube.divisions", cube.divisions, 1)?;
            countable("mesh.cube.divisions", [cube.divisions; 2], 6, MESH_NODES)
        }
        Mesh::Cylinder(cylinder) => check_cylinder(cylinder),
        Mesh::Chain(chain) => {
            positive("mesh.chain.length", chain.length)?;
            at_least("mesh.chain.links", chain.links, 1)?;
            countable("mesh.chain.links", [chain.links, 1], 1, MESH_NODES)
        }
        Mesh::Surface(surface) => check_surface(surface).map_err(|message| ("mesh", message)),
    }
}

fn check_grid(grid: &Grid) -> Result<(), Refusal> {
    at_least("mesh.grid.rows", grid.rows, 1)?;
    at_least("mesh.grid.cols", grid.cols, 1)?;
    let nodes = u64::from(grid.rows) * u64::from(grid.cols);
    demand(nodes >= 2, "mesh.grid", || "has one node; two or more would do".into())?;
    for (count, size) in [(grid.cols, grid.size[0]), (grid.rows, grid.size[1])] {
        if count > 1 || size != 0.0 {
            positive("mesh.grid.size", size)?;
        }
    }
    countable("mesh.grid", [grid.rows, grid.cols], 1, GRID_NODES)
}

fn check_sheet(sheet: &Sheet) -> Result<(), Refusal> {
    sheet.size.iter().try_for_each(|&size| positive("mesh.sheet.size", size))?;
    check_edge("mesh.sheet.edge", sheet.edge, sheet.size[0].min(sheet.size[1]), "the sheet's shorter side")?;
    countable("mesh.sheet.edge", [sheet.nodes(), 1], 1, MESH_NODES)
}

fn check_disc(disc: &Disc) -> Result<(), Refusal> {
    positive("mesh.disc.radius", disc.radius)?;
    check_edge("mesh.disc.edge", disc.edge, 0.5 * disc.radius, "half the disc's radius")?;
    countable("mesh.disc.edge", [disc.nodes(), 1], 1, MESH_NODES)
}

fn check_edge(field: &'static str, edge: f64, most: f64, name: &str) -> Result<(), Refusal> {
    positive(field, edge)?;
    demand(edge <= most, field, || {
        format!("is {} m, at most {name}, {} m, would do", plain(edge), plain(most))
    })
}

fn check_torus(torus: &Torus) -> Result<(), Refusal> {
    positive("mesh.torus.major", torus.major)?;
    positive("mesh.torus.minor", torus.minor)?;
    demand(torus.minor < torus.major, "mesh.torus.minor", || {
        format!(
            "is {} m, but the tube must be thinner than its circle: less than {} m",
            torus.minor, torus.major
        )
    })?;
    at_least("mesh.torus.rings", torus.rings, 3)?;
    at_least("mesh.torus.segments", torus.segments, 3)?;
    countable("mesh.torus", [torus.rings, torus.segments], 1, MESH_NODES)
}

fn check_cylinder(cylinder: &Cylinder) -> Result<(), Refusal> {
    positive("mesh.cylinder.radius", cylinder.radius)?;
    positive("mesh.cylinder.height", cylinder.height)?;
    at_least("mesh.cylinder.segments", cylinder.segments, 3)?;
    at_least("mesh.cylinder.rings", cylinder.rings, 1)?;
    countable("mesh.cylinder", [cylinder.rings, cylinder.segments], 2, MESH_NODES)
}

fn demand(met: bool, field: &'static str, message: impl FnOnce() -> String) -> Result<(), Refusal> {
    if met { Ok(()) } else { Err((field, message())) }
}

fn positive(field: &'static str, value: f64) -> Result<(), Refusal> {
    demand(value > 0.0 && value.is_finite(), field, || {
        format!("is {} m, more than 0 would do", plain(value))
    })?;
    demand(value <= LARGEST_LENGTH, field, || {
        format!("is {} m, at most {LARGEST_LENGTH} m would do", plain(value))
    })
}

fn at_least(field: &'static str, value: u32, least: u32) -> Result<(), Refusal> {
    demand(value >= least, field, || format!("is {value}, {least} or more would do"))
}

/// `factor`·a·b nodes, less than `most`.
fn countable<C: Into<u128>>(
    field: &'static str,
    [a, b]: [C; 2],
    factor: u128,
    most: u64,
) -> Result<(), Refusal> {
    let nodes = factor * a.into() * b.into();
    demand(nodes <= most.into(), field, || format!("makes about {nodes} nodes, {most} are the limit"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cube, Icosphere, Pattern, UvSphere};

    #[track_caller]
    fn refused(mesh: Mesh, field: &str, words: &str) {
        let (at, message) = check_shape(&mesh).unwrap_err();
        assert_eq!(at, field);
        assert!(message.contains(words), "{message}");
    }

    #[test]
    fn sizes_without_sense_are_refused_with_what_would_do() {
        refused(Mesh::grid(0, 3, [1.0; 2]), "mesh.grid.rows", "is 0, 1 or more");
        refused(Mesh::grid(1, 1, [0.0; 2]), "mesh.grid", "one node");
        refused(Mesh::grid(2, 2, [1.0, 0.0]), "mesh.grid.size", "is 0 m");
        refused(Mesh::grid(65536, 65536, [1.0; 2]), "mesh.grid", "4294967296 nodes");
        refused(Mesh::chain(0, 1.0), "mesh.chain.links", "1 or more");
        refused(Mesh::chain(3, f64::NAN), "mesh.chain.length", "NaN m");
        refused(Mesh::chain(3, 1e7), "mesh.chain.length", "is 10000000 m, at most 1000000 m");
        refused(Mesh::Cube(Cube { size: 1.0, divisions: u32::MAX }), "mesh.cube.divisions", "limit");
        refused(
            Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 10 }),
            "mesh.icosphere.subdivisions",
            "0 to 9",
        );
        let ball = UvSphere { radius: -1.0, rings: 1, segments: 2 };
        refused(Mesh::UvSphere(ball), "mesh.uv_sphere.radius", "is -1 m");
        let torus = Torus { major: 1.0, minor: 1.0, rings: 3, segments: 3 };
        refused(Mesh::Torus(torus), "mesh.torus.minor", "thinner");
        refused(Mesh::sheet([1.0, -1.0], 0.1), "mesh.sheet.size", "is -1 m, more than 0");
        refused(Mesh::sheet([1.0, 0.1], 0.2), "mesh.sheet.edge", "at most the sheet's shorter side, 0.1 m");
        refused(Mesh::sheet([1.0, 1.0], f64::NAN), "mesh.sheet.edge", "NaN m");
        refused(Mesh::sheet([1.0, 1.0], 1e-300), "mesh.sheet.edge", "are the limit");
        refused(Mesh::sheet([1e6, 1e6], 0.1), "mesh.sheet.edge", "nodes");
        let disc = |radius, edge| Mesh::Disc(Disc { radius, edge, pattern: Pattern::Grid });
        refused(disc(f64::INFINITY, 0.1), "mesh.disc.radius", "inf m");
        refused(disc(0.1, 0.06), "mesh.disc.edge", "at most half the disc's radius, 0.05 m");
        refused(disc(1e6, 1e-300), "mesh.disc.edge", "are the limit");
        assert!(check_shape(&disc(0.1, 0.05)).is_ok());
        refused(Mesh::File(String::new()), "mesh.file", "is empty");
        assert!(check_shape(&Mesh::grid(1, 2, [1.0, 0.0])).is_ok());
    }
}
