//! Which of its instructions a processor floods with.

use mmsim_maze::{CellSet, MazeSize, Walls};

use super::half::Half;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::x86::run_with;
use super::{Distances, Flood};

/// Instructions that a flood can be made of. All give the same distances, so that only benchmarks
/// need to choose; everything else takes the [best](Self::best).
///
/// ```
/// use mmsim_maze::{MazeSize, Walls};
/// use mmsim_solvers::{Distances, Instructions};
/// let (walls, goals) = (Walls::open(MazeSize::CLASSIC), MazeSize::CLASSIC.central_cells());
/// let expected = Distances::flood(&walls, &goals);
/// for instructions in Instructions::ALL {
///     assert_eq!(Distances::flood_with(instructions, &walls, &goals), expected);
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// What any processor has: words of 64 bits.
    Portable,
    /// What any x86-64 processor has, but not every program that runs without an operating system uses.
    Sse2,
    /// AVX2 and BMI1, as nearly all of them since 2015 have them.
    Avx2,
    /// AVX-512 with the extensions BW and VL, as most servers' and some laptops' processors have it.
    Avx512,
}

impl Instructions {
    /// All of them, the best last.
    pub const ALL: [Self; 4] = [Self::Portable, Self::Sse2, Self::Avx2, Self::Avx512];

    /// The best that this processor has. Without the feature `std` it cannot be asked whether it has
    /// more than all of its kind.
    pub fn best() -> Self {
        Self::ALL
            .into_iter()
            .rfind(|instructions| instructions.is_available())
            .unwrap_or(Self::Portable)
    }

    /// Whether this processor has them.
    pub fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            Self::Sse2 => cfg!(all(target_arch = "x86_64", target_feature = "sse2")),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "std"))]
            Self::Avx2 => {
                use std::arch::is_x86_feature_detected as has;
                has!("avx2") && has!("bmi1") && has!("popcnt")
            }
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2", feature = "std"))]
            Self::Avx512 => {
                use std::arch::is_x86_feature_detected as has;
                let has_avx512 = has!("avx512f") && has!("avx512bw") && has!("avx512vl");
                has_avx512 && has!("bmi1") && has!("popcnt")
            }
            #[cfg(not(all(target_arch = "x86_64", target_feature = "sse2", feature = "std")))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Their name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Sse2 => "SSE2",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        }
    }
}

impl Distances {
    /// As [`flood`](Self::flood), but with these instructions, or with lesser ones if the processor
    /// does not have them.
    pub fn flood_with(instructions: Instructions, walls: &Walls, targets: &CellSet) -> Self {
        run_with(instructions, Flood { walls, targets }, walls.size())
    }
}

/// Something to be done with halves of a maze, of the kind that the processor is best at.
pub(super) trait Task {
    type Output;

    /// `N` is 2 in mazes of up to 16×16 cells, 8 in larger ones.
    fn run<const N: usize, H: Half<N>>(self) -> Self::Output;
}

/// Does this with the best instructions.
pub(super) fn run<T: Task>(task: T, size: MazeSize) -> T::Output {
    run_with(Instructions::Avx512, task, size)
}

/// Does this with these instructions, or with lesser ones if they are not there.
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
fn run_with<T: Task>(_: Instructions, task: T, size: MazeSize) -> T::Output {
    if super::is_small(size) { small(task) } else { large(task) }
}

/// In a maze of up to 16×16 cells.
pub(super) fn small<T: Task>(task: T) -> T::Output {
    task.run::<2, [u64; 2]>()
}

/// In a larger one.
pub(super) fn large<T: Task>(task: T) -> T::Output {
    task.run::<8, [u64; 8]>()
}

/// Does this with all instructions that are there.
#[cfg(test)]
pub(super) fn with_each<T: Task>(
    task: impl Fn() -> T,
    size: MazeSize,
    check: impl FnMut(T::Output),
) {
    let there = Instructions::ALL.into_iter().filter(|instructions| instructions.is_available());
    there.map(|instructions| run_with(instructions, task(), size)).for_each(check);
}
