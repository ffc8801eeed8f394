//! The nodes of a coarser level. One that is held is where the node is that holds it: that of a pin, or one that stands for it.

use crate::cpu::shared::Shared;
use crate::real::Real;

/// No node.
pub const FREE: u32 = u32::MAX;

/// The nodes of a level. What they have in common with those of the body is as of the sub-step; places at rest, and which nodes are held,
/// as of the frame.
pub struct LevelNodes<T> {
    /// Where they are [m].
    pub position: [Shared<T>; 3],
    /// Where they were before limits acted [m]; after that, how far they have gone.
    pub start: [Shared<T>; 3],
    /// Their places at rest [m].
    pub rest: [Shared<T>; 3],
    /// Inverse masses [1/kg]; 0 of those that are held.
    pub inverse_mass: Shared<T>,
    /// Of those that are held, the node of the finer level that holds them; [`FREE`] of others.
    pub held_by: Shared<u32>,
    /// Masses [kg], and inverse masses of nodes that are free.
    pub mass: Vec<T>,
    pub when_free: Vec<T>,
}

impl<T: Real> LevelNodes<T> {
    /// Of nodes with these masses [kg].
    pub fn new(masses: &[f64]) -> Self {
        let columns = || [(); 3].map(|()| Shared::from(vec![T::ZERO; masses.len()]));
        let inverse = |&mass: &f64| T::from_f64(if mass > 0.0 { 1.0 / mass } else { 0.0 });
        let when_free: Vec<T> = masses.iter().map(inverse).collect();
        Self {
            position: columns(),
            start: columns(),
            rest: columns(),
            inverse_mass: when_free.clone().into(),
            held_by: vec![FREE; masses.len()].into(),
            mass: masses.iter().map(|&mass| T::from_f64(mass)).collect(),
            when_free,
        }
    }

    /// Number of them.
    pub fn len(&self) -> usize {
        self.mass.len()
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        (12 * size_of::<T>() + 4) * self.len()
    }
}
