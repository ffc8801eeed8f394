//! Motion that is given: keyframes, and the nodes that follow them.

pub mod cpu;
pub mod keyframes;
pub mod pins;
