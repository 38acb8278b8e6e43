//! Tasks: computations that can run with any instruction set.

use super::wide::plane::ParityPlane;

/// A computation on sets of cells that is generic over the instruction set.
pub(super) trait Task {
    type Output;

    /// Runs the task with bit sets of type `H`. `H::IS_SMALL` must be true for mazes of up to 16×16
    /// cells, and false for larger mazes.
    fn run<H: ParityPlane>(self) -> Self::Output;

    /// Runs the task in a maze of up to 16×16 cells with one byte per cell.
    fn run_on_bytes(self) -> Self::Output;
}
