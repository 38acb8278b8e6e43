//! The trail of a mouse: the last passage between each pair of neighbouring cells.

use mmsim_maze::{Cell, Heading, MazeSize, Pose, Wall};

use crate::movement::{MovementRules, Transition};
use crate::phases::Phases;

/// The path of a mouse, of which only the last passage between each pair of neighbouring cells is
/// kept. The size of a trail therefore depends on the maze and not on the length of the path.
///
/// ```
/// use mmsim_maze::{Cell, Heading, MazeSize, Pose};
/// use mmsim_run::Trail;
///
/// let mut trail = Trail::new(MazeSize::CLASSIC);
/// trail.drive([Cell::new(0, 0), Cell::new(0, 1), Cell::new(0, 0)]);
/// assert_eq!(trail.passages(), [Pose::new(Cell::new(0, 1), Heading::South)]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trail {
    size: MazeSize,
    /// The number of passages so far.
    count: u32,
    last: Option<Cell>,
    /// The last passage through each wall, in the order of [`MazeSize::walls`].
    crossings: Box<[Crossing]>,
}

/// The last passage through a wall that is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Crossing {
    /// The number of the passage, counted from 1, or 0 if there was none.
    number: u32,
    /// True if the mouse was heading south or west.
    is_backward: bool,
}

impl Trail {
    /// Creates the trail of a mouse that has no pose yet.
    pub fn new(size: MazeSize) -> Self {
        let crossings = vec![Crossing::default(); 2 * size.area()].into();
        Self { size, count: 0, last: None, crossings }
    }

    /// Adds the newest state of a run. A mouse that was put back at the start or that jumped leaves no
    /// passage.
    pub fn add(&mut self, rules: &MovementRules, phases: &Phases) {
        let Some(pose) = phases.pose else { return };
        match (self.last, phases.transition) {
            (Some(last), Some(Transition::Move { .. })) => {
                self.drive(rules.cells_between(last, pose.cell));
            }
            _ => self.last = Some(pose.cell),
        }
    }

    /// Adds a path through neighbouring cells. Cells outside the maze, and cells that are not
    /// neighbours of the previous one, leave no passage.
    pub fn drive(&mut self, cells: impl IntoIterator<Item = Cell>) {
        for to in cells {
            let Some(from) = self.last.replace(to) else { continue };
            let heading = Heading::ALL.into_iter().find(|&side| from.neighbour(side) == Some(to));
            let wall = heading.map(|heading| Wall::new(from, heading));
            if let Some(index) = wall.and_then(|wall| self.size.wall_index(wall)) {
                self.count = self.count.saturating_add(1);
                let is_backward = matches!(heading, Some(Heading::South | Heading::West));
                self.crossings[index] = Crossing { number: self.count, is_backward };
            }
        }
    }

    /// Returns the last passage between each pair of neighbouring cells that the mouse has crossed,
    /// oldest first: the cell that it left, and the direction of the step.
    pub fn passages(&self) -> Vec<Pose> {
        let crossed = self.size.walls().zip(&self.crossings).filter_map(|(wall, crossing)| {
            let Wall { cell, heading, .. } = wall;
            let passage = if crossing.is_backward {
                Pose::new(cell.neighbour(heading)?, heading.back())
            } else {
                Pose::new(cell, heading)
            };
            (crossing.number > 0).then_some((crossing.number, passage))
        });
        let mut crossed: Vec<(u32, Pose)> = crossed.collect();
        crossed.sort_unstable_by_key(|&(number, _)| number);
        crossed.into_iter().map(|(_, passage)| passage).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use mmsim_maze::{Maze, Walls};
    use proptest::prelude::*;

    use super::*;

    fn rules(walls: Option<Walls>) -> MovementRules {
        MovementRules::new(
            Pose::new(Cell::new(0, 0), Heading::North),
            MazeSize::CLASSIC.central_cells(),
            walls,
        )
    }

    #[test]
    fn moves_leave_passages_and_jumps_do_not() {
        use Heading::{East, North, South, West};
        let pose = |x, y, heading| Pose::new(Cell::new(x, y), heading);
        let (rules, mut phases, mut trail) =
            (rules(None), Phases::default(), Trail::new(MazeSize::CLASSIC));
        let mut add = |pose: Pose| {
            phases.add(&rules, pose, false);
            trail.add(&rules, &phases);
            trail.passages()
        };
        add(pose(0, 0, North));
        for (x, y, heading) in [(0, 3, North), (2, 3, East), (0, 0, North), (0, 1, North)] {
            add(pose(x, y, heading));
        }
        let expected = [pose(0, 1, North), pose(0, 2, North), pose(0, 3, East), pose(1, 3, East)];
        assert_eq!(add(pose(9, 9, North)), [&expected[..], &[pose(0, 0, North)]].concat());
        add(pose(0, 1, North));
        assert_eq!(add(pose(0, 0, South)), [&expected[..], &[pose(0, 1, South)]].concat());
        assert_eq!(add(pose(0, 0, West)).len(), 5, "a turn");
    }

    #[test]
    fn a_diagonal_goes_around_walls() {
        for (drawing, corner) in [
            ("o---o---o\n|     G |\no---o   o\n| S     |\no---o---o\n", Cell::new(1, 0)),
            ("o---o---o\n|     G |\no   o   o\n| S |   |\no---o---o\n", Cell::new(0, 1)),
        ] {
            let maze: Maze = drawing.parse().unwrap();
            let (rules, mut phases, mut trail) =
                (MovementRules::from_maze(&maze), Phases::default(), Trail::new(maze.size()));
            for pose in [maze.start(), Pose::new(Cell::new(1, 1), Heading::North)] {
                phases.add(&rules, pose, false);
                trail.add(&rules, &phases);
            }
            assert_eq!(trail.passages()[1].cell, corner);
        }
    }

    proptest! {
        /// Compares a trail with the whole path.
        #[test]
        fn a_trail_keeps_the_last_passage_between_cells(
            headings in prop::collection::vec(0usize..4, 0..200),
        ) {
            let size = MazeSize::new(4, 4).unwrap();
            let mut trail = Trail::new(size);
            let mut last: BTreeMap<[Cell; 2], (usize, Pose)> = BTreeMap::new();
            let mut at = Cell::new(0, 0);
            trail.drive([at]);
            for (number, heading) in headings.into_iter().enumerate() {
                let heading = Heading::ALL[heading];
                let Some(next) = size.neighbour(at, heading) else { continue };
                let mut pair = [at, next];
                pair.sort_unstable();
                last.insert(pair, (number, Pose::new(at, heading)));
                trail.drive([next]);
                at = next;
            }
            let mut expected: Vec<_> = last.into_values().collect();
            expected.sort_by_key(|&(number, _)| number);
            let expected: Vec<_> = expected.into_iter().map(|(_, passage)| passage).collect();
            prop_assert_eq!(trail.passages(), expected);
        }
    }
}
