//! Bodies in Bevy's worlds, and the viewer.

mod common;
mod examples;
mod gpu;
mod picture;
#[cfg(feature = "viewer")]
mod record;
#[cfg(all(target_os = "linux", feature = "viewer"))]
mod window;
mod worlds;
