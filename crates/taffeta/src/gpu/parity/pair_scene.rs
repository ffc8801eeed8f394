//! The scene that rows of nodes that touch each other are run on.

use crate::build::Assembly;
use crate::build::body::BodyAssembly;
use crate::gpu::layout::Four;
use crate::gpu::parity::mesh_scene;
use crate::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Scene, Select, SelfCollision};

/// Nodes are within a cube of twice this edge [m].
pub const ROOM: f32 = 0.27;
/// Thickness of the first body [m].
pub const THICKNESS: f32 = 0.0625;

fn touching(name: &str, mesh: Mesh, [thickness, friction, restitution]: [f64; 3]) -> Body {
    let body = Body::cloth(name, mesh).with_mass(Mass::Node(0.0137)).structural(29.0, 0.011);
    Body { self_collision: Some(SelfCollision { thickness, friction, restitution }), ..body }
}

/// Grids with wide neighbourhoods and narrow ones, of one row too, meshes, one whose nodes are crowded, and two that touch
/// none; some nodes are held.
fn bodies() -> Vec<Body> {
    let ball = |radius, subdivisions| Mesh::Icosphere(Icosphere { radius, subdivisions });
    let plain = |name, mesh| Body::cloth(name, mesh).with_mass(Mass::Node(0.01)).structural(29.0, 0.011);
    vec![
        plain("apart", Mesh::grid(3, 5, [0.2, 0.1])),
        touching("sheet", Mesh::grid(9, 13, [0.7, 0.5]), [f64::from(THICKNESS), 0.31, 0.17])
            .shear(17.9, 0.017)
            .pin(Select::rows(0, 1)),
        touching("ball", ball(0.31, 2), [0.0523, 0.43, 0.0]).pin(Select::nodes((20..60).collect::<Vec<_>>())),
        plain("blob", ball(0.2, 1)),
        touching("fine", Mesh::grid(11, 19, [0.2, 0.3]), [0.0471, 0.0, 0.61]).bend(7.9, 0.003),
        touching("row", Mesh::grid(1, 37, [0.8, 0.0]), [0.0377, 0.53, 0.29]),
        touching("crowd", Mesh::chain(45, 1.03), [0.0613, 0.23, 0.13]),
        touching("wide", ball(0.17, 2), [0.0571, 0.67, 0.37]),
    ]
}

/// The bodies above, where a ball turns and a floor slopes; with `meshes`, among some of these too.
pub fn assembly(meshes: bool) -> Result<Assembly, String> {
    let rising = Keyframe::translate(0.5, [0.1, 0.2, -0.1]);
    let mut scene = Scene::new("pairs")
        .collider(Collider::plane([0.0, -0.13, 0.0], [0.03, 1.0, 0.02]).friction(0.4).restitution(0.2))
        .collider(Collider::sphere([0.2, 0.15, 0.1], 0.11).friction(0.3).keyframe(rising))
        .time(0.0173, 0.0041);
    if meshes {
        scene.colliders.extend(mesh_scene::colliders());
    }
    scene.bodies = bodies();
    Assembly::new(&scene).map_err(|error| error.to_string())
}

/// Puts some nodes where it matters: many in a heap; where kernels round as the CPU does, also two at one place, two as far
/// apart as they touch and two a hair nearer, some beyond the last layer of cells, and some nowhere.
pub fn put_awkward(position: &mut [Four], bodies: &[BodyAssembly], exact: bool) {
    let first = |name: &str| bodies.iter().find(|body| body.name == name).map_or(0, |body| body.first);
    let mut put = |place: usize, x: [f32; 3]| position[place][..3].copy_from_slice(&x);
    for i in 0..30 {
        // A line, so that the last one does not touch the first.
        let along = 0.0041 * i as f32;
        put(first("crowd") + i, [0.9 + along, 0.8 - 0.3 * along, 0.7]);
    }
    if !exact {
        return;
    }
    let sheet = first("sheet");
    let pairs = [
        ([0.0; 3], [0.0; 3]),
        ([0.0; 3], [THICKNESS, 0.0, 0.0]),
        ([0.0; 3], [THICKNESS.next_down(), 0.0, 0.0]),
        ([0.0; 3], [0.0, 0.0, -THICKNESS.next_down()]),
    ];
    for (i, (a, b)) in pairs.into_iter().enumerate() {
        let lift = |[x, _, z]: [f32; 3]| [x, 3.0 + i as f32, z];
        put(sheet + 30 + i, lift(a));
        put(sheet + 100 + i, lift(b));
    }
    let fine = first("fine");
    for (i, far) in
        [[1e4, 0.0, 0.0], [1.4e4, 0.0, 0.0], [0.0, -2e4, 3e4], [0.0, -4e4, 5e4]].into_iter().enumerate()
    {
        put(fine + i, far);
        put(fine + 150 + i, far.map(|x| x + 0.02));
    }
    put(fine + 40, [f32::NAN, 0.1, 0.1]);
    put(fine + 80, [0.1, f32::INFINITY, 0.1]);
    put(fine + 120, [0.1, 0.1, f32::NEG_INFINITY]);
}
