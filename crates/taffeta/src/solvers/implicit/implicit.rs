//! Springs by nodes: Newton steps of implicit Euler.
//!
//! Source: Baraff and Witkin, "Large Steps in Cloth Simulation", SIGGRAPH 1998, eq. 16, here for u = v⁺; the stiffness across
//! a spring by its absolute value after Chen, Liu, Levin, Zheng, Kim, "Stabler Neo-Hookean Simulation: Absolute Eigenvalue
//! Filtering for Projected Newton", SIGGRAPH 2024.
//!
//! With mass M, step h, and the velocity v* that all other forces would give, the velocity u after the step solves
//!
//! M (u − v*) = h f(x + h u, u),
//!
//! where f are the springs' forces [N] at the end of the step. Newton's iteration starts from u = v, the velocity before
//! (nodes that are held: from theirs after the step), and each of its steps solves
//!
//! (M + K') δ = h f(x + h u, u) − M (u − v*),   u ← u + δ.
//!
//! K' is made of one block for each spring, at the places x + h u: B = (h² k + h e) n nᵀ + h² g (1 − n nᵀ), with
//! g = |k (l − L)|/l at most k: the change of its impulse per change of velocity [kg]. Without g, and from u = 0, one step is
//! the dual form (`distance.rs`). g keeps taut springs from waving whatever h is; that of compressed springs is taken as
//! positive, too: B stays positive semi-definite, and where forces balance does not depend on B. From u = v, one step follows
//! turning springs as well as two do from rest.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::real::{Real, Symmetric, add, dot, scale, sub, times};

/// Share of the diagonal that is added to a diagonal block before it is inverted, in units of the last place.
const FLOOR: f64 = 16.0;

/// Damping of Jacobi's iteration: no eigenvalue of a graph's matrix is beyond 2 by its diagonal.
const DAMPING: f64 = 0.7;

/// Pairs of steps of Jacobi's iteration on the coarsest level of a body.
pub const LAST_PAIRS: usize = 4;

/// Newton steps in a sub-step at most, where the scene leaves their number to the solver.
pub const MOST_STEPS: u32 = 8;

/// Energy that Newton steps may leave, relative to that of the motion.
pub const LEFT: f64 = 0.01;
/// The share of what outer forces do in the sub-step that is motion.
pub const SHARE_OF_OUTER: f64 = 0.1;

/// A material over a step h [s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stiff<T> {
    /// k [N/m].
    pub k: T,
    /// Damping e [kg/s].
    pub e: T,
    /// h.
    pub h: T,
    /// h².
    pub hh: T,
    /// h² k + h e [kg].
    pub axial: T,
}

/// What a spring contributes: B u = q (q·u) + across·u.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearSpring<T> {
    /// q [kg^½].
    pub q: [T; 3],
    /// h² g [kg].
    pub across: T,
    /// n, and h k (l − L) [N s], its impulse towards the other end.
    pub along: [T; 3],
    pub impulse: T,
}

impl<T: Real> Stiff<T> {
    /// Of stiffness `k` [N/m] and damping `e` [kg/s] over a step `h` [s].
    pub fn new(k: T, e: T, h: T) -> Self {
        Self { k, e, h, hh: h * h, axial: h * (k * h + e) }
    }

    /// The same in numbers of another sort.
    pub fn rounded<U: Real>(&self) -> Stiff<U> {
        let [k, e, h, hh, axial] =
            [self.k, self.e, self.h, self.hh, self.axial].map(|number| U::from_f64(number.to_f64()));
        Stiff { k, e, h, hh, axial }
    }

    /// The impulse of a spring [N s] along it towards its other end, whose velocity is `dv` [m/s] off.
    #[inline(always)]
    pub fn impulse(&self, spring: &LinearSpring<T>, dv: [T; 3]) -> T {
        spring.impulse + self.h * (self.e * dot(dv, spring.along))
    }

    /// The spring with `d` from its one end to the other [m].
    #[inline(always)]
    pub fn spring(&self, d: [T; 3], rest_length: T) -> LinearSpring<T> {
        let squared = dot(d, d);
        let squared = if squared < T::TINY { T::TINY } else { squared };
        let length = squared.sqrt();
        let inverse = T::ONE / length;
        let pull = self.k * (length - rest_length);
        let across = pull.abs() * inverse;
        let across = self.hh * if across > self.k { self.k } else { across };
        // No less than h e, for the stiffness across is at most k.
        let axial = self.axial - across;
        let axial = if axial > T::ZERO { axial.sqrt() } else { T::ZERO };
        let n = scale(d, inverse);
        LinearSpring { q: scale(n, axial), across, along: n, impulse: self.h * pull }
    }
}

/// B u of a spring.
#[inline(always)]
pub fn edge_times<T: Real>(q: [T; 3], across: T, u: [T; 3]) -> [T; 3] {
    let along = dot(q, u);
    [q[0] * along + across * u[0], q[1] * along + across * u[1], q[2] * along + across * u[2]]
}

/// A sum, and a share of what another node or edge has.
#[inline(always)]
pub fn add_weighted<T: Real, const N: usize>(mut sum: [T; N], weight: T, v: [T; N]) -> [T; N] {
    for one in 0..N {
        sum[one] += weight * v[one];
    }
    sum
}

/// A step of Jacobi's iteration from a vector that leaves this of the right side.
#[inline(always)]
pub fn jacobi<T: Real>(inverse: &Symmetric<T>, residual: [T; 3]) -> [T; 3] {
    times(inverse, residual.map(|one| T::from_f64(DAMPING) * one))
}

/// The diagonal of a node on the finest level: what coarser levels see of it beside edges, and the inverse of `all`, which its
/// springs and its mass are, as far as it yields.
#[inline(always)]
pub fn diagonal<T: Real>(
    all: &Symmetric<T>,
    mass: T,
    is_free: bool,
    predicted: &PredictedContact<T>,
) -> (Symmetric<T>, Symmetric<T>) {
    let none = [T::ZERO; 6];
    let (mut own, inverse) = if !is_free || predicted.slides == T::ZERO {
        (*all, none)
    } else if predicted.in_contact() {
        (held(all, predicted.normal), inverse_along(all, predicted.normal))
    } else {
        (none, inverse(all))
    };
    own[..3].iter_mut().for_each(|one| *one += mass);
    (own, inverse)
}

/// Whether a collider holds a node on the finest level, by what coarser levels see of it: of a free one that is its mass alone.
/// Pinned nodes count, too.
#[inline(always)]
pub fn is_held<T: Real>(own: &Symmetric<T>) -> bool {
    let [x, y, z, mixed @ ..] = *own;
    x != y || y != z || mixed != [T::ZERO; 3]
}

/// The right side: springs' impulse, less that of the mass for what the velocity is `off`.
#[inline(always)]
pub fn right_side<T: Real>(impulse: [T; 3], mass: T, off: [T; 3]) -> [T; 3] {
    sub(impulse, scale(off, mass))
}

/// What springs change of a node's velocity [m/s]: what was `found`, and where a surface holds it what they alone, `springs`,
/// press on that.
#[inline(always)]
pub fn velocity_change<T: Real>(predicted: &PredictedContact<T>, found: [T; 3], springs: [T; 3]) -> [T; 3] {
    if !predicted.in_contact() {
        return found;
    }
    if predicted.slides == T::ZERO {
        return springs;
    }
    let along = sub(found, predicted.friction_change());
    add(along, scale(predicted.normal, dot(sub(springs, along), predicted.normal)))
}

/// The motion of a body, twice its energy [J]: of `off`, Σ m |v* − v|², which is what outer forces do in the sub-step, a share, and
/// what Σ m |v|² = `squares` is about the mean velocity, by the momentum Σ m v [N s] and the mass Σ m [kg]. Outer forces are there
/// at rest, too, where errors of their size would keep the body in motion.
pub fn motion<T: Real>([off, squares]: [T; 2], momentum: [T; 3], mass: T) -> T {
    let mean = if mass > T::ZERO { dot(momentum, momentum) / mass } else { T::ZERO };
    T::from_f64(SHARE_OF_OUTER) * off + (squares - mean)
}

/// Whether a residual r, with `left` = r·z by the preconditioner z ≈ A⁻¹ r, asks for another Newton step. It is about twice the
/// energy that the last step has left in springs and elements that have turned since they were linearised. What is no number
/// asks for none: steps do not make one of it.
pub fn leaves_much<T: Real>(left: T, motion: T) -> bool {
    left > T::from_f64(LEFT) * motion
}

/// Whether an error is small enough by what errors are measured by.
pub fn is_solved<T: Real>(error: T, whole: T, tolerance_squared: T) -> bool {
    error <= tolerance_squared * whole || error == T::ZERO
}

/// An error by what errors are measured by.
pub fn residual_fraction<T: Real>(error: T, whole: T) -> T {
    if whole > T::ZERO { error / whole } else { T::ZERO }
}

/// q qᵀ + across.
#[inline(always)]
pub fn block<T: Real>(q: [T; 3], across: T) -> Symmetric<T> {
    [q[0] * q[0] + across, q[1] * q[1] + across, q[2] * q[2] + across, q[0] * q[1], q[0] * q[2], q[1] * q[2]]
}

/// The inverse of a diagonal block, for Jacobi's iteration; 0 of 0. What is less than some last digits of the trace is
/// noise: as much is added first.
#[inline(always)]
pub fn inverse<T: Real>(m: &Symmetric<T>) -> Symmetric<T> {
    let trace = m[0] + m[1] + m[2];
    let floor = T::from_f64(FLOOR) * T::EPSILON * trace;
    let unit = T::ONE / if trace > T::ZERO { trace } else { T::ONE };
    let [a, b, c] = [unit * (m[0] + floor), unit * (m[1] + floor), unit * (m[2] + floor)];
    let [d, e, f] = [unit * m[3], unit * m[4], unit * m[5]];
    let minors = [b * c - f * f, a * c - e * e, a * b - d * d, e * f - d * c, d * f - e * b, d * e - a * f];
    let determinant = a * minors[0] + d * minors[3] + e * minors[4];
    let by = if determinant > T::ZERO { unit / determinant } else { T::ZERO };
    minors.map(|minor| minor * by)
}

/// The inverse of a diagonal block among the directions in which a surface with unit normal `n` lets the node go.
#[inline(always)]
pub fn inverse_along<T: Real>(m: &Symmetric<T>, n: [T; 3]) -> Symmetric<T> {
    // P m P + τ n nᵀ, with P = 1 − n nᵀ: its inverse is that among P's directions, and 1/τ along n.
    let tau = m[0] + m[1] + m[2];
    let w = times(m, n);
    let half = (dot(n, w) + tau) * T::from_f64(0.5);
    let v = [w[0] - half * n[0], w[1] - half * n[1], w[2] - half * n[2]];
    let pair = |i: usize, j: usize| n[i] * v[j] + v[i] * n[j];
    let kept = [
        m[0] - pair(0, 0),
        m[1] - pair(1, 1),
        m[2] - pair(2, 2),
        m[3] - pair(0, 1),
        m[4] - pair(0, 2),
        m[5] - pair(1, 2),
    ];
    let by = if tau > T::ZERO { T::ONE / tau } else { T::ZERO };
    let all = inverse(&kept);
    let normal = block(n, T::ZERO);
    [0, 1, 2, 3, 4, 5].map(|i| all[i] - by * normal[i])
}

/// What holds a node on coarser levels: its diagonal block in the directions in which a surface with unit normal `n` holds it.
#[inline(always)]
pub fn held<T: Real>(m: &Symmetric<T>, n: [T; 3]) -> Symmetric<T> {
    let stiff = dot(n, times(m, n));
    let normal = block(n, T::ZERO);
    normal.map(|one| stiff * one)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: &[f64], b: &[f64], within: f64) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < within), "{a:?} {b:?}");
    }

    #[test]
    fn a_link_is_that_by_hand() {
        // l = 5 along (3, 0, 4), L = 4, k = 10, e = 2, h = 0.5: pull 10, g = 2, h² g = 0.5, h² k + h e = 3.5.
        let spring = Stiff::new(10.0, 2.0, 0.5).spring([3.0, 0.0, 4.0], 4.0);
        let q = f64::sqrt(3.0);
        close(&spring.q, &[0.6 * q, 0.0, 0.8 * q], 1e-14);
        close(&[spring.across, spring.impulse], &[0.5, 5.0], 1e-14);
        // Along n it is h² k + h e, across h² g.
        let b = block(spring.q, spring.across);
        close(&times(&b, [0.6, 0.0, 0.8]), &[2.1, 0.0, 2.8], 1e-14);
        close(&times(&b, [0.0, 1.0, 0.0]), &[0.0, 0.5, 0.0], 1e-14);
        // Compressed by as much: the same block but for |l − L|/l.
        let short = Stiff::new(10.0, 2.0, 0.5).spring([3.0, 0.0, 4.0], 6.0);
        close(&[short.across, short.impulse], &[0.5, -5.0], 1e-14);
    }

    #[test]
    fn blocks_stay_positive_where_a_spring_is_crushed_or_nothing() {
        let stiff = Stiff::<f32>::new(1e6, 0.0, 0.016);
        let crushed = stiff.spring([1e-9, 0.0, 0.0], 0.1);
        assert!(crushed.q == [0.0; 3] && crushed.across.is_finite() && crushed.across > 0.0);
        let none = Stiff::<f32>::new(0.0, 0.0, 0.016).spring([0.0; 3], 0.0);
        assert!(none.q == [0.0; 3] && none.across == 0.0 && none.impulse == 0.0);
    }

    #[test]
    fn inverses_are_inverses_where_the_node_may_go() {
        let m = block([1.0, -2.0, 0.5], 0.7);
        let v = [0.3, 0.2, -0.9];
        close(&times(&inverse(&m), times(&m, v)), &v, 1e-13);
        let n = [2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0];
        let among = inverse_along(&m, n);
        close(&times(&among, n), &[0.0; 3], 1e-13);
        // A tangent t: P m t comes back to t.
        let t = [1.0, -2.0, 0.0];
        let mt = times(&m, t);
        close(&times(&among, mt), &t, 1e-12);
        assert_eq!(inverse(&[0.0; 6]), [0.0; 6]);
        close(&held(&m, n), &block(n, 0.0).map(|one| one * dot(n, times(&m, n))), 1e-15);
    }

    #[test]
    fn a_motion_is_the_same_however_fast_all_of_it_goes() {
        // 1 kg and 3 kg, apart at 2 m/s: Σ m |v − v̄|² = ¾ · 2². Outer forces change 0.1 m/s of either.
        let of = |all: f64| {
            let (v, w) = ([all, 0.0, 0.0], [all + 2.0, 0.0, 0.0]);
            motion([4.0 * 0.01, dot(v, v) + 3.0 * dot(w, w)], add(v, scale(w, 3.0)), 4.0)
        };
        close(&[of(0.0), of(-7.0)], &[3.004; 2], 1e-12);
        assert_eq!(motion([0.0; 2], [0.0; 3], 0.0), 0.0);
        assert!(leaves_much(0.0301, of(0.0)) && !leaves_much(0.03, of(0.0)) && !leaves_much(f64::NAN, 1.0));
    }

    #[test]
    fn an_inverse_in_32_bits_is_positive_however_stiff_the_block() {
        let q = [300.0_f32, 200.0, 100.0];
        let [a, b] = [block(q, 0.0), block([100.0, -310.0, 5.0], 0.0)];
        let m: [f32; 6] = std::array::from_fn(|i| a[i] + b[i] + if i < 3 { 1e-5 } else { 0.0 });
        let inverse = inverse(&m);
        for v in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-0.3, 0.1, 0.9]] {
            assert!(dot(v, times(&inverse, v)) > 0.0);
        }
    }
}
