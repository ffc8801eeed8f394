//! The GPU layer against a real driver; the software one is enough.

mod binding;
mod dispatch;
mod loss;
mod memory;
mod timing;

use taffeta_gpu::{Bindable, Buffer, Choice, DispatchList, Gpu};

/// What kernels of these tests have in common: their number of an invocation, in any dimensions.
const NUMBER: &str = "
    fn number(id: vec3u, counts: vec3u, lane: u32, size: u32) -> u32 {
        return (id.x + id.y * counts.x) * size + lane;
    }";

/// The GPU of `TAFFETA_ADAPTER`, or the best; a test without one fails and says what to install.
fn open() -> Gpu {
    Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}"))
}

fn values(gpu: &Gpu, data: &[u32]) -> Buffer<u32> {
    gpu.buffer_from("values", data).expect("room for values")
}

/// Runs the entry point `main` of `source` once.
fn run(gpu: &Gpu, source: &str, buffers: &[(&str, &dyn Bindable)], groups: u32) {
    let kernel = gpu.kernel("test", &[NUMBER, source], "main", &[]).expect("a kernel");
    let mut list = DispatchList::new();
    list.dispatch(&kernel.bind(gpu, buffers), &[], groups);
    gpu.submit(&list).expect("a submission");
}
