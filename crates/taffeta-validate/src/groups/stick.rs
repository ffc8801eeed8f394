//! A strip that is pressed onto a plane tip down: it sticks or slips.

use crate::bench::{Bench, Extent, Job, Row, Variant};
use crate::groups::Group;
use crate::specimen::{Case, Plain, body, cases, head, nodes, strip, tip};

pub const GROUP: Group = Group {
    name: "stick",
    title: "Stick and slip",
    words: "A strip with next to no weight (Γ = 0.008), clamped upright at its upper end, is pressed onto a plane until its \
            height is H, of a length L. By the \
            elastica (θ″ = −P sin θ + Q cos θ, θ(0) = 0, θ′(1) = 0, ∫ sin θ = 0, ∫ cos θ = H/L) the tip sticks where it touched as long \
            as Coulomb's μ is at least μ* = Q/P. With 1.1 μ* it must not move by 0.002 L, and with 0.9 μ* it must. Below H/L = 0.67 the \
            elastica dips below the height of its tip: there the plane is a ledge that ends 0.005 L beside it. Which nodes stick is \
            decided once in a sub-step, from what pulled in the last one; so tips may creep below the limit, and rows that fail say \
            how far.",
    axes: ["H/L", "way of the tip/L"],
    is_logarithmic: false,
    theory: None,
    jobs,
};

const LENGTH: f64 = 0.2;
const WIDTH: f64 = 0.04;
/// H/L, and the least friction that holds the tip.
const HELD: [(f64, f64); 4] = [(0.95, 0.1035), (0.9, 0.1528), (0.8, 0.2378), (0.6, 0.4344)];
/// Time in which the clamp comes down [s].
const TIME: f64 = 6.0;
/// Time by which the strip stands on its tip [s].
const STANDS: f64 = 0.5;
/// Longest sub-step [s]: friction is decided once in each.
const STEP: f64 = 0.005;
/// What tells a tip that slips from one that sticks, by length.
const SLIPS: f64 = 2e-3;
/// Drag on the whole strip [kg/s], so that it does not swing.
const DRAG: f64 = 0.02;
/// H/L below which the elastica dips below its tip.
const DIPS: f64 = 0.67;
/// How far beside the tip the plane ends, by length, on the side to which the strip bows.
const LEDGE: f64 = 5e-3;
/// Greatest height of the bow at the start, by length.
const BOW: f64 = 0.02;

fn jobs(extent: Extent) -> Vec<Job> {
    let job = |case: Case| {
        Job::of(case, move |bench| {
            let mut rows = Vec::new();
            // A quick run takes one height.
            let held = if extent == Extent::Quick { &HELD[2..3] } else { &HELD[..] };
            for &(height, friction) in held {
                for factor in [0.9, 1.1] {
                    rows.push(run(bench, case, height, friction, factor)?);
                }
            }
            Ok(rows)
        })
    };
    cases(extent, [10, 20, 40])
        .into_iter()
        .filter(|case| case.solver.is_implicit && !case.solver.on_gpu)
        .map(job)
        .collect()
}

fn run(bench: &Bench<'_>, case: Case, height: f64, friction: f64, factor: f64) -> Result<Row, String> {
    let variant: Variant = case.variant(&format!("stick-{height}-{factor}"));
    let flat = strip(LENGTH, WIDTH, case.lattice(LENGTH));
    bench.write(&format!("{}.obj", variant.name), &flat.placed(bowed))?;
    let fabric = Plain {
        density: 0.1,
        stretch: 100.0,
        poisson: 0.0,
        bending: 1e-4,
        bending_poisson: 0.0,
        damping: [1e-4, 1e-2],
    };
    let held = flat.select(|[x, _]| x < 1e-9);
    let offset = 1e-4;
    let scene = head(
        "A strip that is pressed onto a plane",
        0.02,
        case.solver,
        &format!("gravity = [0.0, -1e-3, 0.0]\ndrag = {:?}", DRAG / flat.nodes.len() as f64),
    ) + &body(&variant, &fabric.toml())
        + &format!(
            "[body.place]\nposition = [0.0, {:?}, 0.0]\nrotation = {{ axis = [0.0, 0.0, 1.0], degrees = -90.0 }}\n",
            offset + bowed([LENGTH, 0.0])[0]
        )
        + &format!(
            "[[body.pin]]\nselect = {}\n[[body.pin.motion]]\nt = {TIME:?}\ntranslate = [0.0, {:?}, 0.0]\n",
            nodes(&held),
            (height - 1.0) * LENGTH
        )
        + &format!(
            "[[collider]]\n{}\noffset = {offset:?}\nfriction = {:?}\n",
            floor(height),
            factor * friction
        );
    let scene = scene.replacen("[time]\n", &format!("[time]\nmax_step = {STEP:?}\n"), 1);
    let mut running = bench.start(&variant, &scene)?;
    let tip = tip(&flat, LENGTH);
    running.run_for(STANDS)?;
    let start = running.positions();
    running.run_for(TIME - STANDS + 1.0)?;
    let now = running.positions();
    let way = tip.iter().map(|&node| (now[node][0] - start[node][0]).abs()).fold(0.0, f64::max) / LENGTH;
    let what = if factor > 1.0 { "sticks" } else { "slips" };
    let row = Row::new(format!("way of the tip/L at H/L = {height}, {factor} μ*: {what}"), way, &variant);
    let row = row.at(format!("{factor} μ*"), height);
    Ok(if factor > 1.0 {
        Row { error: Some(way), allowed: Some(SLIPS), unit: "L".into(), ..row }
    } else {
        // Fails where it does not move as far.
        Row { error: Some((SLIPS - way).max(0.0)), allowed: Some(0.0), unit: "L".into(), ..row }
    })
}

/// What the strip stands on.
fn floor(height: f64) -> String {
    if height > DIPS {
        return "plane = { point = [0.0, 0.0, 0.0] }".into();
    }
    format!("box = {{ center = [{:?}, -0.5, 0.0], half = [0.5, 0.5, 0.5] }}", LEDGE * LENGTH - 0.5)
}

/// Where a place of the strip is at the start: it has a slight bow, so that it need not snap into one when it is pressed.
fn bowed([along, across]: [f64; 2]) -> [f64; 3] {
    const STEPS: usize = 200;
    // The height is a cubic with a level start; the way along is what its slope leaves of the strip's length.
    let slope = |u: f64| BOW * 6.75 * u * (2.0 - 3.0 * u);
    let way: f64 = (0..STEPS)
        .map(|step| slope(along / LENGTH * (step as f64 + 0.5) / STEPS as f64))
        .map(|slope| (1.0 - slope * slope).sqrt() / STEPS as f64)
        .sum();
    let u = along / LENGTH;
    if along > 0.0 {
        [along * way, LENGTH * BOW * 6.75 * u * u * (1.0 - u), across]
    } else {
        [along, 0.0, across]
    }
}
