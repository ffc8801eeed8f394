//! The program as a user meets it.

mod desk;
mod input;
mod run;
