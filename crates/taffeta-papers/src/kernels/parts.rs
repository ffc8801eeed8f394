//! What the kernels of several papers have in common.

use taffeta::extension::{Command, GIVEN, Name};

/// Invocations of each workgroup, in both papers.
pub const GROUP: usize = 1024;

/// How the matrix J M⁻¹ Jᵀ of S1's constraint solver is multiplied by a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Product {
    /// As printed: in COO, made by a thread for each two springs, a thread for each entry.
    Printed,
    /// In CSR, a thread for each row.
    Csr,
    /// In ELLPACK, a thread for each row.
    Ell,
    /// Without the matrix: a thread for each node, then one for each spring.
    MatrixFree,
}

/// A kernel that takes loads from where they were summed up, or finds them itself.
pub fn with_loads(entry: &'static str, loads_given: bool) -> Name {
    Name::new(entry).with(if loads_given { GIVEN } else { &[] })
}

/// What the next kernels write is the state that those before have read.
pub fn go_on_in_place<'f>() -> [Command<'f>; 2] {
    [Command::SwapStates, Command::Label("integrate")]
}
