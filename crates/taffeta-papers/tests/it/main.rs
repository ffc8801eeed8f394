//! The program as a user meets it. Its benches need `taffeta`, which a build of the workspace leaves beside it.

mod desk;
mod kernels;
mod report;
