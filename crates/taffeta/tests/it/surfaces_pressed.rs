//! Layers of cloth between colliders that leave them less room than they are thick.

use crate::common::{build_as, turned};
use crate::surfaces::{implicit, touching};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Keyframe, Material, Mesh, Scene};

/// Layers of 5 mm that two boxes press together within so many seconds, until so much is between the boxes [m].
pub fn pressed(layers: u32, room: f64, seconds: f64, layer: impl Fn(Body) -> Body) -> Scene {
    let height = 0.003 * f64::from(layers);
    let scene = (0..layers).fold(Scene::new("pressed"), |scene, number| {
        let n = f64::from(number);
        let mut body = layer(Body::cloth(format!("layer {number}"), Mesh::grid(7, 7, [0.13; 2])));
        body.place = turned([0.2, 1.0, 0.1], 7.0 * n, [0.002 * n, 0.006 * n - height, 0.001 * n]);
        let mut body = touching(body, 0.3);
        body.self_collision.as_mut().expect("it touches").thickness = 0.005;
        scene.body(body)
    });
    [-1.0, 1.0].into_iter().fold(scene, |scene, side| {
        let plate = Collider::cuboid([0.01 * side, side * (height + 0.05), 0.0], [0.05, 0.02, 0.05]);
        let way = side * (height + 0.03 - 0.5 * room);
        scene.collider(
            plate.offset(0.003).friction(0.5).keyframe(Keyframe::translate(seconds, [0.0, -way, 0.0])),
        )
    })
}

fn cotton(body: Body) -> Body {
    body.with_material(Material::preset("cotton"))
}

/// Runs until the boxes are where they end, and shortly after.
fn nothing_is_pierced(scene: &Scene) {
    let mut simulation = build_as(scene, Precision::F32, 2);
    for frame in 1..=38 {
        let report = simulation.step().unwrap();
        assert_eq!(report.squeezed, None, "frame {frame}");
        let found = simulation.intersections();
        assert_eq!(found.pairs, 0, "frame {frame}: {:?}", found.first);
    }
}

#[test]
fn layers_between_two_colliders_share_what_room_there_is() {
    // 30 mm of cloth in 8 mm.
    nothing_is_pierced(&implicit(pressed(6, 0.008, 0.6, cotton), 1.0 / 60.0));
}

#[test]
fn layers_are_not_pushed_into_a_collider_at_rest() {
    // 15 mm of cloth in 6 mm, and one of the boxes goes all the way.
    let mut scene = implicit(pressed(3, 0.006, 0.6, cotton), 1.0 / 60.0);
    scene.colliders[0].motion.clear();
    scene.colliders[1].motion[0].translate[1] *= 2.0;
    nothing_is_pierced(&scene);
}

#[test]
fn layers_without_any_room_are_reported() {
    // 15 mm of cloth in 1 mm.
    let scene = implicit(pressed(3, 0.001, 0.6, cotton), 1.0 / 60.0);
    let mut simulation = build_as(&scene, Precision::F32, 2);
    let mut reported = Vec::new();
    for frame in 1..=38 {
        let report = simulation.step().unwrap();
        reported.extend(report.squeezed.clone().map(|squeezed| (frame, squeezed)));
        // Nothing passes through anything unsaid.
        assert!(simulation.intersections().pairs == 0 || !reported.is_empty(), "frame {frame}");
    }
    let (frame, first) = &reported[0];
    assert!((30..=36).contains(frame) && first.body < 3 && first.vertex < 49, "{reported:?}");
    let mut colliders = first.colliders.clone();
    colliders.sort_unstable();
    assert_eq!(colliders, [0, 1]);
}
