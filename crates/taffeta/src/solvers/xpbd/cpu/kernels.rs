//! Constraints sixteen at a time: between two runs of nodes, and within one.

use crate::real::{Real, dot, sub};
use crate::solvers::xpbd::project::{Stiffness, limit};
use crate::topology::LANES;

/// What moves the ends of constraints.
pub trait Pull<T> {
    /// Whether it asks for the places that the ends had before.
    const LOOKS_BACK: bool;
    /// As [`Stiffness::pull`], of the constraint in a lane. `now` and `before` are the vectors between the ends.
    fn pull(&self, lane: usize, now: [T; 3], before: [T; 3], rest: T, inverse_mass: T) -> T;
}

/// Springs with damping.
impl<T: Real> Pull<T> for Stiffness<T> {
    const LOOKS_BACK: bool = true;
    #[inline(always)]
    fn pull(&self, _: usize, now: [T; 3], before: [T; 3], rest: T, inverse_mass: T) -> T {
        Self::pull(*self, dot(now, now), rest, inverse_mass, dot(now, sub(now, before)))
    }
}

/// Springs without.
#[derive(Clone, Copy)]
pub struct Undamped<T>(pub Stiffness<T>);

impl<T: Real> Pull<T> for Undamped<T> {
    const LOOKS_BACK: bool = false;
    #[inline(always)]
    fn pull(&self, _: usize, now: [T; 3], _: [T; 3], rest: T, inverse_mass: T) -> T {
        self.0.undamped(dot(now, now), rest, inverse_mass)
    }
}

/// Springs of several materials.
pub struct Mixed<T> {
    pub elastic: [T; LANES],
    pub damping: [T; LANES],
}

impl<T: Real> Pull<T> for Mixed<T> {
    const LOOKS_BACK: bool = true;
    #[inline(always)]
    fn pull(&self, lane: usize, now: [T; 3], before: [T; 3], rest: T, inverse_mass: T) -> T {
        let spring = Stiffness { elastic: self.elastic[lane], damping: self.damping[lane] };
        spring.pull(dot(now, now), rest, inverse_mass, dot(now, sub(now, before)))
    }
}

/// Limits of meshes, by their squared lengths.
#[derive(Clone, Copy)]
pub struct Length;

impl<T: Real> Pull<T> for Length {
    const LOOKS_BACK: bool = false;
    #[inline(always)]
    fn pull(&self, _: usize, now: [T; 3], _: [T; 3], rest: T, inverse_mass: T) -> T {
        limit(dot(now, now), rest, inverse_mass)
    }
}

/// Limits of grids: the places that the ends had before are those at rest, and squared lengths relative to the distance there.
#[derive(Clone, Copy)]
pub struct Limit;

impl<T: Real> Pull<T> for Limit {
    const LOOKS_BACK: bool = true;
    #[inline(always)]
    fn pull(&self, _: usize, now: [T; 3], before: [T; 3], rest: T, inverse_mass: T) -> T {
        limit(dot(now, now), dot(before, before) * rest, inverse_mass)
    }
}

/// Some nodes: their positions, inverse masses, and the places that they had before.
pub struct Nodes<'a, T> {
    pub position: [&'a mut [T]; 3],
    pub inverse_mass: &'a [T],
    pub before: [&'a [T]; 3],
}

impl<'a, T> Nodes<'a, T> {
    /// Without the first few, and so many of them.
    #[inline(always)]
    pub fn part(&mut self, from: usize, count: usize) -> Nodes<'_, T> {
        let to = from + count;
        let [x, y, z] = &mut self.position;
        let [x0, y0, z0] = self.before;
        Nodes {
            position: [&mut x[from..to], &mut y[from..to], &mut z[from..to]],
            inverse_mass: &self.inverse_mass[from..to],
            before: [&x0[from..to], &y0[from..to], &z0[from..to]],
        }
    }

    /// The first few, and the others.
    #[inline(always)]
    pub fn split(self, at: usize) -> [Nodes<'a, T>; 2] {
        let [x, y, z] = self.position;
        let ((xa, xb), (ya, yb), (za, zb)) = (x.split_at_mut(at), y.split_at_mut(at), z.split_at_mut(at));
        let (wa, wb) = self.inverse_mass.split_at(at);
        let [x0, y0, z0] = self.before;
        let ((sxa, sxb), (sya, syb), (sza, szb)) = (x0.split_at(at), y0.split_at(at), z0.split_at(at));
        [
            Nodes { position: [xa, ya, za], inverse_mass: wa, before: [sxa, sya, sza] },
            Nodes { position: [xb, yb, zb], inverse_mass: wb, before: [sxb, syb, szb] },
        ]
    }

    /// As many as are a multiple of `count`, and the others.
    #[inline(always)]
    fn whole(self, count: usize) -> [Nodes<'a, T>; 2] {
        let whole = self.inverse_mass.len() / count * count;
        self.split(whole)
    }
}

/// So many nodes side by side.
#[derive(Clone, Copy)]
pub struct Block<T, const N: usize> {
    pub x: [T; N],
    pub y: [T; N],
    pub z: [T; N],
    pub w: [T; N],
    pub x0: [T; N],
    pub y0: [T; N],
    pub z0: [T; N],
}

impl<T: Real, const N: usize> Block<T, N> {
    pub const NONE: Self = {
        let none = [T::ZERO; N];
        Self { x: none, y: none, z: none, w: none, x0: none, y0: none, z0: none }
    };
}

/// Lets constraints act, each between a lane of `a` and that of `b`.
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "a lane of many columns")]
pub fn act<T: Real, P: Pull<T>, const N: usize>(
    pull: &P,
    a: &mut Block<T, N>,
    b: &mut Block<T, N>,
    rest: &[T; N],
) {
    for lane in 0..N {
        let dx = b.x[lane] - a.x[lane];
        let dy = b.y[lane] - a.y[lane];
        let dz = b.z[lane] - a.z[lane];
        let before = if P::LOOKS_BACK {
            [b.x0[lane] - a.x0[lane], b.y0[lane] - a.y0[lane], b.z0[lane] - a.z0[lane]]
        } else {
            [T::ZERO; 3]
        };
        let by = pull.pull(lane, [dx, dy, dz], before, rest[lane], a.w[lane] + b.w[lane]);
        let (by_a, by_b) = (by * a.w[lane], by * b.w[lane]);
        a.x[lane] += by_a * dx;
        a.y[lane] += by_a * dy;
        a.z[lane] += by_a * dz;
        b.x[lane] -= by_b * dx;
        b.y[lane] -= by_b * dy;
        b.z[lane] -= by_b * dz;
    }
}

/// Constraints between each node of a run and that of another.
#[inline(always)]
pub fn between<T: Real, P: Pull<T>>(pull: P, rest: T, a: Nodes<'_, T>, b: Nodes<'_, T>) {
    let (a, b) = between_blocks::<T, P, LANES>(&pull, rest, a, b);
    let (a, b) = between_blocks::<T, P, 8>(&pull, rest, a, b);
    let (a, b) = between_blocks::<T, P, 4>(&pull, rest, a, b);
    between_blocks::<T, P, 1>(&pull, rest, a, b);
}

/// The same of whole blocks; what is left.
#[inline(always)]
fn between_blocks<'a, 'b, T: Real, P: Pull<T>, const N: usize>(
    pull: &P,
    rest: T,
    a: Nodes<'a, T>,
    b: Nodes<'b, T>,
) -> (Nodes<'a, T>, Nodes<'b, T>) {
    let ([a, a_left], [b, b_left]) = (a.whole(N), b.whole(N));
    let ([ax, ay, az], [bx, by, bz]) = (a.position.map(blocks_mut), b.position.map(blocks_mut));
    let (aw, bw) = (blocks::<T, N>(a.inverse_mass), blocks::<T, N>(b.inverse_mass));
    let ([ax0, ay0, az0], [bx0, by0, bz0]) = (a.before.map(blocks), b.before.map(blocks));
    for i in 0..aw.len().min(bw.len()) {
        let mut left = Block { x: ax[i], y: ay[i], z: az[i], w: aw[i], ..Block::NONE };
        let mut right = Block { x: bx[i], y: by[i], z: bz[i], w: bw[i], ..Block::NONE };
        if P::LOOKS_BACK {
            (left.x0, left.y0, left.z0) = (ax0[i], ay0[i], az0[i]);
            (right.x0, right.y0, right.z0) = (bx0[i], by0[i], bz0[i]);
        }
        act(pull, &mut left, &mut right, &[rest; N]);
        (ax[i], ay[i], az[i]) = (left.x, left.y, left.z);
        (bx[i], by[i], bz[i]) = (right.x, right.y, right.z);
    }
    (a_left, b_left)
}

#[inline(always)]
fn blocks<T, const N: usize>(column: &[T]) -> &[[T; N]] {
    column.as_chunks().0
}

#[inline(always)]
fn blocks_mut<T, const N: usize>(column: &mut [T]) -> &mut [[T; N]] {
    column.as_chunks_mut().0
}

/// Constraints within a run, between nodes that are STEP apart: of each 2·STEP nodes in a row the first half with the second.
#[inline(always)]
pub fn within<T: Real, P: Pull<T>, const STEP: usize>(pull: P, rest: T, all: Nodes<'_, T>) {
    let left = within_blocks::<T, P, STEP, LANES>(&pull, rest, all);
    let left = within_blocks::<T, P, STEP, 8>(&pull, rest, left);
    let mut left = within_blocks::<T, P, STEP, 4>(&pull, rest, left);
    // Fewer than four are left, and of these one constraint has both ends, if any.
    let count = left.inverse_mass.len();
    if count > STEP {
        let [mut a, b] = left.part(0, STEP + 1).split(STEP);
        between_blocks::<T, P, 1>(&pull, rest, a.part(0, 1), b);
    }
}

/// The same of whole blocks; what is left. Each lane computes what its own node does, so that a constraint is computed at both of its
/// ends, to the same bits.
#[inline(always)]
fn within_blocks<'a, T: Real, P: Pull<T>, const STEP: usize, const N: usize>(
    pull: &P,
    rest: T,
    all: Nodes<'a, T>,
) -> Nodes<'a, T> {
    let [all, left] = all.whole(N);
    let ([x, y, z], [x0, y0, z0]) = (all.position.map(blocks_mut::<T, N>), all.before.map(blocks::<T, N>));
    let w = blocks::<T, N>(all.inverse_mass);
    for i in 0..w.len() {
        let own = Block { x: x[i], y: y[i], z: z[i], w: w[i], ..Block::NONE };
        let mut other = Block {
            x: swapped::<T, STEP, N>(&own.x),
            y: swapped::<T, STEP, N>(&own.y),
            z: swapped::<T, STEP, N>(&own.z),
            w: swapped::<T, STEP, N>(&own.w),
            ..Block::NONE
        };
        let mut own = own;
        if P::LOOKS_BACK {
            (own.x0, own.y0, own.z0) = (x0[i], y0[i], z0[i]);
            (other.x0, other.y0, other.z0) = (
                swapped::<T, STEP, N>(&own.x0),
                swapped::<T, STEP, N>(&own.y0),
                swapped::<T, STEP, N>(&own.z0),
            );
        }
        act(pull, &mut own, &mut other, &[rest; N]);
        (x[i], y[i], z[i]) = (own.x, own.y, own.z);
    }
    left
}

/// Lanes whose numbers differ by STEP, exchanged.
#[inline(always)]
fn swapped<T: Real, const STEP: usize, const N: usize>(lanes: &[T; N]) -> [T; N] {
    let mut all = [T::ZERO; N];
    for lane in 0..N {
        all[lane] = lanes[lane ^ STEP];
    }
    all
}
