//! A strip that is clamped level at one end.

use crate::bench::{Bench, Extent, Job, Rest, Row};
use crate::groups::Group;
use crate::specimen::{Case, GRAVITY, Plain, body, cases, clamped, head, mean, pin, strip, tip};
use crate::theory;

pub const GROUP: Group = Group {
    name: "cantilever",
    title: "Cantilever",
    words: "A strip of 20 × 5 cm is clamped level at one end and hangs down by its weight. Drop by reach of its free end, against \
            the elastica θ″ = −Γ (1 − s) cos θ with Γ = ρ g L³/B. Allowed are 2 % at 20 elements a length, 1 % at 40, 4 % at 10. At \
            Γ = 8.0042 the chord is 41.5° below the level, which is the reading of ASTM D1388 (Peirce 1930, whose formula \
            B = ρ g L³ cos ½θ/(8 tan θ) takes 7.569: 5.4 % low).",
    axes: ["Γ", "drop/reach"],
    is_logarithmic: true,
    theory: Some(|| {
        let loads = (0..=60).map(|i| 10_f64.powf(f64::from(i) * 1.75 / 60.0));
        loads.map(|load| (load, theory::drop_by_reach(load))).collect()
    }),
    jobs,
};

/// Length and width [m] of the strip.
const LENGTH: f64 = 0.2;
const WIDTH: f64 = 0.05;
/// Mass per area [kg/m²].
const DENSITY: f64 = 0.2;
const LOADS: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];

fn jobs(extent: Extent) -> Vec<Job> {
    let job = |case: Case| {
        let loads = match extent {
            Extent::Quick => vec![5.0],
            Extent::Whole => LOADS.to_vec(),
        };
        Job::of(case, move |bench| {
            let mut rows = Vec::new();
            for &load in &loads {
                rows.push(at_load(bench, case, load)?);
            }
            rows.push(peirce(bench, case)?);
            Ok(rows)
        })
    };
    cases(extent, [10, 20, 40]).into_iter().map(job).collect()
}

/// The drop by reach of a load.
fn at_load(bench: &Bench<'_>, case: Case, load: f64) -> Result<Row, String> {
    let name = format!("cantilever-{load}");
    let (found, note) = hang(bench, case, &name, load)?;
    let row = Row::new(format!("drop/reach at Γ = {load}"), found, &case.variant(&name));
    let allowed = 40.0 / case.elements as f64;
    let row = row.within(theory::drop_by_reach(load), allowed).noting(note);
    // In the plot are the meshes that users would take.
    Ok(if case.elements == 20 { row.at(case.line(), load) } else { row })
}

/// The angle of the chord that a tester reads off.
fn peirce(bench: &Bench<'_>, case: Case) -> Result<Row, String> {
    let (found, note) = hang(bench, case, "peirce", theory::PEIRCE)?;
    let row = Row::new(
        "chord below the level at Γ = 8.0042 [°]",
        found.atan().to_degrees(),
        &case.variant("peirce"),
    );
    Ok(row.within(41.5, 40.0 / case.elements as f64).noting(note))
}

/// Lets a strip hang, and says its drop by reach and whether it came to rest.
fn hang(bench: &Bench<'_>, case: Case, name: &str, load: f64) -> Result<(f64, &'static str), String> {
    let variant = case.variant(name);
    let mesh = strip(LENGTH, WIDTH, case.lattice(LENGTH));
    bench.write(&format!("{}.obj", variant.name), &mesh.obj())?;
    let fabric = Plain {
        density: DENSITY,
        stretch: 300.0,
        poisson: 0.0,
        bending: DENSITY * GRAVITY * LENGTH.powi(3) / load,
        bending_poisson: 0.0,
        damping: case.solver.damping(),
    };
    // As much as lets a swing die within some periods.
    let node_mass = DENSITY * LENGTH * WIDTH / mesh.nodes.len() as f64;
    let drag = format!("drag = {:?}", if case.solver.is_implicit { 0.0 } else { 14.0 * node_mass });
    let scene = head("A strip, clamped level at one end", 0.02, case.solver, &drag)
        + &body(&variant, &fabric.toml())
        + &pin(&clamped(&mesh));
    let mut running = bench.start(&variant, &scene)?;
    let rested = running.settle(Rest { moves: 1e-4 * LENGTH, window: 0.5, longest: 20.0 })?;
    let (places, tip) = (running.positions(), tip(&mesh, LENGTH));
    let found = -mean(&places, &tip, 1) / mean(&places, &tip, 0);
    Ok((found, if rested { "" } else { "still moves after 20 s" }))
}
