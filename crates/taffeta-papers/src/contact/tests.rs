//! The rungs beside the serial program, and what bins keep and lose.

use super::bins::{CAPACITY, Layout, Lost};
use super::ladder::Ladder;
use super::particle::Particle;
use super::rung::Rung;
use super::serial::Serial;
use super::sheet::{Sheet, THICKNESS};
use super::{Contact, on};
use std::sync::OnceLock;
use taffeta::taffeta_gpu::{DispatchList, Gpu};
use taffeta::{Options, Simulation};

const SIDE: u32 = 20;

fn gpu() -> Gpu {
    static SHARED: OnceLock<Gpu> = OnceLock::new();
    SHARED.get_or_init(|| super::open().expect("a GPU; one in software would do")).clone()
}

/// A sheet that has settled, and whose nodes have been shaken since.
fn shaken() -> Serial {
    let sheet = Sheet { side: SIDE };
    let settled = sheet.settled(&Options { threads: Some(1), ..Options::default() });
    let mut serial = Serial::new(&sheet, &settled.expect("it settles"));
    for (i, particle) in serial.now.iter_mut().enumerate().skip(serial.held) {
        for axis in 0..3 {
            let phase = (i * (7 + 4 * axis)) as f32;
            particle.x[axis] += 1e-3 * phase.cos();
            particle.v[axis] += 0.3 * phase.sin();
        }
    }
    serial
}

/// The same with its last rows folded over those before, and a floor through its lowest part: some nodes are in the ball,
/// some below the floor, some near others.
fn folded() -> Serial {
    let (mut serial, side) = (shaken(), SIDE as usize);
    for (row, col) in (15..side).flat_map(|row| (0..side).map(move |col| (row, col))) {
        let below = serial.now[(29 - row) * side + col].x;
        serial.now[row * side + col].x = [below[0], below[1] + 0.014, below[2] + 0.014];
    }
    let mut heights: Vec<f32> = serial.now.iter().map(|particle| particle.x[1]).collect();
    heights.sort_by(f32::total_cmp);
    serial.floor = heights[side];
    serial
}

fn submit(ladder: &mut Ladder, record: impl FnOnce(&mut Ladder, &mut DispatchList)) {
    let mut list = DispatchList::new();
    record(ladder, &mut list);
    ladder.gpu.submit(&list).expect("submitted");
}

/// Largest differences in position [m] and velocity [m/s].
fn apart(serial: &Serial, particles: &[Particle]) -> (f32, f32) {
    assert_eq!(serial.now.len(), particles.len());
    let far = |a: &[f32; 3], b: &[f32; 4]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, |most, one| if one <= most { most } else { one })
    };
    let worst = |most: f32, one: f32| if one <= most { most } else { one };
    serial.now.iter().zip(particles).fold((0.0, 0.0), |(x, v), (one, other)| {
        (worst(x, far(&one.x, &other.x)), worst(v, far(&one.v, &other.v)))
    })
}

/// How many nodes are in the ball, below the floor, and near one that no spring joins them with.
fn contacts(serial: &Serial) -> [usize; 3] {
    let distance =
        |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt();
    let springs = |i: usize| &serial.springs[serial.starts[i] as usize..serial.starts[i + 1] as usize];
    let near = |i: usize, j: usize| {
        i != j
            && distance(serial.now[i].x, serial.now[j].x) < THICKNESS as f32
            && !springs(i).iter().any(|spring| spring.other as usize == j)
    };
    let count = serial.now.len();
    let nodes = serial.now.iter();
    [
        nodes.clone().filter(|node| distance(node.x, serial.ball.0) < serial.ball.1).count(),
        nodes.filter(|node| node.x[1] < serial.floor).count(),
        (0..count).filter(|&i| (0..count).any(|j| near(i, j))).count(),
    ]
}

#[test]
fn every_rung_does_the_sub_step_of_the_serial_program() {
    let gpu = gpu();
    let start = folded();
    let contacts = contacts(&start);
    assert!(contacts.iter().all(|&count| count > 5), "{contacts:?} nodes touch ball, floor and others");
    for rung in Rung::LADDER {
        let name = rung.name();
        let mut serial = folded();
        let mut ladder = Ladder::new(&gpu, rung, &start).expect("it is made");
        submit(&mut ladder, Ladder::refresh);
        // Both ways that buffers take turns.
        for step in 1..=3 {
            serial.step();
            submit(&mut ladder, Ladder::step);
            let (x, v) = apart(&serial, &ladder.particles().expect("read"));
            // Sums in another order, roots and quotients to some units in the last place.
            assert!(x < 1e-6 && v < 2e-5, "{name}, sub-step {step}: {x} m, {v} m/s");
        }
    }
}

/// The bin of each particle, as the table has it; `None` where it has it not.
fn bins_of(ladder: &Ladder) -> Vec<Option<usize>> {
    let bins = ladder.bins.as_ref().expect("it has bins");
    let table = &bins.tables[bins.now()];
    let read = |buffer: &taffeta::taffeta_gpu::Buffer<u32>| buffer.read(&ladder.gpu).expect("read");
    let (filled, members) = (read(&table.filled), read(&table.members));
    let mut bins = vec![None; ladder.particles[0].len()];
    for (bin, (&count, places)) in filled.iter().zip(members.chunks(CAPACITY as usize)).enumerate() {
        for &i in &places[..count as usize] {
            let before = bins[i as usize].replace(bin);
            assert_eq!(before, None, "particle {i} is in two bins");
        }
    }
    bins
}

/// Number of the bin in which a place is.
fn bin_at(layout: &Layout, x: [f32; 4]) -> usize {
    let at = [0, 1, 2].map(|axis| {
        let bin = ((x[axis] - layout.lowest[axis]) / layout.side).floor();
        bin.clamp(0.0, (layout.counts[axis] - 1) as f32) as usize
    });
    let [nx, ny, _] = layout.counts.map(|count| count as usize);
    (at[2] * ny + at[1]) * nx + at[0]
}

#[test]
fn the_serial_program_has_the_springs_of_the_scene() {
    let sheet = Sheet { side: 9 };
    let simulation = Simulation::new(&sheet.scene(), &Options::default()).expect("it is built");
    let count: usize = simulation.bodies()[0].springs.iter().map(|(_, count)| count).sum();
    assert_eq!((count, sheet.springs() as usize), (count, count));
    // Each spring is at both its ends.
    assert_eq!(Serial::new(&sheet, &simulation).springs.len(), 2 * count);
}

#[test]
fn every_rung_leaves_a_line_as_a_bench_does() {
    let gpu = gpu();
    for rung in [&[Rung::Serial][..], &Rung::LADDER, &[Rung::Binned]].concat() {
        let on_gpu = Rung::LADDER.contains(&rung);
        let contact = Contact { rung, side: 8, frames: None, threads: Some(1), gpu: on_gpu };
        let line = on(&contact, Some(2), on_gpu.then_some(&gpu)).expect("it is run");
        assert_eq!(
            (&line["rung"], &line["nodes"], &line["frames"]),
            (&rung.name().into(), &64.into(), &2.into())
        );
        let device = line["device"].as_str().unwrap_or_default();
        assert!(device.starts_with(if on_gpu { "gpu, " } else { "cpu, 1 thread" }), "{line}");
        for path in ["/ms_per_frame/min", "/ms_per_frame/median", "/steps_per_s"] {
            assert!(
                line.pointer(path).and_then(|number| number.as_f64()).is_some_and(|number| number > 0.0),
                "{path}: {line}"
            );
        }
        let note = line["note"].as_str().unwrap_or_default();
        match rung {
            Rung::Scanned => assert!(note.contains("0 nodes found no room in a bin"), "{note}"),
            Rung::Refreshed => assert!(note.contains("0 nodes are in no bin any more"), "{note}"),
            _ => {}
        }
    }
    let none = Contact { rung: Rung::Naive, side: 8, frames: None, threads: None, gpu: true };
    assert_eq!(on(&none, Some(1), None).err().as_deref(), Some("naive needs a GPU"));
}

#[test]
fn bins_hold_every_particle_once_where_it_is() {
    let (gpu, start) = (gpu(), shaken());
    let layout = Layout::around(&start);
    for rung in [Rung::Scanned, Rung::Refreshed] {
        let mut ladder = Ladder::new(&gpu, rung, &start).expect("it is made");
        let before = bins_of(&ladder);
        // An odd number of sub-steps: the particles are in the other buffer, and in that alone somewhat higher.
        (0..3).for_each(|_| submit(&mut ladder, |ladder, list| ladder.frame(list, 33)));
        let mut particles = ladder.particles().expect("read");
        particles.iter_mut().for_each(|particle| particle.x[1] += 0.4 * layout.side);
        ladder.particles[1].write(&gpu, 0, &particles);
        submit(&mut ladder, Ladder::refresh);
        let after = bins_of(&ladder);
        let moved = before.iter().zip(&after).filter(|(before, after)| before != after).count();
        assert!(moved > 10, "{moved} have moved to other bins");
        let expected: Vec<_> = particles.iter().map(|particle| Some(bin_at(&layout, particle.x))).collect();
        let other: Vec<usize> = (0..after.len()).filter(|&i| after[i] != expected[i]).collect();
        // A quotient on the border of two bins may be rounded either way.
        assert!(other.len() <= 1, "{rung:?}: {other:?}");
        let lost = ladder.bins.as_ref().unwrap().lost(&gpu, particles.len()).expect("read");
        assert_eq!((lost.left_out, lost.missing), (0, 0));
    }
}

/// Fills the bins again after particles have been put elsewhere by `put`; left out, and missing.
fn lost_after(rung: Rung, put: impl Fn(&mut [Particle])) -> (u32, u32) {
    let gpu = gpu();
    let mut ladder = Ladder::new(&gpu, rung, &shaken()).expect("it is made");
    let mut particles = ladder.particles().expect("read");
    put(&mut particles);
    ladder.particles[ladder.now].write(&gpu, 0, &particles);
    submit(&mut ladder, Ladder::refresh);
    let lost = ladder.bins.as_ref().unwrap().lost(&gpu, particles.len()).expect("read");
    (lost.left_out, lost.missing)
}

#[test]
fn a_particle_that_crosses_a_whole_bin_is_counted_as_lost_where_neighbours_are_asked() {
    let bin = Layout::around(&shaken()).side;
    let thrown =
        |bins: f32| move |particles: &mut [Particle]| particles[SIDE as usize * 3].x[1] += bins * bin;
    assert_eq!(lost_after(Rung::Refreshed, thrown(2.0)), (0, 1));
    assert_eq!(lost_after(Rung::Refreshed, thrown(1.0)), (0, 0));
    assert_eq!(lost_after(Rung::Scanned, thrown(2.0)), (0, 0));
}

#[test]
fn particles_that_find_no_room_in_their_bin_are_counted() {
    let layout = Layout::around(&shaken());
    // The middle of a bin at the border, and outside of the box: both are the same bin.
    let middle = layout.lowest.map(|x| x + 0.5 * layout.side);
    let crowd = |particles: &mut [Particle]| {
        for (i, particle) in particles.iter_mut().take(CAPACITY as usize + 5).enumerate() {
            let shift = if i % 2 == 0 { 0.0 } else { 2.0 * layout.side };
            particle.x = [middle[0] - shift, middle[1], middle[2], 0.0];
        }
    };
    assert_eq!(lost_after(Rung::Scanned, crowd), (5, 5));
}

#[test]
fn what_bins_have_lost_is_told() {
    let lost = |rung, left_out, missing| Lost { left_out, missing }.words(rung);
    assert_eq!(lost(Rung::Scanned, 1, 1), "1 node found no room in a bin, in all frames together");
    assert_eq!(
        lost(Rung::Refreshed, 2, 5),
        "5 nodes are in no bin any more: 2 found no room, 3 crossed a whole bin in a frame"
    );
    assert!(lost(Rung::Refreshed, 0, 1).starts_with("1 node is in no bin any more: 0 found"));
}
