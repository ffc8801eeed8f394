//! The scenes whose springs are solved for by nodes, by what physics says of them.

use crate::desk::{Desk, ending};
use std::path::Path;

/// Runs a scene of `scenes/` on the CPU, changed as by `--set`; returns what it printed.
fn run(name: &str, sets: &[&str]) -> (Desk, String) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
    let desk = Desk::with(&std::fs::read_to_string(file).unwrap());
    let mut command = desk.taffeta(&["run", "scene.toml", "--out", "o", "--backend", "cpu"]);
    command.args(sets.iter().flat_map(|set| ["--set", set]));
    let (out, err, code) = ending(command);
    assert_eq!(code, Some(0), "{err}");
    (desk, out)
}

/// A column of the table of frames.
fn column(desk: &Desk, name: &str) -> Vec<f64> {
    let table = std::fs::read_to_string(desk.path("o/frames.csv")).unwrap();
    let mut rows = table.lines().map(|line| line.split(','));
    let at = rows.next().unwrap().position(|title| title == name).unwrap();
    rows.map(|mut row| row.nth(at).unwrap().parse().unwrap()).collect()
}

fn most(column: &[f64]) -> f64 {
    column.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// z of all vertices, summed up [m], frame by frame.
fn sums_of_z(desk: &Desk, vertices: usize) -> Vec<f64> {
    let (_, length) = desk.npy("o/positions.npy");
    let bytes = std::fs::read(desk.path("o/positions.npy")).unwrap();
    let numbers = bytes[bytes.len() - length..].as_chunks().0;
    let of_frame = |frame: &[[u8; 4]]| {
        frame.iter().skip(2).step_by(3).map(|number| f64::from(f32::from_le_bytes(*number))).sum()
    };
    numbers.chunks(3 * vertices).map(of_frame).collect()
}

#[test]
fn a_sheet_of_structural_springs_alone_hangs_still_by_the_weight_below_each() {
    let (desk, out) = run("hanging_primal.toml", &[]);
    assert!(!out.contains("warning"), "{out}");
    let stretch = column(&desk, "max_stretch");
    assert!(most(&stretch) < 1.002, "{}", most(&stretch));
    // 33 rows of 0.01 kg hang from the first, by springs of 1/33 m and 1e5 N/m.
    let pull = 33.0 * 0.01 * 9.81;
    let expected = 1.0 + pull / (1e5 / 33.0);
    let last = stretch.last().unwrap();
    assert!((last - expected).abs() < 2e-6, "{last}, expected {expected}");
    let kinetic = column(&desk, "kinetic");
    assert!(kinetic.last().unwrap() < &1e-9, "it comes to rest: {:e} J", kinetic.last().unwrap());
    let energy = column(&desk, "energy");
    assert!(most(&energy) < energy[0] * (1.0 + 1e-7));
    // By springs, implicit along themselves alone, it does not hold.
    let (desk, out) = run("hanging_primal.toml", &["solver.ice.form=compliant", "time.frames=100"]);
    assert!(out.contains("ice.form = \"primal\""), "{out}");
    assert!(most(&column(&desk, "max_stretch")) > 2.0);
}

#[test]
fn a_stiff_flag_gains_no_more_than_wind_and_weight_give_it() {
    let (desk, out) = run("flag_primal.toml", &["time.frames=120"]);
    assert!(!out.contains("warning"), "{out}");
    let stretch = most(&column(&desk, "max_stretch"));
    assert!(stretch < 1.01, "{stretch}");
    // The wind of 1e-3 N a node is a potential.
    let energy = column(&desk, "energy");
    let blown = sums_of_z(&desk, 2400);
    let all: Vec<f64> = energy.iter().zip(&blown).map(|(energy, z)| energy - 1e-3 * z).collect();
    let given = all[0] - all.last().unwrap();
    assert!(most(&all) - all[0] < 0.02 * given, "{} J more than {} J", most(&all), all[0]);
    assert!(blown.last().unwrap() / 2400.0 > 0.05, "it is blown aside: {}", blown.last().unwrap() / 2400.0);
}

/// A blanket that falls on a bar.
const BLANKET: &str = r#"
[time]
max_step = 0.0166666667
frames = 50
[solver]
method = "ice"
ice.form = "primal"
[[body]]
name = "towel"
mesh.sheet = { size = [0.5, 1.0], edge = 0.02 }
place.position = [0.0, 1.0, 0.0]
material.preset = "blanket"
[[collider]]
capsule = { a = [-0.5, 0.9, 0.0], b = [0.5, 0.9, 0.0], radius = 0.02 }
friction = 0.6
"#;

#[test]
fn a_fabric_that_is_stretched_too_far_is_said_with_what_helps_and_that_helps() {
    let run = |sets: &[&str]| {
        let desk = Desk::with(BLANKET);
        let mut command = desk.taffeta(&["run", "scene.toml", "--out", "o", "--backend", "cpu"]);
        command.args(sets.iter().flat_map(|set| ["--set", set]));
        let (out, err, code) = ending(command);
        assert_eq!(code, Some(0), "{err}");
        (most(&column(&desk, "max_stretch")), out)
    };
    // Nothing keeps the blanket from passing through itself, which is said as well.
    let others =
        |out: &str| out.lines().any(|line| line.contains("warning") && !line.contains("passed through"));
    let one = "solver.ice.newton_steps=1";
    let (stretch, out) = run(&[one]);
    assert!(stretch > 1.5 && out.contains("one Newton step in a sub-step of 1.7e-2 s"), "{stretch}: {out}");
    for advice in ["solver.ice.newton_steps=0", "time.max_step=0.004"] {
        assert!(out.contains(&advice.replace('=', " = ")), "{out}");
        let (stretch, out) = run(&[one, advice]);
        assert!(stretch < 1.5 && !others(&out), "{advice}: {stretch}: {out}");
    }
    let (stretch, _) = run(&[]);
    assert!(stretch < 1.5, "as many as are needed are the default: {stretch}");
}
