//! Selection of the instruction set for a task.

use mmsim_maze::MazeSize;

use super::processor::Instructions;
use super::task::Task;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "avx512"))]
use super::wide::avx512::{Avx512Large, Avx512Small, run_avx512};
use super::wide::plane::is_small;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::wide::sse2::{self, run_avx2};

/// Runs a task with the best available instruction set.
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

/// Returns the available instruction sets.
#[cfg(test)]
pub(super) fn available() -> impl Iterator<Item = Instructions> {
    Instructions::ALL.iter().copied().filter(|instructions| instructions.is_available())
}
