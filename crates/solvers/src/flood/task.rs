//! Tasks on parity planes, which run with any instruction set.

use super::plane::ParityPlane;

/// A computation on parity planes that is generic over the instruction set.
pub(super) trait Task {
    type Output;

    /// Runs the task on planes of `N` words. `N` is 2 in mazes of up to 16×16 cells and 8 in larger
    /// mazes.
    fn run<const N: usize, H: ParityPlane<N>>(self) -> Self::Output;
}
