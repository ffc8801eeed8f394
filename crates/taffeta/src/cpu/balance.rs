//! Load balancing: even chunks for workers whose work is uneven. Contact is not evenly distributed over nodes.

use crate::cpu::tiles::{TilePlan, chunks_by_cost};
use std::ops::Range;

/// Frames between two checks.
const FRAMES: u32 = 16;
/// Time of the busiest worker, relative to the mean, from which chunks are changed.
const UNEVEN: f64 = 1.15;
/// Frames in which a change must pay off.
const PAYS_IN: f64 = 64.0;

/// Busy times of workers.
#[derive(Debug)]
pub struct Balance {
    /// Time of each since the last check [s].
    busy: Vec<f64>,
    /// Time that each has waited in the last frame [s].
    pub waited: Vec<f64>,
    frames: u32,
    /// Cost of a change [s].
    cost: f64,
}

impl Balance {
    /// For so many workers. The preparation of features has taken `cost` [s].
    pub fn new(workers: usize, cost: f64) -> Self {
        Self { busy: vec![0.0; workers], waited: vec![0.0; workers], frames: 0, cost }
    }

    /// Adds the busy times of a frame of `seconds`. Returns other chunks of tiles, if a change pays off.
    pub fn after(
        &mut self,
        seconds: f64,
        tiles: &[TilePlan],
        chunks: &[Range<usize>],
    ) -> Option<Vec<Range<usize>>> {
        for (busy, waited) in self.busy.iter_mut().zip(&self.waited) {
            *busy += seconds - *waited;
        }
        self.frames += 1;
        let others = chunks_by_time(tiles, chunks, &self.uneven()?);
        (others != chunks).then_some(others)
    }

    /// Sets the cost of a change [s].
    pub fn set_cost(&mut self, cost: f64) {
        self.cost = cost;
    }

    /// The cost of each worker's tiles, if it is so uneven that a change pays off.
    fn uneven(&mut self) -> Option<Vec<f64>> {
        if self.frames < FRAMES {
            return None;
        }
        let workers = self.busy.len();
        let busy = std::mem::replace(&mut self.busy, vec![0.0; workers]);
        let mean = busy.iter().sum::<f64>() / workers as f64;
        let worst = busy.iter().copied().fold(0.0, f64::max);
        let gain = (worst - mean) / f64::from(std::mem::take(&mut self.frames));
        (worst > UNEVEN * mean && gain * PAYS_IN > self.cost).then_some(busy)
    }
}

/// Chunks of tiles by how long the workers that had `chunks` of them were `busy` [s].
fn chunks_by_time(tiles: &[TilePlan], chunks: &[Range<usize>], busy: &[f64]) -> Vec<Range<usize>> {
    let mut costs = vec![0.0; tiles.len()];
    for (chunk, busy) in chunks.iter().zip(busy) {
        let nodes: usize = tiles[chunk.clone()].iter().map(TilePlan::len).sum();
        for tile in chunk.clone() {
            costs[tile] = busy * tiles[tile].len() as f64 / nodes as f64;
        }
    }
    chunks_by_cost(&costs, chunks.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(frames: u32, busy: &[f64], cost: f64) -> Option<Vec<f64>> {
        let mut balance = Balance { busy: busy.to_vec(), waited: Vec::new(), frames, cost };
        balance.uneven()
    }

    #[test]
    fn shares_change_where_one_worker_has_most_to_do_and_it_pays() {
        assert_eq!(after(FRAMES, &[0.1, 0.3], 0.001), Some(vec![0.1, 0.3]));
        assert_eq!(after(FRAMES, &[0.1, 0.3], 1.0), None, "it takes longer than it gains");
        assert_eq!(after(FRAMES, &[0.19, 0.21], 0.0), None, "nearly even");
        assert_eq!(after(FRAMES - 1, &[0.1, 0.3], 0.0), None, "too early");
    }
}
