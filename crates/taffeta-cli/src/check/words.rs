//! The answer for a mesh in words.

use super::MeshKind;
use super::advice::triangle;
use super::report::{ComponentReport, MeshReport, Verdict};
use crate::console::{self, counted, list};
use std::path::Path;

/// The report as text.
pub fn of(report: &MeshReport, kind: Option<MeshKind>) -> String {
    let count = |n, one, many| counted(n, one, many);
    let mut lines = vec![
        format!(
            "{}: {}, {}",
            report.mesh,
            count(report.vertices, "vertex", "vertices"),
            count(report.faces, "face", "faces")
        ),
        format!(
            "simulated: {}, {}, {}; about {} of memory",
            count(report.nodes, "node", "nodes"),
            count(report.triangles, "triangle", "triangles"),
            count(report.edges, "edge", "edges"),
            memory(report.memory_bytes)
        ),
    ];
    lines.extend(repairs(report));
    lines.push(surface(report));
    lines.extend(borders(report));
    lines.extend(components(report));
    lines.extend(size(report));
    lines.extend(report.bending_factors.map(|[least, largest]| {
        format!("bending of a fabric on this mesh: {least:.2}–{largest:.2} of the fabric's own")
    }));
    if report.self_intersections.first.is_empty() {
        let all = if report.self_intersections.complete {
            "none"
        } else {
            "none found, though not all were looked at"
        };
        lines.push(format!("self-intersections: {all}"));
    }
    lines.extend(report.warnings.iter().map(|warning| format!("warning: {warning}")));
    lines.extend(report.unit.iter().map(|unit| format!("unit: {}", unit.hint)));
    let warnings = lines.iter().filter(|line| line.starts_with("warning: ")).count();
    if kind != Some(MeshKind::Body) {
        lines.push(verdict("shell", &report.shell, warnings));
    }
    if kind != Some(MeshKind::Shell) {
        lines.push(verdict("body", &report.body, warnings));
    }
    lines.extend(next(report));
    lines.join("\n")
}

/// What was repaired, less what the warnings say better.
fn repairs(report: &MeshReport) -> impl Iterator<Item = String> {
    let said = |repair: &&String| ["not a manifold", "not orientable"].iter().any(|s| repair.starts_with(s));
    report.repairs.iter().filter(move |repair| !said(repair)).map(|repair| console::repaired(repair))
}

fn surface(report: &MeshReport) -> String {
    let genus = report.genus.map(|genus| format!(", genus {genus}")).unwrap_or_default();
    let not = if report.orientable { "" } else { "not " };
    let touching = if report.joined_components < report.components {
        format!(" ({} if those that touch at a point are one)", console::grouped(report.joined_components))
    } else {
        String::new()
    };
    format!(
        "surface: {}, {not}orientable, Euler characteristic {}{genus}, {}{touching}",
        if report.closed { "closed" } else { "open" },
        report.euler_characteristic,
        counted(report.components, "component", "components")
    )
}

/// What the open edges make together.
fn borders(report: &MeshReport) -> Option<String> {
    let open = &report.boundary_edges;
    let ends = (report.open_borders > 0).then(|| {
        let borders = counted(report.open_borders, "border that ends", "borders that end");
        format!("{borders} where more than two triangles meet, ")
    });
    (open.count > 0).then(|| {
        format!(
            "borders: {}, {}{} (vertices {})",
            counted(report.holes, "hole", "holes"),
            ends.unwrap_or_default(),
            counted(open.count, "boundary edge", "boundary edges"),
            list(&open.first, open.count, |[a, b]| format!("{a}–{b}"))
        )
    })
}

/// The largest components, if there are several.
fn components(report: &MeshReport) -> Vec<String> {
    if report.components < 2 {
        return Vec::new();
    }
    let line = |part: &ComponentReport| {
        let inside = match part.volume {
            Some(volume) if volume < 0.0 => format!("a cavity, volume {} m³", number(volume)),
            Some(volume) => format!("closed, volume {} m³", number(volume)),
            None => "open".to_owned(),
        };
        let genus = part.genus.map(|genus| format!(", genus {genus}")).unwrap_or_default();
        let triangles = counted(part.triangles, "triangle", "triangles");
        format!("  component at vertex {}: {triangles}, {inside}{genus}", part.vertex)
    };
    let more = report.components - report.largest_components.len();
    let more =
        (more > 0).then(|| format!("  and {}", counted(more, "smaller component", "smaller components")));
    report.largest_components.iter().map(line).chain(more).collect()
}

fn size(report: &MeshReport) -> Vec<String> {
    let [x, y, z] = report.extent.map(number);
    let volume = report.volume.map(|v| format!(", volume {} m³", number(v))).unwrap_or_default();
    let (short, long) = (&report.shortest_edge, &report.longest_edge);
    let ends = |[a, b]: [u32; 2]| format!("vertices {a}–{b}");
    let thin = &report.thinnest_triangle;
    vec![
        format!("size: {x} × {y} × {z} m, area {} m²{volume}", number(report.area)),
        format!(
            "edges: from {} m ({}) to {} m ({}); thinnest triangle {:.1} times as long as high {}",
            number(short.length),
            ends(short.vertices),
            number(long.length),
            ends(long.vertices),
            thin.aspect,
            triangle(&thin.vertices)
        ),
    ]
}

fn verdict(kind: &str, verdict: &Verdict, warnings: usize) -> String {
    match (&verdict.reason, &verdict.remedy) {
        (Some(reason), remedy) => {
            let remedy = remedy.as_ref().map(|remedy| format!("; {remedy}")).unwrap_or_default();
            format!("as a {kind}: refused: {reason}{remedy}")
        }
        (None, _) if warnings == 0 => format!("as a {kind}: accepted"),
        (None, _) => format!("as a {kind}: accepted with {}", counted(warnings, "warning", "warnings")),
    }
}

/// What to do next.
fn next(report: &MeshReport) -> Option<String> {
    let scene = report.scene.as_ref()?;
    let file = Path::new(&report.mesh).with_extension("toml");
    let file = file.display();
    Some(format!(
        "\nnext: save this as {file}; `taffeta check {file}` says more, `taffeta run {file}` simulates it\n\n{}",
        scene.trim_end()
    ))
}

/// A number with four digits.
pub fn number(x: f64) -> String {
    let rounded = format!("{x:.3e}");
    let size: i32 = rounded.split_once('e').and_then(|(_, size)| size.parse().ok()).unwrap_or(0);
    if x == 0.0 {
        "0".to_owned()
    } else if (-4..5).contains(&size) {
        format!("{x:.*}", (3 - size).max(0) as usize)
    } else {
        rounded
    }
}

/// Bytes with their unit.
pub fn memory(bytes: u64) -> String {
    let size = bytes as f64;
    match bytes {
        0..1_000_000 => format!("{:.0} kB", size * 1e-3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", size * 1e-6),
        _ => format!("{:.1} GB", size * 1e-9),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_have_four_digits() {
        let numbers =
            [0.0, 3.2, -0.18, 0.000_123_456, 1e-7, 12345.6, 1e9, 0.000_999_999_9].map(super::number);
        assert_eq!(
            numbers,
            ["0", "3.200", "-0.1800", "0.0001235", "1.000e-7", "12346", "1.000e9", "0.001000"]
        );
        assert_eq!([900, 4_500_000, 3_200_000_000].map(super::memory), ["1 kB", "4.5 MB", "3.2 GB"]);
    }
}
