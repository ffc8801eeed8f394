//! Two million sub-steps of a flag.

use std::path::Path;
use taffeta::{Options, Simulation};
use taffeta_io::checkpoint::identity;
use taffeta_io::{Checkpoint, load_scene};

/// Frames of 67 sub-steps each, and how many lie between two checkpoints.
const FRAMES: u32 = 30_000;
const BETWEEN: u32 = 1_000;

#[test]
#[ignore = "takes some minutes; to be run in release"]
fn a_flag_flies_for_two_million_substeps_and_goes_on_from_any_checkpoint() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/flag_gusts.toml");
    let scene = load_scene(&path, &[]).unwrap().scene;
    let build = || Simulation::new(&scene, &Options { threads: Some(1), ..Options::default() }).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = |number: u32| folder.path().join(format!("{number}.taffeta"));
    let keep = |simulation: &Simulation, number| {
        let checkpoint = Checkpoint { scene: identity(&scene), snapshot: simulation.snapshot(), run: 0_u8 };
        checkpoint.write(&file(number)).unwrap();
    };
    let mut simulation = build();
    keep(&simulation, 0);
    let (mut hashes, mut memory, mut energies) = (vec![simulation.state_hash()], Vec::new(), Vec::new());
    let mut substeps = 0_u64;
    for number in 1..=FRAMES / BETWEEN {
        for _ in 0..BETWEEN {
            let report = simulation.step().unwrap();
            substeps += u64::from(report.substeps);
            // It neither tears nor falls asleep: the wind feeds what the air takes.
            assert!(report.max_stretch < 1.3, "{}", report.max_stretch);
            energies.push(report.kinetic + report.springs);
        }
        keep(&simulation, number);
        hashes.push(simulation.state_hash());
        memory.push(simulation.memory());
    }
    assert!(substeps >= 2_000_000, "{substeps}");
    assert!(memory.iter().all(|bytes| *bytes == memory[0]), "{memory:?}");
    // No drift: the last tenth has the mean energy of the second one.
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let tenth = energies.len() / 10;
    let [early, late] = [mean(&energies[tenth..2 * tenth]), mean(&energies[9 * tenth..])];
    println!("mean energy {early:.4} J early, {late:.4} J late; {} bytes", memory[0]);
    assert!((late / early - 1.0).abs() < 0.1, "{early} J, then {late} J");
    // From checkpoints in no order, a while further each.
    for number in [17, 3, 29, 0, 11] {
        let mut other = build();
        other.restore(&Checkpoint::<u8>::read(&file(number)).unwrap().snapshot).unwrap();
        other.advance(BETWEEN).unwrap();
        assert_eq!(other.state_hash(), hashes[number as usize + 1], "from frame {}", number * BETWEEN);
    }
}
