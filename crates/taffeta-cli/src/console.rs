//! Words to the user.

use serde::Serialize;
use taffeta::Simulation;
use taffeta_io::program::Failure;

pub use taffeta_io::program::{advised, not_built, say};

/// `value` as JSON, indented.
pub fn json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(|error| Failure::Work(format!("JSON: {error}")))
}

/// What is to be said before a scene runs.
pub fn warnings(simulation: &Simulation) -> impl Iterator<Item = String> {
    simulation.warnings().iter().map(|warning| advised(warning, &warning.advice))
}

/// `count` with commas between thousands.
pub fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 vertex`, `2,000 vertices`.
pub fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", grouped(count), if count == 1 { one } else { many })
}

/// The first few of `count` things, with commas between, and whether there are more.
pub fn list<T>(first: &[T], count: usize, word: impl Fn(&T) -> String) -> String {
    let words: Vec<String> = first.iter().map(word).collect();
    words.join(", ") + if count > first.len() { ", …" } else { "" }
}

/// What reading a mesh has to say: what was repaired, or what could not be.
pub fn repaired(repair: &str) -> String {
    let label = if repair.starts_with("not ") { "warning" } else { "repaired" };
    format!("{label}: {repair}")
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_are_grouped() {
        assert_eq!([0, 999, 1000, 7_820_856].map(super::grouped), ["0", "999", "1,000", "7,820,856"]);
    }
}
