//! Colliders of every shape: what stays outside, and what does not pass.

mod depth;
mod energy;
mod fast;
mod hostile;
mod known;
mod outside;
mod plates;
mod reference;
mod refused;
mod ring;
mod sheets;
mod slopes;
