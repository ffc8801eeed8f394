//! From forces to the next state: symplectic Euler, and the keyframed motion of pins and colliders.

pub mod euler;
pub mod keyframes;
pub mod pins;
