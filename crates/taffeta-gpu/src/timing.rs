//! How long the stages of a list take on the device.

use crate::dispatch::Run;
use crate::{DispatchList, Gpu, GpuError, ReadBack};

/// A query set holds this many passes.
const PASSES: usize = (wgpu::QUERY_SET_MAX_QUERIES / 2) as usize;

impl Gpu {
    /// Submits `list` with a pass for each run of dispatches of one stage, waits, and returns how
    /// long each stage took [s], summed by stage, in the order in which stages first appear. Copies
    /// are not timed.
    ///
    /// # Errors
    /// [`GpuError::NoTimestamps`] where the device has none, else those of [`Gpu::submit`].
    pub fn submit_timed(&self, list: &DispatchList) -> Result<Vec<(&'static str, f64)>, GpuError> {
        self.health()?;
        if !self.has_timestamps() {
            return Err(GpuError::NoTimestamps);
        }
        list.check()?;
        let mut total = Vec::new();
        let runs: Vec<Run<'_>> = list.runs(true).collect();
        for part in runs.chunks(PASSES) {
            self.time(part, &mut total)?;
        }
        Ok(total)
    }

    fn time(&self, runs: &[Run<'_>], total: &mut Vec<(&'static str, f64)>) -> Result<(), GpuError> {
        let stages: Vec<&'static str> = runs.iter().filter_map(Run::stage).collect();
        let ticks: ReadBack<[u64; 2]> = self.read_back("timestamps", stages.len())?;
        self.watched(|| {
            let encoder = self.encode_timed(runs, stages.len(), &ticks);
            self.queue().submit([encoder.finish()]);
        });
        let mut times = Vec::new();
        ticks.take(self, &mut times)?;
        let period = f64::from(self.queue().get_timestamp_period()) * 1e-9;
        for (stage, [start, end]) in stages.into_iter().zip(times) {
            add_time(total, stage, end.saturating_sub(start) as f64 * period);
        }
        self.health()
    }

    fn encode_timed(
        &self,
        runs: &[Run<'_>],
        passes: usize,
        ticks: &ReadBack<[u64; 2]>,
    ) -> wgpu::CommandEncoder {
        let count = 2 * passes.max(1) as u32;
        let ty = wgpu::QueryType::Timestamp;
        let queries = self.device().create_query_set(&wgpu::QuerySetDescriptor { label: None, ty, count });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let size = u64::from(count) * 8;
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let resolved = self.device().create_buffer(&descriptor);
        let mut encoder = self.device().create_command_encoder(&Default::default());
        let mut next = 0;
        for run in runs {
            let times = run.stage().map(|_| {
                next += 2;
                wgpu::ComputePassTimestampWrites {
                    query_set: &queries,
                    beginning_of_pass_write_index: Some(next - 2),
                    end_of_pass_write_index: Some(next - 1),
                }
            });
            run.encode(&mut encoder, times);
        }
        if next > 0 {
            encoder.resolve_query_set(&queries, 0..next, &resolved, 0);
            encoder.copy_buffer_to_buffer(&resolved, 0, ticks.raw(), 0, u64::from(next) * 8);
        }
        encoder
    }
}

/// Adds the time of a stage [s] to those of all, which stand in the order in which they first appeared.
pub fn add_time(total: &mut Vec<(&'static str, f64)>, stage: &'static str, seconds: f64) {
    match total.iter_mut().find(|(name, _)| *name == stage) {
        Some((_, sum)) => *sum += seconds,
        None => total.push((stage, seconds)),
    }
}

#[cfg(test)]
mod tests {
    use super::add_time;

    #[test]
    fn a_stage_that_comes_back_is_added_to_what_it_took_before() {
        let mut total = Vec::new();
        for (stage, seconds) in [("one", 1.0), ("two", 2.0), ("one", 4.0)] {
            add_time(&mut total, stage, seconds);
        }
        assert_eq!(total, [("one", 5.0), ("two", 2.0)]);
    }
}
