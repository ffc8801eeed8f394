//! Three buffers of the state: that of now, that after a sub-step, and the last that was found good.

use crate::cpu::tile::Fields;

/// The buffers.
pub type States<T> = [Fields<T>; 3];

/// Which buffer holds what. Sub-steps never write to the good one, so it costs no copy to keep it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turn {
    /// The state of now.
    pub now: usize,
    good: usize,
}

impl Turn {
    /// Where a sub-step writes the state after it.
    pub fn next(self) -> usize {
        if self.is_good() { (self.now + 1) % 3 } else { 3 - self.now - self.good }
    }

    /// The buffers that sub-steps write to, in turn.
    pub fn ahead(self) -> impl Iterator<Item = usize> {
        (0..3).filter(move |&buffer| buffer != self.now && (self.is_good() || buffer != self.good))
    }

    /// A sub-step has ended.
    pub fn pass(&mut self) {
        self.now = self.next();
    }

    /// Whether the state of now is the last good one.
    pub fn is_good(self) -> bool {
        self.now == self.good
    }

    /// The state of now is good.
    pub fn mark_good(&mut self) {
        self.good = self.now;
    }

    /// The last good state is that of now again.
    pub fn return_to_good(&mut self) {
        self.now = self.good;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn substeps_read_what_the_one_before_has_written_and_never_write_to_the_good_state() {
        let mut turn = Turn::default();
        for substeps in [0, 1, 2, 3, 8] {
            turn.mark_good();
            let good = turn.now;
            for _ in 0..substeps {
                let next = turn.next();
                assert!(next < 3 && next != turn.now && next != good);
                turn.pass();
                assert_eq!(turn.now, next);
            }
            turn.return_to_good();
            assert!(turn.is_good() && turn.now == good);
            (0..substeps).for_each(|_| turn.pass());
        }
    }
}
