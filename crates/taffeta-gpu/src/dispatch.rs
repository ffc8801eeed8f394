//! Lists of dispatches and copies, recorded once and submitted as often as wanted.

use crate::kernel::Bound;
use crate::{Bindable, Buffer, Counts, Gpu, GpuError, ReadBack};

/// Workgroups along x where there are more than one row of them; every device lets a dimension have twice as many.
pub const GROUPS_IN_ROW: u32 = 32_768;

/// Dispatches and copies in the order in which they take effect: each sees what those before it
/// have written.
///
/// ```no_run
/// # use taffeta_gpu::{Choice, DispatchList, Gpu};
/// # let source = "
/// #     @group(2) @binding(0) var<storage, read_write> values: array<f32>;
/// #     @compute @workgroup_size(64) fn twice(@builtin(global_invocation_id) id: vec3u) {
/// #         if id.x < arrayLength(&values) { values[id.x] *= 2.0; }
/// #     }";
/// # let gpu = Gpu::open(&Choice::from_env())?;
/// # let kernel = gpu.kernel("twice", &[source], "twice", &[])?;
/// let (values, earlier) = (gpu.buffer_from("values", &[1.0_f32; 100])?, gpu.buffer("earlier", 100)?);
/// let twice = kernel.bind(&gpu, &[("values", &values)]);
/// let mut list = DispatchList::new();
/// list.copy_buffer(&values, &earlier);
/// list.stage("double");
/// list.dispatch(&twice, &[], 2); // Workgroups of 64 for 100 elements.
/// gpu.submit(&list)?;
/// if gpu.has_timestamps() {
///     // The list is submitted again.
///     let stages = gpu.submit_timed(&list)?;
///     println!("{} took {:e} s", stages[0].0, stages[0].1);
/// }
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
#[derive(Default)]
pub struct DispatchList {
    steps: Vec<Step>,
    stage: &'static str,
    /// The first dispatch that does not fit the device.
    misfit: Option<GpuError>,
}

struct Step {
    stage: &'static str,
    work: Work,
}

enum Work {
    Dispatch { bound: Bound, offsets: Vec<u32>, groups: Groups },
    Copy { from: wgpu::Buffer, to: wgpu::Buffer, bytes: u64 },
}

/// How many workgroups a dispatch has.
enum Groups {
    Told([u32; 2]),
    /// As a kernel before it has written them, from that byte on.
    Counted(wgpu::Buffer, u64),
}

impl Work {
    fn is_dispatch(&self) -> bool {
        matches!(self, Work::Dispatch { .. })
    }
}

impl Gpu {
    /// Hands a list to the device as one command buffer, and does not wait for it.
    ///
    /// # Errors
    /// [`GpuError::TooManyGroups`] of a dispatch in the list, or what [`Gpu::health`] says.
    pub fn submit(&self, list: &DispatchList) -> Result<(), GpuError> {
        self.health()?;
        list.check()?;
        self.watched(|| {
            let mut encoder = self.device().create_command_encoder(&Default::default());
            list.runs(false).for_each(|run| run.encode(&mut encoder, None));
            self.queue().submit([encoder.finish()]);
        });
        self.health()
    }
}

impl DispatchList {
    /// An empty list.
    pub fn new() -> Self {
        DispatchList::default()
    }

    /// What follows belongs to the stage `name`, by which [`Gpu::submit_timed`](crate::Gpu::submit_timed) sums.
    pub fn stage(&mut self, name: &'static str) {
        self.stage = name;
    }

    /// Runs a kernel in `groups` workgroups.
    ///
    /// `offsets` choose the records of group 0's uniforms, in the order of their bindings. More than
    /// [`GROUPS_IN_ROW`] workgroups are in rows along y: the number of a workgroup is `x + y * GROUPS_IN_ROW`,
    /// and there can be up to a row of them too many, which the kernel must let pass.
    ///
    /// # Panics
    /// Where there are more or fewer offsets than uniforms in group 0: a mistake of the caller.
    pub fn dispatch(&mut self, bound: &Bound, offsets: &[u32], groups: u32) {
        bound.check_offsets(offsets);
        match fold(groups, bound.most_groups()) {
            Some(groups) => {
                self.push_dispatch(bound, offsets, Groups::Told(groups));
            }
            None => {
                let limit = u64::from(bound.most_groups()) * u64::from(GROUPS_IN_ROW);
                let label = bound.label().to_owned();
                self.misfit.get_or_insert(GpuError::TooManyGroups { label, groups, limit });
            }
        }
    }

    /// Runs a kernel in a plane of workgroups, `groups` along x and y.
    ///
    /// # Panics
    /// As [`DispatchList::dispatch`].
    pub fn dispatch_plane(&mut self, bound: &Bound, offsets: &[u32], groups: [u32; 2]) {
        bound.check_offsets(offsets);
        let most = bound.most_groups();
        if groups.iter().any(|&side| side > most) {
            let (label, limit) = (bound.label().to_owned(), u64::from(most).pow(2));
            let groups = groups[0].saturating_mul(groups[1]);
            self.misfit.get_or_insert(GpuError::TooManyGroups { label, groups, limit });
        } else if !groups.contains(&0) {
            self.push_dispatch(bound, offsets, Groups::Told(groups));
        }
    }

    /// Runs a kernel in as many workgroups as `counts` has at `index` by then, along x, y and z: what a kernel before it
    /// has written. Where one of the three is 0 it does nothing.
    ///
    /// No count may be larger than the device's limit for a dimension: nothing checks that before the device takes them, as
    /// a check would be a dispatch of its own. The kernel itself must not write to `counts`; where it does, [`Gpu::health`]
    /// says so.
    ///
    /// # Panics
    /// As [`DispatchList::dispatch`], where there is no such index, and where the kernel reads `num_workgroups`, which
    /// DirectX 12 does not tell here: mistakes of the caller.
    ///
    /// [`Gpu::health`]: crate::Gpu::health
    pub fn dispatch_counted(&mut self, bound: &Bound, offsets: &[u32], counts: &Counts, index: usize) {
        bound.check_offsets(offsets);
        assert!(index < counts.len(), "counts {index} of {}", counts.len());
        assert!(
            !bound.reads_counts(),
            "kernel `{}` reads num_workgroups, which an indirect dispatch does not provide",
            bound.label()
        );
        let groups = Groups::Counted(counts.raw().clone(), (index * size_of::<[u32; 3]>()) as u64);
        self.push_dispatch(bound, offsets, groups);
    }

    /// Copies the first elements, as many as both have, to where the host can read them.
    pub fn copy<T>(&mut self, from: &Buffer<T>, to: &ReadBack<T>) {
        self.push_copy::<T>(from.raw(), to.raw(), from.len().min(to.len()));
    }

    /// Copies the first elements, as many as both have.
    pub fn copy_buffer<T>(&mut self, from: &Buffer<T>, to: &Buffer<T>) {
        self.push_copy::<T>(from.raw(), to.raw(), from.len().min(to.len()));
    }

    /// Copies all bytes of one buffer to another, as many as both have.
    pub fn copy_all(&mut self, from: &dyn Bindable, to: &dyn Bindable) {
        let (from, to) = (from.buffer(), to.buffer());
        self.push_copy::<u8>(from, to, from.size().min(to.size()) as usize);
    }

    fn push_copy<T>(&mut self, from: &wgpu::Buffer, to: &wgpu::Buffer, count: usize) {
        let bytes = (count * size_of::<T>()) as u64;
        if bytes > 0 {
            self.push(Work::Copy { from: from.clone(), to: to.clone(), bytes });
        }
    }

    fn push_dispatch(&mut self, bound: &Bound, offsets: &[u32], groups: Groups) {
        self.push(Work::Dispatch { bound: bound.clone(), offsets: offsets.to_vec(), groups });
    }

    fn push(&mut self, work: Work) {
        self.steps.push(Step { stage: self.stage, work });
    }

    pub(crate) fn check(&self) -> Result<(), GpuError> {
        self.misfit.clone().map_or(Ok(()), Err)
    }

    /// What goes into one pass each: all dispatches that follow each other, or all of one stage where
    /// stages are `apart`. A copy stands alone.
    pub(crate) fn runs(&self, apart: bool) -> impl Iterator<Item = Run<'_>> {
        let joined = move |a: &Step, b: &Step| {
            a.work.is_dispatch() && b.work.is_dispatch() && !(apart && a.stage != b.stage)
        };
        self.steps.chunk_by(joined).map(Run)
    }
}

/// Dispatches of one pass, or one copy.
pub(crate) struct Run<'a>(&'a [Step]);

impl Run<'_> {
    /// The stage of its first dispatch; `None` for a copy.
    pub fn stage(&self) -> Option<&'static str> {
        self.0.first().filter(|step| step.work.is_dispatch()).map(|step| step.stage)
    }

    /// Records it; a pass writes its start and end as `times` say.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        times: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        if let [Step { work: Work::Copy { from, to, bytes }, .. }] = self.0 {
            return encoder.copy_buffer_to_buffer(from, 0, to, 0, *bytes);
        }
        let descriptor = wgpu::ComputePassDescriptor { label: self.stage(), timestamp_writes: times };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        for step in self.0 {
            if let Work::Dispatch { bound, offsets, groups } = &step.work {
                bound.set(&mut pass, offsets);
                match groups {
                    Groups::Told([x, y]) => pass.dispatch_workgroups(*x, *y, 1),
                    Groups::Counted(counts, from) => pass.dispatch_workgroups_indirect(counts, *from),
                }
            }
        }
    }
}

/// `groups` in rows of [`GROUPS_IN_ROW`], of which there may be `most`.
fn fold(groups: u32, most: u32) -> Option<[u32; 2]> {
    let rows = groups.div_ceil(GROUPS_IN_ROW);
    (rows <= most).then(|| [groups.min(GROUPS_IN_ROW), rows])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn workgroups_have_the_number_that_their_place_says() {
        assert_eq!(fold(64, 65_535), Some([64, 1]));
        assert_eq!(fold(GROUPS_IN_ROW, 65_535), Some([GROUPS_IN_ROW, 1]));
        assert_eq!(fold(GROUPS_IN_ROW + 1, 65_535), Some([GROUPS_IN_ROW, 2]));
        for groups in [0, 1_000_003, 65_535 * GROUPS_IN_ROW] {
            let [x, y] = fold(groups, 65_535).expect("it fits");
            assert!(x * y >= groups && x * y - groups < GROUPS_IN_ROW, "{groups}: {x} times {y}");
        }
    }

    #[test]
    fn what_two_dimensions_do_not_hold_is_refused() {
        assert_eq!(fold(3 * GROUPS_IN_ROW, 3), Some([GROUPS_IN_ROW, 3]));
        assert_eq!(fold(3 * GROUPS_IN_ROW + 1, 3), None);
        assert_eq!(fold(u32::MAX, 65_535), None);
    }
}
