//! Stages are timed on the device.

use taffeta_gpu::{Bound, Buffer, DispatchList, Gpu, GpuError};

use crate::{open, values};

fn spinning(gpu: &Gpu, sum: &Buffer<u32>) -> Bound {
    let source = "@group(0) @binding(0) var<storage, read_write> sum: array<u32>;
        @compute @workgroup_size(1) fn main() {
            for (var i = 0u; i < 20000u; i++) { sum[0] = sum[0] * 3u + i; }
        }";
    gpu.kernel("spin", &[source], "main", &[]).expect("a kernel").bind(gpu, &[("sum", sum)])
}

fn expected(rounds: usize) -> u32 {
    (0..rounds).fold(0, |sum, _| (0..20_000).fold(sum, |sum: u32, i| sum.wrapping_mul(3).wrapping_add(i)))
}

#[test]
fn stages_are_summed_in_the_order_in_which_they_first_appear() {
    let gpu = open();
    let sum = values(&gpu, &[0]);
    let spin = spinning(&gpu, &sum);
    let copy = values(&gpu, &[0]);
    let mut list = DispatchList::new();
    list.stage("one");
    list.dispatch(&spin, &[], 1);
    list.stage("many");
    (0..12).for_each(|_| list.dispatch(&spin, &[], 1));
    list.copy_buffer(&sum, &copy);
    list.stage("one");
    list.dispatch(&spin, &[], 1);
    if !gpu.has_timestamps() {
        assert_eq!(gpu.submit_timed(&list), Err(GpuError::NoTimestamps));
        return;
    }
    let times = gpu.submit_timed(&list).expect("times");
    assert_eq!(times.iter().map(|(stage, _)| *stage).collect::<Vec<_>>(), ["one", "many"]);
    assert!(times.iter().all(|&(_, seconds)| seconds > 0.0 && seconds < 10.0), "{times:?}");
    assert_eq!(copy.read(&gpu).expect("a copy"), [expected(13)]);
    assert_eq!(sum.read(&gpu).expect("a sum"), [expected(14)], "timed or not, it does the same");
    assert_eq!(gpu.submit_timed(&DispatchList::new()), Ok(vec![]));
}

#[test]
fn more_passes_than_a_query_set_holds_are_timed() {
    let gpu = open();
    let source = "@group(0) @binding(0) var<storage, read_write> sum: array<u32>;
        @compute @workgroup_size(1) fn main() { sum[0] += 1u; }";
    let sum = values(&gpu, &[0]);
    let add = gpu.kernel("add", &[source], "main", &[]).expect("a kernel").bind(&gpu, &[("sum", &sum)]);
    let mut list = DispatchList::new();
    for stage in ["even", "odd"].into_iter().cycle().take(2_100) {
        list.stage(stage);
        list.dispatch(&add, &[], 1);
    }
    match gpu.submit_timed(&list) {
        Ok(times) => assert_eq!((times.len(), sum.read(&gpu)), (2, Ok(vec![2_100]))),
        Err(error) => assert_eq!((error, gpu.has_timestamps()), (GpuError::NoTimestamps, false)),
    }
}
