//! What two nodes do to each other that have come nearer than the thickness of their cloth.
//!
//! Source: S2 ("CUDA Cloth Simulation"), "Calculation", step 5: proximity of particles, elastic collision along the line
//! between them. To this come masses, restitution, Coulomb friction, the way apart, and a share for each pair where a node
//! has several, so that no order matters and no energy is won. Proofs: docs/models/contact.md.

use crate::real::{Real, add, dot, scale, sub};

/// Two surfaces as they meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting<T> {
    /// Distance that is kept between their nodes [m].
    pub thickness: T,
    /// Coulomb coefficient.
    pub friction: T,
    /// Share of the normal speed given back.
    pub restitution: T,
}

/// What a pair does to its first node; to its second the opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange<T> {
    /// Change of momentum [N·s].
    pub impulse: [T; 3],
    /// Change of place times mass [kg·m].
    pub shift: [T; 3],
}

/// What a pair does: `d` [m] and `v` [m/s] are place and velocity of the first node less those of the second,
/// `mobility` [1/kg] the sum of their inverse masses, `h` [s] the sub-step that has just gone by, `most` the longest way
/// apart in one, by the thickness. Nodes at one place part along y.
#[inline(always)]
pub fn exchange<T: Real>(
    d: [T; 3],
    v: [T; 3],
    mobility: T,
    meeting: &Meeting<T>,
    (h, most): (T, T),
) -> Exchange<T> {
    let distance = dot(d, d).sqrt();
    let apart = distance > T::ZERO;
    let by = if apart { distance } else { T::ONE };
    let normal = if apart { [d[0] / by, d[1] / by, d[2] / by] } else { [T::ZERO, T::ONE, T::ZERO] };
    let speed = dot(v, normal);
    // Nodes that part already get no impulse, and hence no friction.
    let approach = if speed < T::ZERO { -speed } else { T::ZERO };
    let gained = (T::ONE + meeting.restitution) * approach;
    let tangential = sub(v, scale(normal, speed));
    let (slip, grip) = (dot(tangential, tangential).sqrt(), meeting.friction * gained);
    let lost = if slip > grip { grip / slip } else { T::ONE };
    let friction = scale(tangential, if gained > T::ZERO { -lost } else { T::ZERO });
    // The way that they have come nearer in this sub-step, and gently half of what else is missing, less what they part by
    // themselves; friction takes its way back, too, as with colliders.
    let (missing, come) = (meeting.thickness - distance, h * approach);
    let undone = if come < missing { come } else { missing };
    let (wanted, limit) = ((missing - undone) * T::from_f64(0.5), most * meeting.thickness);
    let wanted = if wanted < limit { wanted } else { limit };
    let left = undone + wanted - h * (speed + gained);
    let push = if left > T::ZERO { left } else { T::ZERO };
    let share = if mobility > T::ZERO { T::ONE / mobility } else { T::ZERO };
    Exchange {
        impulse: scale(add(scale(normal, gained), friction), share),
        shift: scale(add(scale(normal, push), scale(friction, h)), share),
    }
}

/// Time in which nodes that are at one place part by their thickness, at the soonest [s].
pub const RELEASE: f64 = 0.01;

/// Longest way apart in a sub-step of `h` [s], by the thickness.
pub fn most_apart(h: f64) -> f64 {
    (h / RELEASE).min(1.0)
}

/// How two surfaces meet of which each has a thickness, friction and restitution: at the mean distance, with the geometric
/// mean of their friction and the larger restitution.
pub fn meeting<T: Real>(a: &Meeting<T>, b: &Meeting<T>) -> Meeting<T> {
    Meeting {
        thickness: (a.thickness + b.thickness) * T::from_f64(0.5),
        friction: (a.friction * b.friction).sqrt(),
        restitution: if a.restitution > b.restitution { a.restitution } else { b.restitution },
    }
}

/// Share of a pair's exchange that a node gets of which it is the first, or not, where the one of the two that has most
/// contacts has so many.
#[inline(always)]
pub fn share<T: Real>(contacts: u32, is_first: bool) -> T {
    let share = T::ONE / T::from_f64(f64::from(contacts));
    if is_first { share } else { -share }
}
