//! Buffers keep what was written, and are refused where they are too large.

use taffeta_gpu::{Buffer, DispatchList, Gpu, GpuError};

use crate::{open, values};

#[test]
fn a_buffer_reads_back_what_was_written() {
    let gpu = open();
    // The last is uploaded in two pieces, of which the second is odd.
    for count in [0_u32, 1, 3, 65_537, (8 << 20) + 3] {
        let data: Vec<u32> = (0..count).map(|i| i.wrapping_mul(2_654_435_761)).collect();
        let buffer = values(&gpu, &data);
        assert_eq!(buffer.len(), data.len());
        assert!(buffer.read(&gpu).expect("values") == data, "{count} values");
    }
}

#[test]
fn a_new_buffer_is_zero_and_a_write_changes_its_part_alone() {
    let gpu = open();
    let buffer: Buffer<[f32; 3]> = gpu.buffer("triples", 4).expect("room");
    buffer.write(&gpu, 1, &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    buffer.write(&gpu, 4, &[]);
    let zero = [0.0; 3];
    assert_eq!(buffer.read(&gpu).expect("triples"), [zero, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], zero]);
}

#[test]
#[should_panic(expected = "a write past the end of a buffer of 2")]
fn a_write_past_the_end_is_a_mistake_of_ours() {
    let gpu = open();
    values(&gpu, &[1, 2]).write(&gpu, 1, &[3, 4]);
}

#[test]
fn a_buffer_that_no_kernel_could_see_is_refused_with_the_numbers() {
    let gpu = open();
    let limit = gpu.largest_binding();
    let count = (limit / 4 + 1) as usize;
    let error = gpu.buffer::<u32>("springs", count).map(|_| ()).expect_err("too large");
    let bytes = 4 * count as u64;
    assert_eq!(
        error.to_string(),
        format!("buffer `springs` would take {bytes} bytes, and this GPU allows {limit}")
    );
    let endless = gpu.buffer::<[u32; 8]>("springs", usize::MAX).map(|_| ());
    assert!(matches!(endless, Err(GpuError::TooLarge { bytes: u64::MAX, .. })), "{endless:?}");
    let told = gpu.uniforms::<u32>("told", usize::MAX).map(|_| ());
    assert!(matches!(told, Err(GpuError::TooLarge { what: "uniform buffer", .. })), "{told:?}");
    let told = gpu.uniforms::<[u32; 1 << 20]>("told", 1).map(|_| ());
    assert!(matches!(told, Err(GpuError::TooLarge { what: "uniform record", .. })), "{told:?}");
    assert_eq!((gpu.memory_used(), gpu.health()), (0, Ok(())), "nothing was asked of the device");
}

#[test]
fn memory_is_counted_as_long_as_it_is_used() {
    let gpu = open();
    let large: Buffer<u32> = gpu.buffer("large", 1_000).expect("room");
    let empty: Buffer<[u32; 2]> = gpu.buffer("empty", 0).expect("room");
    assert_eq!((large.bytes(), empty.bytes(), gpu.memory_used()), (4_000, 8, 4_008));
    drop(large);
    assert_eq!(gpu.memory_used(), 8);
}

#[test]
fn a_read_back_can_be_taken_later_and_used_again() {
    let gpu = open();
    let (buffer, host) = (values(&gpu, &[1, 2, 3]), gpu.read_back("host", 3).expect("room"));
    let mut list = DispatchList::new();
    list.copy(&buffer, &host);
    let mut seen = vec![9; 7];
    for first in [1, 5] {
        buffer.write(&gpu, 0, &[first]);
        gpu.submit(&list).expect("a submission");
        assert!(!host.ready(&gpu), "it was not asked for");
        host.start();
        gpu.wait().expect("a copy");
        assert!(host.ready(&gpu));
        // What is written after the copy is not in it.
        buffer.write(&gpu, 0, &[7]);
        host.take(&gpu, &mut seen).expect("a copy");
        assert_eq!(seen, [first, 2, 3]);
    }
}

#[test]
fn a_device_of_somebody_else_is_used_as_it_is() {
    let owner = open();
    let info = owner.device().adapter_info();
    let gpu = Gpu::on(owner.device().clone(), owner.queue().clone(), info);
    assert_eq!(gpu.info(), owner.info());
    assert_eq!(values(&gpu, &[4, 5]).read(&gpu).expect("values"), [4, 5]);
    owner.lose();
    let after = gpu.buffer_from("values", &[1]).and_then(|buffer| buffer.read(&gpu));
    assert!(after.is_err(), "{after:?}");
    assert_eq!(gpu.health().map(|()| vec![]), after);
}
