//! The walls and the planner of the published robots.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use mmsim_maze::{Cell, CellMap, CellSet, Heading, MazeSize, Pose};

use crate::trial::sensor_headings;

/// The walls that a published robot has seen, each on the side from which the robot saw it. On the
/// other side, the wall still counts as open.
#[derive(Clone, Debug)]
pub(crate) struct OneSidedWalls {
    size: MazeSize,
    /// For each heading of [`ORDER`], the cells from which a wall was seen in that direction.
    sides: [CellSet; 4],
}

/// The order in which the published planner visits the neighbours of a cell.
const ORDER: [Heading; 4] = [Heading::North, Heading::West, Heading::South, Heading::East];

impl OneSidedWalls {
    /// Creates walls of which none has been seen.
    pub(crate) const fn new(size: MazeSize) -> Self {
        Self { size, sides: [CellSet::EMPTY; 4] }
    }

    /// Stores the walls that the sensors of a robot at `pose` see. Walls in front of them, which
    /// only faulty readings or a wrong pose can cause, are deleted.
    pub(crate) fn observe(&mut self, pose: Pose, sensors: [u8; 3]) {
        let headings = sensor_headings(pose.heading);
        for (heading, walls) in ORDER.into_iter().zip(&mut self.sides) {
            let Some(sensor) = headings.iter().position(|&other| other == heading) else {
                continue;
            };
            let mut here = pose.cell;
            for _ in 0..sensors[sensor] {
                walls.remove(here);
                let Some(next) = self.size.neighbour(here, heading) else { break };
                here = next;
            }
            walls.insert(here);
        }
    }

    /// Plans a path with the published A* search. Returns the heading and the length in cells of
    /// its first straight, or `None` if there is no path or `from` is the target.
    ///
    /// Cells are numbered in the order in which the search reaches them. A cell is reached only
    /// once, even if a shorter path to it is found later. The cell with the lowest sum of its steps
    /// and the `heuristic` is expanded first; ties are broken by the steps, then from west to east,
    /// then from south to north. The path is traced back from the target by moving from each cell
    /// to the neighbour with the lowest number.
    pub(crate) fn first_straight(
        &self,
        from: Cell,
        target: Cell,
        heuristic: impl Fn(Cell) -> u16,
    ) -> Option<(Heading, usize)> {
        let numbers = self.numbers(from, target, heuristic);
        let (mut cell, mut straight) = (target, None);
        while numbers[cell]? > 0 {
            let before = (0..4).filter_map(|place| {
                let before = self.size.neighbour(cell, ORDER[place].back())?;
                self.beyond(before, place)?;
                Some((numbers[before]?, before, ORDER[place]))
            });
            let (_, before, heading) = before.min_by_key(|&(number, ..)| number)?;
            straight = match straight {
                Some((same, cells)) if same == heading => Some((heading, cells + 1)),
                _ => Some((heading, 1)),
            };
            cell = before;
        }
        straight
    }

    /// Returns, for each cell that the search reaches, the number of cells reached before it.
    fn numbers(
        &self,
        from: Cell,
        target: Cell,
        heuristic: impl Fn(Cell) -> u16,
    ) -> CellMap<Option<u16>> {
        let mut numbers = CellMap::new(None);
        let mut open = BinaryHeap::from([Reverse((heuristic(from), 0_u16, from.x, from.y))]);
        numbers[from] = Some(0);
        let mut reached = 0;
        while let Some(Reverse((_, steps, x, y))) = open.pop() {
            let cell = Cell::new(x, y);
            if cell == target && cell != from {
                numbers[cell] = Some(reached + 1);
                break;
            }
            for next in (0..4).filter_map(|place| self.beyond(cell, place)) {
                let number = &mut numbers[next];
                if number.is_none() {
                    reached += 1;
                    *number = Some(reached);
                    open.push(Reverse((steps + 1 + heuristic(next), steps + 1, next.x, next.y)));
                }
            }
        }
        numbers
    }

    /// Returns the neighbour of `cell` in direction `ORDER[place]`, or `None` if a wall was seen
    /// from `cell` in that direction.
    fn beyond(&self, cell: Cell, place: usize) -> Option<Cell> {
        let next = self.size.neighbour(cell, ORDER[place]);
        next.filter(|_| !self.sides[place].contains(cell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_closes_only_the_side_from_which_it_was_seen() {
        let mut walls = OneSidedWalls::new(MazeSize::new(3, 1).unwrap());
        let [west, east] = [0, 2].map(|x| Cell::new(x, 0));
        assert_eq!(walls.first_straight(west, east, |_| 0), Some((Heading::East, 2)));
        walls.observe(Pose { cell: west, heading: Heading::East }, [0, 1, 0]);
        assert_eq!(walls.first_straight(west, east, |_| 0), None);
        assert_eq!(walls.first_straight(east, west, |_| 0), Some((Heading::West, 2)));
        assert_eq!(walls.first_straight(west, west, |_| 0), None, "no path to follow");
    }

    #[test]
    fn later_readings_reopen_a_side() {
        let mut walls = OneSidedWalls::new(MazeSize::new(3, 1).unwrap());
        let (west, east) = (Cell::new(0, 0), Cell::new(2, 0));
        let pose = Pose { cell: west, heading: Heading::North };
        walls.observe(pose, [0, 0, 0]);
        assert_eq!(walls.first_straight(west, east, |_| 0), None);
        walls.observe(pose, [0, 0, 2]);
        assert_eq!(walls.first_straight(west, east, |_| 0), Some((Heading::East, 2)));
    }
}
