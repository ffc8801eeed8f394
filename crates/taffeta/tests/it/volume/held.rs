//! Nodes that are held.

use super::{ball, error};
use crate::common::{build, build_as, norm, positions, run, sub, warnings, weightless};
use taffeta::Precision;
use taffeta::scene::{
    Body, Bounds, Cylinder, Keyframe, Mass, Mesh, Select, Volume, VolumeForm, VolumeKey, VolumeWeights,
};

fn slab(from: f64, to: f64) -> Select {
    Select { inside: Some(Bounds { min: [-9.0, from, -9.0], max: [9.0, to, 9.0] }), ..Select::default() }
}

#[test]
fn a_can_that_is_wrung_by_its_ends_keeps_its_volume() {
    let can = Cylinder { radius: 0.3, height: 1.0, segments: 24, rings: 20, capped: true };
    for (form, most) in
        [(VolumeForm::Corrected, 1e-3), (VolumeForm::Projected, 1e-9), (VolumeForm::None, 1.0)]
    {
        let body = Body::soft("can", Mesh::Cylinder(can)).with_mass(Mass::Whole(2.0));
        let body = body
            .structural(1000.0, 0.3)
            .bend(200.0, 0.1)
            .pin(slab(-0.51, -0.49))
            .pin_moving(slab(0.49, 0.51), vec![Keyframe::rotate(1.0, [0.0, 1.0, 0.0], 90.0, [0.0; 3])]);
        let keeps = form != VolumeForm::None;
        let body = if keeps { body.keep_volume(form) } else { body };
        let mut simulation = build(&weightless("wrung", 0.01, 0.001).body(body));
        let rest = simulation.report().volumes[0].unwrap();
        let mut worst = 0.0_f64;
        for _ in 0..150 {
            run(&mut simulation, 1);
            worst = worst.max((simulation.report().volumes[0].unwrap() / rest - 1.0).abs());
        }
        assert!(worst < most, "{form:?}: {worst:e}");
        assert!(keeps || worst > 0.02, "springs alone lose some: {worst}");
    }
}

#[test]
fn pins_that_change_their_speed_at_once_show_for_one_step() {
    // The lid of a can jumps to 0.5 m/s: its way in the first step is h Δv A more volume, gone a step later.
    let can = Cylinder { radius: 0.3, height: 1.0, segments: 24, rings: 8, capped: true };
    let h = 0.001;
    let body = Body::soft("can", Mesh::Cylinder(can)).with_mass(Mass::Whole(2.0)).structural(300.0, 0.1);
    let body = body.pin_moving(slab(0.49, 0.51), vec![Keyframe::translate(1.0, [0.0, 0.5, 0.0])]);
    let mut simulation = build(&weightless("lid", h, h).body(body.keep_volume(VolumeForm::Corrected)));
    let rest = simulation.report().volumes[0].unwrap();
    let triangles = 24.0 * 0.5 * 0.3_f64.powi(2) * (std::f64::consts::TAU / 24.0).sin();
    // A third of the area of the triangles beside the lid's rim moves with it, too; they stand upright.
    let jump = h * 0.5 * triangles / rest;
    run(&mut simulation, 1);
    assert!((error(&simulation) / jump - 1.0).abs() < 1e-6, "{:e} {jump:e}", error(&simulation));
    for _ in 0..5 {
        run(&mut simulation, 1);
        assert!(error(&simulation).abs() < 0.02 * jump, "{:e}", error(&simulation));
    }
}

#[test]
fn a_body_all_of_which_is_held_runs_and_warns() {
    for form in [VolumeForm::Corrected, VolumeForm::Projected, VolumeForm::PaperShader, VolumeForm::Printed] {
        for precision in [Precision::F32, Precision::F64] {
            let mut body = ball(1, form).pin(slab(-9.0, 9.0));
            body.volume.as_mut().unwrap().target = Some(1.5);
            let mut simulation = build_as(&weightless("held", 0.01, 0.001).body(body), precision, 1);
            let warned =
                warnings(&simulation).iter().filter(|w| w.contains("all its nodes are pinned")).count();
            assert_eq!(warned, 1, "{:?}", simulation.warnings());
            let before = positions(&simulation);
            run(&mut simulation, 10);
            assert!(before == positions(&simulation));
        }
    }
}

#[test]
fn weights_whose_nodes_are_all_held_warn_and_push_nothing() {
    let mut body = ball(2, VolumeForm::Corrected).pin(slab(0.3, 9.0));
    let weights = VolumeWeights { center: [0.0, 0.5, 0.0], radius: 0.18 };
    body.volume = Some(Volume { weights: Some(weights), target: Some(1.1), ..Volume::default() });
    let mut simulation = build(&weightless("held", 0.01, 0.001).body(body));
    let warned = warnings(&simulation).join("\n");
    assert!(warned.contains("within the radius of its volume.weights are held"), "{warned}");
    let before = positions(&simulation);
    run(&mut simulation, 50);
    let moved = before.iter().zip(positions(&simulation)).map(|(&x, now)| norm(sub(now, x)));
    assert!(moved.fold(0.0, f64::max) < 1e-14);
}

#[test]
fn weights_beside_held_nodes_grow_a_bump_there_and_move_little_else() {
    // Held below y = 0.1 m; the weights are at the edge of what is held.
    let mut body = ball(3, VolumeForm::Projected).pin(slab(-9.0, 0.1));
    let weights = VolumeWeights { center: [0.45, 0.2, 0.0], radius: 0.25 };
    let motion = vec![VolumeKey { t: 0.1, target: Some(1.002), pressure: None }];
    body.volume =
        Some(Volume { form: VolumeForm::Projected, weights: Some(weights), motion, ..Volume::default() });
    let mut simulation = build(&weightless("beside", 0.01, 0.001).body(body));
    let before = positions(&simulation);
    run(&mut simulation, 10);
    assert!(error(&simulation).abs() < 1e-9, "{:e}", error(&simulation));
    let most = |near: bool| {
        let moved = before.iter().zip(positions(&simulation)).filter_map(|(&x, now)| {
            ((norm(sub(x, weights.center)) < 0.25) == near).then_some(norm(sub(now, x)))
        });
        moved.fold(0.0, f64::max)
    };
    assert!((0.02..0.1).contains(&most(true)), "{}", most(true));
    assert!(most(false) < 0.5 * most(true), "{} {}", most(false), most(true));
}

#[test]
fn one_free_node_carries_the_volume_of_all() {
    // The cap's node goes out by 3 ΔV over the area of its ring, seen along its way.
    let free = 7;
    let body = ball(1, VolumeForm::Projected);
    let all: Vec<u32> = (0..42).filter(|&n| n != free).collect();
    let mut body = body.pin(Select::nodes(all));
    body.volume.as_mut().unwrap().target = Some(1.05);
    let mut simulation = build(&weightless("one", 0.01, 0.001).body(body));
    run(&mut simulation, 100);
    assert!(error(&simulation).abs() < 1e-9, "{:e}", error(&simulation));
}
