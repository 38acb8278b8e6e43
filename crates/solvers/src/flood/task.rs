//! Tasks on parity planes. A task can run with any instruction set.

use super::plane::ParityPlane;

/// A computation on parity planes that is generic over the instruction set.
pub(super) trait Task {
    type Output;

    /// Runs the task on planes of type `H`, which must suit the size of the maze.
    fn run<H: ParityPlane>(self) -> Self::Output;
}
