//! What to make of a mesh: its unit, and what may spoil a simulation.

use super::report::{IntersectionReport, MeshReport, UnitHint};
use crate::console::{counted, grouped, list};

/// Longest edge over height from which on a triangle is thin.
const THIN: f64 = 100.0;

/// What the unit may be, from the largest extent [m]: figures and garments are half a metre to three metres large.
pub fn unit(extent: f64) -> Option<UnitHint> {
    let known = [("kilometres", 1000.0), ("centimetres", 0.01), ("millimetres", 0.001)];
    let fits = known.into_iter().find(|(_, scale)| (0.5..=3.0).contains(&(extent * scale)));
    let large = super::words::number(extent);
    match fits {
        Some((unit, scale)) => Some(UnitHint {
            hint: format!(
                "it is {large} m large; if this is a garment or figure it is probably in {unit}: place.scale = {scale}"
            ),
            scale: Some(scale),
        }),
        None if (0.01..=5.0).contains(&extent) => None,
        None => Some(UnitHint {
            hint: format!(
                "it is {large} m large; if that is not meant, place.fit = 1.8 makes its largest extent 1.8 m"
            ),
            scale: None,
        }),
    }
}

/// What does not forbid a simulation, but may spoil it.
pub fn warnings(report: &MeshReport) -> Vec<String> {
    let mut warnings = Vec::new();
    let crowded = &report.non_manifold_edges;
    if crowded.count > 0 {
        let edges = counted(crowded.count, "edge", "edges");
        let in_file = report.non_manifold_edges_in_file;
        let in_file = if in_file > crowded.count {
            format!(" ({} before faces were dropped)", grouped(in_file))
        } else {
            String::new()
        };
        warnings.push(format!(
            "not a manifold: {edges} with more than two triangles{in_file}, vertices {}; nothing bends there",
            list(&crowded.first, crowded.count, |[a, b]| format!("{a}–{b}"))
        ));
    }
    let flipped = &report.flipped_edges;
    if !report.orientable {
        let edges = counted(flipped.count, "edge", "edges");
        warnings.push(format!(
            "not orientable, like a Möbius strip: its sides change at {edges}, vertices {}",
            list(&flipped.first, flipped.count, |[a, b]| format!("{a}–{b}"))
        ));
    }
    warnings.extend(intersections(&report.self_intersections));
    let thin = &report.thinnest_triangle;
    if thin.aspect > THIN {
        warnings.push(format!(
            "thin triangles, the thinnest {} {:.0} times as long as high; their light corners need short steps",
            triangle(&thin.vertices),
            thin.aspect
        ));
    }
    warnings
}

/// How many triangles meet where they should not, and the first of them.
fn intersections(found: &IntersectionReport) -> Option<String> {
    let count = |n: u64, one, many| (n > 0).then(|| counted(n as usize, one, many));
    let crossing = count(
        found.crossing,
        "pair of triangles passes through each other or touches",
        "pairs of triangles pass through each other or touch",
    );
    let folded = count(found.folded, "pair of neighbours is", "pairs of neighbours are");
    let folded = folded.map(|words| format!("{words} folded onto each other"));
    let all: Vec<String> = crossing.into_iter().chain(folded).collect();
    let [a, b] = found.first.first()?;
    let least = if found.complete { "" } else { "at least " };
    Some(format!("self-intersections: {least}{}; first {} and {}", all.join(", "), triangle(a), triangle(b)))
}

/// `(0, 1, 2)`.
pub fn triangle([a, b, c]: &[u32; 3]) -> String {
    format!("({a}, {b}, {c})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_in_centimetres_is_told_from_one_in_metres() {
        let scale = |extent| unit(extent).map(|hint| hint.scale);
        assert_eq!([0.16, 0.5, 1.8, 3.0, 4.0].map(scale), [None; 5]);
        assert_eq!(scale(180.0), Some(Some(0.01)));
        assert_eq!(scale(1800.0), Some(Some(0.001)));
        assert_eq!(scale(0.0018), Some(Some(1000.0)));
        assert_eq!([1e-6, 20.0, 1e5].map(scale), [Some(None); 3]);
        let hint = unit(180.0).unwrap().hint;
        assert!(
            hint.contains("if this is a garment or figure it is probably in centimetres: place.scale = 0.01")
        );
    }
}
