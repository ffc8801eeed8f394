//! What a kernel may bind, and how large its workgroups are.

use crate::gpu::layout::{GROUP, SUBSTEPS_SEEN};
use crate::gpu::layout_tests::{fixed, read, sources};
use std::collections::BTreeMap;
use taffeta_gpu::wgpu::naga::valid::ModuleInfo;
use taffeta_gpu::wgpu::naga::{
    AddressSpace, GlobalVariable, Module, ResourceBinding, StorageAccess, TypeInner,
};

/// Buffers that a browser gives a kernel at least.
const MOST_STORAGE: usize = 8;
/// Memory of a workgroup that every device has [bytes].
const MOST_MEMORY: u32 = 16 << 10;
/// Told, fixed, state, scratch.
const GROUPS: u32 = 4;

/// The variables that the kernel with that number uses.
fn used<'m>(module: &'m Module, info: &ModuleInfo, kernel: usize) -> Vec<&'m GlobalVariable> {
    let uses = info.get_entry_point(kernel);
    let all = module.global_variables.iter();
    all.filter(|(handle, _)| !uses[*handle].is_empty()).map(|(_, variable)| variable).collect()
}

/// Calls `check` with each kernel's name and the variables that it uses.
fn each_kernel(check: impl Fn(&Module, &str, &[&GlobalVariable])) {
    for source in sources() {
        let (module, info) = fixed(&source);
        assert!(!module.entry_points.is_empty());
        for (number, point) in module.entry_points.iter().enumerate() {
            check(&module, &point.name, &used(&module, &info, number));
        }
    }
}

fn is_written(variable: &GlobalVariable) -> bool {
    matches!(variable.space, AddressSpace::Storage { access } if access.contains(StorageAccess::STORE))
}

#[test]
fn groups_are_what_is_told_what_is_fixed_the_state_and_scratch() {
    each_kernel(|_, kernel, variables| {
        for variable in variables {
            let Some(ResourceBinding { group, .. }) = variable.binding else { continue };
            let name = variable.name.as_deref().unwrap_or_default();
            let is_state = ["old_position", "old_velocity", "new_position", "new_velocity"].contains(&name);
            assert!(group < GROUPS, "{kernel}: `{name}` is in group {group}");
            assert!(group > 1 || !is_written(variable), "{kernel}: `{name}` of group {group} is written");
            assert_eq!(group == 2, is_state, "{kernel}: `{name}` is in group {group}");
            assert!(!name.starts_with("old_") || !is_written(variable), "{kernel} writes `{name}`");
            let is_uniform = variable.space == AddressSpace::Uniform;
            assert_eq!(is_uniform, name == "substeps", "{kernel}: `{name}` is in uniform memory");
        }
    });
}

#[test]
fn a_name_is_bound_at_one_place_in_all_sources() {
    let mut places: BTreeMap<String, ResourceBinding> = BTreeMap::new();
    for source in sources() {
        for (_, variable) in read(&source).global_variables.iter() {
            if let (Some(name), Some(place)) = (variable.name.clone(), variable.binding) {
                assert_eq!(*places.entry(name.clone()).or_insert(place), place, "`{name}`");
            }
        }
    }
}

#[test]
fn kernels_use_no_more_buffers_than_browsers_give() {
    each_kernel(|_, kernel, variables| {
        let storage = |one: &&&GlobalVariable| matches!(one.space, AddressSpace::Storage { .. });
        let count = variables.iter().filter(storage).count();
        assert!(
            count <= MOST_STORAGE,
            "{kernel} uses {count} storage buffers, {MOST_STORAGE} at most would do"
        );
    });
}

#[test]
fn workgroups_are_lines_with_little_memory() {
    const { assert!(GROUP <= 256, "more than every device has") };
    each_kernel(|module, kernel, variables| {
        let point = module.entry_points.iter().find(|point| point.name == kernel).expect("the kernel");
        let on_leaf_pairs = ["find_surface_contacts", "limit_ways", "push_nodes"].contains(&kernel);
        let width = if on_leaf_pairs { 64 } else { GROUP };
        assert_eq!(point.workgroup_size, [width as u32, 1, 1], "{kernel}");
        let shared = variables.iter().filter(|one| one.space == AddressSpace::WorkGroup);
        let bytes: u32 = shared.map(|one| module.types[one.ty].inner.size(module.to_ctx())).sum();
        assert!(
            bytes <= MOST_MEMORY,
            "{kernel} takes {bytes} bytes of a workgroup's memory of {MOST_MEMORY}"
        );
    });
}

#[test]
fn a_dispatch_sees_so_many_records_of_sub_steps() {
    let mut seen = 0;
    for source in sources() {
        let module = read(&source);
        let named = |one: &&GlobalVariable| one.name.as_deref() == Some("substeps");
        let found = module.global_variables.iter().find(|(_, one)| named(one));
        let Some((_, variable)) = found else { continue };
        seen += 1;
        let inner = &module.types[variable.ty].inner;
        assert!(matches!(inner, TypeInner::Array { .. }));
        let bytes = inner.size(module.to_ctx()) as usize;
        assert_eq!(bytes, SUBSTEPS_SEEN * size_of::<crate::gpu::layout::Substep>());
        // Uniform memory that every device has in one binding.
        assert!(bytes <= 16 << 10);
    }
    assert!(seen > 0, "no kernel is told of sub-steps");
}
