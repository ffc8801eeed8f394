//! How many springs S1's sheets have.

use super::springs::{self, ALL, TWO};
use crate::report::look::{Look, grouped};
use crate::report::page::Section;
use crate::report::table::{Cell, Table};
use crate::runs::behaviour::Scene;
use crate::runs::job::{Job, Quick, What};

/// The sheets of the table of springs: rows, columns, kinds, what S1 prints, and what to say of it.
const COUNTED: [(&str, u32, &[&str], u32, &str); 4] = [
    ("s1-count-32", 32, &ALL, 5826, "fig. 10"),
    ("s1-count-34", 34, &ALL, 6598, "fig. 9"),
    (
        "s1-count-32-two",
        32,
        &TWO,
        3906,
        "fig. 9: S1 calls it the same model as that of 1,156 nodes; it has 1,024",
    ),
    ("s1-count-38-two", 38, &TWO, 5550, "fig. 9: S1 says 1,440 nodes; 38² is 1,444"),
];

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut jobs = Vec::new();
    for (name, side, kinds, ..) in COUNTED {
        let sets = vec![
            format!("body.cloth.mesh.grid.rows={side}"),
            format!("body.cloth.mesh.grid.cols={side}"),
            springs::cloth(kinds, 200.0),
        ];
        let scene = Scene { name: "s1_fig15", sets, threads: None, pictured: false };
        jobs.push(Job { name: name.to_owned(), what: What::Counts(scene), gpu: false, quick: Quick::Whole });
    }
    jobs
}

/// What came out.
pub fn section(look: &Look) -> Section {
    let columns = ["sheet", "nodes", "structural", "shear", "bend", "springs", "S1", "where"];
    let mut table = Table::new(
        "s1-springs",
        "Springs of a sheet of R × C nodes: structural R(C−1) + C(R−1), shear \
        2(R−1)(C−1), bend R(C−2) + C(R−2).",
        &columns,
    );
    for (name, side, _, published, place) in COUNTED {
        let kind = |kind: &'static str| {
            look.cell(name, move |value| Some(value["kinds"][kind].as_u64().unwrap_or(0).to_string()))
        };
        table.row(vec![
            Cell::words(format!("{side} × {side}")),
            look.count(name, "nodes"),
            kind("structural"),
            kind("shear"),
            kind("bend"),
            look.count(name, "springs"),
            Cell::Theirs(grouped(published.into())),
            Cell::words(place),
        ]);
    }
    Section::new("S1: numbers of springs").table(table)
}
