//! The state on the host: fetched when it is asked for, and put back when it was changed.

use crate::gpu::layout::Four;
use crate::gpu::partition::Partition;
use std::ops::Range;
use taffeta_gpu::{Gpu, GpuError, ReadBack};

/// Position and velocity of all places, as the device has them.
#[derive(Clone, Default)]
pub struct Mirror {
    pub position: Vec<Four>,
    pub velocity: Vec<Four>,
}

/// Where the state of a partition arrives.
pub struct Landing {
    position: ReadBack<Four>,
    velocity: ReadBack<Four>,
}

impl Landing {
    /// Room for a partition's state.
    pub fn new(gpu: &Gpu, partition: &Partition) -> Result<Self, GpuError> {
        Ok(Self {
            position: gpu.read_back("positions", partition.places.len())?,
            velocity: gpu.read_back("velocities", partition.places.len())?,
        })
    }

    /// Has the state of now copied here.
    pub fn copy(&self, partition: &Partition, list: &mut taffeta_gpu::DispatchList) {
        list.copy(&partition.state().position, &self.position);
        list.copy(&partition.state().velocity, &self.velocity);
    }
}

impl Mirror {
    /// Takes what has landed, partition after partition; waits for it.
    pub fn take(gpu: &Gpu, landings: &[Landing]) -> Result<Self, GpuError> {
        let mut mirror = Self::default();
        let mut part = Vec::new();
        for landing in landings {
            landing.position.take(gpu, &mut part)?;
            mirror.position.extend_from_slice(&part);
            landing.velocity.take(gpu, &mut part)?;
            mirror.velocity.extend_from_slice(&part);
        }
        Ok(mirror)
    }

    /// A state that nobody can take for one.
    pub fn unknown(places: usize) -> Self {
        let nowhere = vec![[f32::NAN, f32::NAN, f32::NAN, 0.0]; places];
        Self { position: nowhere.clone(), velocity: nowhere }
    }

    /// Puts places back to the device.
    pub fn put(&self, gpu: &Gpu, partitions: &[Partition], changed: &Range<usize>) {
        for partition in partitions {
            let places = &partition.places;
            let range = changed.start.max(places.start)..changed.end.min(places.end);
            if range.start < range.end {
                let at = range.start - places.start;
                partition.state().position.write(gpu, at, &self.position[range.clone()]);
                partition.state().velocity.write(gpu, at, &self.velocity[range]);
            }
        }
    }
}
