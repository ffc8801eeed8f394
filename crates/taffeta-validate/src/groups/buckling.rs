//! A plate that stands on edge and buckles sideways.

use crate::bench::{Bench, Extent, Job, Row};
use crate::flat::Lattice;
use crate::flat::Pattern;
use crate::groups::Group;
use crate::specimen::{Case, GRAVITY, Plain, TURNS, body, clamped, head, pin, strip, tip};

pub const GROUP: Group = Group {
    name: "buckling",
    title: "Lateral buckling",
    words: "A plate is clamped along a short edge, in a vertical plane. Beyond a critical Γ* = ρ g L³/B it falls sideways. A bulge of \
            L/1000 that dies out or grows tenfold in 12 s tells the two apart; Γ* is found by bisection. The critical values of plate \
            theory depend on w/L and ν. Allowed are 5 %.",
    axes: ["w/L", "Γ*"],
    is_logarithmic: false,
    theory: Some(|| CRITICAL.iter().map(|&(width, at, _)| (width, at)).collect()),
    jobs,
};

const LENGTH: f64 = 0.2;
const DENSITY: f64 = 0.2;
/// w/L, and the critical Γ at ν = 0 and 0.3.
const CRITICAL: [(f64, f64, f64); 4] =
    [(0.1, 19.35, 15.67), (0.2, 20.64, 17.00), (0.5, 24.96, 21.60), (1.0, 32.52, 29.83)];
/// Bulge at the start, by length, and how many times larger it is where it grows.
const BULGE: f64 = 1e-3;
const GROWN: f64 = 10.0;

fn jobs(extent: Extent) -> Vec<Job> {
    let mut jobs = Vec::new();
    let meshes: Vec<(Pattern, f64)> = match extent {
        Extent::Quick => vec![(Pattern::Grid, 45.0)],
        Extent::Whole => {
            Pattern::ALL.into_iter().flat_map(|pattern| TURNS.map(|turn| (pattern, turn))).collect()
        }
    };
    for (width, plain, with_poisson) in CRITICAL {
        for (poisson, critical) in [(0.0, plain), (0.3, with_poisson)] {
            // Six elements across the narrowest.
            let elements = (6.0 / width).round().max(20.0) as usize;
            for &(pattern, turn) in &meshes {
                if extent == Extent::Quick && width != 0.5 {
                    continue;
                }
                let case = Case::new(pattern, turn, elements);
                let title = format!("w/L = {width}, ν = {poisson}, {}", case.variant("").mesh);
                jobs.push(Job::new(title, move |bench| run(bench, case, width, poisson, critical)));
            }
        }
    }
    jobs
}

fn run(bench: &Bench<'_>, case: Case, width: f64, poisson: f64, critical: f64) -> Result<Vec<Row>, String> {
    let (mut low, mut high) = (0.6 * critical, 1.6 * critical);
    while high / low > 1.01 {
        let middle = (low * high).sqrt();
        if grows(bench, case, width, poisson, middle)? { high = middle } else { low = middle }
    }
    let found = (low * high).sqrt();
    let variant = case.variant(&format!("buckling-{width}-{poisson}"));
    let row = Row::new(format!("Γ* at w/L = {width}, ν = {poisson}"), found, &variant).within(critical, 5.0);
    Ok(vec![if poisson == 0.0 { row.at(case.line(), width) } else { row }])
}

/// Whether a bulge grows at a load.
fn grows(bench: &Bench<'_>, case: Case, width: f64, poisson: f64, load: f64) -> Result<bool, String> {
    let variant = case.variant(&format!("buckling-{width}-{poisson}"));
    let lattice: Lattice = case.lattice(LENGTH);
    let flat = strip(LENGTH, width * LENGTH, lattice);
    let bulge = |[x, z]: [f64; 2]| [x, if x > 0.0 { BULGE * x * x / LENGTH } else { 0.0 }, z];
    bench.write(&format!("{}.obj", variant.name), &flat.placed(bulge))?;
    let fabric = Plain {
        density: DENSITY,
        // So stiff that the plate hardly sags in its plane.
        stretch: 200.0 * DENSITY * GRAVITY * LENGTH / (width * width).max(0.02),
        poisson,
        bending: DENSITY * GRAVITY * LENGTH.powi(3) / load,
        bending_poisson: poisson,
        damping: [1e-2, 1e-3],
    };
    let scene = head("A plate on edge", 0.02, case.solver, "")
        + &body(&variant, &fabric.toml())
        + "[body.place]\nrotation = { axis = [1.0, 0.0, 0.0], degrees = 90.0 }\n"
        + &pin(&clamped(&flat));
    let mut running = bench.start(&variant, &scene)?;
    let tip = tip(&flat, LENGTH);
    for _ in 0..24 {
        running.run_for(0.5)?;
        let places = running.positions();
        if tip.iter().any(|&node| places[node][2].abs() > GROWN * BULGE * LENGTH) {
            return Ok(true);
        }
    }
    Ok(false)
}
