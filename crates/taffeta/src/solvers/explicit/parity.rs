//! Rows of the particle stages: each on its own, and all at once.

use crate::backend::Backend;
use crate::contact::colliders::gpu::Contact;
use crate::contact::colliders::gpu_layout::Collider;
use crate::diagnostics::normals::normals;
use crate::elements::load::gpu::GIVEN;
use crate::elements::load::gpu_layout::{FORCE, Load};
use crate::elements::load::load as external;
use crate::elements::spring::gpu_layout::ResidentMesh;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP};
use crate::motion::held_cpu::HeldForces;
use crate::parity::bench::{Bench, Given};
use crate::parity::fixture::{Arrays, Fixture, SUBSTEP, words};
use crate::parity::row::{Row, Tolerance};
use crate::solvers::explicit::euler;
use crate::solvers::explicit::gpu_layout::PATCH_NODE_BYTES;
use crate::solvers::explicit::patches::Patches;
use crate::step::Op;
use crate::topology::Csr;
use taffeta_gpu::Kernel;

const SAME: &str = "sums, products, quotients and roots in the same order; hardware may fuse them";
const COLLIDED: &str = "as above; ways out of wedges and into solids multiply what hardware rounds otherwise";
const TURNED: &str = "as above; directions away from triangles are what is left of differences of places";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("integrate_all", "integrate_all", Tolerance::new(0.0, 8.0, SAME), integrate),
    row("contact_all", "contact_all", Tolerance::new(0.0, 512.0, COLLIDED), contact),
    row("contact_all_meshes", "contact_all", Tolerance::new(0.0, 262_144.0, TURNED), contact_on_meshes),
    row("pins_all", "pins_all", Tolerance::new(0.0, 8.0, SAME), pins),
    row("keep_held_forces", "keep_held_forces", Tolerance::new(0.0, 0.0, "copies"), held),
    row("loads_all", "loads_all", Tolerance::new(0.0, 16.0, SAME), loads),
    row("grid_springs_all", "grid_springs_all", Tolerance::new(0.0, 32.0, SAME), grid_springs),
    row("mesh_springs_all", "mesh_springs_all", Tolerance::new(0.0, 32.0, SAME), mesh_springs),
    row("grid_particles", "grid_particles", Tolerance::new(0.0, 512.0, COLLIDED), grid_alone),
    row("grid_particles_given", "grid_particles", Tolerance::new(0.0, 512.0, COLLIDED), grid_given),
    row("grid_particles_later", "grid_particles", Tolerance::new(0.0, 32.0, SAME), grid_later),
    row("mesh_particles", "mesh_particles", Tolerance::new(0.0, 512.0, COLLIDED), mesh_alone),
    row("mesh_particles_given", "mesh_particles", Tolerance::new(0.0, 512.0, COLLIDED), mesh_given),
    row("mesh_particles_later", "mesh_particles", Tolerance::new(0.0, 32.0, SAME), mesh_later),
    row("grid_patches", "grid_patches", Tolerance::new(0.0, 512.0, COLLIDED), grid_patches),
    row("mesh_patches", "mesh_patches", Tolerance::new(0.0, 512.0, COLLIDED), mesh_patches),
    row("vertex_normals", "vertex_normals", Tolerance::new(0.0, 64.0, SAME), vertex_normals),
];

const fn row(
    name: &'static str,
    entry: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry, tolerance, check }
}

/// Two states: with drag, and without.
pub fn fixtures(bench: &Bench<'_>) -> Result<[Fixture; 2], String> {
    Ok([Fixture::new(1, 0.0087, bench.exact)?, Fixture::new(2, 0.0, bench.exact)?])
}

/// The kernel, for slices with as many kinds of springs as the fixtures have.
pub fn kernel_of(bench: &Bench<'_>, name: Name, fixture: &Fixture) -> Result<Kernel, String> {
    bench.kernel(name, &fixture.overrides())
}

fn integrate(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("integrate_all"), &fixtures[0])?;
    for mut fixture in fixtures {
        let (_, mut after) = fixture.on_cpu(&[Op::Integrate]);
        let force = fixture.force.clone();
        for place in (0..force.len()).filter(|&place| !fixture.is_node[place]) {
            (after.position[place], after.velocity[place]) = drift(&fixture, place, force[place]);
        }
        let mut arrays = fixture.arrays();
        arrays.insert("force", words(&fixture.force_fours()));
        let (records, groups) = (fixture.records(), fixture.place_groups());
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            written.fours("force", &fixture.force_fours());
            written.fours("new_position", &after.position);
            written.fours("new_velocity", &after.velocity);
        })?;
    }
    Ok(())
}

/// A place after the stage `integrate`.
fn drift(fixture: &Fixture, place: usize, force: [f32; 3]) -> (Four, Four) {
    let (x, v, h) = (fixture.old.position[place], fixture.old.velocity[place], fixture.substep().h);
    let gravity = fixture.cpu.assembly().world.gravity.map(|c| c as f32);
    let [u, w, t] = [0, 1, 2].map(|i| euler::velocity(v[i], force[i], x[3], gravity[i], h));
    let [a, b, c] = [(0, u), (1, w), (2, t)].map(|(i, v)| euler::position(x[i], v, h));
    ([a, b, c, x[3]], [u, w, t, v[3].abs()])
}

fn contact(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    contact_with(bench, Name::new("contact_all"), fixtures, &[usize::MAX, 2, 1, 0])?;
    contact_with(bench, Name::new("contact_all"), [Fixture::with_layers(34, bench.exact)?], &[usize::MAX])
}

fn contact_on_meshes(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("contact_all").with(Contact::Meshes.choices());
    if !bench.exact {
        return (0..4).try_for_each(|mesh| {
            contact_with(bench, name, [Fixture::with_mesh_apart(mesh)?], &[usize::MAX])
        });
    }
    let mut meshes_alone = Fixture::with_meshes(32, bench.exact)?;
    for substep in &mut meshes_alone.substeps {
        substep.edit_colliders(|all| all.retain(|collider| collider.shape.mesh().is_some()));
    }
    let fixtures = [Fixture::with_meshes(31, bench.exact)?, meshes_alone];
    contact_with(bench, name, fixtures, &[usize::MAX, 2])?;
    contact_of_others(bench, name, Fixture::with_meshes(33, bench.exact)?)
}

/// Colliders leave alone what is led out of them.
fn contact_of_others(bench: &mut Bench<'_>, name: Name, mut fixture: Fixture) -> Result<(), String> {
    let kernel = kernel_of(bench, name, &fixture)?;
    let (_, mut after) = fixture.on_cpu(&[Op::Contact]);
    let (mut arrays, mut records) = (fixture.arrays(), fixture.records());
    arrays.insert("new_position", words(&fixture.new.position));
    arrays.insert("new_velocity", words(&fixture.new.velocity));
    let places = fixture.new.position.len();
    let mut bits = vec![0_u32; places.div_ceil(32).next_multiple_of(4)];
    for place in (0..places).filter(|place| place % 3 == 1) {
        bits[place / 32] |= 1 << (place % 32);
        (after.position[place], after.velocity[place]) =
            (fixture.new.position[place], fixture.new.velocity[place]);
    }
    let data = arrays.entry("mesh_data").or_default();
    records.iter_mut().for_each(|record| record.led_out = data.len() as u32 / 4);
    data.extend(bits);
    let groups = fixture.place_groups();
    bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
        written.fours("new_position", &after.position);
        written.fours("new_velocity", &after.velocity);
    })
}

/// With all colliders, and with so many of them.
fn contact_with<const N: usize>(
    bench: &mut Bench<'_>,
    name: Name,
    fixtures: [Fixture; N],
    numbers: &[usize],
) -> Result<(), String> {
    let kernel = kernel_of(bench, name, &fixtures[0])?;
    for mut fixture in fixtures {
        for &colliders in numbers {
            fixture
                .substeps
                .iter_mut()
                .for_each(|substep| substep.edit_colliders(|all| all.truncate(colliders)));
            let (_, after) = fixture.on_cpu(&[Op::Contact]);
            let mut arrays = fixture.arrays();
            arrays.insert("new_position", words(&fixture.new.position));
            arrays.insert("new_velocity", words(&fixture.new.velocity));
            if colliders == 0 {
                // An array cannot be empty.
                arrays.insert("colliders", vec![f32::NAN.to_bits(); size_of::<Collider>() / 4]);
            }
            let (records, groups) = (fixture.records(), fixture.place_groups());
            bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
                written.fours("new_position", &after.position);
                written.fours("new_velocity", &after.velocity);
            })?;
        }
    }
    Ok(())
}

fn pins(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("pins_all"), &fixtures[0])?;
    for (number, mut fixture) in fixtures.into_iter().enumerate() {
        fixture.substeps.iter_mut().for_each(|substep| substep.pins_may_lag = number != 1);
        fixture.new.velocity.iter_mut().step_by(3).for_each(|velocity| velocity[3] *= -1.0);
        put_on_their_way(&mut fixture);
        let (_, after) = fixture.on_cpu(&[Op::Pins]);
        let (mut position, mut velocity) = (fixture.new.position.clone(), fixture.new.velocity.clone());
        let moving = fixture.cpu.assembly().moving_pins().iter().map(|pin| pin.node);
        for node in moving.chain(fixture.input.moves.iter().map(|(node, ..)| *node)) {
            let node = node as usize;
            (position[node], velocity[node]) = (after.position[node], after.velocity[node]);
        }
        let mut arrays = fixture.arrays();
        arrays.insert("new_position", words(&fixture.new.position));
        arrays.insert("new_velocity", words(&fixture.new.velocity));
        let (records, groups) = (fixture.records(), fixture.place_groups());
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            written.fours("new_position", &position);
            written.fours("new_velocity", &velocity);
        })?;
    }
    Ok(())
}

/// Puts nodes that the program moves where they are on their way but for rounding, all but the first: those that follow keyframes lag.
fn put_on_their_way(fixture: &mut Fixture) {
    let substep = &fixture.substeps[SUBSTEP];
    let (fraction, rate) = substep.frame_fraction;
    let before = f64::from(fraction - substep.h * rate);
    for &(node, start, goal) in fixture.input.moves.iter().skip(1) {
        for axis in 0..3 {
            let place = start[axis] + (goal[axis] - start[axis]) * before;
            fixture.old.position[node as usize][axis] = place as f32;
        }
        let [[x, y, z, _], [u, v, w, _]] =
            [&fixture.old.position, &fixture.old.velocity].map(|old| old[node as usize].map(f64::from));
        fixture.cpu.set(node as usize, [x, y, z], [u, v, w]);
    }
}

fn held(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("keep_held_forces"), &fixtures[0])?;
    for mut fixture in fixtures {
        fixture.on_cpu(&[Op::HeldForces]);
        let cpu = fixture.cpu.feature::<HeldForces>().expect("bodies have pins");
        let wanted: Vec<Four> = cpu.all().map(|(_, force)| written(force)).collect();
        let mut arrays = fixture.arrays();
        arrays.insert("force", words(&fixture.force_fours()));
        arrays.insert("held_nodes", fixture.tables.held.nodes.clone());
        arrays.insert("held_forces", vec![f32::NAN.to_bits(); 4 * wanted.len()]);
        let (records, groups) = (fixture.records(), wanted.len().div_ceil(GROUP));
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            written.fours("force", &fixture.force_fours());
            written.fours("held_forces", &wanted);
        })?;
    }
    Ok(())
}

/// The force of wind and drag alone, on every place.
fn wind_and_drag(fixture: &Fixture) -> Vec<[f32; 3]> {
    let world = &fixture.cpu.assembly().world;
    let (wind, drag) = (world.wind_force.map(|c| c as f32), world.drag as f32);
    let force = |v: &Four| std::array::from_fn(|i| external::wind_and_drag(wind[i], drag, v[i]));
    fixture.old.velocity.iter().map(force).collect()
}

/// A force of three numbers as kernels write it.
fn written([x, y, z]: [f32; 3]) -> Four {
    [x, y, z, 0.0]
}

fn loads(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new("loads_all"), &fixtures[0])?;
    for mut fixture in fixtures {
        let (between, _) = fixture.on_cpu(&[Op::Loads, Op::Gather]);
        let mut wanted = wind_and_drag(&fixture);
        for place in (0..wanted.len()).filter(|&place| fixture.is_node[place]) {
            wanted[place] = between.force[place];
        }
        let wanted: Vec<Four> = wanted.into_iter().map(written).collect();
        let (torques, element_forces) = (fixture.torques(), fixture.element_forces());
        let scaled = scaled_loads(&fixture, &torques);
        let mut arrays = fixture.arrays();
        arrays.insert("loads", words(&scaled));
        arrays.insert("element_forces", words(&element_forces));
        let (records, groups) = (fixture.records(), fixture.place_groups());
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            written.fours("force", &wanted);
            written.fours("element_forces", &element_forces);
            let left: Vec<u32> = written.take("loads");
            let numbers = |words: &[u32]| words.iter().map(|&word| f32::from_bits(word)).collect::<Vec<_>>();
            written.outcome().copied("loads", &numbers(&words(&scaled)), &numbers(&left));
        })?;
    }
    Ok(())
}

/// Loads with the factors that the CPU has found.
pub fn scaled_loads(fixture: &Fixture, torques: &[f32]) -> Vec<Load> {
    let factors = torques.iter().zip(fixture.substep().scales());
    let with = |(load, (&torque, &scale)): (&Load, (&f32, &f32))| Load {
        factor: if load.kind == FORCE { scale } else { torque },
        ..*load
    };
    fixture.tables.loads.loads.iter().zip(factors).map(with).collect()
}

/// Whether each place belongs to a grid's node, and whether to a mesh.
fn sorts(fixture: &Fixture) -> [Vec<bool>; 2] {
    let mut sorts = [vec![false; fixture.is_node.len()], vec![false; fixture.is_node.len()]];
    for body in &fixture.cpu.assembly().bodies {
        let count = if body.grid_layout.is_some() { body.nodes } else { body.places() };
        sorts[usize::from(body.grid_layout.is_none())][body.first..body.first + count].fill(true);
    }
    sorts
}

fn grid_springs(bench: &mut Bench<'_>) -> Result<(), String> {
    springs(bench, "grid_springs_all", 0, |fixture| fixture.tables.springs.tiles.len())
}

fn mesh_springs(bench: &mut Bench<'_>) -> Result<(), String> {
    springs(bench, "mesh_springs_all", 1, |fixture| fixture.place_groups())
}

fn springs(
    bench: &mut Bench<'_>,
    entry: &'static str,
    sort: usize,
    groups: fn(&Fixture) -> usize,
) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, Name::new(entry), &fixtures[0])?;
    for mut fixture in fixtures {
        let (between, _) = fixture.on_cpu(&[Op::Springs]);
        let mut wanted = fixture.force_fours();
        for (place, _) in sorts(&fixture)[sort].iter().enumerate().filter(|(_, is)| **is) {
            wanted[place] = written(between.force[place]);
        }
        let mut arrays = fixture.arrays();
        arrays.insert("force", words(&fixture.force_fours()));
        let records = fixture.records();
        let given = Given { arrays: &arrays, records: &records, groups: groups(&fixture) };
        bench.run(&kernel, &given, |written| written.fours("force", &wanted))?;
    }
    Ok(())
}

fn grid_alone(bench: &mut Bench<'_>) -> Result<(), String> {
    at_once(bench, Name::new("grid_particles"), 0, |fixture| fixture.tables.springs.tiles.len())
}

fn grid_given(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("grid_particles").with(GIVEN);
    at_once(bench, name, 0, |fixture| fixture.tables.springs.tiles.len())
}

fn grid_later(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("grid_particles").with(Contact::Later.choices());
    at_once(bench, name, 0, |fixture| fixture.tables.springs.tiles.len())
}

fn mesh_alone(bench: &mut Bench<'_>) -> Result<(), String> {
    at_once(bench, Name::new("mesh_particles"), 1, |fixture| fixture.place_groups())
}

fn mesh_given(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("mesh_particles").with(GIVEN);
    at_once(bench, name, 1, |fixture| fixture.place_groups())
}

fn mesh_later(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("mesh_particles").with(Contact::Later.choices());
    at_once(bench, name, 1, |fixture| fixture.place_groups())
}

/// All particle stages but pins, and but contact where it comes later, in one kernel.
fn at_once(
    bench: &mut Bench<'_>,
    name: Name,
    sort: usize,
    groups: fn(&Fixture) -> usize,
) -> Result<(), String> {
    let fixtures = fixtures(bench)?;
    let kernel = kernel_of(bench, name, &fixtures[0])?;
    let cases = fixtures.into_iter().map(|fixture| {
        let (sort, groups) = (sorts(&fixture)[sort].clone(), groups(&fixture));
        (fixture, sort, groups)
    });
    stepped(bench, name, &kernel, cases, |_| Vec::new())
}

/// Squares with a rim for two sub-steps, of which one is taken.
fn grid_patches(bench: &mut Bench<'_>) -> Result<(), String> {
    let (name, fixtures) = (Name::new("grid_patches"), fixtures(bench)?);
    let kernel = patch_kernel(bench, name, &fixtures[0], 24 * 24)?;
    let squares = |fixture: &Fixture| Patches::squares(&fixture.tables.springs.grids, 4);
    let cases = fixtures.into_iter().map(|fixture| {
        let (sort, groups) = (sorts(&fixture)[0].clone(), squares(&fixture).len());
        (fixture, sort, groups)
    });
    stepped(bench, name, &kernel, cases, |fixture| vec![("patches", words(&squares(fixture)))])
}

/// The meshes that have room on every device, whole.
fn mesh_patches(bench: &mut Bench<'_>) -> Result<(), String> {
    const ROOM: u32 = 16_384 / PATCH_NODE_BYTES;
    let (name, fixtures) = (Name::new("mesh_patches"), fixtures(bench)?);
    let kernel = patch_kernel(bench, name, &fixtures[0], ROOM)?;
    let resident_meshes = |fixture: &Fixture| -> Vec<ResidentMesh> {
        fixture.tables.springs.meshes.iter().copied().filter(|mesh| mesh.count <= ROOM).collect()
    };
    let cases = fixtures.into_iter().map(|fixture| {
        let mut sort = vec![false; fixture.is_node.len()];
        for small in resident_meshes(&fixture) {
            sort[small.first as usize..(small.first + small.count) as usize].fill(true);
        }
        let groups = resident_meshes(&fixture).len();
        (fixture, sort, groups)
    });
    stepped(bench, name, &kernel, cases, |fixture| {
        vec![("resident_meshes", words(&resident_meshes(fixture)))]
    })
}

/// A kernel that takes one sub-step on patches with room for some nodes.
fn patch_kernel(bench: &Bench<'_>, name: Name, fixture: &Fixture, room: u32) -> Result<Kernel, String> {
    let room = ("ROOM", f64::from(room * PATCH_NODE_BYTES / 4));
    let [kinds, lists, layers] = fixture.overrides();
    bench.kernel(name, &[kinds, lists, layers, room, ("STEPS", 1.0)])
}

/// A sub-step of all particle stages but pins, on the places that each case says.
fn stepped(
    bench: &mut Bench<'_>,
    name: Name,
    kernel: &Kernel,
    cases: impl Iterator<Item = (Fixture, Vec<bool>, usize)>,
    more: impl Fn(&Fixture) -> Vec<(&'static str, Vec<u32>)>,
) -> Result<(), String> {
    for (mut fixture, sort, groups) in cases {
        let load = if name.has(GIVEN[0]) { fixture.force.clone() } else { wind_and_drag(&fixture) };
        fixture.force = load;
        let is_later = Contact::Later.choices().iter().any(|&choice| name.has(choice));
        let operations = [Op::Springs, Op::Integrate, Op::Contact];
        let (between, after) = fixture.on_cpu(&operations[..if is_later { 2 } else { 3 }]);
        let mut arrays = fixture.arrays();
        arrays.extend(more(&fixture));
        let [position, velocity] = particles(&fixture, &arrays, &between.force, &sort, &after);
        let records = fixture.records();
        let given = Given { arrays: &arrays, records: &records, groups };
        bench.run(kernel, &given, |written| {
            written.fours("new_position", &position);
            written.fours("new_velocity", &velocity);
        })?;
    }
    Ok(())
}

/// What the places of a sort come to; the others stay as they are.
fn particles(
    fixture: &Fixture,
    arrays: &Arrays,
    force: &[[f32; 3]],
    sort: &[bool],
    after: &crate::parity::fixture::State,
) -> [Vec<Four>; 2] {
    let poison = [f32::from_bits(arrays["new_position"][0]); 4];
    let mut state = [vec![poison; sort.len()], vec![poison; sort.len()]];
    for place in (0..sort.len()).filter(|&place| sort[place]) {
        let (x, v) = if fixture.is_node[place] {
            (after.position[place], after.velocity[place])
        } else {
            drift(fixture, place, force[place])
        };
        (state[0][place], state[1][place]) = (x, v);
    }
    state
}

/// Of the ball, which lies among other bodies.
fn vertex_normals(bench: &mut Bench<'_>) -> Result<(), String> {
    let kernel = bench.kernel(Name::new("vertex_normals"), &[])?;
    for fixture in fixtures(bench)? {
        let body = &fixture.cpu.assembly().bodies[1];
        let triangles = body.user_surface().triangles;
        let by_node = Csr::corners(body.nodes, &triangles);
        let place = |node: usize| fixture.old.position[body.solver_index(node)];
        let places: Vec<[f32; 3]> =
            (0..body.nodes).map(|node| place(node)[..3].try_into().unwrap_or_default()).collect();
        let wanted: Vec<Four> = normals(&places, &triangles).into_iter().map(written).collect();
        let corners: Vec<u32> =
            triangles.as_flattened().iter().map(|&node| body.solver_index(node as usize) as u32).collect();
        let mut arrays = fixture.arrays();
        arrays.insert("triangle_places", corners);
        arrays.insert("corner_starts", by_node.offsets);
        arrays.insert("node_corners", by_node.items);
        arrays.insert("normals", vec![f32::NAN.to_bits(); 4 * body.nodes]);
        let given =
            Given { arrays: &arrays, records: &fixture.records(), groups: body.nodes.div_ceil(GROUP) };
        bench.run(&kernel, &given, |written| written.fours("normals", &wanted))?;
    }
    Ok(())
}
