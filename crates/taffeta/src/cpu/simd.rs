//! Run-time choice of the vector instructions that kernels are compiled for.
//!
//! Kernels are plain loops; each is compiled once per level. No level may change a result: kernels add, multiply,
//! divide and take correctly rounded roots, in an order that does not depend on the vector width.

use std::fmt;

/// A set of vector instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SimdLevel {
    /// What the target always has: SSE2 on x86-64, SIMD128 in WebAssembly that is built with it.
    Base,
    /// AVX2.
    Avx2,
    /// AVX-512 F, VL, DQ, BW.
    Avx512,
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Base if cfg!(target_arch = "x86_64") => "sse2",
            Self::Base if cfg!(target_feature = "simd128") => "simd128",
            Self::Base => "base",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        })
    }
}

/// Work that is compiled for every level. `run` and all it calls must be `#[inline(always)]`.
pub trait Kernel {
    /// What it returns.
    type Output;
    /// Does the work.
    fn run(self) -> Self::Output;
}

impl SimdLevel {
    /// The best level of this machine, or a lower one named by `TAFFETA_SIMD=sse2|avx2|avx512` (for tests).
    pub fn detect() -> Self {
        let best = Self::best();
        match std::env::var("TAFFETA_SIMD").as_deref() {
            Ok("sse2" | "base") => Self::Base,
            Ok("avx2") => best.min(Self::Avx2),
            _ => best,
        }
    }

    #[cfg(target_arch = "x86_64")]
    fn best() -> Self {
        let avx2 = is_x86_feature_detected!("avx2");
        let avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw");
        match (avx2, avx512) {
            (true, true) => Self::Avx512,
            (true, false) => Self::Avx2,
            _ => Self::Base,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn best() -> Self {
        Self::Base
    }

    /// Runs a kernel with this level's instructions.
    #[cfg(all(target_arch = "x86_64", not(test)))]
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
        fn avx512<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        #[target_feature(enable = "avx2")]
        fn avx2<K: Kernel>(kernel: K) -> K::Output {
            kernel.run()
        }
        match self {
            // SAFETY: a level above `Base` is only made by `best`, which found its instructions on this machine.
            Self::Avx512 => unsafe { avx512(kernel) },
            // SAFETY: as above.
            Self::Avx2 => unsafe { avx2(kernel) },
            Self::Base => kernel.run(),
        }
    }

    /// Runs a kernel. In this library's own tests, too: compiling all kernels again at each level would take longer than all of
    /// these tests, and those of the engine as a whole compare its levels.
    #[cfg(any(not(target_arch = "x86_64"), test))]
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        kernel.run()
    }
}

/// Has the cache line of `items[at]` fetched, which may be beyond their end. Hardware sees by itself that memory is read in
/// order, but begins again on every page, and kernels read many columns at a time.
#[inline(always)]
pub fn prefetch<T>(items: &[T], at: usize) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a hint; nothing is read, whatever the address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(items.as_ptr().wrapping_add(at).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, at);
}
