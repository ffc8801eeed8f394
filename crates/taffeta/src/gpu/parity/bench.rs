//! Runs one kernel on arrays of words, and compares what it has written.

use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, SUBSTEPS_SEEN, Substep};
use crate::gpu::parity::fixture::{Arrays, SUBSTEP};
use crate::gpu::parity::{Difference, Outcome};
use std::num::NonZeroU64;
use taffeta_gpu::bytemuck::{Pod, cast_slice};
use taffeta_gpu::{Access, Bindable, Buffer, DispatchList, Gpu, GpuError, Kernel, Uniforms};

/// A kernel on its way through a row.
pub struct Bench<'a> {
    pub gpu: &'a Gpu,
    /// Whether kernels round as the CPU does: states then have nodes on what kernels branch on.
    pub exact: bool,
    /// What is done to the sources before they are compiled.
    pub edit: &'a dyn Fn(String) -> String,
    pub outcome: Outcome,
}

/// Records of sub-steps, of which the kernel sees as many as its source says.
struct Seen<'a>(&'a Uniforms<Substep>, u64);

impl Bindable for Seen<'_> {
    fn buffer(&self) -> &taffeta_gpu::wgpu::Buffer {
        self.0.buffer()
    }

    fn window(&self) -> Option<NonZeroU64> {
        NonZeroU64::new(self.1)
    }
}

/// What a kernel is told and works on.
pub struct Given<'a> {
    pub arrays: &'a Arrays,
    pub records: &'a [Substep],
    pub groups: usize,
}

/// What a kernel has left in the arrays that it may write; each is to be compared.
pub struct Written<'a> {
    arrays: Arrays,
    outcome: &'a mut Outcome,
}

impl Bench<'_> {
    /// Makes a kernel of whole sources.
    pub fn kernel(&self, name: Name, more: &[&str], overrides: &[(&str, f64)]) -> Result<Kernel, String> {
        let source = (self.edit)([&name.sources()[..], more].concat().join("\n"));
        self.gpu.kernel(name.entry, &[&source], name.entry, overrides).map_err(|error| error.to_string())
    }

    /// Runs a kernel, and lets `compare` look at what it has written.
    pub fn run(
        &mut self,
        kernel: &Kernel,
        given: &Given<'_>,
        compare: impl FnOnce(&mut Written<'_>),
    ) -> Result<(), String> {
        let arrays = run(self.gpu, kernel, given).map_err(|error| error.to_string())?;
        let mut written = Written { arrays, outcome: &mut self.outcome };
        compare(&mut written);
        match written.arrays.first_key_value() {
            Some((name, _)) => Err(format!("what the kernel wrote to `{name}` is not compared")),
            None => Ok(()),
        }
    }
}

fn run(gpu: &Gpu, kernel: &Kernel, given: &Given<'_>) -> Result<Arrays, GpuError> {
    let uniforms: Uniforms<Substep> = gpu.uniforms("sub-steps", given.records.len() + SUBSTEPS_SEEN)?;
    uniforms.write(gpu, given.records);
    let (mut buffers, mut seen, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
    for one in kernel.bindings() {
        match given.arrays.get_key_value(&*one.name) {
            _ if one.access == Access::Uniform => {
                seen.push((one.name.as_str(), Seen(&uniforms, one.size)));
                offsets.push(uniforms.offset(SUBSTEP));
            }
            Some((&name, words)) => buffers.push((name, one.access, gpu.buffer_from(name, words)?)),
            None => {
                let why = format!("a row of the comparison has no array `{}`", one.name);
                return Err(GpuError::Failed { why });
            }
        }
    }
    let mut bound: Vec<(&str, &dyn Bindable)> = Vec::new();
    bound.extend(seen.iter().map(|(name, seen)| (*name, seen as &dyn Bindable)));
    bound.extend(buffers.iter().map(|(name, _, buffer)| (*name, buffer as &dyn Bindable)));
    let mut list = DispatchList::new();
    list.dispatch(&kernel.bind(gpu, &bound), &offsets, given.groups as u32);
    gpu.submit(&list)?;
    let written = buffers.iter().filter(|(_, access, _)| *access == Access::ReadWrite);
    written.map(|(name, _, buffer): &(_, _, Buffer<u32>)| Ok((*name, buffer.read(gpu)?))).collect()
}

impl Written<'_> {
    /// The numbers of an array, which are then taken to be compared.
    pub fn take<T: Pod>(&mut self, name: &str) -> Vec<T> {
        let words = self.arrays.remove(name).unwrap_or_default();
        cast_slice(&words).to_vec()
    }

    /// Compares vectors, whose fourth number is of another quantity and is only copied.
    pub fn fours(&mut self, name: &str, wanted: &[Four]) {
        let found = self.take::<Four>(name);
        self.outcome.compare(name, &threes(wanted), &threes(&found));
        self.outcome.copied(&format!("{name}.w"), &lasts(wanted), &lasts(&found));
    }

    /// Compares vectors, whose fourth number is of another quantity and was computed too.
    pub fn compare_fours(&mut self, name: &str, wanted: &[Four], found: &[Four]) {
        self.outcome.compare(name, &threes(wanted), &threes(found));
        self.outcome.compare(&format!("{name}.w"), &lasts(wanted), &lasts(found));
    }

    /// Where comparisons are noted.
    pub fn outcome(&mut self) -> &mut Outcome {
        self.outcome
    }
}

impl Outcome {
    /// Compares numbers of one quantity, in units in the last place of the largest.
    pub fn compare(&mut self, output: &str, wanted: &[f32], found: &[f32]) {
        let finite = wanted.iter().filter(|number| number.is_finite());
        let largest = finite.fold(0.0_f32, |most, number| most.max(number.abs()));
        self.compare_to(output, wanted, found, f64::from(largest));
    }

    /// Compares numbers in units in the last place of `largest`.
    pub fn compare_to(&mut self, output: &str, wanted: &[f32], found: &[f32], largest: f64) {
        self.count(output, wanted.len(), found.len());
        let unit = last_place(largest);
        for (index, (&cpu, &gpu)) in wanted.iter().zip(found).enumerate() {
            let apart = (f64::from(cpu) - f64::from(gpu)).abs();
            let alike = cpu == gpu || cpu.is_nan() && gpu.is_nan();
            let ulps = if alike { 0.0 } else { apart / unit };
            self.note(if ulps.is_nan() { f64::INFINITY } else { ulps }, output, index, [cpu, gpu]);
        }
    }

    /// Compares numbers that are only copied: they are the same on every device.
    pub fn copied(&mut self, output: &str, wanted: &[f32], found: &[f32]) {
        self.count(output, wanted.len(), found.len());
        for (index, (&cpu, &gpu)) in wanted.iter().zip(found).enumerate() {
            let alike = cpu == gpu || cpu.is_nan() && gpu.is_nan();
            self.note(if alike { 0.0 } else { f64::INFINITY }, output, index, [cpu, gpu]);
        }
    }

    fn count(&mut self, output: &str, wanted: usize, found: usize) {
        self.compared += wanted;
        if wanted != found {
            self.note(f64::INFINITY, &format!("{output}.len()"), 0, [wanted as f32, found as f32]);
        }
    }

    fn note(&mut self, ulps: f64, output: &str, index: usize, [cpu, gpu]: [f32; 2]) {
        if ulps > self.ulps {
            self.ulps = ulps;
            self.place = Some(Difference { output: output.to_owned(), index, cpu, gpu });
        }
    }
}

/// The unit in the last place of a number of 32 bits. What is below the least normal number may be taken for zero.
fn last_place(number: f64) -> f64 {
    let number = (number as f32).max(f32::MIN_POSITIVE);
    (f64::from(number.next_up()) - f64::from(number)).max(f64::from(f32::MIN_POSITIVE))
}

fn threes(fours: &[Four]) -> Vec<f32> {
    fours.iter().flat_map(|&[x, y, z, _]| [x, y, z]).collect()
}

fn lasts(fours: &[Four]) -> Vec<f32> {
    fours.iter().map(|four| four[3]).collect()
}
