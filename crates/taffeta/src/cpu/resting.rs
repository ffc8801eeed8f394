//! Bodies that rest: all of their nodes are held and none is moved, so that nothing of them is computed.

use crate::backend::SETTLING;
use crate::cpu::states::Turn;
use std::ops::Range;

/// Which bodies rest, and which buffers of the state have them as they are.
#[derive(Default)]
pub struct Resting {
    wanted: Vec<bool>,
    /// Frames with held nodes of each, up to [`SETTLING`].
    held: Vec<u32>,
    /// Which are left out, and whether any is.
    left_out: Vec<bool>,
    any: bool,
    is_written: [bool; 3],
}

impl Resting {
    /// Of so many bodies.
    pub fn new(bodies: usize) -> Self {
        Self {
            wanted: vec![false; bodies],
            held: vec![0; bodies],
            left_out: vec![false; bodies],
            ..Self::default()
        }
    }

    /// Whether a body is left out.
    #[inline(always)]
    pub fn has(&self, body: usize) -> bool {
        self.any && self.left_out[body]
    }

    /// Whether any body is.
    #[cfg(any(test, feature = "gpu"))]
    pub fn any(&self) -> bool {
        self.any
    }

    /// Says of which bodies all nodes are held.
    pub fn want(&mut self, bodies: &[bool]) {
        self.wanted.copy_from_slice(bodies);
    }

    /// Something of a body was changed from outside.
    pub fn forget(&mut self, body: usize) {
        self.held[body] = 0;
    }

    /// Nothing is left out before all have been computed again.
    pub fn forget_all(&mut self) {
        self.held.fill(0);
        self.leave_out(false);
    }

    /// From a frame that begins on, leaves out what it can if it may.
    pub fn leave_out(&mut self, may: bool) {
        let is_out = |(&wanted, &held): (&bool, &u32)| may && wanted && held >= SETTLING;
        let now: Vec<bool> = self.wanted.iter().zip(&self.held).map(is_out).collect();
        if now != self.left_out {
            self.is_written = [false; 3];
            self.any = now.contains(&true);
            self.left_out = now;
        }
    }

    /// A frame has ended.
    pub fn end(&mut self) {
        for (held, &wanted) in self.held.iter_mut().zip(&self.wanted) {
            *held = if wanted { SETTLING.min(*held + 1) } else { 0 };
        }
    }

    /// Buffers of the state that sub-steps will write to, and that have not yet what is left out as it is.
    pub fn unwritten(&mut self, turn: Turn) -> Vec<usize> {
        if !self.any {
            return Vec::new();
        }
        self.is_written[turn.now] = true;
        let ahead: Vec<usize> = turn.ahead().filter(|&buffer| !self.is_written[buffer]).collect();
        ahead.iter().for_each(|&buffer| self.is_written[buffer] = true);
        ahead
    }

    /// Does something with those of some things that are not of bodies that are left out, range by range. `of_body` has the things
    /// of each, in ascending ranges, of which the last thing of one and the first of the next may be the same.
    pub fn each_awake(&self, things: Range<usize>, of_body: &[Range<usize>], job: impl FnMut(Range<usize>)) {
        if self.any {
            self.awake(&things, of_body).into_iter().for_each(job);
        } else {
            std::iter::once(things).for_each(job);
        }
    }

    fn awake(&self, things: &Range<usize>, of_body: &[Range<usize>]) -> Vec<Range<usize>> {
        let mut all: Vec<Range<usize>> = Vec::new();
        for (body, own) in of_body.iter().enumerate() {
            let part = own.start.max(things.start)..own.end.min(things.end);
            match all.last_mut() {
                _ if part.is_empty() || self.has(body) => {}
                Some(last) if last.end >= part.start => last.end = last.end.max(part.end),
                _ => all.push(part),
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of three bodies the second is left out.
    fn resting() -> Resting {
        let mut resting = Resting::new(3);
        resting.want(&[false, true, false]);
        for _ in 0..SETTLING {
            resting.leave_out(true);
            assert!(!resting.any());
            resting.end();
        }
        resting.leave_out(true);
        resting
    }

    #[test]
    fn a_body_is_left_out_once_all_of_it_was_computed_with_held_nodes() {
        let mut resting = resting();
        assert_eq!([0, 1, 2].map(|body| resting.has(body)), [false, true, false]);
        resting.leave_out(false);
        assert!(!resting.any());
        resting.leave_out(true);
        assert!(resting.has(1));
        resting.forget(1);
        resting.leave_out(true);
        assert!(!resting.any());
    }

    #[test]
    fn every_buffer_that_is_written_to_is_brought_up_to_date_once() {
        let (mut resting, mut turn) = (resting(), Turn::default());
        // The first frame starts at the good state; the next one starts elsewhere, and nothing is missing.
        assert_eq!(resting.unwritten(turn), [1, 2]);
        turn.pass();
        assert!(resting.unwritten(turn).is_empty());
        resting.forget_all();
        assert!(resting.unwritten(turn).is_empty(), "nothing is left out");
        (0..SETTLING).for_each(|_| resting.end());
        resting.leave_out(true);
        // The good buffer is not written to before another one is good.
        assert_eq!(resting.unwritten(turn), [2]);
        turn.pass();
        assert!(resting.unwritten(turn).is_empty());
        turn.mark_good();
        assert_eq!(resting.unwritten(turn), [0]);
    }

    #[test]
    fn what_shares_a_block_with_a_body_that_is_awake_is_not_left_out() {
        let resting = resting();
        assert_eq!(resting.awake(&(2..9), &[0..4, 3..6, 6..9]), [2..4, 6..9]);
        assert_eq!(resting.awake(&(0..9), &[0..4, 3..6, 4..9]), vec![0..9]);
        assert_eq!(resting.awake(&(4..6), &[0..4, 3..6, 6..9]), Vec::<Range<usize>>::new());
    }
}
