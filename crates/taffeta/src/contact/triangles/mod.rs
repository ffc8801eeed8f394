//! Contact of surfaces: of vertices with triangles and of edges with edges.
//!
//! In a sub-step the pairs that may meet are found where it begins ([`surfaces`], [`closest`]). Those that would end nearer
//! than their thickness get impulses ([`impulse`]), found in rounds in which colliders take part. At its end a filter
//! ([`filter`]) stops nodes before a plane between the sides of their pairs, so that nothing that starts apart ever meets.
//! Before it, what is in the way of colliders that move goes along with them ([`carry`]). What starts through something else is
//! led back first ([`tangle`]).

pub mod carry;
pub mod closest;
pub mod cones;
pub mod cpu;
mod crowd;
pub mod filter;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
#[cfg(feature = "gpu")]
pub mod gpu_tables;
pub mod impulse;
pub mod leaves;
pub mod order;
#[cfg(feature = "gpu")]
pub mod parity;
#[cfg(feature = "gpu")]
mod parity_count;
#[cfg(feature = "gpu")]
pub mod parity_scene;
#[cfg(feature = "gpu")]
pub mod parity_stages;
mod sides;
pub mod slide;
pub mod solved;
pub mod surfaces;
pub mod tangle;
#[cfg(feature = "gpu")]
pub mod twin;
#[cfg(feature = "gpu")]
mod twin_carry;
#[cfg(feature = "gpu")]
mod twin_count;
#[cfg(feature = "gpu")]
mod twin_find;
