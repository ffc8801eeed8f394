//! A body that keeps its volume by one multiplier and the lengths of its springs by others.

use super::{with_acad, with_ice};
use crate::common::{build, run};
use taffeta::scene::{Acad, Body, Collider, Ice, Icosphere, Mass, Mesh, Scene, VolumeForm};

/// A ball with springs of `k` [N/m] that falls 10 cm, in steps of `h` [s].
fn scene(form: VolumeForm, k: f64, h: f64) -> Scene {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
    let ball = Body::soft("ball", mesh).with_mass(Mass::Whole(2.0)).structural(k, 0.5).keep_volume(form);
    Scene::new("volume")
        .time(0.01, h)
        .body(ball.at([0.0, 0.6, 0.0]))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
}

/// Largest error of the volume, by the volume, and largest stretch in the second in which it lands.
fn worst(scene: &Scene) -> [f64; 2] {
    let mut simulation = build(scene);
    let [mut off, mut stretch, mut contacts] = [0.0_f64, 1.0_f64, 0.0];
    for _ in 0..100 {
        run(&mut simulation, 1);
        let report = simulation.report();
        let share = report.volumes[0].expect("closed") / report.volume_targets[0].expect("kept");
        (off, stretch) = (off.max((share - 1.0).abs()), stretch.max(report.max_stretch));
        contacts += report.contacts as f64;
    }
    assert!(contacts > 0.0, "it lands");
    [off, stretch]
}

#[test]
fn a_ball_of_stiff_constraints_that_lands_keeps_its_volume_and_its_lengths() {
    // Springs alone cannot have these steps.
    for (form, h, allowed) in [
        (VolumeForm::Corrected, 0.005, 5e-3),
        (VolumeForm::Corrected, 0.0025, 2e-3),
        (VolumeForm::Projected, 0.005, 1e-9),
    ] {
        let [off, stretch] = worst(&with_ice(scene(form, 1e4, h), Ice::default()));
        assert!(off < allowed && stretch < 1.08, "{form:?}, {h} s: {off:e}, {stretch}");
    }
}

#[test]
fn a_ball_of_soft_springs_keeps_its_volume_and_no_spring_is_far_beyond_the_threshold() {
    let springs = scene(VolumeForm::Corrected, 100.0, 0.00125);
    let [_, free] = worst(&springs);
    let acad = Acad { threshold: 0.05, ..Acad::default() };
    let [off, held] = worst(&with_acad(springs, acad, Ice::default()));
    assert!(off < 1e-3, "{off:e}");
    assert!(held < 1.15 && free > 1.25, "{held}, without constraints {free}");
}
