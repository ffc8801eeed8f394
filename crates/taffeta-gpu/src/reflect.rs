//! What a kernel's source says of itself, read by naga: its bindings and its workgroup's size.

use std::error::Error;

use wgpu::naga;

use naga::back::pipeline_constants::process_overrides;
use naga::front::wgsl::parse_str;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Module, ShaderStage, StorageAccess};

/// A buffer that a kernel uses, as its source declares it.
///
/// ```no_run
/// use taffeta_gpu::{Access, Binding, Choice, Gpu};
///
/// let source = "
///     @group(1) @binding(3) var<storage, read> weights: array<f32, 8>;
///     @group(2) @binding(0) var<storage, read_write> sum: f32;
///     @compute @workgroup_size(1) fn add() { sum += weights[7]; }";
/// let gpu = Gpu::open(&Choice::from_env())?;
/// let kernel = gpu.kernel("add", &[source], "add", &[])?;
/// let (name, access) = ("weights".to_owned(), Access::Read);
/// assert_eq!(kernel.bindings()[0], Binding { name, group: 1, binding: 3, access, size: 32 });
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
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
///
/// ```
/// use taffeta_gpu::{Access, Kernel};
///
/// /// Names of the buffers that a kernel may change.
/// fn outputs(kernel: &Kernel) -> impl Iterator<Item = &str> {
///     let written = kernel.bindings().iter().filter(|one| one.access == Access::ReadWrite);
///     written.map(|one| one.name.as_str())
/// }
/// ```
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
    /// Those that it declares.
    pub overrides: Vec<(String, f64)>,
    /// By group, then by binding.
    pub bindings: Vec<Binding>,
    pub workgroup_size: [u32; 3],
    /// Memory that the invocations of a workgroup share [bytes].
    pub shared: u64,
    /// Whether it asks for `num_workgroups`.
    pub reads_counts: bool,
}

/// A source that was read.
pub(crate) struct Parsed {
    /// As naga has it.
    pub module: Module,
    info: ModuleInfo,
}

impl Parsed {
    /// Reads a source.
    ///
    /// # Errors
    /// In the compiler's words, with the lines that it speaks of.
    pub fn new(source: &str) -> Result<Self, String> {
        let module = parse_str(source).map_err(|error| error.emit_to_string(source))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .map_err(|error| error.emit_to_string(source))?;
        Ok(Self { module, info })
    }

    /// What `entry` uses, where overrides have these values.
    ///
    /// # Errors
    /// In the compiler's words.
    pub fn reflect(&self, entry: &str, overrides: &[(&str, f64)]) -> Result<Reflection, String> {
        let index = point_of(&self.module, entry)?;
        let is_declared =
            |name: &str| self.module.overrides.iter().any(|(_, one)| one.name.as_deref() == Some(name));
        let declared_here = overrides.iter().filter(|(name, _)| is_declared(name));
        let overrides: Vec<_> = declared_here.map(|&(name, value)| (name.to_owned(), value)).collect();
        let values = overrides.iter().cloned().collect();
        let point = Some((ShaderStage::Compute, self.module.entry_points[index].name.as_str()));
        let (module, info) =
            process_overrides(&self.module, &self.info, point, &values).map_err(|error| in_full(&error))?;
        let index = point_of(&module, entry)?;
        let uses = info.get_entry_point(index);
        let used = || module.global_variables.iter().filter(|(handle, _)| !uses[*handle].is_empty());
        let mut bindings: Vec<Binding> =
            used().filter_map(|(_, variable)| declared(&module, variable)).collect();
        bindings.sort_by_key(|one| (one.group, one.binding));
        let point = &module.entry_points[index];
        let reads_counts = point.function.arguments.iter().any(|argument| asks(&module, argument));
        let shared = used().filter(|(_, variable)| variable.space == AddressSpace::WorkGroup);
        Ok(Reflection {
            overrides,
            bindings,
            workgroup_size: point.workgroup_size,
            reads_counts,
            shared: shared.map(|(_, variable)| size(&module, variable).next_multiple_of(16)).sum(),
        })
    }
}

fn point_of(module: &Module, entry: &str) -> Result<usize, String> {
    let is_it = |point: &naga::EntryPoint| point.name == entry && point.stage == ShaderStage::Compute;
    let found = module.entry_points.iter().position(is_it);
    found.ok_or_else(|| format!("there is no compute entry point `{entry}` in it"))
}

/// An error and what is behind it.
fn in_full(error: &dyn Error) -> String {
    let chain = std::iter::successors(Some(error), |&error| error.source());
    chain.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

fn size(module: &Module, variable: &naga::GlobalVariable) -> u64 {
    module.types[variable.ty].inner.size(module.to_ctx()).into()
}

/// Whether an argument, or a member of it, is `num_workgroups`.
fn asks(module: &Module, argument: &naga::FunctionArgument) -> bool {
    let is_it = |binding: &Option<naga::Binding>| {
        matches!(binding, Some(naga::Binding::BuiltIn(naga::BuiltIn::NumWorkGroups)))
    };
    let members = match &module.types[argument.ty].inner {
        naga::TypeInner::Struct { members, .. } => &members[..],
        _ => &[],
    };
    is_it(&argument.binding) || members.iter().any(|member| is_it(&member.binding))
}

fn declared(module: &Module, variable: &naga::GlobalVariable) -> Option<Binding> {
    let at = variable.binding?;
    let access = match variable.space {
        AddressSpace::Uniform => Access::Uniform,
        AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Access::ReadWrite,
        AddressSpace::Storage { .. } => Access::Read,
        _ => return None,
    };
    let name = variable.name.clone().unwrap_or_default();
    Some(Binding { name, group: at.group, binding: at.binding, access, size: size(module, variable) })
}
