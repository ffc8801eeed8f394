//! Springs of S1's scenes, as `--set` takes them; and what several of its tables share.

use crate::runs::job::Quick;

/// All springs of a body: some kinds of one stiffness `k` [N/m] and damping `d` [kg/s].
pub fn of(body: &str, kinds: &[&str], k: f64, d: f64) -> String {
    let each: Vec<String> = kinds.iter().map(|kind| format!("{kind}={{k={k},d={d}}}")).collect();
    format!("body.{body}.springs={{{}}}", each.join(","))
}

/// All springs of the cloth: some kinds of one stiffness [N/m].
pub fn cloth(kinds: &[&str], k: f64) -> String {
    of("cloth", kinds, k, 0.1)
}

/// Kinds of springs, and those without bending.
pub const ALL: [&str; 3] = ["structural", "shear", "bend"];
pub const TWO: [&str; 2] = ["structural", "shear"];

/// Frames of behaviour that a quick look takes.
pub const LOOK: Quick = Quick::Frames(60);

/// Threads of the machine, and one.
pub fn on_threads(name: &str, single: bool) -> String {
    if single { format!("{name}-1t") } else { name.to_owned() }
}

/// Beside kernels of theirs.
pub const NEARLY: &str = "nearly: their kernels written again, without drawing, another GPU";
