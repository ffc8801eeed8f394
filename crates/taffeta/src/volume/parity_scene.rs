//! The scene that rows of volumes are run on.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings};
use crate::backend::{Backend, FrameInput};
use crate::contact::collider_mesh::parity_scene as meshes_by_chance;
use crate::cpu::CpuBackend;
use crate::features::Tables;
use crate::parity::fixture::{Chance, Fixture, State};
use crate::scene::{
    Body, Bounds, Collider, Icosphere, Internal, Keyframe, Mass, Mesh, Scene, Select, Volume, VolumeForm,
    VolumeWeights,
};

fn soft(name: &str, subdivisions: u32, at: [f64; 3], volume: Volume) -> Body {
    let ball = Body::soft(name, Mesh::Icosphere(Icosphere { radius: 0.31, subdivisions }))
        .with_mass(Mass::Volume(23.0))
        .structural(61.3, 0.023)
        .at(at);
    Body { volume: Some(volume), ..ball }
}

fn form(form: VolumeForm) -> Volume {
    Volume { form, ..Volume::default() }
}

/// The body with weights of which no node has touched.
const UNTOUCHED: &str = "weighted";

fn weighted(name: &str, subdivisions: u32, at: [f64; 3]) -> Body {
    let ball = VolumeWeights { center: [at[0], at[1] + 0.11, at[2] + 0.25], radius: 0.35 };
    soft(name, subdivisions, at, Volume { weights: Some(ball), ..form(VolumeForm::Projected) })
}

/// Of one group and of several, the last of which is not full; in every form, with weights and without, beside bodies
/// without a volume; one cannot move at all.
fn bodies() -> Vec<Body> {
    let mut braced = soft("braced", 2, [0.9, 0.3, 0.1], form(VolumeForm::Projected));
    braced.springs.internal = Some(Internal { count: 111, k: 7.9, d: 0.0091, ..Internal::default() });
    let cloth = |name, mesh| Body::cloth(name, mesh).with_mass(Mass::Node(0.01)).structural(29.0, 0.011);
    let blob = Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 1 });
    let pressed = Volume { pressure: Some(37.0), ..Volume::default() };
    let projected = |name: &str, x: f64| soft(name, 1, [x, 0.3, -1.1], form(VolumeForm::Projected));
    // Where weights are large.
    let front = Bounds { min: [-1.0, -1.0, 1.39], max: [9.0, 9.0, 9.0] };
    let large = soft("corrected", 3, [0.1, 0.29, -0.05], form(VolumeForm::Corrected));
    let mut bodies = Vec::from([
        cloth("sheet", Mesh::grid(7, 11, [0.5, 0.3])).at([0.0, 1.4, 0.0]),
        large.pin(Select::nodes([3, 500])),
        braced.pin(Select::nodes([0, 17])),
        cloth("blob", blob).at([0.0, 1.9, 0.0]),
        #[cfg(feature = "paper-forms")]
        soft("printed", 1, [1.7, 0.3, 0.1], form(VolumeForm::Printed)),
        #[cfg(feature = "paper-forms")]
        soft("shader", 2, [2.5, 0.3, 0.1], form(VolumeForm::PaperShader)),
        weighted(UNTOUCHED, 3, [3.3, 0.29, 0.1]),
        soft("pressed", 2, [3.9, 0.3, 1.1], pressed),
        weighted("touched", 2, [4.9, 0.3, 1.1]),
        weighted("held", 1, [5.7, 0.3, 1.1]).pin(Select { inside: Some(front), ..Select::default() }),
        projected("still", 0.0).pin(Select::nodes((0..42).collect::<Vec<_>>())),
    ]);
    // As many as there are volumes to aim at.
    let names = ["one", "two", "three", "four", "five"];
    bodies.extend(names.iter().zip(1..).map(|(name, i)| projected(name, 0.8 * f64::from(i))));
    bodies
}

/// Takes some springs away along edges; the ring stays.
fn thin_out(body: &mut BodyAssembly) {
    let BodySprings::Mesh(lists) = &mut body.springs else { return };
    let Some(list) = lists.first_mut() else { return };
    let keep = |i: &usize| i % 5 != 2;
    list.pairs = (0..list.pairs.len()).filter(keep).map(|i| list.pairs[i]).collect();
    list.rest = (0..list.rest.len()).filter(keep).map(|i| list.rest[i]).collect();
}

/// The bodies above a sloping floor and about a ball that rises; with `meshes`, about some of these too.
fn assembly(drag: f64, meshes: bool) -> Result<Assembly, String> {
    let rising = Keyframe::translate(0.5, [0.1, 0.2, -0.1]);
    let mut scene = Scene::new("volumes")
        .collider(Collider::plane([0.0, 0.02, 0.0], [0.03, 1.0, 0.02]).friction(0.4).restitution(0.2))
        .collider(Collider::sphere([0.9, 0.65, 0.1], 0.11).friction(0.3).keyframe(rising))
        .time(0.0173, 0.0041)
        .friction_between("corrected", "collider0", 0.05)
        .friction_between("touched", "collider0", 0.9);
    if meshes {
        scene.colliders.extend(meshes_by_chance::colliders());
    }
    scene.bodies = bodies();
    scene.world.gravity = [0.37, -9.63, 0.21];
    scene.world.wind_force = [0.013, 0.0071, -0.0193];
    scene.world.drag = drag;
    let mut assembly = Assembly::new(&scene).map_err(|error| error.to_string())?;
    assembly.bodies.iter_mut().filter(|body| body.volume().is_some()).skip(3).for_each(thin_out);
    Ok(assembly)
}

/// Bodies that keep their volumes, stretched and bent; many near what they may touch, and some that have touched.
pub fn fixture(seed: u64, drag: f64, meshes: bool) -> Result<Fixture, String> {
    let states = |chance: &mut Chance, tables: &Tables, cpu: &CpuBackend<f32>| {
        let untouched = cpu.assembly().bodies.iter().find(|body| body.name == UNTOUCHED);
        let untouched = untouched.map_or(0..0, |body| body.solver_range());
        [1.7, 2.3].map(|speed| {
            let mut state = State::default();
            for (place, (&[x, y, z, w], &[.., mass])) in
                tables.position.iter().zip(&tables.velocity).enumerate()
            {
                let noise = chance.three([0.002, 0.01, 0.03][place % 3]);
                let [u, v, t] = chance.three(speed);
                let touches = place % 7 == 3 && w > 0.0 && !untouched.contains(&place);
                let mass = if touches { -mass } else { mass };
                state.position.push([x + noise[0], y + noise[1], z + noise[2], w]);
                state.velocity.push([u, v, t, mass]);
            }
            state
        })
    };
    Fixture::drawn(assembly(drag, meshes)?, &mut Chance::new(seed), states, |_| FrameInput::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::spring::gpu_layout::{IS_RING, NOT_A_MESH};
    use crate::gpu::layout::GROUP;
    use crate::parity::coverage::Count;
    use crate::topology::LANES;
    use crate::volume::gpu_layout::{RESTORED, WEIGHTED};
    use crate::volume::volume::Form;

    #[test]
    fn bodies_that_keep_their_volume_are_of_all_sorts() {
        let mut count = Count::default();
        let fixture = fixture(11, 0.0087, false).expect("a fixture");
        let tables = &fixture.tables;
        for (index, group) in tables.volumes.groups.iter().enumerate() {
            let is_last = index + 1 == (group.first_group + group.groups) as usize;
            count.note("a full group", group.count as usize == GROUP);
            count.note(
                "the last of several, not full",
                is_last && group.groups > 1 && (group.count as usize) < GROUP,
            );
            count.note("the only group", group.groups == 1);
            let flag = |flag: u32| group.flags & flag != 0;
            for (what, is) in [
                ("kept", group.form == Form::Kept as u32),
                ("as the programs do", group.form == Form::PaperShader as u32),
                ("as printed", group.form == Form::Printed as u32),
                ("a pressure", group.form == Form::Pressure as u32),
                ("weighted", flag(WEIGHTED)),
                ("weighted and restored", flag(WEIGHTED) && flag(RESTORED)),
                ("not a node of which is held or has touched", {
                    let body = fixture.tables.volumes.groups[group.first_group as usize].first as usize;
                    flag(WEIGHTED)
                        && (body..group.first as usize + group.count as usize).all(|place| {
                            fixture.new.position[place][3] > 0.0 && fixture.new.velocity[place][3] > 0.0
                        })
                }),
                ("restored alone", !flag(WEIGHTED) && flag(RESTORED)),
                ("neither", group.flags == 0),
            ] {
                count.note(what, is);
            }
            for lane in 0..group.count as usize {
                let (place, at) =
                    (group.first as usize + lane, group.gradients as usize + lane - tables.len());
                let (x, v, weight) =
                    (fixture.new.position[place], fixture.new.velocity[place], tables.volumes.weights[at]);
                count.note("held", x[3] == 0.0);
                count.note("held, with a weight", x[3] == 0.0 && flag(WEIGHTED) && weight > 0.0);
                count.note("one that has touched", v[3] < 0.0 && flag(RESTORED));
                count.note(
                    "one that has touched, with a weight",
                    v[3] < 0.0 && flag(RESTORED) && flag(WEIGHTED) && weight > 0.0,
                );
                count.note("beyond the weights", flag(WEIGHTED) && weight == 0.0);
                let floor = fixture.substep().colliders()[0].depth_and_normal([x[0], x[1], x[2]]).unwrap().0;
                count.note("in the floor", floor > 0.0 && x[3] > 0.0);
                count.note("above the floor", floor < 0.0);
            }
        }
        for run in tables
            .springs
            .runs
            .chunks(tables.springs.kinds)
            .filter(|run| run[0].count & IS_RING != 0 && run[0].count != NOT_A_MESH)
        {
            let entries =
                run[0].start as usize..(run[0].start + LANES as u32 * (run[0].count & !IS_RING)) as usize;
            for entry in &tables.springs.entries[entries] {
                count.note("padding", entry.rest_length == 0.0);
                count.note("a neighbour without a spring", entry.rest_length < 0.0);
                count.note("a spring", entry.rest_length > 0.0);
            }
            count.note("springs of another kind", run[1..].iter().any(|run| run.count > 0));
        }
        count.note("a mesh without a volume", !tables.springs.meshes.is_empty());
        count.note("a grid", !tables.springs.grids.is_empty());
        count.check();
    }
}
