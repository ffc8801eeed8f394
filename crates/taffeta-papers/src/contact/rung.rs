//! The rungs of S2's ladder.

/// How pairs of nodes are found.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Rung {
    /// Every node looks at all others, on one thread: what S2 ("CUDA Cloth Simulation") starts from.
    Serial,
    /// The same on a GPU, one thread a node; S2's first, and each of the next five goes on from the one before.
    Naive,
    /// What is not written is bound as constant.
    Constants,
    /// Distances are compared by their squares.
    Squared,
    /// Two buffers exchange their roles, and nothing is copied back.
    Swapped,
    /// Bins, filled once a frame from all nodes.
    Scanned,
    /// Bins, filled once a frame from those around them.
    Refreshed,
    /// The engine: by clusters of nodes that are looked at when they may touch, and all threads.
    Binned,
}

impl Rung {
    /// S2's rungs on a GPU, in its order.
    pub const LADDER: [Self; 6] =
        [Self::Naive, Self::Constants, Self::Squared, Self::Swapped, Self::Scanned, Self::Refreshed];

    /// Its name in the report.
    pub fn name(self) -> &'static str {
        match self {
            Self::Serial => "serial",
            Self::Naive => "naive",
            Self::Constants => "constants",
            Self::Squared => "squared",
            Self::Swapped => "swapped",
            Self::Scanned => "scanned",
            Self::Refreshed => "refreshed",
            Self::Binned => "binned",
        }
    }

    /// Whether it has bins of fixed room.
    pub fn has_bins(self) -> bool {
        matches!(self, Self::Scanned | Self::Refreshed)
    }
}
