//! Symplectic Euler on the CPU.

use crate::cpu::feature::Feature;
use crate::cpu::simd::Kernel;
use crate::cpu::tile::Tile;
use crate::real::Real;
use crate::solvers::explicit::euler;
use crate::step::Op;

/// The update of free nodes.
pub struct Euler;

impl Euler {
    /// New velocities and positions of a tile, from its forces.
    pub fn apply<T: Real>(tile: &Tile<'_, T>) {
        for (at, run) in tile.plan.runs() {
            let [x, y, z, u, v, w] = tile.after(&run);
            for (axis, (position, velocity)) in [(x, u), (y, v), (z, w)].into_iter().enumerate() {
                tile.nodes.level.run(Integrate {
                    force: &tile.scratch.force[axis][at..at + run.len()],
                    inverse_mass: &tile.nodes.inverse_mass[run.clone()],
                    old_position: &tile.old[axis][run.clone()],
                    old_velocity: &tile.old[3 + axis][run.clone()],
                    position,
                    velocity,
                    gravity: T::from_f64(tile.substep.gravity[axis]),
                    h: tile.substep.h,
                });
            }
        }
    }
}

impl<T: Real> Feature<T> for Euler {
    fn ops(&self) -> &'static [Op] {
        &[Op::Integrate]
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        Self::apply(tile);
    }
}

/// Kernel: symplectic Euler along one axis.
struct Integrate<'a, T> {
    force: &'a [T],
    inverse_mass: &'a [T],
    old_position: &'a [T],
    old_velocity: &'a [T],
    position: &'a mut [T],
    velocity: &'a mut [T],
    gravity: T,
    h: T,
}

impl<T: Real> Kernel for Integrate<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { force, inverse_mass, old_position, old_velocity, position, velocity, gravity, h } = self;
        integrate(force, inverse_mass, old_position, old_velocity, position, velocity, gravity, h);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "slices apart tell the compiler that they do not overlap")]
fn integrate<T: Real>(
    force: &[T],
    inverse_mass: &[T],
    old_position: &[T],
    old_velocity: &[T],
    position: &mut [T],
    velocity: &mut [T],
    gravity: T,
    h: T,
) {
    let n = position.len();
    let (force, inverse_mass) = (&force[..n], &inverse_mass[..n]);
    let (old_position, old_velocity, velocity) = (&old_position[..n], &old_velocity[..n], &mut velocity[..n]);
    for i in 0..n {
        let v = euler::velocity(old_velocity[i], force[i], inverse_mass[i], gravity, h);
        velocity[i] = v;
        position[i] = euler::position(old_position[i], v, h);
    }
}
