//! The same cloth on other meshes, with other steps and by another solver.

use crate::bench::{Bench, Extent, Job, Rest, Row, Solver, Variant, distance};
use crate::flat::Pattern;
use crate::groups::Group;
use crate::specimen::{Case, GRAVITY, Plain, head};

pub const GROUP: Group = Group {
    name: "independence",
    title: "Independence of mesh, step and solver",
    words: "A square of 20 cm is clamped at the middle half of one edge and droops like a leaf. Where its nodes come to rest on 20, 40 \
            and 80 cells a side, with frames of 1/50, 1/100 and 1/200 s, implicitly and explicitly, on the CPU and on a GPU, is \
            held against 80 cells: the mean distance may be 1 % of its size.",
    axes: ["cells a side", "mean distance by size [%]"],
    is_logarithmic: false,
    theory: None,
    jobs,
};

const SIDE: f64 = 0.2;
/// Mass per area [kg/m²], and ρ g L³/B.
const DENSITY: f64 = 0.2;
const LOAD: f64 = 10.0;
/// Largest mean distance [% of the side].
const ALLOWED: f64 = 1.0;

fn jobs(extent: Extent) -> Vec<Job> {
    vec![Job::new("a leaf", move |bench| {
        let finest = if extent == Extent::Quick { 40 } else { 80 };
        let reference = hang(bench, finest, 0.02, Solver::IMPLICIT)?;
        let mut rows = Vec::new();
        let mut compare = |cells: usize, dt: f64, solver: Solver| -> Result<(), String> {
            let found = hang(bench, cells, dt, solver)?;
            let apart = apart(&reference, &found);
            let row = Row::new(
                format!("mean distance from {finest} cells, frames of {dt} s [% of the side]"),
                apart,
                &found.variant,
            );
            let row =
                if dt == 0.02 && solver == Solver::IMPLICIT { row.at("implicit", cells as f64) } else { row };
            rows.push(row.near(0.0, ALLOWED, "%"));
            Ok(())
        };
        compare(20, 0.02, Solver::IMPLICIT)?;
        compare(20, 0.01, Solver::IMPLICIT)?;
        if extent == Extent::Whole {
            compare(40, 0.02, Solver::IMPLICIT)?;
            compare(40, 0.01, Solver::IMPLICIT)?;
            compare(40, 0.005, Solver::IMPLICIT)?;
            compare(40, 0.02, Solver::DOUBLE)?;
            compare(20, 0.005, Solver::IMPLICIT)?;
        }
        compare(20, 0.02, Solver::EXPLICIT)?;
        if bench.gpu.is_some() {
            compare(20, 0.02, Solver::GPU)?;
        }
        Ok(rows)
    })]
}

/// A cloth at rest.
struct Hung {
    cells: usize,
    places: Vec<[f64; 3]>,
    variant: Variant,
}

fn hang(bench: &Bench<'_>, cells: usize, dt: f64, solver: Solver) -> Result<Hung, String> {
    let case = Case::new(Pattern::Grid, 0.0, cells).by(solver);
    let variant = case.variant(&format!("independence-{dt}"));
    let half = 0.5 * SIDE;
    let nodes = (cells + 1) * (cells + 1);
    let fabric = Plain {
        density: DENSITY,
        stretch: 300.0,
        poisson: 0.2,
        bending: DENSITY * GRAVITY * SIDE.powi(3) / LOAD,
        bending_poisson: 0.2,
        damping: solver.damping(),
    };
    let drag = if solver.is_implicit { 0.0 } else { 7.0 * DENSITY * SIDE * SIDE / nodes as f64 };
    let scene = head("A leaf", dt, solver, &format!("drag = {drag:?}"))
        + &format!(
            "[[body]]\nname = \"cloth\"\nmesh.grid = {{ rows = {0}, cols = {0}, size = [{SIDE:?}, {SIDE:?}] }}\n{1}[[body.pin]]\n\
             select = {{ box = {{ min = [{2:?}, -1.0, {3:?}], max = [{4:?}, 1.0, {5:?}] }} }}\n",
            cells + 1,
            fabric.toml(),
            -0.5 * half - 1e-6,
            -half - 1e-6,
            0.5 * half + 1e-6,
            // Two rows of the coarsest mesh.
            -half + SIDE / 20.0 + 1e-6
        );
    let mut running = bench.start(&variant, &scene)?;
    running.settle(Rest { moves: 1e-4 * SIDE, window: 0.5, longest: 20.0 })?;
    Ok(Hung { cells, places: running.positions(), variant })
}

/// Mean distance of the nodes that both have [% of the side].
fn apart(fine: &Hung, coarse: &Hung) -> f64 {
    let cells = coarse.cells.min(fine.cells).min(20);
    let at = |hung: &Hung, row: usize, column: usize| {
        let step = hung.cells / cells;
        hung.places[row * step * (hung.cells + 1) + column * step]
    };
    let mut sum = 0.0;
    for row in 0..=cells {
        for column in 0..=cells {
            sum += distance(at(fine, row, column), at(coarse, row, column));
        }
    }
    100.0 * sum / ((cells + 1) * (cells + 1)) as f64 / SIDE
}
