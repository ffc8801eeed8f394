//! The bench on a triangle mesh, subdivided until it is large.

use super::measure::Bench;
use super::scenes::FRAME;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use taffeta::scene::{Body, Mass, Mesh, Scene, Torus};
use taffeta::topology::Surface;
use taffeta::{Options, Simulation};
use taffeta_io::program::Failure;

/// Of each node [kg].
const NODE_MASS: f64 = 1e-3;
/// Of each spring [N/m]: well inside the stable step for the valences of meshes.
const STIFFNESS: f64 = 60.0;
/// Of each spring [kg/s].
const DAMPING: f64 = 0.01;
/// What stands in for the armadillo.
const TORUS: Torus = Torus { major: 1.0, minor: 0.4, rings: 160, segments: 64 };

/// Edges of `file`, else of the armadillo where it is there, else of a torus, as springs: about `springs` of them.
/// Splitting ends where one more would be further away from that number, as a ratio.
pub fn bench(file: Option<&Path>, springs: usize) -> Result<Bench, Failure> {
    let armadillo = || model(&["armadillo_30k.ply", "armadillo.ply"]);
    let (origin, surface) = match file.map(Path::to_owned).or_else(armadillo) {
        Some(path) => (path.display().to_string(), load(&path)?),
        None => ("a torus (`cargo xtask models` fetches the armadillo)".to_owned(), torus(&TORUS)?),
    };
    // Three edges for two triangles, where the surface is closed; a split makes four times as many.
    let (surface, times) = split(surface, springs.div_ceil(3));
    let note = format!("mesh: {origin}, each triangle split in four {times} times");
    let n = vec![surface.nodes.len() as u32];
    let disturbance = 0.02 * mean_edge(&surface);
    let body = Body::cloth("mesh", Mesh::Surface(Arc::new(surface)))
        .with_mass(Mass::Node(NODE_MASS))
        .structural(STIFFNESS, DAMPING);
    let scene = Scene::new("bench mesh").body(body).time(FRAME.0, FRAME.1);
    Ok(Bench { disturbance, notes: vec![note], ..Bench::new("mesh", n, scene) })
}

/// The first of these files that `cargo xtask models`, or the user, has put where models are.
pub fn model(names: &[&str]) -> Option<PathBuf> {
    let folders = [Some(PathBuf::from("models")), std::env::var_os("TAFFETA_MODELS").map(PathBuf::from)];
    let folders: Vec<PathBuf> = folders.into_iter().flatten().collect();
    let file = |name: &&str| folders.iter().map(|folder| folder.join(name)).find(|file| file.is_file());
    names.iter().find_map(file)
}

/// The surface in a file.
pub fn load(path: &Path) -> Result<Surface, Failure> {
    let surface = taffeta_io::load_mesh(path, &taffeta_io::MeshOptions::default())
        .map_err(|error| Failure::Input(error.to_string()))?;
    if surface.triangles.is_empty() {
        return Err(Failure::Input(format!("{}: has no triangles", path.display())));
    }
    Ok(surface)
}

/// A torus as a surface.
pub fn torus(torus: &Torus) -> Result<Surface, Failure> {
    let body = Body::cloth("torus", Mesh::Torus(*torus)).with_mass(Mass::Node(NODE_MASS));
    let built = Simulation::new(&Scene::new("torus").body(body), &Options::default())
        .map_err(|error| Failure::Work(error.to_string()))?;
    built.surface(built.bodies()[0].handle).map_err(|error| Failure::Work(error.to_string()))
}

/// The surface with each triangle split in four until there are at least `triangles`, and how many times that was.
pub fn split(mut surface: Surface, triangles: usize) -> (Surface, u32) {
    let mut times = 0;
    while surface.triangles.len() < triangles {
        surface = subdivided(&surface);
        times += 1;
    }
    (surface, times)
}

/// Mean length of the triangles' first edges [m].
fn mean_edge(surface: &Surface) -> f64 {
    let length = |&[a, b, _]: &[u32; 3]| {
        let (p, q) = (surface.nodes[a as usize], surface.nodes[b as usize]);
        (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt()
    };
    surface.triangles.iter().map(length).sum::<f64>() / surface.triangles.len() as f64
}

/// Each triangle split in four at the middles of its edges.
fn subdivided(surface: &Surface) -> Surface {
    let mut nodes = surface.nodes.clone();
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let (p, q) = (surface.nodes[a as usize], surface.nodes[b as usize]);
            nodes.push(std::array::from_fn(|axis| 0.5 * (p[axis] + q[axis])));
            nodes.len() as u32 - 1
        })
    };
    let split = |&[a, b, c]: &[u32; 3]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let triangles: Vec<[u32; 3]> = surface.triangles.iter().flat_map(split).collect();
    Surface::of_triangles(nodes, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_split_triangle_is_four_that_share_middles() {
        let mut one = Surface { triangles: vec![[0, 1, 2]], ..Surface::default() };
        one.nodes = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let four = subdivided(&one);
        assert_eq!((four.nodes.len(), four.triangles.len(), four.polygons.len()), (6, 4, 4));
        assert_eq!(four.nodes[4], [1.0, 2.0, 0.0]);
        assert_eq!(subdivided(&four).nodes.len(), 15);
    }
}
