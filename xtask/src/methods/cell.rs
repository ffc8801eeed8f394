//! What is compared: sheets of some sizes and stiffnesses, and the steps that each way of solving springs takes on them.

use super::way::Way;

/// Length of a frame [s].
pub const FRAME: f64 = 1.0 / 60.0;
/// Stiffness of all springs [N/m].
pub const STIFFNESSES: [f64; 3] = [1e2, 1e3, 1e4];

/// A sheet of nodes, and what is run on it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Size {
    /// What the user calls it.
    pub name: &'static str,
    /// Nodes along an edge.
    pub side: u32,
    /// Frames that are run: fewer where a reference costs more.
    pub frames: u32,
    /// Sub-steps of explicit springs, in multiples of the fewest that are stable.
    pub explicit: &'static [u32],
    /// Sub-steps in a frame of the dual form.
    pub dual: &'static [u32],
    /// The same, where it goes on until it is solved.
    pub solved: &'static [u32],
    /// Sub-steps in a frame of the primal form.
    pub primal: &'static [u32],
}

/// All sizes.
pub const SIZES: [Size; 4] = [
    Size {
        name: "1k",
        side: 32,
        frames: 30,
        explicit: &[1, 2, 4],
        dual: &[1, 2, 4, 8, 16, 32],
        solved: &[1, 2, 4],
        primal: &[1, 2, 4, 8, 16, 32],
    },
    Size {
        name: "10k",
        side: 100,
        frames: 30,
        explicit: &[1, 2, 4],
        dual: &[1, 2, 4, 8],
        solved: &[1, 4],
        primal: &[1, 2, 4, 8, 16],
    },
    Size {
        name: "100k",
        side: 316,
        frames: 15,
        explicit: &[1, 2],
        dual: &[1, 4],
        solved: &[],
        primal: &[1, 2, 4, 8],
    },
    Size {
        name: "1M",
        side: 1000,
        frames: 2,
        explicit: &[1],
        dual: &[1, 2],
        solved: &[],
        primal: &[1, 2, 4],
    },
];

/// Sizes of a look that takes two minutes.
pub const QUICK: [Size; 2] = [
    Size { frames: 6, explicit: &[1], dual: &[1, 4], solved: &[1], primal: &[1, 4], ..SIZES[0] },
    Size { frames: 6, explicit: &[1], dual: &[1, 4], solved: &[], primal: &[1, 4], ..SIZES[1] },
];

/// A size with a stiffness.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    pub size: Size,
    /// Stiffness [N/m].
    pub k: f64,
}

impl Cell {
    /// Time that is run [s].
    pub fn seconds(&self) -> f64 {
        f64::from(self.size.frames) * FRAME
    }

    /// What is run: ways with their sub-steps in a frame, where `fewest` is what explicit springs need. They are run with one
    /// as well, to see it blow up.
    pub fn plan(&self, fewest: u32) -> Vec<(Way, u32)> {
        let explicit = [1].into_iter().chain(self.size.explicit.iter().map(|times| times * fewest));
        let implicit = |way: Way| {
            self.implicit(way).iter().filter(|&&steps| steps <= fewest).map(move |&steps| (way, steps))
        };
        let ways = Way::ALL.into_iter().flat_map(implicit);
        explicit.map(|steps| (Way::Springs, steps)).chain(ways).collect()
    }

    /// Sub-steps in a frame of implicit springs.
    fn implicit(&self, way: Way) -> &'static [u32] {
        match way {
            Way::Springs => &[],
            Way::Dual => self.size.dual,
            Way::DualSolved => self.size.solved,
            Way::Primal => self.size.primal,
        }
    }
}

/// All cells of some sizes.
pub fn cells(sizes: &[Size]) -> Vec<Cell> {
    sizes.iter().flat_map(|&size| STIFFNESSES.map(|k| Cell { size, k })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn implicit_springs_take_no_more_steps_than_explicit_ones_need() {
        let plan = Cell { size: SIZES[0], k: 1e2 }.plan(10);
        let steps = |wanted: Way| {
            plan.iter().filter(|(way, _)| *way == wanted).map(|&(_, steps)| steps).collect::<Vec<_>>()
        };
        assert_eq!(steps(Way::Springs), [1, 10, 20, 40]);
        assert_eq!(steps(Way::Dual), [1, 2, 4, 8]);
        assert_eq!(steps(Way::DualSolved), [1, 2, 4]);
        assert_eq!(steps(Way::Primal), [1, 2, 4, 8]);
    }
}
