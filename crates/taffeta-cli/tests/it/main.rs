//! The program as a user meets it.

mod check_mesh;
mod checkpoint;

mod constraints;
mod contact_scenes;
mod desk;
mod gpu;
mod gpu_check;
mod input;
mod primal;
mod readme;
mod run;
mod scenes;
mod validate;
