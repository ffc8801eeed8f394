//! Contact between triangles in steps that are too long for what happens: shorter ones take their place as long as it does.

use crate::common::build_as;
use crate::surfaces::{fabric, implicit};
use taffeta::Precision;
use taffeta::scene::{Collider, Keyframe, Material, Scene};

/// Two boxes push a cloth on the floor together, and let it go.
fn pinched() -> Scene {
    let pushing = |side: f64| {
        let key = |t: f64, way: f64| Keyframe::translate(t, [-side * way, 0.0, 0.0]);
        let collider = Collider::cuboid([side * 0.18, 0.052, 0.0], [0.05, 0.05, 0.2]);
        let keys = [key(0.1, 0.0), key(0.6, 0.12), key(0.8, 0.12), key(0.9, 0.0)];
        keys.into_iter().fold(collider.offset(0.003).friction(0.6), Collider::keyframe)
    };
    let scene = Scene::new("pinched")
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction(0.2))
        .collider(pushing(-1.0))
        .collider(pushing(1.0))
        .body(fabric("cloth", [12, 15], [0.0, 0.01, 0.0]).with_material(Material::preset("cotton")));
    implicit(scene, 1.0 / 60.0)
}

#[test]
fn long_steps_become_shorter_while_cloth_is_pinched() {
    let mut simulation = build_as(&pinched(), Precision::F32, 2);
    let mut frames = Vec::new();
    for _ in 0..62 {
        let report = simulation.step().unwrap();
        frames.push((report.substeps, report.max_stretch));
        assert_eq!(simulation.intersections().pairs, 0, "frame {}", simulation.frame());
    }
    // Nobody touches anything else before the boxes come, and they are gone at the end.
    assert!(frames[..9].iter().all(|&(substeps, _)| substeps == 1), "{frames:?}");
    assert!(frames[20..50].iter().any(|&(substeps, _)| substeps == 16), "{frames:?}");
    assert!(frames[61].0 < 16, "{frames:?}");
    let most = frames.iter().fold(0.0, |most: f64, &(_, stretch)| most.max(stretch));
    assert!(most < 1.6, "cotton was stretched to {most} times its length");
}
