//! Bindings are read from the source, and buffers find them by name.

use taffeta_gpu::{Access, DispatchList, GpuError};

use crate::{open, values};

#[repr(C)]
#[derive(Clone, Copy, taffeta_gpu::bytemuck::Pod, taffeta_gpu::bytemuck::Zeroable)]
#[bytemuck(crate = "taffeta_gpu::bytemuck")]
struct Told {
    factor: u32,
    summand: u32,
}

const SOURCE: &str = "
    struct Told { factor: u32, summand: u32 }
    @group(0) @binding(3) var<uniform> told: Told;
    @group(1) @binding(0) var<storage, read> weights: array<u32>;
    @group(1) @binding(1) var<storage, read> unused: array<vec4f>;
    @group(3) @binding(7) var<storage, read_write> values: array<u32>;
    override SIZE: u32 = 4;
    override STEP: u32;
    var<workgroup> shared_sum: array<u32, SIZE * 2>;

    @compute @workgroup_size(SIZE) fn affine(@builtin(global_invocation_id) id: vec3u) {
        if id.x < arrayLength(&values) {
            values[id.x] = told.factor * values[id.x] * weights[id.x] + told.summand;
        }
    }
    @compute @workgroup_size(SIZE, 2) fn reversed(@builtin(local_invocation_index) lane: u32) {
        shared_sum[lane] = values[lane];
        workgroupBarrier();
        values[lane] = shared_sum[2 * SIZE - 1 - lane] + STEP;
    }";

#[test]
fn a_kernel_has_the_bindings_that_its_entry_point_uses() {
    let gpu = open();
    let affine = gpu.kernel("affine", &[SOURCE], "affine", &[("SIZE", 8.0)]).expect("a kernel");
    let found: Vec<_> =
        affine.bindings().iter().map(|b| (&*b.name, b.group, b.binding, b.access, b.size)).collect();
    let expected = [
        ("told", 0, 3, Access::Uniform, 8),
        ("weights", 1, 0, Access::Read, 4),
        ("values", 3, 7, Access::ReadWrite, 4),
    ];
    assert_eq!(found, expected);
    assert_eq!(affine.workgroup_size(), [8, 1, 1]);
    let reversed = gpu.kernel("reversed", &[SOURCE], "reversed", &[("STEP", 1.0)]).expect("a kernel");
    assert_eq!(reversed.bindings().iter().map(|b| &*b.name).collect::<Vec<_>>(), ["values"]);
    assert_eq!(reversed.workgroup_size(), [4, 2, 1]);
}

#[test]
fn a_kernel_alone_in_its_source_has_no_binding_that_it_leaves_alone() {
    let gpu = open();
    let source = "
        @group(0) @binding(0) var<storage, read_write> unused: array<u32>;
        @group(0) @binding(1) var<storage, read_write> values: array<u32>;
        fn first() -> u32 { return values[0]; }
        @compute @workgroup_size(1) fn main() { values[1] = first(); }";
    let kernel = gpu.kernel("alone", &[source], "main", &[]).expect("a kernel");
    assert_eq!(kernel.bindings().iter().map(|b| &*b.name).collect::<Vec<_>>(), ["values"]);
    assert_eq!(gpu.health(), Ok(()));
}

#[test]
fn each_dispatch_sees_the_record_that_its_offset_chooses() {
    let gpu = open();
    let told = gpu.uniforms("told", 3).expect("uniforms");
    told.write(&gpu, &[(2, 1), (0, 0), (3, 5)].map(|(factor, summand)| Told { factor, summand }));
    let (weights, state) = (values(&gpu, &[1, 10]), values(&gpu, &[1, 2]));
    // One list of names serves several kernels: `elsewhere` is not one of this kernel's.
    let affine = gpu.kernel("affine", &[SOURCE], "affine", &[]).expect("a kernel");
    let bound = affine
        .bind(&gpu, &[("elsewhere", &state), ("values", &state), ("told", &told), ("weights", &weights)]);
    let mut list = DispatchList::new();
    list.dispatch(&bound, &[told.offset(0)], 1);
    list.dispatch(&bound, &[told.offset(2)], 1);
    gpu.submit(&list).expect("a submission");
    assert_eq!(state.read(&gpu).expect("values"), [3 * 3 + 5, 41 * 3 * 10 + 5]);
}

#[test]
fn an_override_sizes_the_workgroup_and_its_memory() {
    let gpu = open();
    let state = values(&gpu, &[0, 1, 2, 3, 4, 5]);
    let overrides = [("SIZE", 3.0), ("STEP", 100.0)];
    let reversed = gpu.kernel("reversed", &[SOURCE], "reversed", &overrides).expect("a kernel");
    assert_eq!(reversed.workgroup_size(), [3, 2, 1]);
    let mut list = DispatchList::new();
    list.dispatch(&reversed.bind(&gpu, &[("values", &state)]), &[], 1);
    gpu.submit(&list).expect("a submission");
    assert_eq!(state.read(&gpu).expect("values"), [105, 104, 103, 102, 101, 100]);
}

#[test]
#[should_panic(expected = "kernel `affine` has no buffer for `weights`")]
fn a_missing_buffer_is_a_mistake_of_ours() {
    let gpu = open();
    let (told, state) = (gpu.uniforms::<Told>("told", 1).expect("uniforms"), values(&gpu, &[1]));
    let affine = gpu.kernel("affine", &[SOURCE], "affine", &[]).expect("a kernel");
    affine.bind(&gpu, &[("values", &state), ("told", &told)]);
}

#[test]
fn a_buffer_that_is_too_small_for_its_binding_is_seen_in_the_health() {
    let gpu = open();
    let source = "@group(0) @binding(0) var<storage, read_write> four: array<u32, 4>;
        @compute @workgroup_size(1) fn main() { four[3] = 1; }";
    let kernel = gpu.kernel("four", &[source], "main", &[]).expect("a kernel");
    kernel.bind(&gpu, &[("four", &values(&gpu, &[1, 2]))]);
    assert!(matches!(gpu.health(), Err(GpuError::Failed { why }) if why.contains("four")));
}

#[test]
fn a_wrong_source_is_told_with_its_line() {
    let gpu = open();
    let wrong = |sources: &[&str], entry, overrides: &[_]| {
        gpu.kernel("springs", sources, entry, overrides).map(|_| ()).expect_err(entry).to_string()
    };
    let text = wrong(&["fn fine() {}", "fn main() { let x: u32 = 1.5; }"], "main", &[]);
    assert!(text.starts_with("kernel `springs`: ") && text.contains("let x: u32 = 1.5"), "{text}");
    let text = wrong(&["@compute @workgroup_size(1) fn other() {}"], "main", &[]);
    assert_eq!(text, "kernel `springs`: there is no compute entry point `main` in it");
    let text = wrong(&[SOURCE], "reversed", &[]);
    assert!(text.contains("STEP"), "{text}");
    let text = wrong(&[SOURCE], "reversed", &[("STEP", 1.0), ("SIZE", 4096.0)]);
    assert!(text.starts_with("kernel `springs`: a workgroup of 4096 × 2 × 1 invocations; "), "{text}");
    let shares = "override N = 1; var<workgroup> much: array<vec4f, N>;
        @compute @workgroup_size(1) fn main() { much[0].x = 1.0; }";
    let text = wrong(&[shares], "main", &[("N", 1e6)]);
    assert!(text.starts_with("kernel `springs`: a workgroup shares 16000000 bytes; "), "{text}");
    assert_eq!(gpu.health(), Ok(()), "a wrong source is told once, by the call that was given it");
}
