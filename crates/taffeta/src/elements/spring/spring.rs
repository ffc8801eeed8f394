//! Damped linear springs.
//!
//! Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021,
//! eq. 1. With d = x_b − x_a [m], l = |d|, Δv = v_b − v_a [m/s], stiffness k [N/m], damping c [kg/s]:
//! f_a = [k (l − L) + c Δv·d/l] d/l, f_b = −f_a [N].

use crate::real::{Real, dot};

/// The factor [N/m] that turns d into the force on a: f_a = factor · d.
///
/// f_a = [k − k L/l + c (Δv·d)/l²] d, with one division and one root. As l → 0 the factor stays finite, and the
/// force, a multiple of d, goes to 0.
#[inline(always)]
pub fn factor<T: Real>(d: [T; 3], dv: [T; 3], k: T, damping: T, rest_length: T) -> T {
    let squared = dot(d, d);
    let squared = if squared < T::TINY { T::TINY } else { squared };
    let inverse_squared = T::ONE / squared;
    let inverse = inverse_squared.sqrt();
    k - k * rest_length * inverse + damping * (dot(dv, d) * inverse_squared)
}

/// Energy ½ k (l − L)² [J].
#[inline(always)]
pub fn energy<T: Real>(length: T, k: T, rest_length: T) -> T {
    let stretch = length - rest_length;
    T::from_f64(0.5) * k * stretch * stretch
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretched_moving_spring_pulls_as_by_hand() {
        // l = 5 along (3, 0, 4), L = 4, k = 10: pull 10. Δv·d/l = (1·3 + 2·4)/5 = 2.2, c = 2: 4.4. In all 14.4.
        let d = [3.0, 0.0, 4.0];
        let f = factor(d, [1.0, 7.0, 2.0], 10.0, 2.0, 4.0);
        assert!((f * 5.0 - 14.4_f64).abs() < 1e-12);
        assert_eq!(energy(5.0, 10.0, 4.0), 5.0);
    }

    #[test]
    fn ends_at_one_place_get_no_force_and_no_nan() {
        let f = factor([0.0_f32; 3], [1.0, 0.0, 0.0], 10.0, 2.0, 4.0);
        assert!(f.is_finite() && f * 0.0 == 0.0);
    }

    #[test]
    fn a_nan_position_is_not_hidden() {
        assert!(factor([f32::NAN, 0.0, 0.0], [0.0; 3], 10.0, 2.0, 4.0).is_nan());
    }
}
