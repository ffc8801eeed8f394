//! The engine against the naive reference in 64 bits.

use super::{ball, ring};
use crate::common::compare::{DT, STEP, compare_for, reference, scene};
use crate::common::lists::{edges, lumped};
use crate::common::reference::{Obstacle, Reference, Rigid};
use crate::common::{build, build_as, farthest, positions, run, surface};
use taffeta::scene::{Body, Collider, Keyframe, Scene, Select, VolumeForm};
use taffeta::{Precision, Simulation};

/// A body that falls onto a slanted plane which rises, with a pin that moves; and the same for the reference.
fn both(body: Body, form: VolumeForm) -> (Scene, Simulation, Reference) {
    let path =
        Rigid { until: 0.4, shift: [0.02, 0.05, 0.0], axis: [0.0, 1.0, 0.0], radians: 0.3, pivot: [0.0; 3] };
    let key = |path: &Rigid| Keyframe {
        translate: path.shift,
        ..Keyframe::rotate(path.until, path.axis, path.radians.to_degrees(), path.pivot)
    };
    let rise =
        Rigid { until: 0.3, shift: [0.0, 0.05, 0.0], axis: [0.0, 0.0, 1.0], radians: 0.0, pivot: [0.0; 3] };
    let normal = [0.0, 0.8, 0.6];
    let slope = Collider::plane([0.0, -0.65, 0.0], normal).offset(0.0).friction(0.0);
    let scene = scene(body.pin_moving(Select::nodes([3]), vec![key(&path)]))
        .collider(slope.keyframe(Keyframe::translate(rise.until, rise.shift)));
    let simulation = build(&scene);
    let (triangles, x) = (surface(&simulation, 0).triangles, positions(&simulation));
    let share = lumped(&x, &triangles, 1.0);
    let total: f64 = share.iter().sum();
    let mass = share.iter().map(|s| 2.0 * s / total).collect();
    let mut reference = reference(&scene, &simulation, mass);
    reference.join(edges(&triangles), [300.0, 0.1]);
    reference.held.insert(3);
    reference.pins.push((3, x[3], path));
    reference.obstacles.push(Obstacle {
        at: [0.0, -0.65, 0.0],
        ball: None,
        normal,
        friction: 0.0,
        restitution: 0.0,
        motion: rise,
    });
    reference.keep_volume(triangles, form == VolumeForm::Projected);
    (scene, simulation, reference)
}

fn bodies(form: VolumeForm) -> [Body; 2] {
    [ball(2, form), ring(form)]
}

#[test]
fn bodies_that_keep_their_volume_move_as_their_triangles_do() {
    for form in [VolumeForm::Corrected, VolumeForm::Projected] {
        for body in bodies(form) {
            let (_, simulation, reference) = both(body, form);
            // 300 steps.
            compare_for(simulation, reference, 0.005, 100);
        }
    }
}

#[test]
fn in_32_bits_they_move_as_in_64_bits_to_a_tenth_of_a_millimetre() {
    for form in [VolumeForm::Corrected, VolumeForm::Projected] {
        for body in bodies(form) {
            let (scene, mut fine, _) = both(body, form);
            let mut coarse = build_as(&scene, Precision::F32, 2);
            let steps = f64::ceil(DT / STEP) as u32;
            run(&mut fine, 300 / steps);
            run(&mut coarse, 300 / steps);
            let apart = farthest(&positions(&fine), &positions(&coarse));
            assert!(apart < 1e-4, "{form:?}: {apart:e} m");
        }
    }
}
