//! What a kernel's source says of itself, read by naga: its bindings and its workgroup's size.

use std::collections::HashMap;
use wgpu::naga;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Module, ShaderStage, StorageAccess};

/// A buffer that a kernel uses, as its source declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The variable's name.
    pub name: String,
    /// Its `@group`.
    pub group: u32,
    /// Its `@binding`.
    pub binding: u32,
    /// What the kernel may do with it.
    pub access: Access,
    /// The least size of a buffer that would do [bytes].
    pub size: u64,
}

/// What a kernel may do with a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `var<uniform>`
    Uniform,
    /// `var<storage, read>`
    Read,
    /// `var<storage, read_write>`
    ReadWrite,
}

pub(crate) struct Reflection {
    /// By group, then by binding.
    pub bindings: Vec<Binding>,
    pub workgroup_size: [u32; 3],
}

/// Reads what `entry` uses of `source`.
///
/// # Errors
/// In the compiler's words, with the lines that it speaks of.
pub(crate) fn reflect(source: &str, entry: &str, overrides: &[(&str, f64)]) -> Result<Reflection, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|error| error.emit_to_string(source))?;
    let (index, point) = module
        .entry_points
        .iter()
        .enumerate()
        .find(|(_, point)| point.name == entry && point.stage == ShaderStage::Compute)
        .ok_or_else(|| format!("there is no compute entry point `{entry}` in it"))?;
    let _ = point;
    Ok(Reflection {
        bindings: bindings(&module, &info, index),
        workgroup_size: workgroup_size(&module, &info, entry, overrides)?,
    })
}

fn bindings(module: &Module, info: &ModuleInfo, entry: usize) -> Vec<Binding> {
    let uses = info.get_entry_point(entry);
    let used = module.global_variables.iter().filter(|(handle, _)| !uses[*handle].is_empty());
    let mut found: Vec<Binding> = used.filter_map(|(_, variable)| declared(module, variable)).collect();
    found.sort_by_key(|one| (one.group, one.binding));
    found
}

fn declared(module: &Module, variable: &naga::GlobalVariable) -> Option<Binding> {
    let at = variable.binding?;
    let access = match variable.space {
        AddressSpace::Uniform => Access::Uniform,
        AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Access::ReadWrite,
        AddressSpace::Storage { .. } => Access::Read,
        _ => return None,
    };
    let size = module.types[variable.ty].inner.size(module.to_ctx()).into();
    let name = variable.name.clone().unwrap_or_default();
    Some(Binding { name, group: at.group, binding: at.binding, access, size })
}

fn workgroup_size(
    module: &Module,
    info: &ModuleInfo,
    entry: &str,
    overrides: &[(&str, f64)],
) -> Result<[u32; 3], String> {
    let values: HashMap<String, f64> =
        overrides.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let values = values.into_iter().collect();
    let point = Some((ShaderStage::Compute, entry));
    let (fixed, _) = naga::back::pipeline_constants::process_overrides(module, info, point, &values)
        .map_err(|error| error.to_string())?;
    let point = fixed.entry_points.iter().find(|point| point.name == entry);
    point.map(|point| point.workgroup_size).ok_or_else(|| format!("entry point `{entry}` was lost"))
}
