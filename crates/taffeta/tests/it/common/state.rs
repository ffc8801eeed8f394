//! States in 64 bits, and numbers at random to start from.

use super::V;
use taffeta::scene::Body;
use taffeta::{Precision, Simulation};

/// Makes all springs of a body stiffer, by a factor.
pub fn stiffen(body: &mut Body, by: f64) {
    let springs = &mut body.springs;
    for spring in [&mut springs.structural, &mut springs.shear, &mut springs.bend].into_iter().flatten() {
        spring.k *= by;
    }
}

/// Places [m] and velocities [m/s] of all nodes, in 64 bits.
pub fn state(simulation: &Simulation) -> (Vec<V>, Vec<V>) {
    let snapshot = simulation.snapshot();
    assert_eq!(snapshot.precision, Precision::F64);
    let numbers: Vec<f64> = snapshot.state.as_chunks().0.iter().map(|&b| f64::from_le_bytes(b)).collect();
    let (x, v) = numbers.as_chunks().0.split_at(snapshot.nodes as usize);
    (x.to_vec(), v.to_vec())
}

/// Puts nodes where they are wanted, with velocities, in 64 bits.
pub fn set(simulation: &mut Simulation, x: &[V], v: &[V]) {
    let mut snapshot = simulation.snapshot();
    assert_eq!((snapshot.precision, snapshot.nodes), (Precision::F64, x.len() as u64));
    snapshot.state = x.iter().chain(v).flatten().flat_map(|c| c.to_le_bytes()).collect();
    simulation.restore(&snapshot).expect("it fits");
}

/// Puts nodes at places, at rest.
pub fn put(simulation: &mut Simulation, x: &[V]) {
    let mut snapshot = simulation.snapshot();
    snapshot.precision = Precision::F64;
    snapshot.state = x
        .iter()
        .flatten()
        .chain([0.0; 3].iter().cycle().take(3 * x.len()))
        .flat_map(|c| c.to_le_bytes())
        .collect();
    simulation.restore(&snapshot).expect("it fits");
}

/// Numbers from -1 to 1, the same ones every time.
pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A vector of such numbers.
pub fn any(random: &mut impl FnMut() -> f64) -> V {
    std::array::from_fn(|_| random())
}
