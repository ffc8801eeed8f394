//! The experiments of three papers, run with taffeta, as a report that has what they print beside what comes out here.
//!
//! - S1: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021.
//! - S2: the article "CUDA Cloth Simulation".
//! - S3: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023.
//!
//! Every number of ours is read from what a run of the program left, and the report has that, too.

pub mod errata;
pub mod page;
pub mod plot;
pub mod store;
pub mod table;
pub mod tournament;
