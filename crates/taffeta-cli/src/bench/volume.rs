//! The bench on bodies that keep their volume.

use super::measure::Bench;
use super::mesh;
use std::path::Path;
use std::sync::Arc;
use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Torus, VolumeForm};
use taffeta::topology::Surface;
use taffeta_io::program::Failure;

/// A frame [s] and its longest sub-step [s]: 34 sub-steps.
const FRAME: (f64, f64) = (1.0 / 60.0, 5e-4);
/// Largest extent of the body [m].
const EXTENT: f64 = 2.0;
/// Where its lowest node starts above the floor [m].
const DROP: f64 = 0.05;
/// Of each node [kg], and of each spring [N/m, kg/s]: those of Va, Choi and Hong 2023.
const MATERIAL: (f64, f64, f64) = (1.0, 1000.0, 200.0);
/// Triangles of the torus, where nothing says otherwise.
const TRIANGLES: u32 = 20_000;

/// A body that falls on a floor and sags there: that in `file`, split until it has at least `triangles`; else a torus of
/// about `triangles`, or where they are not given the dragon, if it is there.
pub fn bench(file: Option<&Path>, triangles: Option<u32>) -> Result<Bench, Failure> {
    let dragon = || triangles.is_none().then(|| mesh::model(&["dragon_20k.ply", "dragon.ply"])).flatten();
    let (note, surface) = match file.map(Path::to_owned).or_else(dragon) {
        Some(path) => {
            let (surface, times) = mesh::split(mesh::load(&path)?, triangles.unwrap_or(0) as usize);
            let often = if times == 0 {
                String::new()
            } else {
                format!(", each triangle split in four {times} times")
            };
            (format!("mesh: {}{often}", path.display()), surface)
        }
        None => {
            let of = "(`cargo xtask models` fetches the dragon)";
            (format!("mesh: a torus {of}"), mesh::torus(&torus(triangles.unwrap_or(TRIANGLES)))?)
        }
    };
    let n = vec![surface.triangles.len() as u32];
    Ok(Bench { notes: vec![note], ..Bench::new("volume", n, scene(surface)) })
}

/// A torus of about `triangles` triangles, 5 rings for 2 segments.
fn torus(triangles: u32) -> Torus {
    let segments = ((f64::from(triangles) / 5.0).sqrt().round() as u32).max(3);
    let rings = (triangles / (2 * segments)).max(3);
    Torus { major: 0.7, minor: 0.3, rings, segments }
}

fn scene(surface: Surface) -> Scene {
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
        surface.nodes.iter().map(|node| node[axis]).fold(from, pick)
    };
    let low = bound(1, f64::min, f64::INFINITY);
    let extent = |axis| bound(axis, f64::max, f64::NEG_INFINITY) - bound(axis, f64::min, f64::INFINITY);
    let scale = EXTENT / (0..3).map(extent).fold(0.0, f64::max);
    let (mass, k, d) = MATERIAL;
    let mut body = Body::soft("body", Mesh::Surface(Arc::new(surface)))
        .with_mass(Mass::Node(mass))
        .structural(k, d)
        .at([0.0, DROP - scale * low, 0.0]);
    body.place.fit = Some(EXTENT);
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction(0.3);
    Scene::new("bench volume").body(body).collider(floor).time(FRAME.0, FRAME.1)
}

/// The same with the volume kept by `form`.
pub fn keeping(bench: &Bench, form: VolumeForm) -> Scene {
    let mut scene = bench.scene.clone();
    scene.bodies = scene.bodies.into_iter().map(|body| body.keep_volume(form)).collect();
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torus_has_about_the_triangles_asked_for() {
        for wanted in [18, 1_000, 20_000, 1_000_000] {
            let torus = torus(wanted);
            let count = 2 * torus.rings * torus.segments;
            assert!((f64::from(count) / f64::from(wanted) - 1.0).abs() < 0.05, "{count} for {wanted}");
        }
    }
}
