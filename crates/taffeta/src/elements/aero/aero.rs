//! Lift and drag of a triangle in a flow of air.
//!
//! With the area A [m²], the unit normal n, the flow w [m/s] (the air's velocity less the mean of the corners'), its
//! direction ŵ and s = n·ŵ, the sine of the angle of attack, the force is
//!
//!   f = ½ ρ A |w|² (C_D |s| ŵ + C_L s (n − s ŵ))  [N]
//!
//! Drag is that of Keckeisen, Kimmerle, Thomaszewski, Wacker, "Modelling effects of wind fields in cloth animations", 2004
//! (and of Ling, Damodaran, Gay, "Aerodynamic force models for animating cloth motion in an air flow", 1996, for a steady
//! flow): with the area that the flow sees. Lift acts in the plane of n and ŵ as theirs, but grows as the sine times the
//! cosine of the angle of attack, as on a flat plate: theirs is greatest where the triangle lies along the flow and jumps
//! there to the other side. No term depends on the side that n is on.
//!
//! With d = h ρ A C_D |s| |w| / (2 M), l = h ρ A C_L s √(1 − s²) |w| / (2 M), J the quarter turn from ŵ towards n and
//! X = d + l J, that is f = (M/h) X w. An explicit step overshoots once X is not small. So the flow that counts is, with |w|, n
//! and the direction of lift held, some of that at the end of the step, w' = w − h f/M:
//!
//!   f = (M/h) X ((1 − β) w + β w'),   so   f = (M/h) X (1 + β X)⁻¹ w
//!   β = 2 − 1/|X|, but from 0 to 1, and ½ − d/|X|² at least,   |X|² = d² + l²
//!
//! Up to |X| = ½ that is the formula itself: then what holds cloth back in a wind, and a triangle that has come to its last
//! speed, bear the right force. From |X| = 1 on it is the flow at the end. Between them half of the flow is left, and for any step
//! |w'| ≤ |w| and w'·w > 0.

use crate::elements::aero::gust::GustNow;
use crate::real::{Real, add, dot, scale};
use crate::scene::Air;

/// Air in one sub-step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AirNow<T> {
    /// Velocity [m/s].
    pub velocity: [T; 3],
    /// ρ/12 [kg/m³]: a third of ρ/4, for each corner.
    pub density: T,
    /// h ρ/4 [kg·s/m³].
    pub exposure: T,
    /// Drag coefficient.
    pub drag: T,
    /// Lift coefficient.
    pub lift: T,
    /// Gusts, if there are any.
    pub gust: Option<GustNow<T>>,
}

impl<T: Real> AirNow<T> {
    /// At time `t` [s], for a step of `h` [s].
    pub fn new(air: &Air, t: f64, h: f64) -> Self {
        Self {
            velocity: air.velocity.map(T::from_f64),
            density: T::from_f64(air.density / 12.0),
            exposure: T::from_f64(h * air.density / 4.0),
            drag: T::from_f64(air.drag),
            lift: T::from_f64(air.lift),
            gust: air.gust.map(|gust| GustNow::new(&gust, air.velocity, t)),
        }
    }

    /// Velocity [m/s] at some places `x` [m], by axis, with gusts where there are any.
    #[inline(always)]
    pub fn velocities<const N: usize>(&self, x: &[[T; N]; 3]) -> [[T; N]; 3] {
        let [u, v, w] = self.velocity;
        let mut all = [[u; N], [v; N], [w; N]];
        if let Some(gust) = &self.gust {
            let gusts = gust.velocities(x);
            for axis in 0..3 {
                for i in 0..N {
                    all[axis][i] += gusts[axis][i];
                }
            }
        }
        all
    }

    /// Force on each corner [N] of a triangle with the normal `twice`, twice its area long [m²], in the flow `w` [m/s].
    /// `lightness` is 1/M [1/kg]. Without area or flow there is none.
    #[inline(always)]
    pub fn corner_force(&self, twice: [T; 3], w: [T; 3], lightness: T) -> [T; 3] {
        let (area, speed, through) = (dot(twice, twice), dot(w, w), dot(twice, w));
        // Without branches: lanes of a vector compute both and choose.
        let is_in_flow = (area > T::TINY) & (speed > T::TINY);
        let root = area.sqrt() * speed.sqrt();
        let size = if is_in_flow { root } else { T::ONE };
        let sine = through / size;
        let rest = T::ONE - sine * sine;
        let cosine_squared = if rest > T::ZERO { rest } else { T::ZERO };
        let (drag, lift) = (self.drag * through.abs(), self.lift * through);
        let exposure = self.exposure * lightness;
        let exposure = exposure * at_end(exposure * drag, exposure * exposure * lift * lift * cosine_squared);
        let (d, turn) = (T::ONE + exposure * drag, exposure * lift * cosine_squared);
        let left = d * d + exposure * lift * turn;
        let along = drag * d + lift * (turn - sine);
        let across = lift * (speed / size);
        let factor = self.density / left;
        let factor = if is_in_flow { factor } else { T::ZERO };
        scale(add(scale(w, along), scale(twice, across)), factor)
    }
}

/// β, how much of the flow that counts is that at the end of the step, for d and l².
#[inline(always)]
fn at_end<T: Real>(d: T, l_squared: T) -> T {
    let half = T::from_f64(0.5);
    let squared = d * d + l_squared;
    let size = squared.sqrt();
    let size = if size > half { size } else { half };
    let enough = T::from_f64(2.0) - T::ONE / size;
    // What is added across a velocity makes it longer: lift alone needs half at any step.
    let least = half - d / if squared > T::TINY { squared } else { T::TINY };
    let share = if enough > least { enough } else { least };
    if share < T::ONE { share } else { T::ONE }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::{cross, norm, sub};

    /// Air at rest with numbers that differ.
    fn air(h: f64) -> AirNow<f64> {
        AirNow::new(&Air { density: 1.3, drag: 1.1, lift: 0.9, ..Air::default() }, 0.0, h)
    }

    /// The whole force [N] on a triangle of 0.5 m² with that normal, of 2 kg.
    fn force(h: f64, normal: [f64; 3], w: [f64; 3]) -> [f64; 3] {
        scale(air(h).corner_force(normal, w, 0.5), 3.0)
    }

    /// A unit vector at an angle to x, in the plane of x and (0, 0.6, 0.8).
    fn tilted(angle: f64) -> [f64; 3] {
        [angle.cos(), 0.6 * angle.sin(), 0.8 * angle.sin()]
    }

    #[test]
    fn across_the_flow_there_is_drag_alone_and_along_it_nothing() {
        // ½ · 1.3 · 1.1 · 0.5 · 4² = 5.72 N.
        let across = force(1e-12, [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]);
        assert!(norm(sub(across, [5.72, 0.0, 0.0])) < 1e-10, "{across:?}");
        assert_eq!(force(1e-12, [0.0, 1.0, 0.0], [4.0, 0.0, 0.0]), [0.0; 3]);
    }

    #[test]
    fn at_an_angle_drag_goes_by_its_sine_and_lift_by_sine_and_cosine() {
        for degrees in [5.0_f64, 30.0, 45.0, 60.0, 85.0, 120.0, 175.0, 260.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            // The angle of attack is that from the flow to the triangle, a right angle less to its normal.
            let found =
                force(1e-12, tilted(std::f64::consts::FRAC_PI_2 - degrees.to_radians()), [4.0, 0.0, 0.0]);
            let pressure = 0.5 * 1.3 * 0.5 * 16.0;
            let lift = pressure * 0.9 * sine * cosine;
            let wanted = [pressure * 1.1 * sine.abs(), 0.6 * lift, 0.8 * lift];
            assert!(norm(sub(found, wanted)) < 1e-9, "{degrees}°: {found:?}, expected {wanted:?}");
        }
    }

    #[test]
    fn both_sides_are_alike_to_the_bit() {
        for (n, w) in [([0.3, -0.2, 0.7], [1.0, 2.0, -3.0]), ([1e-3, 2e-4, -5e-4], [-10.0, 3.0, 0.1])] {
            assert_eq!(force(0.01, n, w), force(0.01, scale(n, -1.0), w));
        }
    }

    #[test]
    fn any_step_leaves_less_of_the_flow_and_none_of_it_turned_back() {
        let (mass, w) = (2.0, [3.0, -1.0, 2.0]);
        for h in [1e-6, 1e-3, 0.1, 1.0, 10.0, 1e4] {
            for angle in [0.0, 0.3, 0.8, 1.2, 1.5, std::f64::consts::FRAC_PI_2] {
                let left = sub(w, scale(force(h, tilted(angle), w), h / mass));
                assert!(norm(left) <= norm(w) * (1.0 + 1e-15), "{h} s, {angle}");
                assert!(dot(left, w) > -1e-15, "{h} s, {angle}: {left:?}");
            }
        }
    }

    /// What is left of a flow by the equations with the flow at their end, β of it, less by the force itself; 0: no error.
    fn error(h: f64, share: f64) -> f64 {
        let (mass, w, n) = (2.0, [3.0, -1.0, 2.0], tilted(0.4));
        let (speed, sine) = (norm(w), dot(n, w) / norm(w));
        let rate = h * 1.3 * 0.5 * speed / (2.0 * mass);
        let left = sub(w, scale(force(h, n, w), h / mass));
        let counts = add(scale(w, 1.0 - share), scale(left, share));
        // The quarter turn about the axis w × n.
        let axis = cross(w, n);
        let turned = cross(scale(axis, 1.0 / norm(axis)), counts);
        let cosine = (1.0 - sine * sine).sqrt();
        let change = add(scale(counts, rate * 1.1 * sine.abs()), scale(turned, rate * 0.9 * sine * cosine));
        norm(sub(left, sub(w, change)))
    }

    #[test]
    fn a_short_step_takes_the_flow_as_it_is_and_a_long_one_as_it_will_be() {
        // |X| is 0.45, 0.75 and 2 at these steps.
        let unit = {
            let (w, n) = ([3.0, -1.0, 2.0], tilted(0.4));
            let (speed, sine) = (norm(w), dot(n, w).abs() / norm(w));
            let rate = 1.3 * 0.5 * speed / 4.0 * sine;
            (rate * 1.1).hypot(rate * 0.9 * (1.0 - sine * sine).sqrt())
        };
        for (size, share) in [(0.45, 0.0), (0.75, 2.0 - 1.0 / 0.75), (2.0, 1.0)] {
            assert!(error(size / unit, share) < 1e-14, "{size}");
        }
    }

    #[test]
    fn lift_alone_makes_no_flow_longer() {
        for h in [1e-4, 0.01, 0.3, 1.0, 100.0] {
            let air = AirNow::new(&Air { density: 1.3, drag: 0.0, lift: 0.9, ..Air::default() }, 0.0, h);
            let w = [3.0, -1.0, 2.0];
            let left = sub(w, scale(air.corner_force(tilted(0.4), w, 0.5), 3.0 * h / 2.0));
            assert!(norm(left) <= norm(w) * (1.0 + 1e-15) && dot(left, w) > 0.0, "{h} s");
        }
    }

    #[test]
    fn without_area_or_flow_there_is_no_force_and_no_nan() {
        for (n, w) in
            [([0.0; 3], [1.0; 3]), ([1.0; 3], [0.0; 3]), ([1e-170; 3], [1.0; 3]), ([1.0; 3], [1e-170; 3])]
        {
            assert_eq!(force(0.01, n, w), [0.0; 3]);
        }
    }
}
