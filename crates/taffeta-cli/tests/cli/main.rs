//! The program as a user meets it.

mod checkpoint;
mod desk;
mod input;
mod run;
