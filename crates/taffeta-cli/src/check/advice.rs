//! What to make of a mesh: its unit, what may spoil a simulation, and a scene to begin with.

use super::report::{IntersectionReport, MeshReport, UnitHint};
use super::{Args, MeshKind};
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
    let ties = &report.bow_ties;
    if ties.count > 0 {
        let nodes = counted(ties.count, "point", "points");
        let vertices = list(&ties.first, ties.count, u32::to_string);
        warnings.push(format!(
            "{nodes} where parts only touch (vertices {vertices}); they turn there like joints"
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

/// A scene with this mesh; `None` for one that is refused as what it is to be.
pub fn scene(report: &MeshReport, args: &Args) -> Option<String> {
    let soft = match args.kind {
        Some(kind) => kind == MeshKind::Body,
        None => report.body.accepted,
    };
    if soft && !report.body.accepted {
        return None;
    }
    let name = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
    let body: String = name(args.path.file_stem()).chars().take(40).map(plain).collect();
    // A string of JSON is one of TOML.
    let file = serde_json::Value::from(name(args.path.file_name()));
    let scale = report.unit.as_ref().and_then(|unit| unit.scale);
    let mass = if soft { 1.0 } else { AREA_DENSITY * report.area * scale.unwrap_or(1.0).powi(2) };
    let stiffness = stiffness(mass / report.nodes as f64);
    let mut lines = vec![
        format!("[time]\nmax_step = {STEP}"),
        format!("[[body]]\nname = \"{body}\"\nkind = \"{}\"", if soft { "soft" } else { "cloth" }),
        if soft { format!("mass = {mass:.1}") } else { format!("area_density = {AREA_DENSITY}") },
        format!("mesh.file = {file}"),
    ];
    lines.extend(args.fill_holes.then(|| "fill_holes = true".to_owned()));
    lines.extend(scale.map(|scale| format!("place.scale = {scale}")));
    lines.push(format!("springs.structural = {{ k = {stiffness:?}, d = {:?} }}", stiffness * STEP));
    Some(lines.join("\n") + "\n")
}

/// Step of the scene [s].
const STEP: f64 = 0.0005;
/// Mass per area of the scene's cloth [kg/m²].
const AREA_DENSITY: f64 = 0.2;

/// A stiffness [N/m] of one digit at which a node of this mass [kg] with some twenty springs is stable at [`STEP`].
fn stiffness(mass: f64) -> f64 {
    let limit = 0.05 * mass / (STEP * STEP);
    let digit = 10_f64.powf(limit.log10().floor());
    // Through its digits, so that no rounding shows.
    format!("{:.0e}", (limit / digit).floor() * digit).parse().unwrap_or(limit)
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

    #[test]
    fn the_stiffness_has_one_digit() {
        assert_eq!([5.4e-4, 1e-6, 3.0].map(stiffness), [100.0, 0.2, 600000.0]);
    }
}
