//! What a frame starts from, kept so that it can be repeated.

use crate::gpu::partition::Partition;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError};

/// The state of a partition, and what else lasts from one frame to the next.
#[derive(Default)]
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

fn words(buffer: &dyn Bindable) -> usize {
    (buffer.buffer().size() / 4) as usize
}

impl Backup {
    /// Keeps the state of now. Memory is asked for where buffers have another length than before.
    pub fn keep(&mut self, gpu: &Gpu, partition: &Partition) -> Result<(), GpuError> {
        self.current = partition.current;
        let from = lasting(partition, self.current);
        let lengths = from.iter().map(|&buffer| words(buffer));
        if !lengths.clone().eq(self.words.iter().map(Buffer::len)) {
            let new = lengths.map(|length| gpu.buffer("what a frame starts from", length));
            self.words = new.collect::<Result<_, _>>()?;
        }
        let mut list = DispatchList::new();
        from.into_iter().zip(&self.words).for_each(|(from, to)| list.copy_all(from, to));
        gpu.submit(&list)
    }

    /// Puts it back.
    pub fn restore(&self, gpu: &Gpu, partition: &mut Partition) -> Result<(), GpuError> {
        partition.current = self.current;
        let (mut list, to) = (DispatchList::new(), lasting(partition, self.current));
        self.words.iter().zip(to).for_each(|(from, to)| list.copy_all(from, to));
        gpu.submit(&list)
    }
}
