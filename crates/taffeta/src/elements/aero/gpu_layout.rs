//! The record of air of a sub-step.

use crate::elements::aero::aero::AirNow;
use crate::gpu::layout::{Air, Gusts};

impl Air {
    /// That of a sub-step.
    pub fn of(air: Option<&AirNow<f32>>) -> Self {
        let Some(air) = air else { return Self::default() };
        let AirNow { velocity, density, exposure, drag, lift, gust } = *air;
        let gusts = gust.map_or_else(Gusts::default, |gust| Gusts {
            offset: gust.offset,
            cells_a_metre: gust.cells_a_metre,
            keys: gust.keys,
            weights: gust.weights,
        });
        Self { velocity, density, exposure, drag, lift, gap: 0, gusts }
    }
}
