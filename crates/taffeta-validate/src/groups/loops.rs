//! The heart loop.

use crate::bench::{Bench, Extent, Job, Rest, Row};
use crate::flat::Flat;
use crate::groups::Group;
use crate::specimen::{Case, Plain, body, cases, head, nodes};
use std::fmt::Write;

pub const GROUP: Group = Group {
    name: "loops",
    title: "Heart loop",
    words: "Both ends of a strip without weight are brought together, pointing upwards: it forms a heart. Its depth below the clamp is \
            0.1339 of its length, and its width 0.3259 (Peirce 1930; here by shooting along the elastica). Allowed are 2 % at 40 \
            elements a length, and 1 % at 80.",
    axes: ["elements a length", "depth/length"],
    is_logarithmic: false,
    theory: Some(|| vec![(20.0, DEPTH), (80.0, DEPTH)]),
    jobs,
};

const LENGTH: f64 = 0.2;
const WIDTH: f64 = 0.04;
/// Depth and width of the loop, by the length of the strip.
const DEPTH: f64 = 0.133_860;
const SPAN: f64 = 0.325_933;
/// Time in which the ends are brought together [s].
const TIME: f64 = 4.0;

fn jobs(extent: Extent) -> Vec<Job> {
    let job = |case: Case| Job::of(case, move |bench| run(bench, case));
    let cases = cases(extent, [20, 40, 80]);
    cases.into_iter().filter(|case| case.solver.is_implicit && !case.solver.on_gpu).map(job).collect()
}

fn run(bench: &Bench<'_>, case: Case) -> Result<Vec<Row>, String> {
    let variant = case.variant("heart");
    let lattice = case.lattice(LENGTH);
    let (half, behind) = (0.5 * LENGTH, 2.0 * lattice.edge);
    let mesh = Flat::rectangle(
        [-half - behind, -0.5 * WIDTH],
        [half + behind, 0.5 * WIDTH],
        &[-half, half],
        lattice,
    );
    bench.write(&format!("{}.obj", variant.name), &mesh.obj())?;
    let fabric = Plain {
        density: 0.1,
        stretch: 100.0,
        poisson: 0.0,
        bending: 1e-4,
        bending_poisson: 0.0,
        damping: [1e-4, 1e-2],
    };
    let ends = [mesh.select(|[x, _]| x < 1e-9 - half), mesh.select(|[x, _]| x > half - 1e-9)];
    let mut scene = head("A heart loop", 0.02, case.solver, "gravity = [0.0, 0.0, 0.0]")
        + &body(&variant, &fabric.toml());
    for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
        scene += &format!("[[body.pin]]\nselect = {}\n", nodes(end));
        scene += &closing(sign);
    }
    let mut running = bench.start(&variant, &scene)?;
    running.run_for(TIME)?;
    let rested = running.settle(Rest { moves: 1e-4 * LENGTH, window: 0.5, longest: 12.0 })?;
    let places = running.positions();
    let lowest = places.iter().map(|place| place[1]).fold(f64::INFINITY, f64::min);
    let across = |sign: f64| places.iter().map(|place| sign * place[0]).fold(f64::NEG_INFINITY, f64::max);
    let (allowed, note) = (80.0 / case.elements as f64, if rested { "" } else { "still moves" });
    let row = |what: &str, found: f64| Row::new(what, found, &variant).noting(note);
    let depth = row("depth/length", -lowest / LENGTH).at(case.line(), case.elements as f64);
    Ok(vec![
        depth.within(DEPTH, allowed),
        row("width/length", (across(1.0) + across(-1.0)) / LENGTH).within(SPAN, allowed),
    ])
}

/// Keyframes that turn an end by three quarters of a turn and bring it to the middle, along circular arcs as long as they are open.
fn closing(sign: f64) -> String {
    const KEYS: usize = 18;
    let mut text = String::new();
    for key in 1..=KEYS {
        let turned = 270_f64 * key as f64 / KEYS as f64;
        let angle = turned.to_radians();
        // Half the chord of an arc whose ends have turned by this angle.
        let half_chord = (0.5 * LENGTH / angle * angle.sin()).max(0.0);
        let half_chord = if turned > 180.0 { 0.0 } else { half_chord };
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "[[body.pin.motion]]\nt = {:?}\ntranslate = [{:?}, 0.0, 0.0]\nrotate = {{ axis = [0.0, 0.0, 1.0], degrees = {:?} }}\n\
             pivot = [{:?}, 0.0, 0.0]\n",
            TIME * key as f64 / KEYS as f64,
            sign * (half_chord - 0.5 * LENGTH),
            sign * turned,
            sign * 0.5 * LENGTH
        );
    }
    text
}
