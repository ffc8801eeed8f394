//! Records of air as kernels see them.

use crate::elements::aero::aero::AirNow;
use bytemuck::{Pod, Zeroable};

/// `Air` of air.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Air {
    pub velocity: [f32; 3],
    pub density: f32,
    pub exposure: f32,
    pub drag: f32,
    pub lift: f32,
    pub gap: u32,
    pub gusts: Gusts,
}

/// `Gusts` of gust.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Gusts {
    pub offset: [f32; 3],
    pub cells_a_metre: f32,
    pub keys: [u32; 2],
    pub weights: [f32; 2],
}

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
