//! The sub-steps of a frame, in the backend's numbers. What features tell a sub-step is among its extensions.

pub mod refinement;

use crate::assembly::Assembly;
use crate::extensions::Extensions;
use crate::plan::refinement::InVain;
use crate::real::Real;

/// The parameters of a sub-step.
pub struct Substep<T> {
    /// Length, and that of the longest in its frame [s].
    pub h: T,
    pub longest: T,
    /// Whether surfaces may hold back nodes that pins move.
    pub pins_may_lag: bool,
    /// When it is in vain to go on with the frame.
    pub in_vain: InVain,
    /// Gravity [m/s²].
    pub gravity: [f64; 3],
    /// Force of the wind on each node [N].
    pub wind_force: [f64; 3],
    /// Linear drag [kg/s].
    pub drag: f64,
    /// When its frame starts [s].
    pub frame_start: f64,
    /// Fraction of the frame at its end, and its rate [1/s].
    pub frame_fraction: (T, T),
    /// Parameters of features.
    pub extensions: Extensions,
}

/// Adds the parameters of features to a sub-step from time `t` on, of length `h` [s].
pub type Parameters<T> = fn(&Assembly, [f64; 2], &mut Substep<T>);

impl<T: Real> Substep<T> {
    /// No sub-step: between frames.
    pub fn at_rest() -> Self {
        Self {
            h: T::ZERO,
            longest: T::ZERO,
            pins_may_lag: false,
            in_vain: InVain::NEVER,
            gravity: [0.0; 3],
            wind_force: [0.0; 3],
            drag: 0.0,
            frame_start: 0.0,
            frame_fraction: (T::ZERO, T::ZERO),
            extensions: Extensions::default(),
        }
    }
}

/// The sub-steps of the frame that starts at time `start` [s], those of the scene cut into `parts` each, unless that is in vain.
pub fn frame<T: Real>(
    assembly: &Assembly,
    start: f64,
    (parts, in_vain): (u32, InVain),
    parameters: Parameters<T>,
) -> Vec<Substep<T>> {
    let (time, world) = (&assembly.time, &assembly.world);
    let share = 1.0 / f64::from(parts);
    let longest = T::from_f64(share * time.longest_step());
    let substep = |(offset, h): (f64, f64)| {
        let mut substep = Substep {
            h: T::from_f64(h),
            longest,
            pins_may_lag: assembly.surfaces().is_some(),
            in_vain,
            gravity: world.gravity,
            wind_force: world.wind_force,
            drag: world.drag,
            frame_start: start,
            frame_fraction: (T::from_f64((offset + h) / time.dt), T::from_f64(1.0 / time.dt)),
            extensions: Extensions::default(),
        };
        parameters(assembly, [start + offset, h], &mut substep);
        substep
    };
    let first = if start == 0.0 { assembly.first_share() } else { None };
    let spans = (0..time.substeps() * parts).flat_map(|index| {
        let (offset, whole) = time.substep(index / parts);
        let (offset, h) = (offset + share * f64::from(index % parts) * whole, share * whole);
        match first.filter(|_| index == 0) {
            Some(share) => vec![(offset, share * h), (offset + share * h, (1.0 - share) * h)],
            None => vec![(offset, h)],
        }
    });
    spans.map(substep).collect()
}
