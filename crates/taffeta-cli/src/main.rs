//! The program `taffeta`.
fn main() {}
