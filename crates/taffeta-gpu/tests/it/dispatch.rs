//! Dispatches reach every workgroup, in the order in which they were recorded.

use taffeta_gpu::{DispatchList, GROUPS_IN_ROW, GpuError};

use crate::{NUMBER, open, run, values};

const COUNT: &str = "
    @group(2) @binding(0) var<storage, read_write> values: array<atomic<u32>>;
    @compute @workgroup_size(2)
    fn main(@builtin(workgroup_id) id: vec3u, @builtin(num_workgroups) counts: vec3u,
            @builtin(local_invocation_index) lane: u32) {
        let i = number(id, counts, lane, 2u);
        if i < arrayLength(&values) { atomicAdd(&values[i], 1u); }
    }";

#[test]
fn each_of_many_workgroups_runs_once() {
    let gpu = open();
    let groups = gpu.limits().max_compute_workgroups_per_dimension * 2 + 3;
    let counts = values(&gpu, &vec![0; 2 * groups as usize]);
    run(&gpu, COUNT, &[("values", &counts)], groups);
    let counts = counts.read(&gpu).expect("counts");
    assert_eq!(counts.iter().position(|&count| count != 1), None);
}

#[test]
fn no_workgroups_change_nothing() {
    let gpu = open();
    let counts = values(&gpu, &[7]);
    run(&gpu, COUNT, &[("values", &counts)], 0);
    assert_eq!(counts.read(&gpu).expect("counts"), [7]);
}

#[test]
fn more_workgroups_than_two_dimensions_hold_are_refused_with_the_numbers() {
    let gpu = open();
    let most = gpu.limits().max_compute_workgroups_per_dimension;
    let Some(groups) = most.checked_mul(GROUPS_IN_ROW).and_then(|all| all.checked_add(1)) else { return };
    let kernel = gpu.kernel("count", &[NUMBER, COUNT], "main", &[]).expect("a kernel");
    let mut list = DispatchList::new();
    list.dispatch(&kernel.bind(&gpu, &[("values", &values(&gpu, &[0]))]), &[], groups);
    let limit = u64::from(groups) - 1;
    assert_eq!(gpu.submit(&list), Err(GpuError::TooManyGroups { label: "count".into(), groups, limit }));
    assert_eq!(gpu.health(), Ok(()), "nothing of it reached the device");
}

/// Each takes from its left neighbour, so that an order other than the recorded one shows.
const SHIFT: &str = "
    @group(0) @binding(0) var<storage, read> old: array<u32>;
    @group(0) @binding(1) var<storage, read_write> next: array<u32>;
    @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
        let n = arrayLength(&old);
        if id.x < n { next[id.x] = 3u * old[(id.x + n - 1u) % n] + id.x; }
    }";

fn shifted(old: &[u32]) -> Vec<u32> {
    let n = old.len();
    (0..n).map(|i| old[(i + n - 1) % n].wrapping_mul(3).wrapping_add(i as u32)).collect()
}

#[test]
fn dispatches_of_one_pass_see_what_those_before_them_wrote() {
    let gpu = open();
    let mut expected: Vec<u32> = (0..1_000).collect();
    let (a, b) = (values(&gpu, &expected), values(&gpu, &vec![0; 1_000]));
    let kernel = gpu.kernel("shift", &[SHIFT], "main", &[]).expect("a kernel");
    let there = kernel.bind(&gpu, &[("old", &a), ("next", &b)]);
    let back = kernel.bind(&gpu, &[("old", &b), ("next", &a)]);
    let mut list = DispatchList::new();
    for _ in 0..10 {
        list.dispatch(&there, &[], 16);
        list.dispatch(&back, &[], 16);
    }
    gpu.submit(&list).expect("a submission");
    // A list can be submitted again.
    gpu.submit(&list).expect("a submission");
    for _ in 0..40 {
        expected = shifted(&expected);
    }
    assert_eq!(a.read(&gpu).expect("values"), expected);
}

#[test]
fn a_copy_between_dispatches_takes_what_is_there_then() {
    let gpu = open();
    let start = [1, 2, 3, 4, 5];
    let (a, b, kept) = (values(&gpu, &start), values(&gpu, &[0; 5]), values(&gpu, &[9; 3]));
    let host = gpu.read_back("host", 5).expect("room");
    let kernel = gpu.kernel("shift", &[SHIFT], "main", &[]).expect("a kernel");
    let mut list = DispatchList::new();
    list.dispatch(&kernel.bind(&gpu, &[("old", &a), ("next", &b)]), &[], 1);
    list.copy_buffer(&b, &kept);
    list.copy(&b, &host);
    list.dispatch(&kernel.bind(&gpu, &[("old", &a), ("next", &b)]), &[], 1);
    list.dispatch(&kernel.bind(&gpu, &[("old", &b), ("next", &a)]), &[], 1);
    gpu.submit(&list).expect("a submission");
    let once = shifted(&start);
    let mut seen = Vec::new();
    host.take(&gpu, &mut seen).expect("a copy");
    assert_eq!(seen, once);
    assert_eq!(kept.read(&gpu).expect("a copy"), once[..3], "as many as both have");
    assert_eq!(a.read(&gpu).expect("values"), shifted(&once));
}

#[test]
#[should_panic(expected = "kernel `shift` takes 0 offsets, not 1")]
fn an_offset_for_no_uniform_is_a_mistake_of_ours() {
    let gpu = open();
    let (a, b) = (values(&gpu, &[1]), values(&gpu, &[1]));
    let kernel = gpu.kernel("shift", &[SHIFT], "main", &[]).expect("a kernel");
    DispatchList::new().dispatch(&kernel.bind(&gpu, &[("old", &a), ("next", &b)]), &[256], 1);
}

/// Writes how many workgroups come next.
const COUNTED: &str = "
    @group(1) @binding(0) var<storage, read> wanted: array<u32>;
    @group(2) @binding(0) var<storage, read_write> counts: array<u32>;
    @compute @workgroup_size(64) fn main(@builtin(local_invocation_index) lane: u32) {
        if lane < arrayLength(&counts) { counts[lane] = wanted[lane]; }
    }";

const ADD: &str = "
    @group(2) @binding(0) var<storage, read_write> values: array<u32>;
    @compute @workgroup_size(1) fn main(@builtin(workgroup_id) id: vec3u) {
        values[id.x + 3u * id.y] += 1u;
    }";

fn counted(wanted: &[u32]) -> Vec<u32> {
    let gpu = open();
    let (counts, values) = (gpu.counts("counts", 2).expect("room"), values(&gpu, &[0; 6]));
    let writes = gpu.kernel("write", &[COUNTED], "main", &[]).expect("a kernel");
    let adds = gpu.kernel("add", &[ADD], "main", &[]).expect("a kernel");
    let wanted = crate::values(&gpu, wanted);
    let mut list = DispatchList::new();
    list.dispatch(&writes.bind(&gpu, &[("wanted", &wanted), ("counts", &counts)]), &[], 1);
    let adds = adds.bind(&gpu, &[("values", &values)]);
    list.dispatch_counted(&adds, &[], &counts, 0);
    list.dispatch_counted(&adds, &[], &counts, 1);
    gpu.submit(&list).expect("a submission");
    values.read(&gpu).expect("values")
}

#[test]
fn a_kernel_tells_the_next_one_how_many_workgroups_it_has() {
    assert_eq!(counted(&[3, 1, 1, 1, 2, 1]), [2, 1, 1, 1, 0, 0]);
}

#[test]
fn a_kernel_that_counts_no_workgroups_makes_the_next_one_do_nothing() {
    assert_eq!(counted(&[0, 1, 1, 0, 1, 1]), [0; 6]);
    assert_eq!(counted(&[0, 1, 1, 1, 1, 1]), [1, 0, 0, 0, 0, 0], "the second has counts of its own");
}

#[test]
fn counts_that_the_kernel_itself_writes_are_refused() {
    let gpu = open();
    let counts = gpu.counts("counts", 2).expect("room");
    let writes = gpu.kernel("write", &[COUNTED], "main", &[]).expect("a kernel");
    let wanted = values(&gpu, &[1; 6]);
    let mut list = DispatchList::new();
    list.dispatch_counted(&writes.bind(&gpu, &[("wanted", &wanted), ("counts", &counts)]), &[], &counts, 0);
    let error = gpu.submit(&list).expect_err("two usages at once").to_string();
    assert!(error.contains("counts"), "{error}");
}

#[test]
#[should_panic(expected = "kernel `count` reads num_workgroups, which an indirect dispatch does not provide")]
fn a_kernel_that_asks_for_counts_is_not_run_by_them() {
    let gpu = open();
    let (counts, values) = (gpu.counts("counts", 1).expect("room"), values(&gpu, &[0]));
    let kernel = gpu.kernel("count", &[NUMBER, COUNT], "main", &[]).expect("a kernel");
    DispatchList::new().dispatch_counted(&kernel.bind(&gpu, &[("values", &values)]), &[], &counts, 0);
}
