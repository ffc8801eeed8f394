//! The papers: what of each is run, and the tables that have its numbers beside those that come out here.

pub mod aims;
mod curve;
pub mod limits;
pub mod paper;
pub mod s1;
pub mod s2;
pub mod s3;
