//! All kernels, each with what it may import, in the driver's language.

use std::collections::BTreeSet;
use taffeta::extension::{choices, shaders};
use taffeta::taffeta_gpu::wgpu::naga;

use naga::back::pipeline_constants::process_overrides;
use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Module, ShaderStage};

/// A kernel as the driver gets it.
pub struct Spirv {
    pub entry: String,
    /// Files that stand for what it imports by a name.
    pub with: String,
    pub words: Vec<u32>,
    pub buffers: Vec<Buffer>,
}

/// A buffer of a kernel.
pub struct Buffer {
    pub group: u32,
    pub binding: u32,
    pub is_uniform: bool,
}

/// The kernels of all files, with all choices that change their files.
pub fn all() -> Result<Vec<Spirv>, String> {
    let shaders = shaders();
    let mut kernels = Vec::new();
    for file in shaders.with_kernels() {
        let mut seen = BTreeSet::new();
        for choices in choices(file) {
            let source = shaders.source(file, &choices)?;
            if !seen.insert(source.clone()) {
                continue;
            }
            let with: Vec<_> = choices.iter().map(|&(_, file)| file).collect();
            kernels.extend(
                compiled(&source, &with.join(" "))
                    .map_err(|error| format!("{file} with {with:?}: {error}"))?,
            );
        }
    }
    Ok(kernels)
}

fn compiled(source: &str, with: &str) -> Result<Vec<Spirv>, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    module.entry_points.iter().map(|point| entry(&module, &info, &point.name, with)).collect()
}

/// An entry point with the overrides that its source gives.
fn entry(module: &Module, info: &ModuleInfo, name: &str, with: &str) -> Result<Spirv, String> {
    let point = (ShaderStage::Compute, name);
    let (module, info) = process_overrides(module, info, Some(point), &Default::default())
        .map_err(|error| format!("{name}: {error}"))?;
    let pipeline = spv::PipelineOptions { shader_stage: point.0, entry_point: name.to_owned() };
    let words = spv::write_vec(&module, &info, &options(), Some(&pipeline))
        .map_err(|error| format!("{name}: {error}"))?;
    let index = module.entry_points.iter().position(|point| point.name == name);
    let uses = info.get_entry_point(index.ok_or_else(|| format!("{name} is gone"))?);
    let used = module.global_variables.iter().filter(|(handle, _)| !uses[*handle].is_empty());
    let buffers = used.filter_map(|(_, variable)| {
        let at = variable.binding?;
        Some(Buffer {
            group: at.group,
            binding: at.binding,
            is_uniform: variable.space == AddressSpace::Uniform,
        })
    });
    Ok(Spirv { entry: name.to_owned(), with: with.to_owned(), words, buffers: buffers.collect() })
}

/// As wgpu-hal 29 has them for a driver of Vulkan 1.3 that checks the bounds of buffers itself.
fn options() -> spv::Options<'static> {
    spv::Options {
        lang_version: (1, 6),
        flags: spv::WriterFlags::empty(),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Unchecked,
            image_load: BoundsCheckPolicy::Unchecked,
            binding_array: BoundsCheckPolicy::Unchecked,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::Native,
        force_loop_bounding: true,
        ..Default::default()
    }
}
