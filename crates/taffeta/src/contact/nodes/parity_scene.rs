//! The scene that rows of nodes that touch each other are run on.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::backend::{Backend, FrameInput};
use crate::contact::collider_mesh::parity_scene as meshes_by_chance;
use crate::cpu::CpuBackend;
use crate::features::Tables;
use crate::gpu::layout::Four;
use crate::parity::fixture::{Chance, Fixture, State};
use crate::scene::{
    Body, Collider, ContactForm, Icosphere, Keyframe, Layers, Mass, Mesh, Scene, Select, SelfCollision,
};

/// Nodes are within a cube of twice this edge [m].
const ROOM: f32 = 0.27;
/// Thickness of the first body [m].
const THICKNESS: f32 = 0.0625;

fn touching(name: &str, mesh: Mesh, [thickness, friction, restitution]: [f64; 3]) -> Body {
    let body = Body::cloth(name, mesh).with_mass(Mass::Node(0.0137)).structural(29.0, 0.011);
    Body {
        self_collision: Some(SelfCollision {
            form: ContactForm::Nodes,
            thickness,
            friction,
            restitution,
            ..SelfCollision::default()
        }),
        ..body
    }
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

/// The bodies above, where a ball turns and a floor slopes; with `meshes`, among some of these too, and with `layers`, some of them
/// not meeting others.
fn assembly(meshes: bool, layers: bool) -> Result<Assembly, String> {
    let rising = Keyframe::translate(0.5, [0.1, 0.2, -0.1]);
    let mut scene = Scene::new("pairs")
        .collider(Collider::plane([0.0, -0.13, 0.0], [0.03, 1.0, 0.02]).friction(0.4).restitution(0.2))
        .collider(Collider::sphere([0.2, 0.15, 0.1], 0.11).friction(0.3).keyframe(rising))
        .time(0.0173, 0.0041)
        .friction_between("fine", "collider0", 0.9)
        .friction_between("ball", "collider0", 0.0);
    if meshes {
        scene.colliders.extend(meshes_by_chance::colliders());
    }
    scene.bodies = bodies();
    if layers {
        // Two of each other's layers, and one that the first alone meets.
        scene.bodies[1].layers = Layers::new([0, 1], [2, 3]);
        scene.bodies[2].layers = Layers::new([3], [1]);
        scene.bodies[5].layers = Layers::new([2], [4]);
    }
    Assembly::new(&scene).map_err(|error| error.to_string())
}

/// Puts some nodes where it matters: many in a heap; where kernels round as the CPU does, also two at one place, two as far
/// apart as they touch and two a hair nearer, some beyond the last layer of cells, and some nowhere.
fn put_awkward(position: &mut [Four], bodies: &[BodyAssembly], exact: bool) {
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

/// Bodies that touch each other: crowded, here and there exactly as far apart as they touch, and far out. With an even seed some do
/// not meet others.
pub fn fixture(seed: u64, exact: bool, meshes: bool) -> Result<Fixture, String> {
    let states = |chance: &mut Chance, tables: &Tables, cpu: &CpuBackend<f32>| {
        let [old, mut new] = [0, 1].map(|_| {
            let mut state = State::default();
            for (place, (&[.., w], &[.., mass])) in tables.position.iter().zip(&tables.velocity).enumerate() {
                let ([x, y, z], [u, v, t]) = (chance.three(ROOM), chance.three(1.3));
                state.position.push([x, y, z, w]);
                state.velocity.push([u, v, t, if place % 7 == 3 { -mass } else { mass }]);
            }
            state
        });
        put_awkward(&mut new.position, &cpu.assembly().bodies, exact);
        [old, new]
    };
    Fixture::drawn(assembly(meshes, seed.is_multiple_of(2))?, &mut Chance::new(seed), states, |_| {
        FrameInput::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::nodes::gpu_layout::Surface;
    use crate::contact::nodes::parity::Work;
    use crate::parity::coverage::Count;

    #[test]
    fn nodes_touch_each_other_in_all_sorts_of_ways() {
        let mut count = Count::default();
        let fixture = fixture(21, true, false).expect("a fixture");
        let work = Work::new(&fixture);
        let surface = |node: usize| {
            let is_of = |one: &&Surface| (one.first..one.first + one.count).contains(&(node as u32));
            fixture.tables.self_collision.surfaces.iter().find(is_of)
        };
        for (node, contacts) in work.contacts.iter().enumerate() {
            let (x, nearest) = (fixture.new.position[node], work.nearest[node]);
            let free = x[3] > 0.0;
            count.note("none", contacts.is_empty() && surface(node).is_some());
            count.note("one alone", contacts.len() == 1);
            count.note("exactly sixteen", contacts.len() == 16);
            count.note("more than sixteen", contacts.len() > 16);
            count.note("at one place", nearest == 0.0);
            count.note("a hair nearer than it is kept", nearest > 0.99999 && nearest < 1.0);
            count.note("beyond the last layer", x[0] > 4e3 && !contacts.is_empty());
            count.note("no number", x[..3].iter().any(|x| x.is_nan()) && surface(node).is_some());
            count.note("a place without a surface", surface(node).is_none() && fixture.is_node[node]);
            let Some(own) = surface(node) else { continue };
            for &other in contacts {
                let is_held = fixture.new.position[other as usize][3] == 0.0;
                count.note("both held", !free && is_held);
                count.note("one held", free && is_held);
                count.note(
                    "one of a grid, far along it",
                    own.cols > 0 && surface(other as usize) == Some(own),
                );
                count.note(
                    "one of a mesh, far along it",
                    own.cols == 0 && surface(other as usize) == Some(own),
                );
                count.note("another body", surface(other as usize) != Some(own));
            }
        }
        let distant = fixture
            .tables
            .self_collision
            .surfaces
            .iter()
            .filter(|surface| surface.high > 2 || surface.wide > 2);
        count.note("wide neighbourhoods", distant.count() > 0);
        count.check();
    }
}
