//! Who a plane stops goes on along it.
//!
//! The filter notes for each node, in one word, what part of its way it may make and which plane stops it: the least word of all its
//! pairs counts, so the order in which they are looked at does not. In the next round the node goes on where it was to go, without
//! what leads it towards that plane. Without that, nodes which layers press together as near as they may come would stay where they
//! are, in whatever direction they are pulled.

use crate::contact::colliders::moving::ColliderNow;
use crate::real::{Real, add, dot, norm, scale};

/// The word of a node that may go all its way.
pub const UNLIMITED: u32 = u32::MAX;
/// Parts are counted in so many steps, rounded down.
pub const PART_STEPS: f64 = 1023.0;
/// Bits of the number of steps, of each coordinate of a direction, and half the greatest of these.
pub const STEP_BITS: u32 = 22;
pub const AXIS_BITS: u32 = 11;
pub const HALF_AXIS: f64 = 1023.5;
/// Nodes slide in the first rounds of a sub-step, of which there are more only for those that go far.
pub const SLIDES: usize = 4;
/// A node moves away from the plane by this part of its way along it: about twice as much as a direction may be off.
pub const TILT: f64 = 4e-3;

/// The word of a node that may make a `part` of its way, for a plane from which `away` leads.
#[inline]
pub fn word<T: Real>(part: T, away: [T; 3]) -> u32 {
    if part >= T::ONE {
        return UNLIMITED;
    }
    let steps = ((part.to_f64() as f32 * PART_STEPS as f32) as u32).min(PART_STEPS as u32 - 1);
    steps << STEP_BITS | direction(away.map(|along| along.to_f64() as f32))
}

/// The part of its way that a node with this word may make.
#[inline]
pub fn part<T: Real>(word: u32) -> T {
    T::from_f64(f64::from((word >> STEP_BITS) as f32 / PART_STEPS as f32))
}

/// What must be added to the way that is left of a node with this word [m] for it to lead along the plane. Nothing if it leads away.
#[inline]
pub fn lift<T: Real>(left: [T; 3], word: u32) -> [T; 3] {
    let away = away(word).map(|along| T::from_f64(f64::from(along)));
    let missing = T::from_f64(TILT) * norm(left) - dot(left, away);
    if missing > T::ZERO { scale(away, missing) } else { [T::ZERO; 3] }
}

/// A position, moved out of the convex colliders that are no deeper there than `most` [m]: in what is deeper, a node was before.
pub fn out_of_solids<T: Real>(colliders: &[ColliderNow<T>], x: [T; 3], most: T) -> [T; 3] {
    colliders.iter().fold(x, |x, collider| match collider.depth_and_normal(x) {
        Some((depth, normal)) if depth > T::ZERO && depth <= most => add(x, scale(normal, depth)),
        _ => x,
    })
}

/// A direction on an octahedron that is unfolded to a square (Meyer et al., "On Floating-Point Normal Vectors", 2010).
fn direction([x, y, z]: [f32; 3]) -> u32 {
    let sum = x.abs() + y.abs() + z.abs();
    let by = if sum > 0.0 { sum } else { 1.0 };
    let (u, v) = (x / by, y / by);
    let (u, v) = if z < 0.0 { folded(u, v) } else { (u, v) };
    let [u, v] = [u, v].map(|along| (along * HALF_AXIS as f32 + (HALF_AXIS + 0.5) as f32) as u32);
    u << AXIS_BITS | v
}

/// The unit vector of a word, away from the plane.
pub fn away(word: u32) -> [f32; 3] {
    let axis = |bits: u32| (bits & ((1 << AXIS_BITS) - 1)) as f32 / HALF_AXIS as f32 - 1.0;
    let (u, v) = (axis(word >> AXIS_BITS), axis(word));
    let z = 1.0 - u.abs() - v.abs();
    let (x, y) = if z < 0.0 { folded(u, v) } else { (u, v) };
    let length = norm([x, y, z]);
    [x, y, z].map(|along| along / length)
}

/// The lower half of the octahedron lies around the upper one.
fn folded(u: f32, v: f32) -> (f32, f32) {
    let turned = |along: f32, other: f32| {
        let left = 1.0 - other.abs();
        if along < 0.0 { -left } else { left }
    };
    (turned(u, v), turned(v, u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::sub;
    use crate::topology::random::SplitMix64;

    fn unit(random: &mut SplitMix64) -> [f64; 3] {
        loop {
            let x: [f64; 3] = std::array::from_fn(|_| 2.0 * random.unit() - 1.0);
            if norm(x) > 0.01 && norm(x) < 1.0 {
                return scale(x, 1.0 / norm(x));
            }
        }
    }

    #[test]
    fn a_word_keeps_a_part_and_a_direction() {
        let mut random = SplitMix64::new(5);
        let corners = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(|along: i32| f64::from(along - 1)));
        let corners: Vec<[f64; 3]> =
            corners.filter(|x| norm(*x) > 0.0).map(|x| scale(x, 1.0 / norm(x))).collect();
        for number in 0..20_000 {
            let x = corners.get(number).copied().unwrap_or_else(|| unit(&mut random));
            let wanted = random.unit();
            let word = word(wanted, x);
            let found: f64 = part(word);
            assert!(found <= wanted && wanted - found < 1.01 / PART_STEPS, "{wanted} {found}");
            let off = norm(sub(away(word).map(f64::from), x));
            assert!(off < 0.6 * TILT, "{x:?} is off by {off}");
            assert!(word < UNLIMITED);
        }
        assert_eq!((word(1.0, [0.0, 1.0, 0.0]), part::<f64>(UNLIMITED)), (UNLIMITED, 1.0));
        assert!(part::<f32>(word(1.0_f32.next_down(), [0.0; 3])) < 1.0);
        // Who may make less of its way has the lesser word, whatever its plane.
        assert!(word(0.2, [1.0, 1.0, 0.0]) < word(0.201, [-1.0, -1.0, -1.0]));
    }

    #[test]
    fn what_goes_on_along_a_plane_does_not_come_nearer_to_it() {
        let mut random = SplitMix64::new(6);
        for _ in 0..20_000 {
            let (away, left) = (unit(&mut random), scale(unit(&mut random), random.unit()));
            // All that is left, or nearly nothing but what leads along the plane.
            let across = sub(left, scale(away, dot(left, away)));
            for left in [left, sub(across, scale(away, 1e-5 * norm(across)))] {
                let towards = -dot(left, away);
                let goes = add(left, lift(left, word(0.5, away)));
                assert!(dot(goes, away) > 0.0, "{away:?} {left:?} {goes:?}");
                let wanted = add(left, scale(away, towards.max(0.0)));
                assert!(norm(sub(goes, wanted)) < 2.0 * TILT * norm(left), "{goes:?} {wanted:?}");
            }
        }
    }
}
