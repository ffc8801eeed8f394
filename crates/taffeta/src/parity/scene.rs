//! The scene that rows are run on: bodies of every sort at odd sizes, everything that acts on them, and colliders
//! of all convex kinds, still and moving.

use crate::scene::{
    Air, Body, Collider, FabricDamping, Force, Gust, Icosphere, Internal, Keyframe, Mass, Material, Mesh,
    RestCurvature, ScaleKey, Scene, Select, Torque, Zone,
};

/// The sheet's edge has pins; its corner at the end of the first row is moved by the program.
pub const SHEET: [u32; 2] = [19, 37];

/// Grids of several tiles, of one and of two nodes' width; meshes with one and with three kinds of springs. On hardware
/// the balls stand `apart`.
pub fn scene(drag: f64, apart: bool) -> Scene {
    let mut scene = Scene::new("parity").time(0.0173, 0.0041);
    scene.world.gravity = [0.37, -9.63, 0.21];
    scene.world.wind_force = [0.013, 0.0071, -0.0193];
    scene.world.drag = drag;
    scene.world.air = Some(air());
    scene.bodies = vec![sheet(), ball(), ribbon(), thread(), pole(), blob(), chain(), cape(), sack()];
    scene.forces = forces();
    scene.colliders = colliders(apart);
    let slips = [
        ("sheet", 1, 0.71),
        ("ball", 1, 0.13),
        ("ball", 3, 1.7),
        ("ribbon", 6, 0.21),
        ("blob", 0, 0.0),
        ("blob", 1, 0.37),
        ("cape", 0, 0.0),
    ];
    slips.into_iter().fold(scene, |scene, (body, collider, value)| {
        scene.friction_between(body, format!("collider{collider}"), value)
    })
}

/// Gusts smaller than bodies.
fn air() -> Air {
    let gust = Gust { speed: 2.3, length: 0.19, period: 0.041, seed: 5 };
    Air { velocity: [1.7, -0.6, 0.9], density: 1.31, drag: 1.07, lift: 0.83, gust: Some(gust) }
}

fn sheet() -> Body {
    let motion = |shift, degrees| Keyframe {
        translate: shift,
        ..Keyframe::rotate(0.5, [0.3, 0.8, -0.2], degrees, [0.11, -0.07, 0.23])
    };
    Body::cloth("sheet", Mesh::grid(SHEET[0], SHEET[1], [1.31, 0.77]))
        .with_mass(Mass::Area(0.19))
        .structural(43.7, 0.031)
        .shear(17.9, 0.017)
        .bend(5.3, 0.0071)
        .at([0.07, 0.11, -0.05])
        .pin(Select::nodes([5, 6, SHEET[1] - 1]))
        .pin_moving(Select::cols(0, 1), vec![motion([0.3, 0.2, -0.4], 70.0)])
        .pin_moving(Select::rows(18, 18), vec![motion([-0.2, 0.1, 0.3], -130.0)])
}

/// A sheet with more nodes on its first coarser level than a workgroup has invocations.
pub fn wide_sheet() -> Body {
    Body::cloth("wide sheet", Mesh::grid(41, 43, [0.93, 1.07]))
        .with_mass(Mass::Node(0.0031))
        .structural(33.1, 0.013)
        .shear(11.3, 0.0059)
        .bend(4.7, 0.0043)
        .at([-0.1, 0.2, 0.3])
        .pin(Select::nodes([0, 42, 900]))
}

fn ball() -> Body {
    let mut ball = Body::soft("ball", Mesh::Icosphere(Icosphere { radius: 0.43, subdivisions: 3 }))
        .with_mass(Mass::Volume(2.3))
        .structural(61.3, 0.023)
        .bend(11.7, 0.013)
        .at([-0.2, 0.3, 0.15])
        .pin(Select::nodes([17, 300]));
    ball.springs.internal = Some(Internal { count: 333, k: 7.9, d: 0.0091, ..Internal::default() });
    ball.with_elements()
}

fn ribbon() -> Body {
    Body::cloth("ribbon", Mesh::grid(41, 2, [0.043, 0.91]))
        .with_mass(Mass::Node(0.0037))
        .structural(29.1, 0.011)
        .shear(13.3, 0.0053)
        .at([0.3, 0.2, 0.1])
}

fn thread() -> Body {
    Body::cloth("thread", Mesh::grid(1, 29, [0.83, 0.0]))
        .with_mass(Mass::Node(0.0023))
        .structural(37.3, 0.0087)
        .bend(3.7, 0.0029)
        .at([0.1, 0.4, 0.3])
}

fn pole() -> Body {
    Body::cloth("pole", Mesh::grid(23, 1, [0.0, 0.71]))
        .with_mass(Mass::Node(0.0029))
        .structural(31.9, 0.0077)
        .bend(4.1, 0.0033)
        .at([-0.3, 0.1, 0.2])
}

fn blob() -> Body {
    let blob = Body::cloth("blob", Mesh::Icosphere(Icosphere { radius: 0.29, subdivisions: 2 }))
        .with_mass(Mass::Node(0.0053))
        .structural(47.9, 0.019);
    blob.at([0.25, -0.1, -0.3]).with_elements()
}

/// A fabric with borders, a clamp, a limit and a zone of another fabric, whose warp runs askew.
fn cape() -> Body {
    let band = Zone { select: Select::rows(3, 6), rest_scale: Some([0.9, 0.95].into()), ..Zone::default() };
    let material = Material {
        stretch: Some([23.0, 41.0].into()),
        shear: Some(7.3),
        poisson: Some(0.31),
        bending: Some([0.0021, 0.0037].into()),
        bending_poisson: Some(0.23),
        damping: Some(FabricDamping { stretch: 0.0013, bending: 0.0071 }),
        strain_limit: Some(0.3),
        warp: Some([0.8, 0.3]),
        zones: [("band".into(), Zone { strain_limit: Some(0.1), ..band })].into(),
        ..Material::preset("denim")
    };
    let cape = Body::cloth("cape", Mesh::grid(12, 17, [0.71, 0.53])).with_material(material);
    cape.at([-0.1, 0.3, -0.2]).pin(Select::rows(0, 1))
}

/// A closed fabric that is round at rest.
fn sack() -> Body {
    let material = Material {
        density: Some(0.17),
        stretch: Some(29.0.into()),
        bending: Some(0.0043.into()),
        damping: Some(FabricDamping { stretch: 0.0017, bending: 0.0059 }),
        rest_curvature: RestCurvature::Mesh,
        ..Material::preset("jersey")
    };
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.37, subdivisions: 2 });
    Body::cloth("sack", mesh).with_material(material).at([0.15, 0.2, -0.25])
}

fn chain() -> Body {
    Body::cloth("chain", Mesh::chain(37, 1.03)).with_mass(Mass::Node(0.0041)).structural(53.9, 0.021)
}

/// Forces that overlap, torques on more nodes than a workgroup has invocations and on one node alone.
fn forces() -> Vec<Force> {
    let scale = |scale: f64| vec![ScaleKey { t: 0.001, scale: 0.3 }, ScaleKey { t: 0.31, scale }];
    let push = |body: &str, select, force| Force {
        body: body.to_owned(),
        select,
        force: Some(force),
        motion: scale(1.7),
        ..Force::default()
    };
    let turn = |body: &str, select, value| Force {
        body: body.to_owned(),
        select,
        torque: Some(Torque { axis: [0.3, 0.9, -0.4], value, about: [-0.25, 0.3125, 0.125] }),
        motion: scale(-2.3),
        ..Force::default()
    };
    vec![
        push("sheet", Select::rows(2, 11), [0.031, -0.017, 0.023]),
        push("sheet", Select::rows(9, 15), [-0.013, 0.029, 0.0081]),
        turn("ball", Select::nodes((0..642).collect::<Vec<_>>()), 0.37),
        push("ball", Select::nodes([3, 5, 641]), [0.011, 0.019, -0.037]),
        turn("ribbon", Select::rows(3, 7), -0.021),
        turn("pole", Select::nodes([4]), 0.013),
        turn("chain", Select::nodes((0..38).collect::<Vec<_>>()), 0.053),
    ]
}

/// A node of the pole that has a torque of its own; the fixture puts it on the axis.
pub const ON_THE_AXIS: (usize, [f32; 3]) = (4, [-0.25, 0.3125, 0.125]);

/// Height of the still floor [m].
pub const FLOOR: f32 = -0.25;
/// Height of the plane that faces it [m].
pub const CEILING: f32 = 4.5;
/// Centre of the still ball.
pub const CENTER: [f32; 3] = [2.0, 0.5, -1.5];

/// Between two balls that overlap [m], and in one of them where they stand apart.
pub fn middle(apart: bool) -> [f32; 3] {
    [0.29, if apart { 0.5 } else { -0.1 }, -0.07]
}

/// A floor and a slope make a wedge, two balls overlap; one plane faces the floor. Between a ball and what it is
/// pressed against, the way out depends on the last digit: where devices may round in their own ways, the balls stand
/// apart.
fn colliders(apart: bool) -> Vec<Collider> {
    let balls = if apart {
        [[0.21, 0.65, -0.13], [1.25, 0.34, 0.68]]
    } else {
        [[0.21, 0.05, -0.13], [0.35, -0.11, -0.02]]
    };
    let moving = Keyframe {
        translate: [0.2, -0.1, 0.15],
        ..Keyframe::rotate(0.5, [-0.2, 0.7, 0.4], 80.0, [0.31, 0.13, -0.22])
    };
    let slow = Keyframe {
        translate: [-0.1, 0.15, 0.1],
        ..Keyframe::rotate(0.5, [0.4, 0.3, -0.6], -60.0, [-0.2, 0.3, 0.1])
    };
    let floor = [0.0, f64::from(FLOOR), 0.0];
    vec![
        Collider::sphere(balls[0], 0.37).friction(0.4).restitution(0.3).keyframe(moving.clone()),
        Collider::plane(floor, [0.0, 1.0, 0.0]).friction(0.5).restitution(0.25).offset(0.0),
        Collider::plane([-0.6, 0.0, 0.0], [0.7, 0.45, 0.1]).friction(0.7).restitution(0.1).keyframe(moving),
        Collider::sphere(balls[1], 0.29).friction(0.9).restitution(0.6),
        Collider::sphere(CENTER.map(f64::from), 0.375).friction(0.2).restitution(0.15).offset(0.0),
        Collider::cuboid([-0.45, 0.6, 0.4], [0.27, 0.13, 0.21])
            .friction(0.35)
            .restitution(0.2)
            .keyframe(slow.clone()),
        Collider::capsule([0.5, 0.3, 0.4], [0.8, 0.7, 0.2], 0.11).friction(0.6).restitution(0.35),
        Collider::cylinder([-0.1, 0.4, -0.7], [-0.5, 0.8, -0.5], 0.17).friction(0.45).keyframe(slow),
        Collider::plane([0.0, f64::from(CEILING), 0.0], [0.0, -1.0, 0.0])
            .friction(0.3)
            .restitution(0.2)
            .offset(0.0),
    ]
}
