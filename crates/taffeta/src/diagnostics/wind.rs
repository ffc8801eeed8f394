//! What wind can do to bodies, and whether the step lets it.

use crate::advice::{Advice, Warning, round_down};
use crate::assembly::Assembly;
use crate::elements::aero::build::aero_triangles;
use crate::real::norm;
use crate::scene::Air;

/// Fastest wind that is usual [m/s]: with gusts as strong as their mean square.
fn speed(air: &Air) -> f64 {
    norm(air.velocity) + air.gust.map_or(0.0, |gust| gust.speed)
}

/// The most that wind does to each node [N], by solver index, for a triangle at any angle; nothing without air.
///
/// |f| = ½ ρ A w² s √(C_D² + C_L² (1 − s²)) is at most ½ ρ A w² √(C_D² + C_L²/4).
pub fn pushes(assembly: &Assembly) -> Vec<f64> {
    let Some(air) = &assembly.world.air else { return Vec::new() };
    let pressure = 0.5 * air.density * speed(air).powi(2) * air.drag.hypot(0.5 * air.lift);
    let mut pushes = vec![0.0; assembly.places];
    for body in &assembly.bodies {
        for triangle in aero_triangles(body) {
            let third = pressure * triangle.area / 3.0;
            triangle.corners.iter().for_each(|&corner| pushes[body.first + corner as usize] += third);
        }
    }
    pushes
}

/// A warning where cloth that is held back feels less of a wind across it than there is: the step is too long for so light a
/// triangle ([`crate::elements::aero::aero`]).
pub fn weakened(assembly: &Assembly) -> Option<Warning> {
    let air = assembly.world.air.as_ref()?;
    let step = assembly.time.substep(0).1;
    let of_body = |body| {
        aero_triangles(body).into_iter().map(move |triangle| (body, triangle.lightness * triangle.area))
    };
    let (body, lightest) = assembly.bodies.iter().flat_map(of_body).max_by(|a, b| a.1.total_cmp(&b.1))?;
    // d of a triangle across the wind, in a second.
    let rate = 0.5 * air.density * air.drag * speed(air) * lightest;
    let d = step * rate;
    (d > 0.5).then(|| {
        let felt = 100.0 / (1.0 + d * (2.0 - 1.0 / d).min(1.0));
        let longest = round_down(0.495 / rate);
        let message = format!(
            "a wind of {:.3} m/s across body `{}` presses with {felt:.0} % of its force where something holds the body back: the \
             step of {step:.3e} s is too long for cloth of {:.2e} kg/m²; sub-steps of {longest:e} s or less would do where that matters",
            speed(air),
            body.name,
            1.0 / lightest,
        );
        Warning::new(message, [Advice::LongestStep(longest)])
    })
}
