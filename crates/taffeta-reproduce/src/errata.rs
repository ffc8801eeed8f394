//! What is wrong in the papers, each with a small experiment that shows it.

use crate::page::Section;

/// All of them.
pub fn section() -> Section {
    Section::new("Errata")
}
