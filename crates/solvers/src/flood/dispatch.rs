//! The choice of the code that runs on this processor.
//!
//! `wide` contains the code for processors with 64-bit registers, and `bytes` contains the code for
//! microcontrollers. This file and the SIMD files in `wide` contain all `unsafe` code.

#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "std"))]
use std::arch::is_x86_feature_detected as has;

use mmsim_maze::MazeSize;

use super::steps::is_small;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "avx512"))]
use super::wide::avx512::{Avx512Large, Avx512Small};
use super::wide::plane::ParityPlane;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::wide::sse2;

/// An instruction set for floods. All instruction sets give the same distances, so only benchmarks
/// need to choose one. All other code uses the [best](Self::best) available set.
///
/// ```
/// use mmsim_maze::{MazeSize, Walls};
/// use mmsim_solvers::{Distances, Instructions};
/// let (walls, goals) = (Walls::open(MazeSize::CLASSIC), MazeSize::CLASSIC.central_cells());
/// let expected = Distances::flood(&walls, &goals);
/// for instructions in Instructions::ALL {
///     assert_eq!(Distances::flood_with(*instructions, &walls, &goals), expected);
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Instructions {
    /// One byte per cell instead of one bit, which is the fastest way on processors with 32-bit
    /// registers. Mazes of more than 16×16 cells use [`Portable`](Self::Portable).
    Bytes,
    /// Operations on 64-bit words, which are available on every processor.
    Portable,
    /// SSE2, which every x86-64 processor has. Programs without an operating system may be compiled
    /// without SSE2.
    Sse2,
    /// AVX2 and BMI1, which most x86-64 processors since 2015 have.
    Avx2,
    /// AVX-512 with the BW and VL extensions, which most servers and some laptops have. AVX-512 is
    /// available only with the crate feature `avx512`.
    Avx512,
}

impl Instructions {
    /// All instruction sets. On processors with 64-bit registers, they are in ascending order of
    /// speed.
    pub const ALL: &'static [Self] =
        &[Self::Bytes, Self::Portable, Self::Sse2, Self::Avx2, Self::Avx512];

    /// True if the processor has 32-bit registers.
    // WebAssembly has 32-bit pointers, but 64-bit integers.
    pub(super) const PREFERS_BYTES: bool =
        !cfg!(any(target_pointer_width = "64", target_family = "wasm"));
    /// The instruction set to ask for if all are available.
    const PREFERRED: Self = if Self::PREFERS_BYTES { Self::Bytes } else { Self::Avx512 };

    /// Returns the best available instruction set.
    #[must_use]
    pub fn best() -> Self {
        if Self::PREFERS_BYTES {
            return Self::Bytes;
        }
        let mut from_best = Self::ALL.iter().copied().rev();
        from_best.find(|instructions| instructions.is_available()).unwrap_or(Self::Portable)
    }

    /// Returns true if this processor supports the instruction set and this crate was built with
    /// support for it. Without the `std` feature, only instruction sets that every processor of the
    /// target supports are available.
    pub fn is_available(self) -> bool {
        match self {
            Self::Bytes | Self::Portable => true,
            Self::Sse2 => cfg!(all(target_arch = "x86_64", target_feature = "sse2")),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "std"))]
            Self::Avx2 => has!("avx2") && has!("bmi1") && has!("popcnt"),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "std"))]
            #[cfg(feature = "avx512")]
            Self::Avx512 => {
                let has_avx512 = has!("avx512f") && has!("avx512bw") && has!("avx512vl");
                has_avx512 && has!("bmi1") && has!("popcnt")
            }
            #[allow(unreachable_patterns)] // depends on the target and the features
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Returns the name of the instruction set.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bytes => "bytes",
            Self::Portable => "portable",
            Self::Sse2 => "SSE2",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        }
    }
}

/// A computation that is compiled for each instruction set.
pub(super) trait Task: Sized {
    type Output;

    fn run<H: ParityPlane>(self) -> Self::Output;

    /// Does the same as [`run`](Self::run) in a small maze, with one byte per cell.
    fn run_on_bytes(self) -> Self::Output;
}

/// Runs a task with the best available instruction set.
#[inline]
pub(super) fn run<T: Task>(task: T, size: MazeSize) -> T::Output {
    run_with(Instructions::PREFERRED, task, size)
}

/// Runs a task with the given instruction set. Falls back to a slower instruction set if the given
/// one is not available.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(super) fn run_with<T: Task>(instructions: Instructions, task: T, size: MazeSize) -> T::Output {
    match (instructions, is_small(size)) {
        (Instructions::Bytes, true) => task.run_on_bytes(),
        (_, true) => task.run::<[u64; 2]>(),
        (_, false) => task.run::<[u64; 8]>(),
    }
}

/// Runs a task with the given instruction set. Falls back to a slower instruction set if the given
/// one is not available.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[allow(unsafe_code)]
// Inlined, so that a constant instruction set leaves only the check whether it is available.
#[inline]
pub(super) fn run_with<T: Task>(instructions: Instructions, task: T, size: MazeSize) -> T::Output {
    use Instructions::{Avx2, Avx512, Bytes, Portable, Sse2};
    // A single call, so that the result is written in place.
    let run: unsafe fn(T) -> T::Output = match (instructions, is_small(size)) {
        (Bytes, true) => T::run_on_bytes,
        (Portable, true) => T::run::<[u64; 2]>,
        (Bytes | Portable, false) => T::run::<[u64; 8]>,
        #[cfg(feature = "avx512")]
        (Avx512, true) if Avx512.is_available() => run_avx512::<Avx512Small, T>,
        #[cfg(feature = "avx512")]
        (Avx512, false) if Avx512.is_available() => run_avx512::<Avx512Large, T>,
        (Avx512 | Avx2, true) if Avx2.is_available() => run_avx2::<sse2::Sse2<1>, T>,
        (Avx512 | Avx2, false) if Avx2.is_available() => run_avx2::<sse2::Sse2<4>, T>,
        (Avx512 | Avx2 | Sse2, true) => T::run::<sse2::Sse2<1>>,
        (Avx512 | Avx2 | Sse2, false) => T::run::<sse2::Sse2<4>>,
    };
    // SAFETY: the processor supports the features of `run`. `is_available` has checked all of them
    // except SSE2.
    unsafe { run(task) }
}

/// Runs a task written for SSE2, but lets the compiler use AVX2 instructions.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[allow(unsafe_code)]
#[target_feature(enable = "avx2,bmi1,popcnt")]
unsafe fn run_avx2<H: ParityPlane, T: Task>(task: T) -> T::Output {
    task.run::<H>()
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "avx512"))]
#[allow(clippy::incompatible_msrv)] // The feature `avx512` needs Rust 1.89.
#[allow(unsafe_code)]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,bmi1,popcnt")]
unsafe fn run_avx512<H: ParityPlane, T: Task>(task: T) -> T::Output {
    task.run::<H>()
}
