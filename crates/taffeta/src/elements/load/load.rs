//! Loads on single nodes: uniform wind, linear drag, point forces, shared torques.

use crate::real::{Real, cross, dot, scale, sub};

/// Uniform wind force [N] less linear drag [kg/s]: f = w − c v, one axis.
#[inline(always)]
pub fn wind_and_drag<T: Real>(wind: T, drag: T, velocity: T) -> T {
    wind - drag * velocity
}

/// Lever of a node about an axis through `about`: a × r [m], `axis` of unit length.
#[inline(always)]
pub fn lever<T: Real>(x: [T; 3], axis: [T; 3], about: [T; 3]) -> [T; 3] {
    cross(axis, sub(x, about))
}

/// The factor [N/m] on each lever so that the moments about the axis add up to `torque` [N·m]:
/// f_i = τ (a × r_i)/Σ|a × r_j|², hence Σ a·(r_i × f_i) = τ. Nodes on the axis alone carry none.
///
/// The sum is taken in [`SUM_LANES`] lanes, then by halves, as a workgroup of a GPU does it.
pub fn torque_factor<T: Real>(torque: T, levers: impl Iterator<Item = [T; 3]>) -> T {
    let mut lanes = [T::ZERO; SUM_LANES];
    for (index, lever) in levers.enumerate() {
        lanes[index % SUM_LANES] += dot(lever, lever);
    }
    let mut half = SUM_LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    if lanes[0] > T::TINY { torque / lanes[0] } else { T::ZERO }
}

/// Lanes of a sum over the nodes of a torque.
pub const SUM_LANES: usize = 256;

/// Force of a shared torque on one node [N].
#[inline(always)]
pub fn torque_force<T: Real>(factor: T, lever: [T; 3]) -> [T; 3] {
    scale(lever, factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_forces_add_up_to_the_torque_and_to_no_net_force_when_symmetric() {
        let (axis, about) = ([0.0, 1.0, 0.0], [0.5, 0.0, 0.0]);
        let nodes = [[1.5, 2.0, 0.0], [-0.5, 1.0, 0.0], [0.5, 0.0, 2.0], [0.5, 0.0, -2.0]];
        let factor = torque_factor(20.0_f64, nodes.iter().map(|&x| lever(x, axis, about)));
        let mut moment = 0.0;
        let mut net = [0.0; 3];
        for x in nodes {
            let f = torque_force(factor, lever(x, axis, about));
            moment += dot(axis, cross(sub(x, about), f));
            net = crate::real::add(net, f);
        }
        assert!((moment - 20.0).abs() < 1e-12);
        assert!(net.iter().all(|c| c.abs() < 1e-12));
    }
}
