//! The scene that rows of surfaces that touch each other are run on.

use crate::assembly::Assembly;
use crate::backend::{Backend, FrameInput};
use crate::cpu::CpuBackend;
use crate::features::Tables;
use crate::parity::fixture::{Chance, Fixture, State};
use crate::real::{add, sub};
use crate::scene::{
    Body, Collider, ContactForm, ContactZone, Icosphere, Keyframe, Mass, Mesh, Place, Rotation, Scene,
    Select, SelfCollision, Solver,
};

/// Where nodes are that are not [m].
const NOWHERE: f32 = 9.0;
/// Where a strip lies flat that is folded in the state, and the width of its quads [m]. It is a single leaf.
const FOLD: ([f64; 3], f64) = ([0.6, 0.0, 0.0], 0.05);
/// The folded strip, from its first edge to its last, at heights above each other [m].
const FOLDED: [[f32; 2]; 5] = [[0.0, 0.0], [0.03, 0.0], [0.045, 0.006], [0.03, 0.012], [0.0, 0.012]];

/// Two layers that are all pinned: where the lower one is, how far they are apart, nearer than a plane that goes along allows, and how
/// far their pins go [m].
const LAYERS: ([f64; 3], f64, [f32; 3]) = ([0.3, 0.4, 0.3], 1e-4, [0.004, -0.003, 0.002]);
/// How the upper one is turned, so that which of their edges and vertices are nearest is no matter of the last bit.
const TURNED: Rotation = Rotation { axis: [0.0, 1.0, 0.0], degrees: 19.0 };

/// Sheets one above the other, coarse and fine, so far from each other [m], a ball among them, a box, and a strip and pinned layers
/// beside them.
fn assembly(solver: Solver, between: f64) -> Result<Assembly, String> {
    let touching = |name: &str, mesh: Mesh, [thickness, friction]: [f64; 2]| Body {
        self_collision: Some(SelfCollision {
            form: ContactForm::Triangles,
            thickness,
            friction,
            ..SelfCollision::default()
        }),
        ..Body::cloth(name, mesh).with_mass(Mass::Node(0.0137)).structural(29.0, 0.011)
    };
    let ball = Mesh::Icosphere(Icosphere { radius: 0.07, subdivisions: 1 });
    let apart = Body::cloth("apart", Mesh::grid(3, 5, [0.2, 0.1])).with_mass(Mass::Node(0.01));
    // In each sub-step it goes up by more than half the least thickness.
    let middle = [0.1, -0.066, 0.05];
    let way =
        Keyframe { translate: [0.03, 0.3, 0.02], ..Keyframe::rotate(0.1, [0.3, 0.2, -1.0], 40.0, middle) };
    let moving = Collider::cuboid(middle, [0.07, 0.03, 0.05]).keyframe(way);
    let mut scene = Scene::new("surfaces")
        .collider(Collider::plane([0.0, -0.07, 0.0], [0.03, 1.0, 0.02]).friction(0.4))
        .collider(moving.friction(0.3).offset(0.017))
        .time(0.0173, 0.0041);
    let mut fine = touching("fine", Mesh::grid(8, 10, [0.17, 0.22]), [0.0171, 0.43]);
    let hem = ContactZone { select: Select::rows(0, 3), thickness: 0.0193 };
    fine.self_collision.iter_mut().for_each(|touch| touch.zones = [("hem".into(), hem.clone())].into());
    let layer = |name: &str, height: f64, rotation: Option<Rotation>| {
        let [x, y, z] = LAYERS.0;
        let all = Select::nodes((0..20).collect::<Vec<_>>());
        let mut body = touching(name, Mesh::grid(4, 5, [0.04, 0.03]), [0.016, 0.1]).pin(all);
        body.place = Place { position: [x, y + height, z], rotation, ..Place::default() };
        body
    };
    scene.bodies = vec![
        layer("under", 0.0, None),
        layer("upon", LAYERS.1, Some(TURNED)),
        touching("coarse", Mesh::grid(7, 6, [0.33, 0.28]), [0.0213, 0.31])
            .pin(Select::nodes((0..42).filter(|node| node % 3 > 0).collect::<Vec<_>>())),
        apart.structural(29.0, 0.011).at([0.0, 1.0, 0.0]),
        fine.at([0.0, between, 0.0]),
        touching("ball", ball, [0.0191, 0.0]).at([0.03, 0.1, 0.02]),
        touching("fold", Mesh::grid(2, 5, [4.0 * FOLD.1, 0.03]), [0.016, 0.2]).at(FOLD.0),
    ];
    scene.solver = solver;
    Assembly::new(&scene).map_err(|error| error.to_string())
}

/// A place of the strip where it is folded.
fn folded([x, y, z]: [f32; 3]) -> [f32; 3] {
    let ([middle, ..], width) = FOLD;
    let quad = ((f64::from(x) - middle) / width).round() as i32 + 2;
    let [along, up] = FOLDED[quad.clamp(0, 4) as usize];
    [middle as f32 + along, y + up, z]
}

/// Nodes near their start, some of which go far.
pub fn fixture(seed: u64) -> Result<Fixture, String> {
    fixture_with(seed, Solver::default(), 0.021)
}

/// The same with a solver, and with sheets so far from each other [m].
pub fn fixture_with(seed: u64, solver: Solver, between: f64) -> Result<Fixture, String> {
    let states = |chance: &mut Chance, tables: &Tables, cpu: &CpuBackend<f32>| {
        let bodies = &cpu.assembly().bodies;
        let strip = bodies.last().map(|body| body.solver_range());
        let layers = bodies[..2].iter().map(|body| body.solver_range()).collect::<Vec<_>>();
        let mut old = State::default();
        let mut new = State::default();
        for (place, (&[x, y, z, w], &[.., mass])) in tables.position.iter().zip(&tables.velocity).enumerate()
        {
            let is_folded = strip.as_ref().is_some_and(|strip| strip.contains(&place));
            let is_layer = layers.iter().any(|layer| layer.contains(&place));
            let (at, by) = if is_folded { (folded([x, y, z]), 0.001) } else { ([x, y, z], 0.007) };
            let mut start = add(at, chance.three(by));
            let mut way = chance.three(if place % 11 == 0 { 0.07 } else { 0.006 });
            if is_layer {
                // Some lag before, and some after.
                let lags = [0, 1].map(|which| if place % 9 == which { [0.0, 1e-3, 0.0] } else { [0.0; 3] });
                (start, way) = (add(at, lags[0]), sub(add(LAYERS.2, lags[1]), lags[0]));
            }
            let [u, v, t] = chance.three(1.7);
            let mass = if place % 7 == 3 { -mass } else { mass };
            let end = add(start, way);
            old.position.push([start[0], start[1], start[2], w]);
            new.position.push([end[0], end[1], end[2], w]);
            old.velocity.push([NOWHERE, NOWHERE, NOWHERE, mass]);
            new.velocity.push([u, v, t, mass]);
        }
        [old, new]
    };
    Fixture::drawn(assembly(solver, between)?, &mut Chance::new(seed), states, |_| FrameInput::default())
}
