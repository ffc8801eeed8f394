//! Rows of the bodies that keep their volume.

use crate::backend::Backend;
use crate::contact::colliders::cpu::Colliders;
use crate::contact::colliders::gpu::Contact;
use crate::cpu::CpuBackend;
use crate::gpu::kernels::Name;
use crate::gpu::layout::Four;
use crate::motion::held_cpu::HeldForces;
use crate::parity::bench::{Bench, Given, Written};
use crate::parity::fixture::{Arrays, Fixture, SUBSTEP, words};
use crate::parity::row::{Row, Tolerance};
use crate::solvers::explicit::parity::kernel_of;
use crate::step::{self, Op, Parts};
use crate::volume::constraint::Goals;
use crate::volume::cpu::Volumes;
use crate::volume::gpu_layout::{RESTORED, VOLUME_PARTS, WEIGHTED};
use crate::volume::parity_scene;
use crate::volume::volume::WEIGHTED_SUMS;
use taffeta_gpu::Kernel;

const SUMMED: &str =
    "the same operations, and sums by halves in the same order; hardware may fuse products and sums";
const MOVED: &str = "as above; contact multiplies what hardware rounds otherwise";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("volume_forces", Tolerance::new(0.0, 64.0, SUMMED), forces),
    row("volume_forces_given", Tolerance::new(0.0, 64.0, SUMMED), forces_given),
    row("volume_gradients", Tolerance::new(0.0, 64.0, SUMMED), gradients),
    row("volume_particles", Tolerance::new(0.0, 128.0, MOVED), particles),
    row("measure_kept_volumes", Tolerance::new(0.0, 64.0, SUMMED), measure),
    row("restore_volumes", Tolerance::new(0.0, 128.0, MOVED), restore),
    Row {
        name: "restore_volumes_meshes",
        ..row("restore_volumes", Tolerance::new(0.0, 512.0, MOVED), restore_on_meshes)
    },
];

const fn row(
    name: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry: name, tolerance, check }
}

fn fixtures() -> Result<[Fixture; 2], String> {
    Ok([parity_scene::fixture(11, 0.0087, false)?, parity_scene::fixture(12, 0.0, false)?])
}

/// What the passes of volumes leave to each other, by place.
struct Found {
    /// Force [N] without that of the constraint.
    force: Vec<[f32; 3]>,
    /// Gradient of the volume [m²].
    gradient: Vec<[f32; 3]>,
    /// Whether a place has touched a collider.
    in_contact: Vec<bool>,
    /// Sums of each group.
    sums: Vec<[f32; WEIGHTED_SUMS]>,
}

/// What they have left: of the state before, or once it is there, of that `after`.
fn found(cpu: &mut CpuBackend<f32>, after: bool) -> Found {
    let places = cpu.assembly().places;
    let in_contact =
        cpu.feature::<Colliders<f32>>().map_or(Vec::new(), |colliders| colliders.all_in_contact().to_vec());
    let waiting: Vec<[f32; 6]> = (0..places).map(|place| cpu.after(place)).collect();
    let (mut force, mut gradient) = (vec![[0.0; 3]; places], vec![[0.0; 3]; places]);
    let volumes = cpu.feature::<Volumes<f32>>().expect("bodies keep their volume");
    for (among, place) in volumes.places() {
        if after {
            gradient[place] = volumes.gradient_of(among);
        } else {
            let [x, y, z, forces @ ..] = waiting[place];
            (gradient[place], force[place]) = ([x, y, z], forces);
        }
    }
    Found { force, gradient, in_contact, sums: volumes.all_sums().to_vec() }
}

/// Forces, gradients and sums of the sub-step, from forces that stand in the fixture.
fn sum_up(fixture: &mut Fixture, operations: &[Op]) -> Found {
    fixture.on_cpu(&[operations, &[Op::VolumeSums]].concat());
    found(&mut fixture.cpu, false)
}

/// What bodies that keep their volume, and restore it, have.
fn volumes() -> Parts {
    Parts { volumes: true, restored: true, held: true, ..Parts::default() }
}

/// Lends the state after the sub-step to the CPU, with those who have touched in it.
fn put_new(fixture: &mut Fixture) {
    let Fixture { cpu, new, .. } = fixture;
    for (place, (x, v)) in new.position.iter().zip(&new.velocity).enumerate() {
        cpu.set_after(place, [x[0], x[1], x[2], v[0], v[1], v[2]]);
    }
    let colliders = cpu.feature::<Colliders<f32>>().expect("every scene has some");
    let in_contact = colliders.all_in_contact().iter_mut().zip(&new.velocity);
    in_contact.for_each(|(in_contact, velocity)| *in_contact = velocity[3] < 0.0);
}

/// The state that the CPU has come to where bodies have those flags; elsewhere that of the `start`.
fn after(fixture: &mut Fixture, [mut position, mut velocity]: [Vec<Four>; 2], flags: u32) -> [Vec<Four>; 2] {
    let in_contact = found(&mut fixture.cpu, true).in_contact;
    for group in fixture.tables.volumes.groups.iter().filter(|group| group.flags & flags == flags) {
        for place in (group.first..group.first + group.count).map(|place| place as usize) {
            let [x, y, z, u, v, w] = fixture.cpu.after(place);
            let mass = fixture.old.velocity[place][3].abs();
            position[place] = [x, y, z, fixture.old.position[place][3]];
            velocity[place] = [u, v, w, if in_contact[place] { -mass } else { mass }];
        }
    }
    [position, velocity]
}

/// Forces by place, gradients of NaN, and weights.
fn forces_and_weights(fixture: &Fixture, force: &[Four]) -> Vec<Four> {
    let weights = fixture.tables.volumes.weights.iter().map(|&weight| [f32::NAN, f32::NAN, f32::NAN, weight]);
    force.iter().copied().chain(weights).collect()
}

/// The same with what the CPU has found for bodies with those flags.
fn forces_found(fixture: &Fixture, start: &[Four], found: &Found, flags: u32) -> Vec<Four> {
    let mut all = start.to_vec();
    for group in fixture.tables.volumes.groups.iter().filter(|group| group.flags & flags == flags) {
        for lane in 0..group.count as usize {
            let (place, at) = (group.first as usize + lane, group.gradients as usize + lane);
            let [x, y, z] = found.force[place];
            all[place] = [x, y, z, 0.0];
            if let Some(four) = all.get_mut(at) {
                four[..3].copy_from_slice(&found.gradient[place]);
            }
        }
    }
    all
}

/// Sums of bodies with those flags as kernels keep them, part after part; what is not written is NaN.
fn parts(fixture: &Fixture, origins: &[Four], found: &Found, flags: u32) -> Vec<Four> {
    let groups = &fixture.tables.volumes.groups;
    let mut all = vec![[f32::NAN; 4]; VOLUME_PARTS * groups.len()];
    for (index, (group, s)) in groups.iter().zip(&found.sums).enumerate() {
        if group.flags & flags != flags {
            continue;
        }
        let is_first = index == group.first_group as usize;
        let goal = if is_first { fixture.substep().goals()[group.goal as usize] } else { 0.0 };
        let mut put = |part: usize, four: Four| all[part * groups.len() + index] = four;
        put(0, [s[0], s[1], s[2], goal]);
        if group.flags & WEIGHTED == 0 {
            continue;
        }
        if is_first {
            let [x, y, z, _] = origins[group.origin as usize];
            put(1, [x, y, z, 0.0]);
        }
        put(2, [s[4], s[5], s[6], s[3]]);
        for (part, at, last) in [(3, 7, s[19]), (4, 10, 0.0), (5, 13, 0.0), (6, 16, 0.0)] {
            put(part, [s[at], s[at + 1], s[at + 2], last]);
        }
    }
    all
}

fn compare_forces(written: &mut Written<'_>, wanted: &[Four], places: usize) {
    let found: Vec<Four> = written.take("force");
    let three = |fours: &[Four]| fours.iter().flat_map(|&[x, y, z, _]| [x, y, z]).collect::<Vec<f32>>();
    let last = |fours: &[Four]| fours.iter().map(|four| four[3]).collect::<Vec<f32>>();
    let at = places.min(found.len());
    written.outcome().compare("force", &three(&wanted[..places]), &three(&found[..at]));
    written.outcome().compare("gradient", &three(&wanted[places..]), &three(&found[at..]));
    written.outcome().copied("force.w", &last(wanted), &last(&found));
}

/// Each number of each part is a quantity of its own.
fn compare_parts(written: &mut Written<'_>, wanted: &[Four]) {
    let found: Vec<Four> = written.take("volume_sums");
    let groups = wanted.len() / VOLUME_PARTS;
    for (part, axis) in (0..VOLUME_PARTS).flat_map(|part| (0..4).map(move |axis| (part, axis))) {
        let one = |all: &[Four]| -> Vec<f32> {
            all.iter().skip(part * groups).take(groups).map(|four| four[axis]).collect()
        };
        written.outcome().compare(&format!("volume_sums[{part}][{axis}]"), &one(wanted), &one(&found));
    }
}

/// A kernel that finds forces, gradients and sums. It starts from the forces that `given` makes of those that stand in the
/// fixture and of those that the CPU comes to.
fn sums(
    bench: &mut Bench<'_>,
    entry: &'static str,
    given: impl Fn(&Fixture, &Found) -> Vec<Four>,
    operations: &[Op],
) -> Result<(), String> {
    let fixtures = fixtures()?;
    let kernel = kernel_of(bench, Name::new(entry), &fixtures[0])?;
    for mut fixture in fixtures {
        let (places, found) = (fixture.is_node.len(), sum_up(&mut fixture, operations));
        let start = forces_and_weights(&fixture, &given(&fixture, &found));
        let wanted = forces_found(&fixture, &start, &found, 0);
        let wanted_parts = parts(&fixture, &fixture.old.position, &found, 0);
        let mut arrays = fixture.arrays();
        arrays.insert("force", words(&start));
        run(bench, &fixture, &kernel, &arrays, |written| {
            compare_forces(written, &wanted, places);
            compare_parts(written, &wanted_parts);
        })?;
    }
    Ok(())
}

fn run(
    bench: &mut Bench<'_>,
    fixture: &Fixture,
    kernel: &Kernel,
    arrays: &Arrays,
    compare: impl FnOnce(&mut Written<'_>),
) -> Result<(), String> {
    let (records, groups) = (fixture.records(), fixture.tables.volumes.groups.len());
    bench.run(kernel, &Given { arrays, records: &records, groups }, compare)
}

fn forces(bench: &mut Bench<'_>) -> Result<(), String> {
    let operations = [Op::Loads, Op::Rings, Op::Springs];
    sums(bench, "volume_forces", |fixture, _| poison(fixture), &operations)
}

fn forces_given(bench: &mut Bench<'_>) -> Result<(), String> {
    sums(bench, "volume_forces_given", |fixture, _| fixture.force_fours(), &[Op::Rings, Op::Springs])
}

fn gradients(bench: &mut Bench<'_>) -> Result<(), String> {
    let given = |fixture: &Fixture, found: &Found| forces_found(fixture, &poison(fixture), found, 0);
    sums(bench, "volume_gradients", given, &[Op::Rings, Op::Springs])
}

/// Numbers for all places that nobody has written.
fn poison(fixture: &Fixture) -> Vec<Four> {
    vec![[f32::NAN; 4]; fixture.is_node.len()]
}

fn particles(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures()?;
    let kernel = kernel_of(bench, Name::new("volume_particles"), &fixtures[0])?;
    for mut fixture in fixtures {
        let found = sum_up(&mut fixture, &[Op::Loads, Op::Rings, Op::Springs]);
        let Fixture { cpu, substeps, .. } = &mut fixture;
        let operations = [Op::Multipliers, Op::VolumeForces, Op::HeldForces, Op::Integrate, Op::Contact];
        cpu.passes(&substeps[SUBSTEP], &step::part_of(&volumes(), &operations));
        let start = [poison(&fixture), poison(&fixture)];
        let wanted = after(&mut fixture, start, 0);
        let force = forces_found(&fixture, &forces_and_weights(&fixture, &poison(&fixture)), &found, 0);
        let parts = parts(&fixture, &fixture.old.position, &found, 0);
        let mut kept = force.clone();
        let held = fixture.cpu.feature::<HeldForces>().expect("bodies have pins");
        for (place, [x, y, z]) in held.all().filter(|(place, _)| force[*place][0].is_finite()) {
            kept[place] = [x, y, z, 0.0];
        }
        moved(bench, &fixture, &kernel, fixture.arrays(), (&wanted, [&force, &kept], &parts))?;
    }
    Ok(())
}

/// Runs a kernel that moves nodes, keeps forces on those that are held, and leaves sums as they are.
fn moved(
    bench: &mut Bench<'_>,
    fixture: &Fixture,
    kernel: &Kernel,
    mut arrays: Arrays,
    (wanted, [force, kept], parts): (&[Vec<Four>; 2], [&[Four]; 2], &[Four]),
) -> Result<(), String> {
    arrays.insert("force", words(force));
    arrays.insert("volume_sums", words(parts));
    let places = fixture.is_node.len();
    run(bench, fixture, kernel, &arrays, |written| {
        written.fours("new_position", &wanted[0]);
        written.fours("new_velocity", &wanted[1]);
        compare_forces(written, kept, places);
        compare_parts(written, parts);
    })
}

fn measure(bench: &mut Bench<'_>) -> Result<(), String> {
    let fixtures = fixtures()?;
    let kernel = kernel_of(bench, Name::new("measure_kept_volumes"), &fixtures[0])?;
    for mut fixture in fixtures {
        let places = fixture.is_node.len();
        let found = measured(&mut fixture);
        let start = forces_and_weights(&fixture, &poison(&fixture));
        let mut wanted = forces_found(&fixture, &start, &found, RESTORED);
        wanted[..places].copy_from_slice(&start[..places]);
        let wanted_parts = parts(&fixture, &fixture.new.position, &found, RESTORED);
        let mut arrays = fixture.arrays();
        // The kernel reads the state that the others have written.
        arrays.insert("old_position", words(&fixture.new.position));
        arrays.insert("old_velocity", words(&fixture.new.velocity));
        arrays.insert("force", words(&start));
        run(bench, &fixture, &kernel, &arrays, |written| {
            compare_forces(written, &wanted, places);
            compare_parts(written, &wanted_parts);
        })?;
    }
    Ok(())
}

/// Gradients and sums in the state after the sub-step.
fn measured(fixture: &mut Fixture) -> Found {
    put_new(fixture);
    let Fixture { cpu, substeps, .. } = fixture;
    cpu.passes(&substeps[SUBSTEP], &step::part_of(&volumes(), &[Op::MeasureVolumes]));
    found(cpu, true)
}

/// Volumes to keep that are more or less by these shares than those that are there, body by body.
const OFF: [f64; 10] = [0.1, -0.07, 0.05, 0.06, -0.04, 0.0, 0.8e-6, -0.8e-6, 1.25e-6, -1.25e-6];

fn restore(bench: &mut Bench<'_>) -> Result<(), String> {
    restore_with(bench, Name::new("restore_volumes"), fixtures()?)
}

fn restore_on_meshes(bench: &mut Bench<'_>) -> Result<(), String> {
    let name = Name::new("restore_volumes").with(Contact::Meshes.choices());
    // On hardware there are no meshes: near one, other roundings turn the way out.
    let fixture = parity_scene::fixture(13, 0.0087, bench.exact)?;
    restore_with(bench, name, [fixture])
}

fn restore_with<const N: usize>(
    bench: &mut Bench<'_>,
    name: Name,
    fixtures: [Fixture; N],
) -> Result<(), String> {
    let kernel = kernel_of(bench, name, &fixtures[0])?;
    for mut fixture in fixtures {
        let found = measured(&mut fixture);
        aim(&mut fixture, &found, bench.exact);
        put_new(&mut fixture);
        let Fixture { cpu, substeps, new, .. } = &mut fixture;
        let operations = [Op::MeasureVolumes, Op::RestoreVolumes, Op::Contact];
        cpu.passes(&substeps[SUBSTEP], &step::part_of(&volumes(), &operations));
        let start = [new.position.clone(), new.velocity.clone()];
        let wanted = after(&mut fixture, start, RESTORED);
        let mut force =
            forces_found(&fixture, &forces_and_weights(&fixture, &poison(&fixture)), &found, RESTORED);
        force[..fixture.is_node.len()].copy_from_slice(&poison(&fixture));
        let parts = parts(&fixture, &fixture.new.position, &found, RESTORED);
        let mut arrays = fixture.arrays();
        arrays.insert("new_position", words(&fixture.new.position));
        arrays.insert("new_velocity", words(&fixture.new.velocity));
        moved(bench, &fixture, &kernel, arrays, (&wanted, [&force, &force], &parts))?;
    }
    Ok(())
}

/// Sets the volumes to keep by [`OFF`]; where kernels may round in their own way, none is near what is tolerated.
fn aim(fixture: &mut Fixture, measured: &Found, exact: bool) {
    let groups = fixture.tables.volumes.groups.clone();
    let mut fractions = OFF.iter().filter(|fraction| exact || fraction.abs() > 1e-5).cycle();
    for first in (0..groups.len()).filter(|&i| groups[i].first_group as usize == i) {
        if groups[first].flags & RESTORED == 0 {
            continue;
        }
        let all = &measured.sums[first..first + groups[first].groups as usize];
        let volume = all.iter().map(|sums| f64::from(sums[0])).sum::<f64>() / 3.0;
        let fraction = fractions.next().copied().unwrap_or(0.0);
        let goals: &mut Goals<f32> = fixture.substeps[SUBSTEP].extensions.get_mut();
        goals.0[groups[first].goal as usize] = (volume * (1.0 + fraction)) as f32;
    }
}
