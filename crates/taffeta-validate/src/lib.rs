//! `taffeta validate`: cloth beside theory.
//!
//! Each [`Group`] of tests simulates strips, plates or discs on several meshes, turned against the outline, with both solvers and on
//! both backends, and holds them against closed forms, elastica and measurements. Scenes and meshes are written to files, so that
//! `taffeta run` repeats each of them.

mod bench;
mod flat;
mod groups;
mod report;
mod runs;
mod specimen;
mod theory;

pub use bench::{Extent, Row};
pub use groups::{GROUPS, Group};
pub use report::{Report, Section};
pub use runs::{Failure, Plan, Progress, validate};
