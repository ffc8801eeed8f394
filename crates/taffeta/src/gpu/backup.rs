//! What a frame starts from, kept so that it can be repeated.

use crate::gpu::partition::Partition;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError};

/// The state of a partition, and what else lasts from one frame to the next.
pub struct Backup {
    /// Which of the two states was that of now.
    current: usize,
    words: Vec<Buffer<u32>>,
}

/// The buffers of a partition that last.
fn lasting(partition: &Partition, current: usize) -> Vec<&dyn Bindable> {
    let state = &partition.states[current];
    let of_features = partition.features.iter().flat_map(|feature| feature.lasting());
    [&state.position as &dyn Bindable, &state.velocity].into_iter().chain(of_features).collect()
}

impl Backup {
    /// Of the state of now.
    pub fn of(gpu: &Gpu, partition: &Partition) -> Result<Self, GpuError> {
        let (current, mut list) = (partition.current, DispatchList::new());
        let copy = |from: &dyn Bindable| {
            let words = gpu.buffer("what a frame starts from", (from.buffer().size() / 4) as usize)?;
            list.copy_all(from, &words);
            Ok(words)
        };
        let words = lasting(partition, current).into_iter().map(copy).collect::<Result<_, GpuError>>()?;
        gpu.submit(&list)?;
        Ok(Self { current, words })
    }

    /// Puts it back.
    pub fn restore(&self, gpu: &Gpu, partition: &mut Partition) -> Result<(), GpuError> {
        partition.current = self.current;
        let mut list = DispatchList::new();
        for (words, to) in self.words.iter().zip(lasting(partition, self.current)) {
            list.copy_all(words, to);
        }
        gpu.submit(&list)
    }
}
