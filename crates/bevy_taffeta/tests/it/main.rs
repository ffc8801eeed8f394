//! Bodies in Bevy's worlds, and the viewer.

mod carried;
mod common;
mod examples;
mod gpu;
mod picture;
#[cfg(feature = "viewer")]
mod record;
mod refused;
#[cfg(all(target_os = "linux", feature = "viewer"))]
mod window;
mod worlds;
