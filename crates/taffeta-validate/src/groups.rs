//! The groups of tests.

mod buckling;
mod cantilever;
mod drape;
mod independence;
mod loops;
mod pulls;
mod springs;
mod stick;

use crate::bench::{Extent, Job};

/// The points of a line.
pub type Curve = fn() -> Vec<(f64, f64)>;

/// Tests that are described and plotted together.
pub struct Group {
    /// What it is called on the command line.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What is tested, with its source.
    pub words: &'static str,
    /// Names of the axes of its plot.
    pub axes: [&'static str; 2],
    /// Whether both axes of its plot are logarithmic.
    pub is_logarithmic: bool,
    /// The line of theory in its plot.
    pub theory: Option<Curve>,
    /// Its work.
    pub jobs: fn(Extent) -> Vec<Job>,
}

/// All groups, in the order of the report.
pub const GROUPS: &[Group] = &[
    cantilever::GROUP,
    buckling::GROUP,
    stick::GROUP,
    loops::GROUP,
    pulls::GROUP,
    drape::GROUP,
    independence::GROUP,
    springs::GROUP,
];
