//! Selection of the instruction set for a task.

use mmsim_maze::MazeSize;

#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "avx512"))]
use super::avx512::{Avx512Large, Avx512Small, run_avx512};
use super::plane::is_small;
use super::processor::Instructions;
use super::task::Task;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::x86::{self, run_avx2};

/// Runs a task with the best available instruction set.
pub(super) fn run<T: Task>(task: T, size: MazeSize) -> T::Output {
    run_with(Instructions::Avx512, task, size)
}

/// Runs a task with the given instruction set. Falls back to a slower instruction set if the given
/// one is not available.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(super) fn run_with<T: Task>(_: Instructions, task: T, size: MazeSize) -> T::Output {
    if is_small(size) { task.run::<[u64; 2]>() } else { task.run::<[u64; 8]>() }
}

/// Runs a task with the given instruction set. Falls back to a slower instruction set if the given
/// one is not available.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[allow(unsafe_code)]
pub(super) fn run_with<T: Task>(instructions: Instructions, task: T, size: MazeSize) -> T::Output {
    use Instructions::{Avx2, Avx512, Portable, Sse2};
    // A single call, so that the result is written in place.
    let run: unsafe fn(T) -> T::Output = match (instructions, is_small(size)) {
        (Portable, true) => T::run::<[u64; 2]>,
        (Portable, false) => T::run::<[u64; 8]>,
        #[cfg(feature = "avx512")]
        (Avx512, true) if Avx512.is_available() => run_avx512::<Avx512Small, T>,
        #[cfg(feature = "avx512")]
        (Avx512, false) if Avx512.is_available() => run_avx512::<Avx512Large, T>,
        (Avx512 | Avx2, true) if Avx2.is_available() => run_avx2::<x86::Sse2<1>, T>,
        (Avx512 | Avx2, false) if Avx2.is_available() => run_avx2::<x86::Sse2<4>, T>,
        (Avx512 | Avx2 | Sse2, true) => T::run::<x86::Sse2<1>>,
        (Avx512 | Avx2 | Sse2, false) => T::run::<x86::Sse2<4>>,
    };
    // SAFETY: the processor supports the features of `run`. `is_available` has checked all of them
    // except SSE2.
    unsafe { run(task) }
}

/// Runs a task with each available instruction set and calls `check` with each result.
#[cfg(test)]
pub(super) fn with_each<T: Task>(
    task: impl Fn() -> T,
    size: MazeSize,
    check: impl FnMut(T::Output),
) {
    let available = Instructions::ALL.iter().filter(|instructions| instructions.is_available());
    available.map(|&instructions| run_with(instructions, task(), size)).for_each(check);
}
