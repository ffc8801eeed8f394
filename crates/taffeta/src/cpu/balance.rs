//! Even chunks for workers where work is uneven: contact is where it is, and not where the nodes are.

use crate::cpu::tiles::{TilePlan, chunks_by_cost};
use std::ops::Range;

/// Frames after which shares are looked at.
const FRAMES: u32 = 16;
/// Time of the busiest worker by the mean from which on shares are changed.
const UNEVEN: f64 = 1.15;
/// Frames in which a change must pay.
const PAYS_IN: f64 = 64.0;

/// How busy workers have been.
#[derive(Debug)]
pub struct Balance {
    /// Time of each since shares were looked at [s].
    busy: Vec<f64>,
    /// Time that each has waited in the last frame [s].
    pub waited: Vec<f64>,
    frames: u32,
    /// What a change takes [s].
    cost: f64,
}

impl Balance {
    /// Of so many workers; to prepare features has taken `cost` [s].
    pub fn new(workers: usize, cost: f64) -> Self {
        Self { busy: vec![0.0; workers], waited: vec![0.0; workers], frames: 0, cost }
    }

    /// Notes how long workers were busy in a frame of `seconds`. Other chunks of tiles, where these are so uneven that a change
    /// pays.
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

    /// A change has taken so long [s].
    pub fn set_cost(&mut self, cost: f64) {
        self.cost = cost;
    }

    /// What each worker's tiles cost, if that is so uneven that a change pays.
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

/// Shares tiles anew by how long the workers that had `chunks` of them were `busy` [s].
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
