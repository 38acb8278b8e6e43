//! The selection of instructions for a task.

use mmsim_maze::MazeSize;

#[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "avx512"))]
use super::avx512::{large_avx512, small_avx512};
use super::plane::is_small;
use super::processor::Instructions;
use super::task::Task;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::x86::{self, Sse2Large, large_avx2, small_avx2};

/// Runs a task with the best available instructions.
pub(super) fn run<T: Task>(task: T, size: MazeSize) -> T::Output {
    run_with(Instructions::Avx512, task, size)
}

/// Runs a task with the given instructions. Falls back to a lesser instruction set if the given
/// instructions are not available.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(super) fn run_with<T: Task>(_: Instructions, task: T, size: MazeSize) -> T::Output {
    if is_small(size) { small(task) } else { large(task) }
}

/// Runs a task with the given instructions. Falls back to a lesser instruction set if the given
/// instructions are not available.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
#[allow(unsafe_code)]
pub(super) fn run_with<T: Task>(instructions: Instructions, task: T, size: MazeSize) -> T::Output {
    use Instructions::{Avx2, Avx512, Portable, Sse2};
    let is_available = |some: Instructions| some.is_available();
    // A single call, so that the result is written in place.
    let run: unsafe fn(T) -> T::Output = match (instructions, is_small(size)) {
        (Portable, true) => small,
        (Portable, false) => large,
        #[cfg(feature = "avx512")]
        (Avx512, true) if is_available(Avx512) => small_avx512,
        #[cfg(feature = "avx512")]
        (Avx512, false) if is_available(Avx512) => large_avx512,
        (Avx512 | Avx2, true) if is_available(Avx2) => small_avx2,
        (Avx512 | Avx2, false) if is_available(Avx2) => large_avx2,
        (Avx512 | Avx2 | Sse2, true) => T::run::<2, x86::Sse2>,
        (Avx512 | Avx2 | Sse2, false) => T::run::<8, Sse2Large>,
    };
    // SAFETY: the processor supports the features of `run`. `is_available` has checked all of them
    // except SSE2.
    unsafe { run(task) }
}

/// Runs a task without vector instructions in a maze of up to 16×16 cells.
fn small<T: Task>(task: T) -> T::Output {
    task.run::<2, [u64; 2]>()
}

/// Runs a task without vector instructions in a larger maze.
fn large<T: Task>(task: T) -> T::Output {
    task.run::<8, [u64; 8]>()
}

/// Runs a task with each available instruction set and checks each result.
#[cfg(test)]
pub(super) fn with_each<T: Task>(
    task: impl Fn() -> T,
    size: MazeSize,
    check: impl FnMut(T::Output),
) {
    let available = Instructions::ALL.iter().filter(|instructions| instructions.is_available());
    available.map(|&instructions| run_with(instructions, task(), size)).for_each(check);
}
