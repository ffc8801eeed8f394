//! Even chunks for workers where work is uneven: contact is where it is, and not where the nodes are.

use crate::cpu::backend::CpuBackend;
use crate::cpu::tiles::{TilePlan, shares_by};
use crate::real::Real;
use std::time::Instant;

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

impl<T: Real> CpuBackend<T> {
    /// Notes how long workers were busy in a frame of `seconds`, and now and then shares tiles anew. No result depends on
    /// who computes it.
    pub(crate) fn balance(&mut self, seconds: f64) {
        if self.chunks.len() == 1 || !self.features.iter().any(|feature| feature.is_uneven()) {
            return;
        }
        let Balance { busy, waited, .. } = &mut self.balance;
        for (busy, waited) in busy.iter_mut().zip(waited) {
            *busy += seconds - *waited;
        }
        self.balance.frames += 1;
        if let Some(busy) = self.balance.uneven() {
            self.share_anew(&busy);
        }
    }

    fn share_anew(&mut self, busy: &[f64]) {
        let start = Instant::now();
        let tiles = &self.nodes.tiles;
        let mut costs = vec![0.0; tiles.len()];
        for (chunk, busy) in self.chunks.iter().zip(busy) {
            let nodes: usize = tiles[chunk.clone()].iter().map(TilePlan::len).sum();
            for tile in chunk.clone() {
                costs[tile] = busy * tiles[tile].len() as f64 / nodes as f64;
            }
        }
        let chunks = shares_by(&costs, self.chunks.len());
        if chunks == self.chunks {
            return;
        }
        for feature in self.features.iter_mut() {
            feature.share_anew(&self.assembly, tiles, &chunks);
        }
        self.chunks = chunks;
        self.balance.cost = start.elapsed().as_secs_f64();
    }
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
