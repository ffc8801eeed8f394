use crate::scene::Air;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Frames and steps.
///
/// ```
/// use taffeta::scene::Time;
///
/// let time = Time { dt: 1.0 / 60.0, max_step: Some(5e-3), ..Time::default() };
/// // Three sub-steps of 5 ms, and one that takes the rest.
/// assert_eq!(time.substeps(), 4);
/// ```
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Time {
    /// One frame [s].
    pub dt: f64,
    /// Longest sub-step [s]: a frame is ceil(dt/max_step) of them, the last takes the rest, and a rest below a thousandth
    /// of `max_step` as well. Contact between triangles cuts sub-steps into up to 16 parts where cloth comes too fast for them. Without
    /// it: `dt`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_step: Option<f64>,
    /// How many frames a run has.
    pub frames: u32,
}

impl Default for Time {
    fn default() -> Self {
        Self { dt: 1.0 / 60.0, max_step: None, frames: 300 }
    }
}

/// Into how many parts contact between triangles may cut a sub-step, a power of two, and how short it may make one [s].
const MOST_PARTS: u32 = 16;
const SHORTEST: f64 = 2.5e-4;

impl Time {
    /// Number of sub-steps in a frame.
    pub fn substeps(&self) -> u32 {
        let max = self.max_step.unwrap_or(self.dt);
        (self.dt / max - SLIVER).ceil().max(1.0) as u32
    }

    /// Start within the frame and length of sub-step `index` [s], counted from 0; those from the last on end with the frame.
    pub fn substep(&self, index: u32) -> (f64, f64) {
        let count = self.substeps();
        if count == 1 {
            return (0.0, self.dt);
        }
        let max = self.max_step.unwrap_or(self.dt);
        let start = f64::from(index.min(count - 1)) * max;
        (start, if index >= count - 1 { self.dt - start } else { max })
    }

    /// Into how many parts contact between triangles may cut each sub-step: a power of two.
    pub(crate) fn most_parts(&self) -> u32 {
        let mut parts = 1;
        while parts < MOST_PARTS && self.longest_step() / f64::from(2 * parts) >= SHORTEST {
            parts *= 2;
        }
        parts
    }

    /// Length of the longest sub-step [s].
    pub fn longest_step(&self) -> f64 {
        self.substep(0).1.max(self.substep(self.substeps() - 1).1)
    }
}

/// The share of a sub-step that is not worth one: below, the numbers were meant to divide, as 1/60 s in seven digits and in
/// fifteen are.
const SLIVER: f64 = 1e-3;

/// What acts on every node.
///
/// ```
/// use taffeta::scene::{Scene, World};
///
/// let moon = World { gravity: [0.0, -1.62, 0.0], ..World::default() };
/// let scene = Scene { world: moon, ..Scene::new("on the moon") };
/// assert_eq!(scene.world.drag, 0.0);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct World {
    /// Acceleration [m/s²].
    pub gravity: [f64; 3],
    /// Linear drag [kg/s]: f = −drag·v on every node.
    pub drag: f64,
    /// Force on every node [N]: an even wind.
    pub wind_force: [f64; 3],
    /// Air that flows around triangles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub air: Option<Air>,
}

impl Default for World {
    fn default() -> Self {
        Self { gravity: [0.0, -9.81, 0.0], drag: 0.0, wind_force: [0.0; 3], air: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thirtieth_in_milliseconds_is_33_full_steps_and_a_short_one() {
        let time = Time { dt: 1.0 / 30.0, max_step: Some(1e-3), frames: 1 };
        assert_eq!(time.substeps(), 34);
        assert_eq!(time.substep(32).1, 1e-3);
        assert!((time.substep(33).1 - (1.0 / 30.0 - 0.033)).abs() < 1e-15);
        let tenth = Time { dt: 0.1, max_step: Some(0.01), frames: 1 };
        assert_eq!(tenth.substeps(), 10);
        assert_eq!(Time { dt: 0.3, max_step: Some(0.1), frames: 1 }.substeps(), 3);
        assert_eq!(Time { dt: 0.01, max_step: Some(1.0), frames: 1 }.substep(0), (0.0, 0.01));
        assert_eq!(time.substep(u32::MAX), time.substep(33));
    }

    #[test]
    fn sub_steps_are_cut_into_up_to_sixteen_parts_and_none_becomes_too_short() {
        let parts = |step| Time { dt: 0.1, max_step: Some(step), frames: 1 }.most_parts();
        assert_eq!([0.1, 1.0 / 240.0, 1.0 / 1000.0, 6e-4, 4e-4].map(parts), [16, 16, 4, 2, 1]);
    }

    #[test]
    fn digits_that_are_left_out_make_no_sub_step() {
        for (dt, max_step, count) in [
            (0.0166666667, 1.0 / 60.0, 1),
            (0.016667, 1.0 / 60.0, 1),
            (0.0333333334, 1.0 / 120.0, 4),
            (1.0 / 60.0, 0.00833333, 2),
            (1.0 / 60.0, 1.66666e-8, 1_000_004),
            (0.01, 0.00999, 2),
        ] {
            let time = Time { dt, max_step: Some(max_step), frames: 1 };
            assert_eq!(time.substeps(), count, "{dt} s in steps of {max_step} s");
            let (start, last) = time.substep(count - 1);
            assert!((start + last - dt).abs() < 1e-15, "{start} {last}");
            assert!((1e-3 * max_step..=1.001 * max_step).contains(&last), "{last} of {max_step}");
            assert!(time.longest_step() == last || last < max_step && time.longest_step() == max_step);
        }
    }
}
