//! Updating distances after walls have changed.

use mmsim_maze::{Cell, CellSet, Heading, Walls};

use super::{Distances, UNREACHABLE};

impl Distances {
    /// Updates the distances after the walls around `seen` have changed. Floods the maze again if
    /// any distance changes. Returns true if the maze was flooded.
    ///
    /// The distances must have been correct for the same targets before the change, and no other
    /// walls may have changed. If the size of the maze has changed, the maze is always flooded.
    ///
    /// Distances are correct if the distance of each reachable cell, except for the targets, is one
    /// more than the smallest distance among its open neighbours. If only the walls around `seen`
    /// have changed, it is enough to check `seen` and its neighbours.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
    /// use mmsim_solvers::Distances;
    /// let (mut walls, goals) = (Walls::open(MazeSize::CLASSIC), MazeSize::CLASSIC.central_cells());
    /// let mut distances = Distances::flood(&walls, &goals);
    /// walls.set(Cell::new(0, 0), Heading::East, true);
    /// assert!(!distances.update(&walls, &goals, Cell::new(0, 0)), "north is as short");
    /// walls.set(Cell::new(0, 7), Heading::East, true);
    /// assert!(distances.update(&walls, &goals, Cell::new(0, 7)), "now a detour");
    /// assert_eq!(distances, Distances::flood(&walls, &goals));
    /// ```
    pub fn update(&mut self, walls: &Walls, targets: &CellSet, seen: Cell) -> bool {
        let changes = !self.remains_correct(walls, seen);
        if changes {
            self.reflood(walls, targets);
        }
        changes
    }

    /// Returns true if the cell is a target or has an open neighbour nearer to a target. Suppose
    /// that a mouse always goes downhill, never removes a wall, and adds walls only around its own
    /// cell. If this method returns true for the mouse's cell, the distance of that cell is still
    /// correct.
    pub(crate) fn is_downhill_open(&self, walls: &Walls, cell: Cell) -> bool {
        let (steps, around, sides) = (self.raw(cell), self.raw_around(cell), walls.sides(cell));
        // This code has no branches, because branches would be unpredictable.
        let is_downhill = |any: u8, heading: Heading| {
            let is_nearer = u8::from(around[heading as usize] < steps);
            any | u8::from(!sides.has(heading)) & is_nearer
        };
        steps == 0 || Heading::ALL.into_iter().fold(0, is_downhill) > 0
    }

    /// Returns true if the distances are still correct after the walls around `seen` have changed.
    /// They are correct if the distance of each open neighbour of `seen` differs from that of
    /// `seen` by at most one step, and neither `seen` nor a neighbour behind a wall has lost its
    /// last open neighbour nearer to a target.
    fn remains_correct(&self, walls: &Walls, seen: Cell) -> bool {
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
            && (steps == UNREACHABLE || self.is_downhill_open(walls, seen))
            && behind_walls.all(|heading| {
                around[heading as usize] != steps.wrapping_add(1)
                    || seen
                        .neighbour(heading)
                        .filter(|&neighbour| self.size.contains(neighbour))
                        .is_none_or(|neighbour| self.is_downhill_open(walls, neighbour))
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
        fn an_update_equals_a_flood(
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
    fn cells_become_reachable_and_unreachable() {
        let mut walls = Walls::closed(MazeSize::new(3, 1).unwrap());
        let (cell, targets) = (Cell::new(1, 0), [Cell::new(2, 0)].into_iter().collect());
        let mut distances = Distances::flood(&walls, &targets);
        walls.set(cell, Heading::West, false);
        assert!(!distances.update(&walls, &targets, cell), "both are still unreachable");
        walls.set(cell, Heading::East, false);
        assert!(distances.update(&walls, &targets, cell));
        assert_eq!(distances.at(Cell::new(0, 0)), Some(2));
        walls.set(cell, Heading::West, true);
        assert!(distances.update(&walls, &targets, cell));
        assert_eq!(distances.at(Cell::new(0, 0)), None);
    }
    #[test]
    fn a_maze_of_another_size_is_flooded() {
        let (cell, targets) = (Cell::new(0, 0), [Cell::new(1, 1)].into_iter().collect());
        for (before, after) in [(2, 3), (3, 2), (2, 17), (17, 2), (17, 18), (18, 17)] {
            let open = |side| Walls::open(MazeSize::new(side, side).unwrap());
            let mut distances = Distances::flood(&open(before), &targets);
            assert!(!distances.update(&open(before), &targets, cell));
            assert!(distances.update(&open(after), &targets, cell), "{before} to {after}");
            assert_eq!(distances, Distances::flood(&open(after), &targets));
        }
    }
}
