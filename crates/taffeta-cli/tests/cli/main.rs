//! The program as a user meets it.

mod check_mesh;
mod checkpoint;
mod desk;
mod gpu;
mod input;
mod run;
