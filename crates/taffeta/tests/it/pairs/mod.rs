//! Nodes that touch each other.

mod bits;
mod bodies;
mod crossing;
mod many;
mod oracle;
mod sheets;
mod stack;
mod two;

use crate::common::{V, positions};
use std::sync::Arc;
use taffeta::scene::{Body, ContactForm, Mass, Mesh, Select, SelfCollision};
use taffeta::topology::Surface;
use taffeta::{Precision, Simulation};

/// Most nodes that one hub of a cloud holds.
const SPOKES: usize = 1000;
/// How far away hubs are [m].
const AWAY: f64 = 100.0;

/// Nodes that no spring joins: each is a neighbour of a held hub far away alone, and touches all others. The hubs are the
/// last nodes.
fn cloud(name: &str, places: &[V], mass: f64, touch: SelfCollision) -> Body {
    let (mut nodes, mut links) = (places.to_vec(), Vec::new());
    // Hubs of bodies with other names are elsewhere.
    let away = AWAY + f64::from(name.as_bytes()[0]);
    for (number, spokes) in (0..places.len()).collect::<Vec<_>>().chunks(SPOKES).enumerate() {
        let hub = nodes.len() as u32;
        let [x, y, z] = places[0];
        nodes.push([x + away, y, z + AWAY * number as f64]);
        links.extend(spokes.iter().map(|&node| [node as u32, hub]));
    }
    let hubs: Vec<u32> = (places.len() as u32..nodes.len() as u32).collect();
    let surface = Surface { vertices: nodes.clone(), nodes, links, ..Surface::default() };
    let mut body = Body::cloth(name, Mesh::Surface(Arc::new(surface))).with_mass(Mass::Node(mass));
    body.self_collision = Some(touch);
    body.pin(Select::nodes(hubs))
}

/// How nodes touch.
fn touch(thickness: f64, friction: f64, restitution: f64) -> SelfCollision {
    SelfCollision { form: ContactForm::Nodes, thickness, friction, restitution, ..SelfCollision::default() }
}

/// Velocities of all nodes [m/s].
pub fn velocities(simulation: &Simulation) -> Vec<V> {
    let snapshot = simulation.snapshot();
    let numbers: Vec<f64> = match snapshot.precision {
        Precision::F64 => {
            snapshot.state.as_chunks().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect()
        }
        Precision::F32 => {
            snapshot.state.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes).into()).collect()
        }
    };
    numbers[numbers.len() / 2..].as_chunks().0.to_vec()
}

/// Gives the first nodes these velocities [m/s].
pub fn set_velocities(simulation: &mut Simulation, given: &[V]) {
    let mut all = velocities(simulation);
    all[..given.len()].copy_from_slice(given);
    let mut snapshot = simulation.snapshot();
    let numbers = positions(simulation).into_iter().chain(all).flatten();
    snapshot.state = match snapshot.precision {
        Precision::F64 => numbers.flat_map(f64::to_le_bytes).collect(),
        Precision::F32 => numbers.flat_map(|x| (x as f32).to_le_bytes()).collect(),
    };
    simulation.restore(&snapshot).unwrap();
}

/// Numbers from 0 to 1 in no order, the same for the same seed (a linear congruence with Knuth's factor).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}
