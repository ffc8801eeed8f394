//! A report: tables whose numbers say where they come from, plots, pictures, and the file with all of it.

pub mod look;
pub mod page;
pub mod store;
pub mod table;
pub mod write;
