//! After a loss every call says so, and none waits or panics.

use taffeta_gpu::{Choice, DispatchList, Gpu, GpuError};

use crate::{NUMBER, open, values};

fn is_lost<T>(result: Result<T, GpuError>) -> bool {
    matches!(result, Err(GpuError::Lost { .. }))
}

#[test]
fn every_call_after_a_loss_says_so() {
    let gpu = open();
    let source = "@group(0) @binding(0) var<storage, read_write> values: array<u32>;
        @compute @workgroup_size(1) fn main() { values[0] += 1u; }";
    let kernel = gpu.kernel("one", &[source], "main", &[]).expect("a kernel");
    let (state, host) = (values(&gpu, &[1, 2]), gpu.read_back("host", 2).expect("room"));
    let told = gpu.uniforms::<u32>("told", 1).expect("room");
    let bound = kernel.bind(&gpu, &[("values", &state)]);
    let mut list = DispatchList::new();
    list.dispatch(&bound, &[], 1);
    list.copy(&state, &host);
    gpu.submit(&list).expect("a submission");
    gpu.lose();
    assert!(is_lost(gpu.health()));
    assert!(is_lost(gpu.submit(&list)));
    assert!(is_lost(gpu.submit_timed(&list)));
    assert!(is_lost(gpu.wait()));
    assert!(is_lost(state.read(&gpu)));
    assert!(is_lost(host.take(&gpu, &mut vec![])));
    assert!(is_lost(gpu.buffer::<u32>("more", 1)));
    assert!(is_lost(gpu.kernel("two", &[NUMBER, source], "main", &[])));
    state.write(&gpu, 0, &[1]);
    told.write(&gpu, &[1]);
    kernel.bind(&gpu, &[("values", &state)]);
    assert_eq!(gpu.health().expect_err("lost").to_string(), "the GPU was lost: it was given up");
    assert!(open().health().is_ok(), "another device can be opened");
}

#[test]
fn a_read_back_under_way_or_arrived_is_lost_with_the_device() {
    for arrived in [false, true] {
        let gpu = open();
        let (state, host) = (values(&gpu, &[1, 2]), gpu.read_back("host", 2).expect("room"));
        let mut list = DispatchList::new();
        list.copy(&state, &host);
        gpu.submit(&list).expect("a submission");
        host.start();
        if arrived {
            gpu.wait().expect("a copy");
        }
        gpu.lose();
        let mut seen = vec![9];
        assert!(is_lost(host.take(&gpu, &mut seen)));
        assert!(is_lost(host.take(&gpu, &mut seen)));
        assert_eq!(seen, [9]);
    }
}

#[test]
fn a_command_that_the_device_refuses_is_seen_in_the_health() {
    let gpu = open();
    let buffer = values(&gpu, &[1]);
    // The tests' own mistake: nothing here would write outside of a buffer.
    gpu.queue().write_buffer(buffer.raw(), 64, &[0; 8]);
    let first = gpu.health().expect_err("it was refused");
    assert!(matches!(&first, GpuError::Failed { why } if why.contains("Queue::write_buffer")), "{first}");
    assert_eq!(gpu.submit(&DispatchList::new()), Err(first));
}

#[test]
fn an_adapter_that_is_not_there_is_told_with_those_that_are() {
    let all = taffeta_gpu::adapters();
    let error = Gpu::open(&Choice::Named("no such thing".to_owned())).map(|_| ()).expect_err("no adapter");
    let text = error.to_string();
    assert!(text.starts_with("TAFFETA_ADAPTER=`no such thing` fits no adapter; there "), "{text}");
    assert!(all.iter().all(|one| text.contains(&one.to_string())), "{text}");
    assert!(all.is_sorted_by_key(|one| one.is_software()), "hardware is first: {text}");
    assert_eq!(all, taffeta_gpu::adapters(), "the order stays");
}

#[test]
fn what_is_shared_between_threads_can_be() {
    fn shared<T: Send + Sync + 'static>() {}
    shared::<(Gpu, taffeta_gpu::Kernel, taffeta_gpu::Bound, DispatchList, GpuError)>();
    shared::<(taffeta_gpu::Buffer<f32>, taffeta_gpu::Uniforms<f32>, taffeta_gpu::ReadBack<f32>)>();
}
