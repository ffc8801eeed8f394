//! A body that keeps its volume by one multiplier and the lengths of its springs by others.

use super::common::{build, run};
use super::{with_acad, with_ice};
use taffeta::scene::{Acad, Body, Collider, Ice, Icosphere, Mass, Mesh, Scene, VolumeForm};

fn scene(form: VolumeForm) -> Scene {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
    let ball = Body::soft("ball", mesh).with_mass(Mass::Whole(2.0)).structural(1e4, 0.5).keep_volume(form);
    Scene::new("volume")
        .time(0.01, 0.005)
        .body(ball.at([0.0, 0.6, 0.0]))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
}

#[test]
fn a_ball_that_lands_keeps_its_volume_and_its_lengths() {
    let acad = Acad { threshold: 0.01, ..Acad::default() };
    for (form, allowed) in [(VolumeForm::Corrected, 1e-3), (VolumeForm::Projected, 1e-8)] {
        let soft = || {
            let mut scene = scene(form);
            scene.bodies[0].springs.structural.as_mut().expect("it has them").k = 100.0;
            scene
        };
        for scene in [with_ice(scene(form), Ice::default()), with_acad(soft(), acad.clone(), Ice::default())]
        {
            let mut simulation = build(&scene);
            let [mut off, mut stretch, mut contacts] = [0.0_f64, 1.0_f64, 0.0];
            for _ in 0..100 {
                run(&mut simulation, 1);
                let report = simulation.report();
                let share = report.volumes[0].expect("closed") / report.volume_targets[0].expect("kept");
                (off, stretch) = (off.max((share - 1.0).abs()), stretch.max(report.max_stretch));
                contacts += report.contacts as f64;
            }
            assert!(contacts > 0.0);
            assert!(
                off < allowed && stretch < 1.05,
                "{form:?}, {:?}: {off:e}, {stretch}",
                scene.solver.method
            );
        }
    }
}
