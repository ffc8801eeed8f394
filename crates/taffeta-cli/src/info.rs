//! `taffeta info`: what this build and this machine are.

use crate::console;
use crate::gpu;
use crate::limits;
use taffeta::taffeta_gpu::{AdapterInfo, adapters};
use taffeta_io::program::{Failure, processor};

/// Say what this build and this machine are
#[derive(clap::Args)]
pub struct Args {
    /// Measure memory bandwidth and arithmetic, with one thread and with all
    #[arg(long)]
    limits: bool,
}

/// Prints it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
    console::say(&format!(
        "taffeta {}\ncpu: {}, {arch}, {os}\nsimd: {}\nthreads: {threads}\n{}",
        env!("CARGO_PKG_VERSION"),
        processor(),
        taffeta::simd_level(),
        gpus(),
    ))?;
    if !args.limits {
        return Ok(());
    }
    let mut counts = vec![1, threads];
    counts.dedup();
    for count in counts {
        let found = limits::measure(count);
        console::say(&format!(
            "limits, {count} thread{}: memory {:.1} GB/s (STREAM triad), arithmetic {:.0} GFLOP/s (f32 FMA)",
            if count == 1 { "" } else { "s" },
            found.memory_gb_per_s,
            found.fma_gflop_per_s
        ))?;
    }
    Ok(())
}

/// The adapters, numbered as `TAFFETA_ADAPTER` takes them, and that which would be taken.
fn gpus() -> String {
    let all = adapters();
    let mut lines: Vec<String> = all.iter().enumerate().map(adapter).collect();
    lines.push(match gpu::open() {
        Ok(gpu) => {
            let most = crate::memory::size(gpu.largest_binding());
            format!("--backend gpu takes {}; its kernels see {most} in one piece at most", gpu.info())
        }
        Err(error) if all.is_empty() => format!("gpu: {error}"),
        Err(error) => format!("--backend gpu: {error}"),
    });
    lines.join("\n")
}

fn adapter((number, one): (usize, &AdapterInfo)) -> String {
    let driver = if one.driver.is_empty() { String::new() } else { format!(", driver {}", one.driver) };
    format!("gpu {number}: {one}{driver}")
}
