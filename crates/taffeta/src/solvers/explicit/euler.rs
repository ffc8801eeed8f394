//! Symplectic Euler: v += h (w f + g), x += h v.
//!
//! Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023,
//! eqs. 2–3, with the inverse mass w [1/kg]; w = 0 is a held node, which gravity does not move either.

use crate::real::Real;

/// New velocity [m/s] along one axis from velocity, force [N] and gravity [m/s²] over a step `h` [s].
#[inline(always)]
pub fn velocity<T: Real>(v: T, force: T, inverse_mass: T, gravity: T, h: T) -> T {
    let gravity = if inverse_mass > T::ZERO { gravity } else { T::ZERO };
    v + h * (inverse_mass * force + gravity)
}

/// New position [m] along one axis from position and **new** velocity.
#[inline(always)]
pub fn position<T: Real>(x: T, new_velocity: T, h: T) -> T {
    x + h * new_velocity
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_fall_drops_what_symplectic_euler_drops() {
        let (mut x, mut v) = (0.0_f64, 0.0_f64);
        for _ in 0..400 {
            v = velocity(v, 0.0, 1.0, -9.81, 0.005);
            x = position(x, v, 0.005);
        }
        assert!((x + 19.66905).abs() < 1e-9 && (v + 19.62).abs() < 1e-9);
    }

    #[test]
    fn a_held_node_feels_neither_force_nor_gravity() {
        assert_eq!(velocity(0.5_f32, 100.0, 0.0, -9.81, 0.1), 0.5);
    }
}
