//! After new walls: a flood only when it is needed.

use mmsim_maze::{Cell, CellSet, Heading, Walls};

use super::{Distances, UNREACHABLE};

impl Distances {
    /// Brings these distances up to date after a mouse has learned the walls around a cell: floods
    /// anew only if that changes anything, and says whether it did. For these distances to be right
    /// afterwards they must have been so before for the same targets, and no wall may be another
    /// now but those around this cell.
    ///
    /// Distances are right if each cell is one step further than its nearest neighbour. New walls
    /// around a cell matter to that cell and its neighbours alone.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
    /// use mmsim_solvers::Distances;
    /// let (mut walls, goals) = (Walls::open(MazeSize::CLASSIC), MazeSize::CLASSIC.central_cells());
    /// let mut distances = Distances::flood(&walls, &goals);
    /// walls.set(Cell::new(0, 0), Heading::East, true);
    /// assert!(!distances.update(&walls, &goals, Cell::new(0, 0)), "north is as good");
    /// walls.set(Cell::new(0, 7), Heading::East, true);
    /// assert!(distances.update(&walls, &goals, Cell::new(0, 7)), "a detour now");
    /// assert_eq!(distances, Distances::flood(&walls, &goals));
    /// ```
    pub fn update(&mut self, walls: &Walls, targets: &CellSet, seen: Cell) -> bool {
        let changes = !self.stays_right(walls, seen);
        if changes {
            self.refill(walls, targets);
        }
        changes
    }

    /// Whether a step leads from this cell to one that is nearer, or it is a target itself. As long as
    /// a mouse that goes downhill learns of walls around itself alone, and none of them is gone, that
    /// makes sure that its own distance is still right.
    pub(crate) fn lead_on(&self, walls: &Walls, cell: Cell) -> bool {
        let (steps, around, sides) = (self.raw(cell), self.raw_around(cell), walls.sides(cell));
        // All asked at once, since nobody can predict the answers.
        let leads_on = |any: u8, heading: Heading| {
            let is_nearer = u8::from(around[heading as usize] < steps);
            any | u8::from(!sides.has(heading)) & is_nearer
        };
        steps == 0 || Heading::ALL.into_iter().fold(0, leads_on) > 0
    }

    /// Returns whether the distances are right with the walls around `seen`: open neighbours differ by
    /// at most one step, and `seen` and each cell behind a wall still have a nearer neighbour.
    fn stays_right(&self, walls: &Walls, seen: Cell) -> bool {
        if walls.size() != self.size {
            return false;
        }
        let (steps, around, sides) = (self.raw(seen), self.raw_around(seen), walls.sides(seen));
        let differs = |any: u8, heading: Heading| {
            let is_far = u8::from(steps.abs_diff(around[heading as usize]) > 1);
            any | u8::from(!sides.has(heading)) & is_far
        };
        let mut behind_walls = Heading::ALL.into_iter().filter(|&heading| sides.has(heading));
        Heading::ALL.into_iter().fold(0, differs) == 0
            && (steps == UNREACHABLE || self.lead_on(walls, seen))
            && behind_walls.all(|heading| {
                around[heading as usize] != steps.wrapping_add(1)
                    || seen
                        .neighbour(heading)
                        .filter(|&neighbour| self.size.contains(neighbour))
                        .is_none_or(|neighbour| self.lead_on(walls, neighbour))
            })
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::MazeSize;
    use proptest::prelude::*;

    use super::*;
    use crate::flood::tests::{any_targets, any_walls};

    proptest! {
        #[test]
        fn an_update_is_a_flood(
            mut walls in any_walls(),
            targets in any_targets(),
            changes in prop::collection::vec((0u8..32, 0u8..32, any::<[bool; 4]>()), 0..60),
        ) {
            let mut distances = Distances::flood(&walls, &targets);
            for (x, y, present) in changes {
                let cell = Cell::new(x % walls.size().width(), y % walls.size().height());
                for (heading, present) in Heading::ALL.into_iter().zip(present) {
                    walls.set(cell, heading, present);
                }
                let before = distances.clone();
                let changed = distances.update(&walls, &targets, cell);
                prop_assert_eq!(&distances, &Distances::flood(&walls, &targets));
                prop_assert!(changed || distances == before);
            }
        }
    }

    #[test]
    fn what_cannot_be_reached_may_be_reached_later_and_the_other_way_round() {
        let mut walls = Walls::closed(MazeSize::new(3, 1).unwrap());
        let (cell, targets) = (Cell::new(1, 0), [Cell::new(2, 0)].into_iter().collect());
        let mut distances = Distances::flood(&walls, &targets);
        walls.set(cell, Heading::West, false);
        assert!(!distances.update(&walls, &targets, cell), "both cannot be reached as before");
        walls.set(cell, Heading::East, false);
        assert!(distances.update(&walls, &targets, cell));
        assert_eq!(distances.at(Cell::new(0, 0)), Some(2));
        walls.set(cell, Heading::West, true);
        assert!(distances.update(&walls, &targets, cell));
        assert_eq!(distances.at(Cell::new(0, 0)), None);
    }
}
