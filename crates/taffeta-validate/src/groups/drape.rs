//! Cusick's drape test.

use crate::bench::{Bench, Extent, Job, Rest, Row};
use crate::flat::{Flat, Lattice, Pattern};
use crate::groups::Group;
use crate::specimen::{Case, body, head, pin};
use std::f64::consts::PI;
use taffeta::scene::{PRESETS, Preset};

pub const GROUP: Group = Group {
    name: "drape",
    title: "Cusick drape",
    words: "A disc of fabric, 30 cm across, is held between two of 18 cm and hangs down around them (Cusick 1968; BS 5058). The drape \
            coefficient is the area that its shadow takes of the ring: (A − A_disc)/(A_specimen − A_disc). Each preset is held against \
            the band of its fabric in the literature, and the meshes of 1,000 to 4,000 nodes against each other: at most 3 points from \
            their mean. A specimen falls into one of several numbers of folds, which small differences decide; rows say into how many. \
            Meshes of 1,000 nodes are coarse for the folds of silk.",
    axes: ["nodes", "drape coefficient [%]"],
    is_logarithmic: false,
    theory: None,
    jobs,
};

/// Radii of the specimen and of the discs that hold it [m].
const SPECIMEN: f64 = 0.15;
const DISC: f64 = 0.09;
/// Side of a square of the shadow [m].
const SQUARE: f64 = 2e-4;
/// Nodes of the meshes.
const NODES: [usize; 3] = [1000, 2000, 4000];
/// Height of a wave of the specimen at the start [m]; there are six, one on the other.
const UNEVEN: f64 = 5e-4;
/// How far a mesh may be from the mean of all [points].
const SPREAD: f64 = 3.0;

fn jobs(extent: Extent) -> Vec<Job> {
    let job = |preset: &'static Preset| {
        Job::new(preset.name, move |bench| {
            let meshes: Vec<(Pattern, usize)> = match extent {
                Extent::Quick => vec![(Pattern::Equilateral, NODES[0])],
                Extent::Whole => {
                    Pattern::ALL.into_iter().flat_map(|pattern| NODES.map(|nodes| (pattern, nodes))).collect()
                }
            };
            let mut rows = Vec::new();
            for (pattern, nodes) in meshes {
                let (found, folds, variant, note) = drape(bench, preset, pattern, nodes)?;
                let row = Row::new(
                    format!("drape coefficient of {}, {folds} folds [%]", preset.name),
                    found,
                    &variant,
                );
                rows.push(row.at(preset.name, nodes as f64).noting(note));
            }
            let mean = rows.iter().map(|row| row.ours).sum::<f64>() / rows.len() as f64;
            for row in &mut rows {
                *row = row.clone().near(mean, SPREAD, "points");
            }
            rows.extend(in_band(preset, mean, &rows[0]));
            Ok(rows)
        })
    };
    let chosen = |name: &str| extent == Extent::Whole || name == "cotton";
    PRESETS.iter().filter(|preset| chosen(preset.name)).map(job).collect()
}

/// The mean of all meshes beside the band of the literature.
fn in_band(preset: &Preset, mean: f64, of: &Row) -> Option<Row> {
    let (_, low, high) = BANDS.into_iter().find(|(name, ..)| *name == preset.name)?;
    let expected = mean.clamp(low, high);
    let row = Row { ours: mean, plot: None, mesh: "mean of all".into(), ..of.clone() }
        .near(expected, 0.0, "points");
    let quantity = format!("drape coefficient of {}, in {low} to {high} [%]", preset.name);
    let note = if preset.name == "denim" { DENIM } else { "" };
    Some(Row { quantity, note: note.into(), ..row })
}

/// Least and largest drape coefficients of fabrics in the literature [%].
const BANDS: [(&str, f64, f64); 4] =
    [("silk", 20.0, 40.0), ("cotton", 60.0, 76.0), ("wool", 40.0, 70.0), ("denim", 70.0, 90.0)];

/// Why denim fails.
const DENIM: &str =
    "the bending that Wang and others measured on their denim is less than that of the denims of the band";

/// Drag by mass [1/s], which brings a specimen to rest and changes nothing of where that is.
const DRAG: f64 = 2.0;

/// Lets a specimen drape: its coefficient [%] and its folds.
fn drape(
    bench: &Bench<'_>,
    preset: &Preset,
    pattern: Pattern,
    nodes: usize,
) -> Result<(f64, usize, crate::bench::Variant, &'static str), String> {
    // A node has the area of a cell: that of two triangles.
    let cell = PI * SPECIMEN * SPECIMEN / nodes as f64;
    let edge = if pattern == Pattern::Grid { cell.sqrt() } else { (cell / 0.75_f64.sqrt()).sqrt() };
    let mesh = Flat::disc(SPECIMEN, &[DISC], Lattice { pattern, edge, turn: 0.0 });
    let case = Case::new(pattern, 0.0, nodes);
    let variant = case.variant(&format!("drape-{}", preset.name));
    bench.write(&format!("{}.obj", variant.name), &mesh.placed(uneven))?;
    let held = mesh.select(|[x, y]| x.hypot(y) < DISC + 1e-6);
    let name = preset.name;
    let material =
        format!("[body.material]\npreset = \"{name}\"\ndamping = {{ stretch = 1e-3, bending = 1e-2 }}\n");
    // Relative to what gravity does in a step, a tolerance of 1e-3 leaves enough for silk to wander for ever.
    let drag = DRAG * preset.fabric.density * PI * SPECIMEN * SPECIMEN / mesh.nodes.len() as f64;
    let scene = head(&format!("Drape of {name}"), 0.02, case.solver, &format!("drag = {drag:?}"))
        .replace("1e-5", "1e-4")
        + &body(&variant, &material)
        + &pin(&held);
    let mut running = bench.start(&variant, &scene)?;
    let rested = running.settle(Rest { moves: 5e-4, window: 1.0, longest: 12.0 })?;
    let places = running.positions();
    let shadow = shadow(&mesh, &places);
    let [all, disc] = [SPECIMEN, DISC].map(|radius| PI * radius * radius);
    let folds = folds(&mesh, &places);
    Ok((
        100.0 * (shadow - disc) / (all - disc),
        folds,
        variant,
        if rested { "" } else { "still moves after 12 s" },
    ))
}

/// A disc that is uneven by up to 2.5 mm at its border, as fabrics are, so that it is the same on all meshes where it folds.
fn uneven([x, z]: [f64; 2]) -> [f64; 3] {
    let (radius, angle) = (x.hypot(z), z.atan2(x));
    let out = (radius - DISC).max(0.0) / (SPECIMEN - DISC);
    let waves = [(2.0, 0.3), (3.0, 1.1), (4.0, 2.3), (5.0, 0.7), (6.0, 1.9), (7.0, 2.9)];
    let height: f64 = waves.into_iter().map(|(count, phase): (f64, f64)| (count * angle + phase).cos()).sum();
    [x, UNEVEN * out * height, z]
}

/// The area [m²] of the shadow on the floor, by squares whose middles are below a triangle.
fn shadow(mesh: &Flat, places: &[[f64; 3]]) -> f64 {
    let side = (2.2 * SPECIMEN / SQUARE) as usize;
    let mut dark = vec![false; side * side];
    let to_square = |x: f64| (x + 1.1 * SPECIMEN) / SQUARE - 0.5;
    for triangle in &mesh.triangles {
        let corners = triangle.map(|node| [0, 2].map(|axis| to_square(places[node as usize][axis])));
        let range = |axis: usize| {
            let all = corners.map(|corner| corner[axis]);
            let low = all.iter().copied().fold(f64::INFINITY, f64::min).ceil().max(0.0) as usize;
            let high = all.iter().copied().fold(0.0, f64::max).floor().min(side as f64 - 1.0) as usize;
            low..=high
        };
        for row in range(1) {
            for column in range(0) {
                dark[row * side + column] |= is_inside(corners, [column as f64, row as f64]);
            }
        }
    }
    dark.iter().filter(|&&dark| dark).count() as f64 * SQUARE * SQUARE
}

fn is_inside([a, b, c]: [[f64; 2]; 3], [x, y]: [f64; 2]) -> bool {
    let side = |p: [f64; 2], q: [f64; 2]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    let all = [side(a, b), side(b, c), side(c, a)];
    all.iter().all(|&side| side >= 0.0) || all.iter().all(|&side| side <= 0.0)
}

/// Number of folds: the greatest harmonic of the radius of the border.
fn folds(mesh: &Flat, places: &[[f64; 3]]) -> usize {
    let border = mesh.select(|[x, y]| x.hypot(y) > SPECIMEN - 1e-6);
    let amplitude = |count: usize| {
        let wave = |turn: f64| {
            border
                .iter()
                .map(|&node| {
                    let ([x, y], place) = (mesh.nodes[node], places[node]);
                    place[0].hypot(place[2]) * (count as f64 * y.atan2(x) + turn).cos()
                })
                .sum::<f64>()
        };
        wave(0.0).hypot(wave(-0.5 * PI))
    };
    (2..=16).max_by(|&a, &b| amplitude(a).total_cmp(&amplitude(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The kept report and the presets' ranges are two copies of the same numbers. The report has the worst of each number of folds.
    #[test]
    fn presets_have_the_drape_that_the_kept_report_has() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/results/validate/report.md");
        let report = std::fs::read_to_string(path).unwrap();
        for preset in PRESETS {
            let name = format!("drape coefficient of {}, ", preset.name);
            let of_mesh = |line: &&str| line.contains(&name) && line.contains(" folds [%]");
            let ours = |line: &str| -> f64 { line.split('|').nth(3).unwrap().trim().parse().unwrap() };
            let [low, high] = preset.drape;
            let found: Vec<f64> = report.lines().filter(of_mesh).map(ours).collect();
            let is_end = |&one: &f64| (one - low).abs() < 0.06 || (one - high).abs() < 0.06;
            assert!(found.iter().any(is_end), "{}: {found:?} %", preset.name);
            assert!(
                found.iter().all(|one| (low - 0.06..high + 0.06).contains(one)),
                "{}: {found:?} %",
                preset.name
            );
        }
    }
}
