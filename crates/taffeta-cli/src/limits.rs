//! What the machine can do at most: memory bandwidth and arithmetic, measured with the same threads as a bench.

use serde::Serialize;
use std::hint::black_box;
use std::sync::Barrier;
use std::time::Instant;

/// Length of each array of the triad, all threads together [float]: 64 MB, beyond most caches.
const TRIAD: usize = 16 << 20;
/// Independent sums a thread keeps in flight: more than latency times width on current processors.
const SUMS: usize = 256;
/// Rounds over the sums a try.
const ROUNDS: usize = 200_000;
/// Tries; the best counts.
const TRIES: usize = 5;

/// Measured limits.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Limits {
    /// Bytes read and written a second by a STREAM triad [GB/s].
    pub memory_gb_per_s: f64,
    /// Fused multiply-adds in f32, two operations each [GFLOP/s].
    pub fma_gflop_per_s: f64,
}

/// Measures both limits with `threads` threads.
pub fn measure(threads: usize) -> Limits {
    Limits { memory_gb_per_s: triad(threads), fma_gflop_per_s: fma(threads) }
}

/// STREAM triad a = b + s·c: two arrays read, one written.
fn triad(threads: usize) -> f64 {
    let chunk = TRIAD.div_ceil(threads);
    let seconds = best_of(threads, || {
        let (mut a, b, c) = (vec![0.0_f32; chunk], vec![1.0_f32; chunk], vec![2.0_f32; chunk]);
        // Each page is touched before the clock starts.
        a.fill(3.0);
        move || {
            let scale = black_box(0.5);
            for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
                *a = b + scale * c;
            }
            black_box(&mut a);
        }
    });
    let bytes = 3 * size_of::<f32>() * chunk * threads;
    bytes as f64 / seconds * 1e-9
}

fn fma(threads: usize) -> f64 {
    let seconds = best_of(threads, || {
        let mut sums = [1.0_f32; SUMS];
        move || {
            multiply_add(black_box(&mut sums));
        }
    });
    let operations = 2 * SUMS * ROUNDS * threads;
    operations as f64 / seconds * 1e-9
}

/// Shortest time [s] of `TRIES` in which all threads do the work that `prepare` makes for each of them.
fn best_of<W: FnMut()>(threads: usize, prepare: impl Fn() -> W + Sync) -> f64 {
    let (start, end) = (Barrier::new(threads), Barrier::new(threads));
    let work = |mut job: W| {
        let mut best = f64::INFINITY;
        for _ in 0..TRIES {
            start.wait();
            let clock = Instant::now();
            job();
            end.wait();
            best = best.min(clock.elapsed().as_secs_f64());
        }
        best
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(|| work(prepare()));
        }
        work(prepare())
    })
}

/// x = x·a + b on all sums, `ROUNDS` times, with the widest instructions there are.
#[cfg(target_arch = "x86_64")]
fn multiply_add(sums: &mut [f32; SUMS]) {
    #[target_feature(enable = "avx512f")]
    fn avx512(sums: &mut [f32; SUMS]) {
        for block in sums.as_chunks_mut::<256>().0 {
            rounds::<256>(block, f32::mul_add);
        }
    }
    #[target_feature(enable = "avx2,fma")]
    fn avx2(sums: &mut [f32; SUMS]) {
        for block in sums.as_chunks_mut::<64>().0 {
            rounds::<64>(block, f32::mul_add);
        }
    }
    if is_x86_feature_detected!("avx512f") {
        // SAFETY: the feature was just found.
        unsafe { avx512(sums) }
    } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the features were just found.
        unsafe { avx2(sums) }
    } else {
        base(sums);
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn multiply_add(sums: &mut [f32; SUMS]) {
    base(sums);
}

/// Without the instruction `mul_add` is a library call: a product and a sum instead.
fn base(sums: &mut [f32; SUMS]) {
    for block in sums.as_chunks_mut::<32>().0 {
        rounds::<32>(block, |x, a, b| x * a + b);
    }
}

/// Sums that fit the vector registers stay there.
#[inline(always)]
fn rounds<const N: usize>(block: &mut [f32; N], step: impl Fn(f32, f32, f32) -> f32) {
    let (a, b) = (black_box(0.999), black_box(0.001));
    let mut sums = *block;
    for _ in 0..ROUNDS {
        for x in &mut sums {
            *x = step(*x, a, b);
        }
    }
    *block = sums;
}
