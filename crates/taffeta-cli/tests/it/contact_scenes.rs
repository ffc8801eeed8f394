//! Scenes of contact between triangles: frame by frame the exact test finds nothing that passes through.

use std::path::{Path, PathBuf};
use taffeta::scene::Scene;
use taffeta::{Options, Simulation};

/// Scenes, and as many frames as a test has time for. The whole of each is run by hand with `--verify-contact=stop`.
const SCENES: [(&str, u32); 13] = [
    ("cards", 30),
    ("coarse_fine", 45),
    ("corner_drag", 100),
    ("knot", 70),
    ("layers", 5),
    ("needles", 45),
    ("pile", 15),
    ("pinch", 70),
    ("ribbons", 45),
    ("spike", 45),
    ("stack", 4),
    ("twist_ten", 30),
    ("twist_tube", 50),
];

/// Scenes that start tangled, and the frame from which on they are free.
const TANGLED: [(&str, u32); 1] = [("layered", 20)];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/contact")
}

fn scene(name: &str) -> Scene {
    let loaded = taffeta_io::load_scene(&folder().join(name).with_extension("toml"), &[]);
    loaded.unwrap_or_else(|error| panic!("{name}: {error}")).scene
}

fn built(name: &str) -> Simulation {
    let scene = scene(name);
    let options = Options { threads: Some(2), ..Options::default() };
    Simulation::new(&scene, &options).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn nothing_passes_through_in_any_frame() {
    for (name, frames) in SCENES {
        let mut simulation = built(name);
        let mut touched = 0;
        for frame in 0..=frames {
            if frame > 0 {
                simulation.step().unwrap_or_else(|error| panic!("{name}: {error}"));
            }
            let found = simulation.intersections();
            assert_eq!((found.pairs, found.complete), (0, true), "{name}, frame {frame}: {:?}", found.first);
            touched += simulation.report().pairs;
        }
        assert!(touched > 30, "{name} has contacts: {touched}");
    }
}

#[test]
fn what_starts_tangled_comes_free_and_stays_so() {
    for (name, frames) in TANGLED {
        let mut simulation = built(name);
        assert!(simulation.intersections().pairs > 100, "{name} starts tangled");
        for frame in 1..=frames + 6 {
            simulation.step().unwrap_or_else(|error| panic!("{name}: {error}"));
            let found = simulation.intersections();
            assert!(frame < frames || found.pairs == 0, "{name}, frame {frame}: {:?}", found.first);
        }
    }
}

/// The mean height of bodies of so many vertices each [m].
fn heights(simulation: &Simulation, vertices: usize) -> Vec<f64> {
    let mut all: Vec<[f64; 3]> = Vec::new();
    simulation.positions_f64(&mut all);
    all.chunks(vertices).map(|x| x.iter().map(|x| x[1]).sum::<f64>() / x.len() as f64).collect()
}

#[test]
fn a_house_of_cards_stands() {
    let mut simulation = built("cards");
    let start = heights(&simulation, 35);
    for _ in 0..90 {
        simulation.step().expect("a stable scene");
    }
    for (card, (now, start)) in heights(&simulation, 35).into_iter().zip(start).enumerate() {
        // Cards sag by their weight.
        assert!((start - now).abs() < 0.006, "card {card} was {start} m high and is {now} m");
    }
    // Contact does not shake what air has slowed: 28 g at 1 mm/s.
    let kinetic = simulation.report().kinetic;
    assert!(kinetic < 1.4e-8, "{kinetic} J");
}

#[test]
fn layers_keep_their_order() {
    let mut simulation = built("layers");
    let start = simulation.memory();
    for _ in 0..8 {
        simulation.step().expect("a stable scene");
    }
    let heights = heights(&simulation, 100);
    assert!(heights.len() == 50 && heights.is_sorted(), "{heights:?}");
    // Fifty layers are the dense pile that `check` tells of.
    let lists = (simulation.memory() - start) as f64;
    let [flat, piled] = scene("layers").memory_needed().contact_lists.map(|bytes| bytes as f64);
    assert!(lists > 3.0 * flat && lists < piled, "{flat} {lists} {piled}");
}

#[test]
fn every_scene_is_tested() {
    let entries =
        std::fs::read_dir(folder()).expect("the scenes").map(|entry| entry.expect("an entry").path());
    let scenes = entries.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    let mut names: Vec<String> =
        scenes.map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned()).collect();
    names.sort();
    let mut tested: Vec<&str> = SCENES.iter().chain(&TANGLED).map(|(name, _)| *name).collect();
    tested.sort_unstable();
    assert_eq!(names, tested);
}
