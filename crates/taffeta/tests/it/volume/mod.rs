//! Bodies that keep their volume, or are under a pressure.

mod bits;
mod contact;
mod drive;
mod free;
mod held;
mod oracle;
mod shapes;

use crate::common::{V, add, cross, dot, scale, sub};
use std::sync::Arc;
use taffeta::Simulation;
use taffeta::scene::{Body, Icosphere, Mass, Mesh, Torus, VolumeForm};
use taffeta::topology::Surface;

/// A ball of 0.5 m radius and 2 kg with damped springs.
fn ball(subdivisions: u32, form: VolumeForm) -> Body {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions });
    Body::soft("ball", mesh).with_mass(Mass::Whole(2.0)).structural(300.0, 0.1).keep_volume(form)
}

/// A ring of 2 kg with damped springs.
fn ring(form: VolumeForm) -> Body {
    let mesh = Mesh::Torus(Torus { major: 0.5, minor: 0.2, rings: 32, segments: 16 });
    Body::soft("ring", mesh).with_mass(Mass::Whole(2.0)).structural(300.0, 0.1).keep_volume(form)
}

/// Share by which the first body's volume differs from its target now.
fn error(simulation: &Simulation) -> f64 {
    let report = simulation.report();
    report.volumes[0].expect("it is closed") / report.volume_targets[0].expect("it keeps one") - 1.0
}

/// A surface given as data.
fn surface(nodes: Vec<V>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh::Surface(Arc::new(Surface::of_triangles(nodes, triangles)))
}

/// V = Σ a·(b×c)/6 [m³], from their mean.
fn enclosed(x: &[V], triangles: &[[u32; 3]]) -> f64 {
    let middle = scale(x.iter().copied().fold([0.0; 3], add), 1.0 / x.len() as f64);
    let corner = |&n: &u32| sub(x[n as usize], middle);
    triangles.iter().map(|[a, b, c]| dot(corner(a), cross(corner(b), corner(c)))).sum::<f64>() / 6.0
}
