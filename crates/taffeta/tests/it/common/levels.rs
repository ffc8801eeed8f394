//! The same with other vector instructions: each level in a process of its own, for it is chosen once.

use std::process::Command;

/// What the ignored test `name` prints behind `hash|`, line by line, in a process told to use `level`.
pub fn printed_with(level: &str, name: &str) -> Vec<String> {
    let output = Command::new(std::env::current_exe().expect("a test is a program"))
        .args(["--ignored", "--exact", name, "--nocapture"])
        .env("TAFFETA_SIMD", level)
        .output()
        .expect("a test runs as a program");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines().filter_map(|line| Some(line.split_once("hash|")?.1.to_owned())).collect()
}

/// Levels beside the lowest, `sse2`. A machine without one takes the best that it has.
pub const OTHERS: [&str; 3] = ["avx2", "avx512", "best"];

/// Every level prints the same `count` lines in the ignored test `name`.
pub fn assert_same(name: &str, count: usize) {
    let plain = printed_with("sse2", name);
    assert_eq!(plain.len(), count, "{plain:?}");
    for level in OTHERS {
        assert_eq!(plain, printed_with(level, name), "{level}");
    }
}
