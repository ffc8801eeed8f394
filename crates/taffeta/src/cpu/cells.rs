//! Values that one worker has at a time.

use atomic_refcell::{AtomicRef, AtomicRefCell, AtomicRefMut};

/// Values on cache lines of their own, so that workers do not contend. Whoever asks for one has it until the guard is dropped: that
/// nobody changes it meanwhile is not promised but checked, at some nanoseconds each time, and panics.
pub struct Cells<S>(Vec<Cell<S>>);

/// One for each worker.
pub type PerWorker<S> = Cells<S>;

#[repr(align(128))]
struct Cell<S>(AtomicRefCell<S>);

impl<S> Cells<S> {
    /// So many.
    pub fn new(count: usize, make: impl Fn(usize) -> S) -> Self {
        Self((0..count).map(|index| Cell(AtomicRefCell::new(make(index)))).collect())
    }

    /// How many they are.
    #[cfg(feature = "gpu")]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// One of them, to change.
    #[inline]
    pub fn of(&self, index: usize) -> AtomicRefMut<'_, S> {
        self.0[index].0.borrow_mut()
    }

    /// One of them, to read.
    #[inline]
    pub fn read(&self, index: usize) -> AtomicRef<'_, S> {
        self.0[index].0.borrow()
    }

    /// All of them, to read.
    pub fn iter(&self) -> impl Iterator<Item = AtomicRef<'_, S>> {
        self.0.iter().map(|cell| cell.0.borrow())
    }

    /// All of them, where no worker works.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut S> {
        self.0.iter_mut().map(|cell| cell.0.get_mut())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::team::Team;

    #[test]
    #[should_panic(expected = "already mutably borrowed")]
    fn a_value_is_not_given_away_twice() {
        let cells = Cells::new(1, |_| 0);
        let _first = cells.of(0);
        cells.of(0);
    }

    #[test]
    fn workers_read_what_others_have_written_before_a_barrier() {
        let cells = PerWorker::new(3, |_| 0);
        Team::new(3).run(|worker, barrier| {
            for round in 1..=100 {
                *cells.of(worker) += worker;
                barrier.wait();
                assert_eq!(cells.iter().map(|one| *one).sum::<usize>(), 3 * round);
                barrier.wait();
            }
        });
    }
}
