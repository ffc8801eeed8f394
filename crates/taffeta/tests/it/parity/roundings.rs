//! Other roundings than the CPU's, which no row may take for a fault on hardware.

use super::faults::{chosen, sources};
use crate::common::gpu;
use taffeta::parity::rows;

/// What other devices may round otherwise: here by a unit in the last place, where they fuse or take a short way.
const ROUNDINGS: &[(&str, &str)] = &[
    ("return a.x * b.x + a.y * b.y + a.z * b.z;", "return 1.0000001 * (a.x * b.x + a.y * b.y + a.z * b.z);"),
    (
        "return vec3f(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);",
        "return 0.9999999 * (a.yzx * b.zxy) - 1.0000001 * (a.zxy * b.yzx);",
    ),
    ("return sqrt(dot3(a, a));", "return 1.0000001 * sqrt(dot3(a, a));"),
    ("let length = sqrt(squared);", "let length = 0.9999999 * sqrt(squared);"),
    ("let inverse = sqrt(inverse_squared);", "let inverse = 1.0000001 * sqrt(inverse_squared);"),
    (
        "let size = select(1.0, sqrt(area) * sqrt(speed), is_in_flow);",
        "let size = select(1.0, 1.0000001 * sqrt(area) * sqrt(speed), is_in_flow);",
    ),
    ("return sum * (1.0 / sqrt(squares));", "return sum * (1.0000001 / sqrt(squares));"),
    ("let inverse = 1.0 / squared;", "let inverse = 0.9999999 / squared;"),
    ("return x + h * new_velocity;", "return x + 1.0000001 * h * new_velocity;"),
    ("let t = num / select", "let t = 1.0000001 * num / select"),
    (
        "select(0.0, 1.0 - h / longest, h < longest)",
        "select(0.0, 1.0 - 0.9999999 * (h / longest), h < longest)",
    ),
];

#[test]
#[ignore = "all rows take a minute: `cargo xtask mutate`"]
fn what_hardware_may_round_otherwise_is_allowed_there() {
    let edit = |source: String| {
        let replace = |source: String, (written, rounded): &(&str, &str)| source.replace(written, rounded);
        ROUNDINGS.iter().fold(source, replace)
    };
    for row in chosen(rows()) {
        let outcome =
            row.run_edited(&gpu(), false, &edit).unwrap_or_else(|why| panic!("{}: {why}", row.name));
        let allowed = row.tolerance.hardware;
        println!("{}: {} ulps of {allowed}", row.name, outcome.ulps);
        let place = outcome.place;
        assert!(outcome.ulps <= allowed, "{}: {} ulps, {allowed} allowed: {place:?}", row.name, outcome.ulps);
    }
}

#[test]
fn what_is_rounded_is_in_the_sources() {
    let text = sources();
    for (written, _) in ROUNDINGS {
        assert!(text.contains(written), "`{written}` is in no source");
    }
}

/// Groups of leaves that are near more boxes than they can note have each leaf look alone.
#[test]
fn leaves_list_the_same_pairs_where_their_group_notes_few_boxes() {
    let edit = |source: String| source.replace("const FRONT: u32 = 1024u;", "const FRONT: u32 = 2u;");
    assert_ne!(edit(sources()), sources());
    let row = rows().into_iter().find(|row| row.name == "list_leaf_pairs").expect("a row");
    let outcome = row.run_edited(&gpu(), true, &edit).expect("it runs");
    assert_eq!(outcome.ulps, 0.0, "{:?}", outcome.place);
}
