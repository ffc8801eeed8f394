//! Layers that lie on each other.

use super::crossing::crossings;
use super::sheets::sheet;
use crate::common::{V, build_as, positions, run, surface};
use taffeta::scene::{Collider, Scene};
use taffeta::{Precision, Simulation};

const SIDE: u32 = 10;
const SPACING: f64 = 0.02;
const LAYERS: usize = 5;

/// Sheets a little apart and a little shifted above a floor.
fn layers(h: f64) -> Scene {
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(0.5);
    let mut scene = Scene::new("stack").time(0.02, h).collider(floor);
    for layer in 0..LAYERS {
        let count = layer as f64;
        let at = [0.003 * count, 0.01 + 0.021 * count, -0.004 * count];
        scene = scene.body(sheet(&layer.to_string(), SIDE, SPACING, SPACING).at(at));
    }
    scene
}

/// Mean height of each layer [m].
fn heights(simulation: &Simulation) -> Vec<f64> {
    let x = positions(simulation);
    x.chunks(x.len() / LAYERS)
        .map(|layer| layer.iter().map(|x| x[1]).sum::<f64>() / layer.len() as f64)
        .collect()
}

#[test]
fn a_stack_of_sheets_comes_to_rest_in_its_order() {
    for precision in [Precision::F64, Precision::F32] {
        let mut simulation = build_as(&layers(0.0005), precision, 1);
        run(&mut simulation, 50);
        let before = heights(&simulation);
        for _ in 0..10 {
            run(&mut simulation, 2);
            // 0.25 kg; at 1 cm/s that is 1.25e-5 J.
            let kinetic = simulation.report().kinetic;
            assert!(kinetic < 5e-5, "{precision}: {kinetic:e} J");
        }
        let after = heights(&simulation);
        for layer in 0..LAYERS {
            // A node lies between four of the layer below: at √½ of the spacing.
            let expected = layer as f64 * SPACING * 0.5_f64.sqrt();
            let off = (after[layer] - expected).abs();
            assert!(off < 0.1 * SPACING, "{precision}: {after:?}");
            assert!((after[layer] - before[layer]).abs() < 0.02 * SPACING, "{before:?} {after:?}");
        }
        let (x, triangles) = (positions(&simulation), surface(&simulation, 0).triangles);
        let layers: Vec<&[V]> = x.chunks(x.len() / LAYERS).collect();
        for pair in layers.windows(2) {
            assert_eq!(crossings([pair[0], pair[1]], [&triangles, &triangles]), 0, "{precision}");
        }
    }
}
