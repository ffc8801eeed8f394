//! Runs one kernel on arrays of words, and compares what it has written.

use crate::features::shaders;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, SUBSTEPS_SEEN, Substep};
use crate::parity::fixture::{Arrays, SUBSTEP};
use crate::parity::outcome::Outcome;
use std::num::NonZeroU64;
use taffeta_gpu::bytemuck::{Pod, cast_slice};
use taffeta_gpu::{Access, Bindable, Buffer, DispatchList, Gpu, GpuError, Kernel, Shader, Uniforms, shaders};

/// Kernels that only compute a formula.
const FORMULAS: &[Shader] = shaders!("parity", ["formulas.wgsl"]);

/// A kernel on its way through a row.
pub struct Bench<'a> {
    pub gpu: &'a Gpu,
    /// The entry point of the row.
    pub entry: &'static str,
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
    /// Makes a kernel of its source as it is edited.
    pub fn kernel(&self, name: Name, overrides: &[(&str, f64)]) -> Result<Kernel, String> {
        let source = (self.edit)(name.source(&shaders().with(FORMULAS.iter().copied()))?);
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

fn threes(fours: &[Four]) -> Vec<f32> {
    fours.iter().flat_map(|&[x, y, z, _]| [x, y, z]).collect()
}

fn lasts(fours: &[Four]) -> Vec<f32> {
    fours.iter().map(|four| four[3]).collect()
}
