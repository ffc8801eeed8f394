//! The experiments of three papers, run with taffeta, as a report that has what they print beside
//! what comes out here.
//!
//! - S1: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021.
//! - S2: the article "CUDA Cloth Simulation".
//! - S3: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023.
//!
//! A paper's module has its runs ([`runs::job::Job`]) and the tables that are made of what they leave
//! ([`report::look::Look`]). Every number of ours is read from what a run left ([`report::store::Kept`]), and the report has that,
//! too.

pub mod contact;
pub mod draw;
pub mod drive;
pub mod errata;
pub mod papers;
pub mod progress;
pub mod report;
pub mod reproduce;
pub mod runs;
pub mod tournament;

/// The repository's root: the folder above `crates/`.
fn root() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
