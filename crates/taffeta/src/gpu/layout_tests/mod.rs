//! Records, bindings and constants as naga reads them from the WGSL, against those of the Rust side.

mod bindings;
mod constants;
mod records;

use crate::contact::colliders::gpu::Contact;
use crate::elements::load::gpu::GIVEN;
use crate::features::shaders;
use crate::gpu::kernels::Name;
use std::collections::BTreeSet;
use taffeta_gpu::wgpu::naga;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Handle, Module, Scalar, ScalarKind, Type, TypeInner};

/// The sources of every kernel, whatever it is put together with.
fn sources() -> BTreeSet<String> {
    let shaders = shaders();
    let mut all = BTreeSet::new();
    for file in shaders.with_kernels() {
        for contact in [Contact::Solids, Contact::Later, Contact::Meshes] {
            for loads in [&[][..], GIVEN] {
                let name = Name::new("").with(contact.choices()).with(loads);
                all.insert(name.source_of(file, &shaders).expect("what it imports"));
            }
        }
    }
    all
}

#[test]
fn a_kernel_is_in_the_source_of_its_file_alone() {
    let shaders = shaders();
    for (file, text) in shaders.files().filter(|(file, _)| shaders.with_kernels().any(|one| one == *file)) {
        let source = Name::new("").source_of(file, &shaders).expect("what it imports");
        let count = |text: &str| text.matches("\n@compute").count();
        assert_eq!(count(&source), count(text), "`{file}` imports a file that has kernels");
    }
}

/// A source as it stands.
fn read(source: &str) -> Module {
    naga::front::wgsl::parse_str(source).expect("sources that can be read")
}

/// A source with numbers in place of its overrides, without what no kernel uses.
fn fixed(source: &str) -> (Module, ModuleInfo) {
    let module = read(source);
    let check = |module: &Module| {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        validator.validate(module).expect("sources that are valid")
    };
    let info = check(&module);
    let (fixed, _) =
        naga::back::pipeline_constants::process_overrides(&module, &info, None, &Default::default())
            .expect("overrides that have numbers");
    let fixed = fixed.into_owned();
    let info = check(&fixed);
    (fixed, info)
}

/// A type in WGSL's words.
fn words(module: &Module, ty: Handle<Type>) -> String {
    let scalar = |Scalar { kind, width }: Scalar| {
        let letter = match kind {
            ScalarKind::Sint => 'i',
            ScalarKind::Uint => 'u',
            ScalarKind::Float => 'f',
            _ => '?',
        };
        format!("{letter}{}", 8 * u32::from(width))
    };
    let ty = &module.types[ty];
    match ty.inner {
        TypeInner::Scalar(one) => scalar(one),
        TypeInner::Vector { size, scalar: one } => format!("vec{}<{}>", size as u8, scalar(one)),
        TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } => {
            format!("array<{}, {count}>", words(module, base))
        }
        TypeInner::Array { base, .. } => format!("array<{}>", words(module, base)),
        _ => ty.name.clone().unwrap_or_default(),
    }
}
