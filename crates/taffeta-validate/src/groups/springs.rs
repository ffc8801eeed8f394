//! The springs of the papers: chains, pendulums, friction, volumes.

use crate::bench::{Bench, Extent, Job, Rest, Row, Solver, Variant};
use crate::groups::Group;
use crate::specimen::GRAVITY;
use std::f64::consts::PI;

pub const GROUP: Group = Group {
    name: "springs",
    title: "Springs of the papers",
    words: "A chain hangs in its elastic catenary (ends of the same height, 60 links). A pendulum of one stiff link, let go level, has the \
            period 2.3678 s of a length of 1 m. A patch of cloth sticks on a slope of 20° with μ = 0.5, and slides with \
            g (sin 20° − μ cos 20°) with 0.2. A hollow ball keeps its volume within 0.1 % as it falls.",
    axes: ["", ""],
    is_logarithmic: false,
    theory: None,
    jobs: |_: Extent| {
        vec![
            Job::new("catenary", catenary),
            Job::new("pendulum", pendulum),
            Job::new("friction", friction),
            Job::new("volume", volume),
        ]
    },
};

fn variant(name: &str, mesh: &str) -> Variant {
    Variant {
        name: format!("springs-{name}"),
        mesh: mesh.into(),
        solver: Solver { is_double: true, ..Solver::EXPLICIT },
    }
}

/// Sag of a chain between two ends.
fn catenary(bench: &Bench<'_>) -> Result<Vec<Row>, String> {
    let (links, length, k, node_mass, span) = (60, 2.0, 2000.0, 0.005, 1.3);
    let variant = variant("catenary", "60 links");
    let scene = format!(
        "title = \"A chain between two ends\"\n[time]\ndt = 0.02\nmax_step = 5e-4\n[world]\ndrag = 0.01\n[[body]]\nname = \"chain\"\n\
         node_mass = {node_mass:?}\nmesh.chain = {{ links = {links}, length = {length:?} }}\n[body.springs]\nstructural = {{ k = {k:?}, \
         d = 0.05 }}\n[[body.pin]]\nselect = {{ nodes = [0] }}\n[[body.pin.motion]]\nt = 1.0\ntranslate = [{0:?}, 0.0, 0.0]\n\
         [[body.pin]]\nselect = {{ nodes = [{links}] }}\n[[body.pin.motion]]\nt = 1.0\ntranslate = [-{0:?}, 0.0, 0.0]\n",
        0.5 * (length - span)
    );
    let mut running = bench.run(&variant, &scene)?;
    running.settle(Rest { moves: 1e-6, window: 1.0, longest: 30.0 })?;
    let sag = -running.positions()[links / 2][1];
    // An elastic chain of mass per length w/g: x(s) = (H/w) asinh(w s/H) + H s/EA, y(s) = (√(H² + w² s²) − H)/w + w s²/(2 EA).
    let (weight, stiffness) = (node_mass * GRAVITY * links as f64 / length, k * length / links as f64);
    let half = 0.5 * length;
    let reach = |pull: f64| pull / weight * (weight * half / pull).asinh() + pull * half / stiffness;
    let (mut low, mut high) = (1e-6, 1e3);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if reach(middle) > 0.5 * span { high = middle } else { low = middle }
    }
    let pull = 0.5 * (low + high);
    let expected = ((pull * pull + weight * weight * half * half).sqrt() - pull) / weight
        + weight * half * half / (2.0 * stiffness);
    Ok(vec![Row::new("sag of a chain [m]", sag, &variant).within(expected, 0.2)])
}

/// Period of a pendulum that is let go level.
fn pendulum(bench: &Bench<'_>) -> Result<Vec<Row>, String> {
    let variant = variant("pendulum", "1 link");
    let dt = 1e-3;
    let scene = format!(
        "title = \"A pendulum\"\n[time]\ndt = {dt:?}\nmax_step = 1e-4\n[[body]]\nname = \"pendulum\"\nnode_mass = 1.0\n\
         mesh.chain = {{ links = 1, length = 1.0 }}\n[body.springs]\nstructural = {{ k = 1e6, d = 100.0 }}\n[[body.pin]]\n\
         select = {{ nodes = [0] }}\n"
    );
    let mut running = bench.run(&variant, &scene)?;
    // From node 1 at the right it is below node 0 after a quarter and after three quarters of its period.
    let (mut crossings, mut time, mut before) = (Vec::new(), 0.0, 1.0);
    while crossings.len() < 2 && time < 4.0 {
        running.step()?;
        time += dt;
        let places = running.positions();
        let now = places[1][0] - places[0][0];
        if (now > 0.0) != (before > 0.0) {
            crossings.push(time - dt * now / (now - before));
        }
        before = now;
    }
    let [first, second] = crossings[..] else { return Err("the pendulum does not swing".into()) };
    // T = 2 π √(L/g)/AGM(1, cos 45°) for an amplitude of 90°.
    let (mut a, mut b) = (1.0, (0.25 * PI).cos());
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    let expected = 2.0 * PI / (a * GRAVITY.sqrt());
    Ok(vec![Row::new("period from 90° [s]", 2.0 * (second - first), &variant).within(expected, 0.1)])
}

/// A patch on a slope.
fn friction(bench: &Bench<'_>) -> Result<Vec<Row>, String> {
    let slope = 20_f64.to_radians();
    let mut rows = Vec::new();
    for coefficient in [0.5, 0.2] {
        let variant = variant(&format!("friction-{coefficient}"), "grid, 9 cells");
        let scene = format!(
            "title = \"A patch on a slope\"\n[time]\ndt = 0.01\nmax_step = 5e-4\n[[body]]\nname = \"patch\"\nnode_mass = 5e-4\n\
             mesh.grid = {{ rows = 10, cols = 10, size = [0.2, 0.2] }}\n[body.place]\nposition = [{:?}, {:?}, 0.0]\n\
             rotation = {{ axis = [0.0, 0.0, 1.0], degrees = 20.0 }}\n[body.springs]\nstructural = {{ k = 100.0, d = 0.005 }}\n\
             shear = {{ k = 50.0, d = 0.005 }}\n[[collider]]\nplane = {{ normal = [{:?}, {:?}, 0.0] }}\noffset = 0.01\n\
             friction = {coefficient:?}\n",
            -0.01 * slope.sin(),
            0.01 * slope.cos(),
            -slope.sin(),
            slope.cos()
        );
        let mut running = bench.run(&variant, &scene)?;
        let along = |places: &[[f64; 3]]| {
            let sum =
                places.iter().map(|place| -place[0] * slope.cos() - place[1] * slope.sin()).sum::<f64>();
            sum / places.len() as f64
        };
        let start = along(&running.positions());
        running.run_for(1.0)?;
        let way = along(&running.positions()) - start;
        let row = Row::new(format!("way down a slope in 1 s, μ = {coefficient} [m]"), way, &variant);
        rows.push(if coefficient > 0.3 {
            row.near(0.0, 1e-6, "m")
        } else {
            row.within(0.5 * GRAVITY * (slope.sin() - coefficient * slope.cos()), 0.2)
        });
    }
    Ok(rows)
}

/// A hollow ball that falls on the floor.
fn volume(bench: &Bench<'_>) -> Result<Vec<Row>, String> {
    let variant = variant("volume", "icosphere, 642 nodes");
    let scene = "title = \"A ball that keeps its volume\"\n[time]\nmax_step = 5e-4\n[[body]]\nname = \"ball\"\nkind = \"soft\"\n\
                 node_mass = 1.0\nmesh.icosphere = { radius = 1.0, subdivisions = 3 }\n[body.place]\nposition = [0.0, 1.5, 0.0]\n\
                 [body.springs]\nstructural = { k = 1000.0, d = 100.0 }\n[body.volume]\nform = \"corrected\"\n[[collider]]\n\
                 plane = { point = [0.0, 0.0, 0.0] }\nfriction = 0.3\n";
    let mut running = bench.run(&variant, scene)?;
    let rest = running.simulation.bodies()[0].rest_volume.ok_or("the ball is not closed")?;
    let mut worst = 0.0_f64;
    for _ in 0..240 {
        running.step()?;
        let volume = running.simulation.report().volumes[0].unwrap_or(f64::NAN);
        worst = worst.max(100.0 * (volume / rest - 1.0).abs());
    }
    Ok(vec![Row::new("largest error of the volume in a fall [%]", worst, &variant).near(0.0, 0.1, "%")])
}
