//! Compute pipelines whose bindings stand in their source alone, and their binding to buffers by name.

use std::borrow::Cow;
use std::num::NonZeroU64;
use std::sync::Arc;

use crate::cache::{Key, Module};
use crate::gpu::told;
use crate::reflect::{Parsed, Reflection};
use crate::{Access, Bindable, Binding, Gpu, GpuError};

/// A compute pipeline, and what its source says of it. Cheap to clone.
///
/// ```no_run
/// use taffeta_gpu::{Choice, Gpu};
///
/// let source = "
///     override SIZE: u32 = 64;
///     @group(2) @binding(0) var<storage, read_write> values: array<f32>;
///     @compute @workgroup_size(SIZE) fn clear(@builtin(global_invocation_id) id: vec3u) {
///         if id.x < arrayLength(&values) { values[id.x] = 0.0; }
///     }";
/// let gpu = Gpu::open(&Choice::from_env())?;
/// let kernel = gpu.kernel("clear", &[source], "clear", &[("SIZE", 128.0)])?;
/// assert_eq!(kernel.workgroup_size(), [128, 1, 1]);
/// assert_eq!(kernel.bindings()[0].name, "values");
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
#[derive(Clone)]
pub struct Kernel(Arc<Inner>);

struct Inner {
    label: String,
    pipeline: wgpu::ComputePipeline,
    layouts: Vec<wgpu::BindGroupLayout>,
    bindings: Vec<Binding>,
    workgroup_size: [u32; 3],
    reads_counts: bool,
}

/// A kernel with the buffers that it works on, which it keeps alive. Cheap to clone.
///
/// ```no_run
/// # use taffeta_gpu::{Choice, DispatchList, Gpu};
/// # let source = "
/// #     @group(2) @binding(0) var<storage, read_write> values: array<f32>;
/// #     @compute @workgroup_size(64) fn twice(@builtin(global_invocation_id) id: vec3u) {
/// #         if id.x < arrayLength(&values) { values[id.x] *= 2.0; }
/// #     }";
/// # let gpu = Gpu::open(&Choice::from_env())?;
/// let kernel = gpu.kernel("twice", &[source], "twice", &[])?;
/// let (left, right) = (gpu.buffer_from("left", &[1.0_f32])?, gpu.buffer_from("right", &[3.0_f32])?);
/// let mut list = DispatchList::new();
/// for values in [&left, &right] {
///     // The list keeps what is bound.
///     list.dispatch(&kernel.bind(&gpu, &[("values", values)]), &[], 1);
/// }
/// gpu.submit(&list)?;
/// assert_eq!((left.read(&gpu)?, right.read(&gpu)?), (vec![2.0], vec![6.0]));
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
#[derive(Clone)]
pub struct Bound {
    kernel: Arc<Inner>,
    groups: Arc<[wgpu::BindGroup]>,
    most_groups: u32,
}

impl Gpu {
    /// Compiles the entry point `entry` of `sources`, whole WGSL texts that are put one behind the
    /// other, with values for its `override` declarations; names that it does not declare are let pass,
    /// so that one list serves several kernels. Its bindings are read from the source, and only those
    /// that the entry point uses. A source is read once for a device, and the kernels that were asked
    /// for last are kept, whoever asks for them next.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with the label and what the compiler said, or what [`Gpu::health`] says.
    pub fn kernel(
        &self,
        label: &str,
        sources: &[&str],
        entry: &str,
        overrides: &[(&str, f64)],
    ) -> Result<Kernel, GpuError> {
        self.health()?;
        let source = sources.join("\n");
        let key = Key::new(label, source, entry, overrides);
        if let Some(kernel) = self.cache().kernel(&key) {
            return Ok(kernel);
        }
        let wrong = |why| GpuError::Shader { label: label.to_owned(), why };
        let known = self.cache().module(key.source());
        let module = match known {
            Some(module) => module,
            None => {
                let parsed = Parsed::new(key.source()).map_err(wrong)?;
                let module = self.checked(label, || module(self.device(), label, &parsed))?;
                self.cache().keep_module(key.source(), Module { parsed, module })
            }
        };
        let read = module.parsed.reflect(entry, overrides).map_err(wrong)?;
        fits(&read, self.limits()).map_err(wrong)?;
        let (pipeline, layouts) = self.checked(label, || {
            let layouts = layouts(self.device(), label, &read.bindings);
            (pipeline(self.device(), label, &module.module, entry, &read.overrides, &layouts), layouts)
        })?;
        let Reflection { bindings, workgroup_size, reads_counts, .. } = read;
        let label = label.to_owned();
        let kernel =
            Kernel(Arc::new(Inner { label, pipeline, layouts, bindings, workgroup_size, reads_counts }));
        self.cache().keep_kernel(key, kernel.clone());
        Ok(kernel)
    }

    /// Runs what makes something of a shader.
    fn checked<R>(&self, label: &str, work: impl FnOnce() -> R) -> Result<R, GpuError> {
        let (made, error) = self.scoped(work);
        match error {
            // A device that is lost tells only its callback.
            None => self.health().map(|()| made),
            Some(error @ wgpu::Error::OutOfMemory { .. }) => Err(told(&error)),
            Some(error) => Err(GpuError::Shader { label: label.to_owned(), why: error.to_string() }),
        }
    }
}

fn module(device: &wgpu::Device, label: &str, parsed: &Parsed) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Naga(Cow::Owned(parsed.module.clone()));
    device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
}

/// wgpu checks these before `override` declarations have their values.
fn fits(read: &Reflection, limits: &wgpu::Limits) -> Result<(), String> {
    let [x, y, z] = read.workgroup_size;
    let most = limits.max_compute_invocations_per_workgroup;
    let [mx, my, mz] = [
        limits.max_compute_workgroup_size_x,
        limits.max_compute_workgroup_size_y,
        limits.max_compute_workgroup_size_z,
    ];
    let count = [x, y, z].into_iter().map(u64::from).fold(1, u64::saturating_mul);
    if x > mx || y > my || z > mz || count > most.into() {
        return Err(format!(
            "a workgroup of {x} × {y} × {z} invocations; this GPU allows {mx} × {my} × {mz} and {most} in all"
        ));
    }
    let limit = limits.max_compute_workgroup_storage_size;
    if read.shared > limit.into() {
        return Err(format!("a workgroup shares {} bytes; this GPU allows {limit}", read.shared));
    }
    Ok(())
}

/// One layout for each group up to the last that is used.
fn layouts(device: &wgpu::Device, label: &str, bindings: &[Binding]) -> Vec<wgpu::BindGroupLayout> {
    let count = bindings.last().map_or(0, |last| last.group + 1);
    let layout = |group| {
        let entries: Vec<_> = bindings.iter().filter(|one| one.group == group).map(layout_entry).collect();
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
    };
    (0..count).map(layout).collect()
}

fn layout_entry(one: &Binding) -> wgpu::BindGroupLayoutEntry {
    let ty = match one.access {
        Access::Uniform => wgpu::BufferBindingType::Uniform,
        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Access::ReadWrite => wgpu::BufferBindingType::Storage { read_only: false },
    };
    let has_dynamic_offset = is_told(one);
    wgpu::BindGroupLayoutEntry {
        binding: one.binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: NonZeroU64::new(one.size) },
        count: None,
    }
}

/// Whether each dispatch says by an offset what it sees here.
fn is_told(one: &Binding) -> bool {
    one.group == 0 && one.access == Access::Uniform
}

fn pipeline(
    device: &wgpu::Device,
    label: &str,
    module: &wgpu::ShaderModule,
    entry: &str,
    overrides: &[(String, f64)],
    layouts: &[wgpu::BindGroupLayout],
) -> wgpu::ComputePipeline {
    let layouts: Vec<_> = layouts.iter().map(Some).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    let constants: Vec<_> = overrides.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: Some(&layout),
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
        cache: None,
    })
}

impl Kernel {
    /// What the entry point uses, by group, then by binding.
    pub fn bindings(&self) -> &[Binding] {
        &self.0.bindings
    }

    /// The number of invocations of a workgroup in each dimension.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.0.workgroup_size
    }

    /// Binds `buffers` by the names that they have in the source. Names that the kernel does not use
    /// are let pass, so that one list serves several kernels. A buffer that is too small or of the
    /// wrong sort is seen in [`Gpu::health`].
    ///
    /// # Panics
    /// Where a name that the kernel uses is missing: a mistake of the caller.
    pub fn bind(&self, gpu: &Gpu, buffers: &[(&str, &dyn Bindable)]) -> Bound {
        let groups = (0..).zip(&self.0.layouts).map(|(group, layout)| {
            let entries: Vec<_> = self
                .0
                .bindings
                .iter()
                .filter(|one| one.group == group)
                .map(|one| wgpu::BindGroupEntry {
                    binding: one.binding,
                    resource: self.resource(one, buffers),
                })
                .collect();
            let label = Some(self.0.label.as_str());
            let descriptor = wgpu::BindGroupDescriptor { label, layout, entries: &entries };
            gpu.watched(|| gpu.device().create_bind_group(&descriptor))
        });
        let most_groups = gpu.limits().max_compute_workgroups_per_dimension;
        Bound { groups: groups.collect(), kernel: self.0.clone(), most_groups }
    }

    fn resource<'a>(&self, one: &Binding, buffers: &[(&str, &'a dyn Bindable)]) -> wgpu::BindingResource<'a> {
        let found = buffers.iter().find(|(name, _)| *name == one.name);
        let (_, buffer) =
            found.unwrap_or_else(|| panic!("kernel `{}` has no buffer for `{}`", self.0.label, one.name));
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: buffer.buffer(),
            offset: buffer.offset(),
            size: buffer.window(),
        })
    }
}

impl Bound {
    /// The kernel's label.
    pub fn label(&self) -> &str {
        &self.kernel.label
    }

    /// The most workgroups of one dimension.
    pub(crate) fn most_groups(&self) -> u32 {
        self.most_groups
    }

    pub(crate) fn reads_counts(&self) -> bool {
        self.kernel.reads_counts
    }

    pub(crate) fn check_offsets(&self, offsets: &[u32]) {
        let told = self.kernel.bindings.iter().filter(|one| is_told(one)).count();
        assert!(
            offsets.len() == told,
            "kernel `{}` takes {told} offsets, not {}",
            self.label(),
            offsets.len()
        );
    }

    pub(crate) fn set(&self, pass: &mut wgpu::ComputePass<'_>, offsets: &[u32]) {
        pass.set_pipeline(&self.kernel.pipeline);
        for (number, group) in (0..).zip(&*self.groups) {
            pass.set_bind_group(number, group, if number == 0 { offsets } else { &[] });
        }
    }
}
