//! Springs as constraints on positions, solved one after the other, over several levels (XPBD).
//!
//! After a sub-step has moved the nodes under all other forces, each spring moves its two ends. Springs that share no
//! node have one colour and act at once; colours follow each other, so that each spring sees what those before it have done. Before
//! the springs, coarser levels act: pairs of nodes some edges apart, which may not be farther apart than the cloth between
//! them is long. They carry a load across the whole cloth in one sub-step, for which springs alone would need as many as
//! there are nodes along the way.

pub mod colours;
pub mod cpu;
pub mod grid;
pub mod levels;
pub mod mesh;
pub mod project;
