//! Kernels run, and what they wrote is read back.

use taffeta_gpu::{Choice, DispatchList, Gpu};

#[test]
fn a_kernel_doubles_numbers() {
    let source = "
        @group(2) @binding(0) var<storage, read_write> values: array<f32>;
        @compute @workgroup_size(64) fn twice(@builtin(global_invocation_id) id: vec3u) {
            if id.x < arrayLength(&values) { values[id.x] *= 2.0; }
        }";
    let gpu = Gpu::open(&Choice::from_env()).expect("a GPU");
    let values = gpu.buffer_from("values", &[1.0_f32, 2.0, 3.0]).expect("a buffer");
    let twice = gpu.kernel("twice", &[source], "twice", &[]).expect("a kernel");
    let bound = twice.bind(&gpu, &[("values", &values)]);
    let mut list = DispatchList::new();
    list.dispatch(&bound, &[], 1);
    gpu.submit(&list).expect("a submission");
    assert_eq!(values.read(&gpu).expect("what was written"), [2.0, 4.0, 6.0]);
}
