//! Poses.

use core::fmt;

use crate::cell::Cell;
use crate::heading::{Heading, Step};

/// The cell and heading of a mouse.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pose {
    /// The cell of the mouse.
    pub cell: Cell,
    /// The direction in which the mouse faces.
    pub heading: Heading,
}

impl Pose {
    /// Creates a pose from a cell and a heading.
    pub const fn new(cell: Cell, heading: Heading) -> Self {
        Self { cell, heading }
    }

    /// Returns the pose after `step`, ignoring walls. Returns `None` if a coordinate of the new
    /// cell would be less than 0 or greater than 255.
    #[must_use]
    pub fn after(self, step: Step) -> Option<Self> {
        let heading = self.heading.turned(step);
        self.cell.neighbour(heading).map(|cell| Self { cell, heading })
    }
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} heading {}", self.cell, self.heading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_a_turn_and_one_cell() {
        let pose = Pose::new(Cell::new(5, 5), Heading::East);
        let ends: Vec<_> = Step::ALL.into_iter().map(|step| pose.after(step).unwrap()).collect();
        assert_eq!(ends[0], Pose::new(Cell::new(6, 5), Heading::East));
        assert_eq!(ends[1], Pose::new(Cell::new(5, 6), Heading::North));
        assert_eq!(ends[2], Pose::new(Cell::new(5, 4), Heading::South));
        assert_eq!(ends[3], Pose::new(Cell::new(4, 5), Heading::West));
        assert_eq!(Pose::new(Cell::new(0, 0), Heading::North).after(Step::Left), None);
        assert_eq!(pose.to_string(), "(5, 5) heading east");
    }
}
