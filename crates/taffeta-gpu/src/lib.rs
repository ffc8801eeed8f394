//! Typed buffers, kernels whose bindings are read from their source, and lists of dispatches, on
//! any GPU that wgpu reaches. It knows nothing of what is computed.
//!
//! ```no_run
//! use taffeta_gpu::{Choice, DispatchList, Gpu};
//!
//! let source = "
//!     @group(2) @binding(0) var<storage, read_write> values: array<f32>;
//!     @compute @workgroup_size(64) fn twice(@builtin(global_invocation_id) id: vec3u) {
//!         if id.x < arrayLength(&values) { values[id.x] *= 2.0; }
//!     }";
//! let gpu = Gpu::open(&Choice::from_env())?;
//! let values = gpu.buffer_from("values", &[1.0_f32, 2.0, 3.0])?;
//! let twice = gpu.kernel("twice", &[source], "twice", &[])?.bind(&gpu, &[("values", &values)]);
//! let mut list = DispatchList::new();
//! list.dispatch(&twice, &[], 1);
//! gpu.submit(&list)?;
//! assert_eq!(values.read(&gpu)?, [2.0, 4.0, 6.0]);
//! # Ok::<(), taffeta_gpu::GpuError>(())
//! ```

mod adapter;
mod buffer;
mod cache;
mod dispatch;
mod error;
mod gpu;
mod kernel;
mod memory;
mod readback;
mod reflect;
mod shaders;
mod timing;

pub use adapter::{AdapterInfo, Choice, Kind, adapters};
pub use buffer::{Bindable, Buffer, Counts, Uniforms};
pub use bytemuck;
pub use dispatch::{DispatchList, GROUPS_IN_ROW};
pub use error::GpuError;
pub use gpu::Gpu;
pub use kernel::{Bound, Kernel};
pub use readback::ReadBack;
pub use reflect::{Access, Binding};
pub use shaders::{Shader, Shaders};
pub use timing::add_time;
pub use wgpu;
