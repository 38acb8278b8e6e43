//! The trail of a mouse: the last passage between each pair of neighbouring cells.

use mmsim_maze::{Cell, Heading, MazeSize, Pose, Walls};

/// The path of a mouse, of which only the last passage between each pair of neighbouring cells is
/// kept. The size of a trail therefore depends on the maze and not on the length of the path.
///
/// ```
/// use mmsim_drawing::{Passage, Trail};
/// use mmsim_maze::{Cell, Heading, MazeSize, Pose};
///
/// let mut trail = Trail::new(MazeSize::CLASSIC);
/// trail.jump_to(Pose::new(Cell::new(0, 0), Heading::North));
/// trail.move_to(Pose::new(Cell::new(0, 1), Heading::North), None);
/// trail.move_to(Pose::new(Cell::new(0, 0), Heading::South), None);
/// assert_eq!(trail.passages(), [Passage { from: Cell::new(0, 1), heading: Heading::South }]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trail {
    size: MazeSize,
    /// The number of passages so far.
    count: u32,
    last: Option<Pose>,
    /// For each cell, the last passage across its north and its east side.
    crossings: Box<[[Crossing; 2]]>,
}

/// The last passage across a side of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Crossing {
    /// The number of the passage, counted from 1, or 0 if the mouse has never crossed the side.
    number: u32,
    /// True if the mouse was heading south or west.
    is_backward: bool,
}

/// A step of a mouse from a cell to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// The cell that the mouse left.
    pub from: Cell,
    /// The direction of the step.
    pub heading: Heading,
}

impl Trail {
    /// Creates the trail of a mouse that has no pose yet.
    pub fn new(size: MazeSize) -> Self {
        let crossings = vec![Default::default(); size.area()].into();
        Self { size, count: 0, last: None, crossings }
    }

    /// Returns the last pose.
    pub const fn last(&self) -> Option<Pose> {
        self.last
    }

    /// Adds the next pose of the mouse. If `is_move` returns false for the last pose, or if there is no
    /// last pose, the mouse was placed in the new pose, which leaves no passage.
    pub fn extend(
        &mut self,
        pose: Pose,
        walls: Option<&Walls>,
        is_move: impl FnOnce(Pose) -> bool,
    ) {
        match self.last {
            Some(last) if is_move(last) => self.move_to(pose, walls),
            _ => self.jump_to(pose),
        }
    }

    /// Places the mouse in its first pose, or in another pose without a passage, for example back at
    /// the start. A pose outside the maze is ignored.
    pub fn jump_to(&mut self, pose: Pose) {
        self.last = Some(pose).filter(|pose| self.size.contains(pose.cell)).or(self.last);
    }

    /// Moves the mouse in a straight line or into a diagonal neighbour. On its way to a diagonal
    /// neighbour, it passes a cell that has an opening to both cells, if `walls` are given. For any
    /// other move, use [`jump_to`](Self::jump_to). A pose outside the maze is ignored.
    pub fn move_to(&mut self, pose: Pose, walls: Option<&Walls>) {
        if !self.size.contains(pose.cell) {
            return;
        }
        let mut last = self.last.unwrap_or(pose).cell;
        if last.x != pose.cell.x && last.y != pose.cell.y {
            let corners = [Cell::new(last.x, pose.cell.y), Cell::new(pose.cell.x, last.y)];
            let is_open = |from: Cell, to: Cell| {
                walls.zip(direction(from, to)).is_some_and(|(walls, side)| !walls.has(from, side))
            };
            let is_passage = |&corner: &Cell| is_open(last, corner) && is_open(corner, pose.cell);
            let corner = corners.into_iter().find(is_passage).unwrap_or(corners[0]);
            self.drive(last, corner);
            last = corner;
        }
        self.drive(last, pose.cell);
        self.last = Some(pose);
    }

    /// Adds the passages of a straight line.
    fn drive(&mut self, mut from: Cell, to: Cell) {
        let Some(heading) = direction(from, to) else { return };
        while let Some(next) = from.neighbour(heading).filter(|_| from != to) {
            self.cross(from, next, heading);
            from = next;
        }
    }

    fn cross(&mut self, from: Cell, to: Cell, heading: Heading) {
        self.count = self.count.saturating_add(1);
        let is_backward = matches!(heading, Heading::South | Heading::West);
        let side = usize::from(matches!(heading, Heading::East | Heading::West));
        let cell = if is_backward { to } else { from };
        let index = usize::from(cell.y) * usize::from(self.size.width()) + usize::from(cell.x);
        self.crossings[index][side] = Crossing { number: self.count, is_backward };
    }

    /// Returns the last passage between each pair of neighbouring cells that the mouse has crossed,
    /// oldest first.
    pub fn passages(&self) -> Vec<Passage> {
        let crossed = self.size.cells().zip(&self.crossings).flat_map(|(cell, crossings)| {
            [Heading::North, Heading::East].into_iter().zip(crossings).filter_map(
                move |(heading, &Crossing { number, is_backward })| {
                    let passage = if is_backward {
                        Passage { from: cell.neighbour(heading)?, heading: heading.back() }
                    } else {
                        Passage { from: cell, heading }
                    };
                    (number > 0).then_some((number, passage))
                },
            )
        });
        let mut crossed: Vec<(u32, Passage)> = crossed.collect();
        crossed.sort_unstable_by_key(|&(number, _)| number);
        crossed.into_iter().map(|(_, passage)| passage).collect()
    }

    pub(crate) const fn size(&self) -> MazeSize {
        self.size
    }
}

impl Passage {
    /// Returns the cell that the mouse entered, or `None` if it would be west or south of (0, 0).
    pub fn to(self) -> Option<Cell> {
        self.from.neighbour(self.heading)
    }

    /// Returns the side that the mouse crossed, as the north or east side of a cell.
    pub(crate) fn side(self) -> (Cell, Heading) {
        match (self.heading, self.to()) {
            (Heading::South | Heading::West, Some(to)) => (to, self.heading.back()),
            _ => (self.from, self.heading),
        }
    }
}

/// Returns the direction of a straight line from one cell to another.
fn direction(from: Cell, to: Cell) -> Option<Heading> {
    match (from.x == to.x, from.y == to.y) {
        (true, false) => Some(if to.y > from.y { Heading::North } else { Heading::South }),
        (false, true) => Some(if to.x > from.x { Heading::East } else { Heading::West }),
        _ => None,
    }
}

/// Returns the trail of a mouse that moves through these cells.
#[cfg(test)]
pub(crate) fn through(size: MazeSize, cells: &[Cell]) -> Trail {
    let mut trail = Trail::new(size);
    for &cell in cells {
        trail.move_to(Pose::new(cell, Heading::North), None);
    }
    trail
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    /// Returns the passages of a trail, each as x, y and heading.
    fn passages(trail: &Trail) -> Vec<(u8, u8, Heading)> {
        let passages = trail.passages().into_iter();
        passages.map(|Passage { from, heading }| (from.x, from.y, heading)).collect()
    }

    #[test]
    fn moves_leave_passages_and_jumps_do_not() {
        use Heading::{East, North, South, West};
        let cell = Cell::new;
        let mut trail = through(MazeSize::CLASSIC, &[cell(0, 0), cell(0, 3), cell(2, 3)]);
        trail.jump_to(Pose::new(cell(0, 0), North));
        trail.move_to(Pose::new(cell(0, 1), North), None);
        trail.move_to(Pose::new(cell(0, 16), North), None);
        trail.move_to(Pose::new(cell(0, 0), South), None);
        let expected = [(0, 1, North), (0, 2, North), (0, 3, East), (1, 3, East), (0, 1, South)];
        assert_eq!(passages(&trail), expected);
        assert_eq!(trail.last(), Some(Pose::new(cell(0, 0), South)));
        trail.move_to(Pose::new(cell(0, 0), West), None);
        assert_eq!(passages(&trail), expected, "a turn");
    }

    #[test]
    fn a_diagonal_goes_around_walls() {
        use Heading::{East, North};
        let (start, diagonal) = (Cell::new(0, 0), Cell::new(1, 1));
        let mut walls = Walls::open(MazeSize::CLASSIC);
        for (wall, expected) in [
            ((start, North), [(0, 0, East), (1, 0, North)]),
            ((start, East), [(0, 0, North), (0, 1, East)]),
        ] {
            walls.set(wall.0, wall.1, true);
            let mut trail = through(MazeSize::CLASSIC, &[start]);
            trail.move_to(Pose::new(diagonal, North), Some(&walls));
            assert_eq!(passages(&trail), expected);
            walls.set(wall.0, wall.1, false);
        }
    }

    proptest! {
        /// Compares a trail with the whole path.
        #[test]
        fn a_trail_keeps_the_last_passage_between_cells(
            path in prop::collection::vec((0u8..4, 0u8..4, 0u8..10), 0..200),
        ) {
            let size = MazeSize::new(4, 4).unwrap();
            let mut trail = Trail::new(size);
            let mut last: BTreeMap<[Cell; 2], (usize, Passage)> = BTreeMap::new();
            let mut at: Option<Cell> = None;
            for (x, y, kind) in path {
                let to = Pose::new(Cell::new(x, y), Heading::North);
                let from = at.replace(to.cell).unwrap_or(to.cell);
                if kind == 0 {
                    trail.jump_to(to);
                    continue;
                }
                trail.move_to(to, None);
                // Without walls, a mouse drives north or south first.
                let mut cell = from;
                while cell != to.cell {
                    let heading = match (cell.x, cell.y) {
                        (_, y) if y < to.cell.y => Heading::North,
                        (_, y) if y > to.cell.y => Heading::South,
                        (x, _) if x < to.cell.x => Heading::East,
                        _ => Heading::West,
                    };
                    let next = cell.neighbour(heading).unwrap();
                    let mut pair = [cell, next];
                    pair.sort_unstable();
                    let number = last.values().map(|(number, _)| number + 1).max().unwrap_or(0);
                    last.insert(pair, (number, Passage { from: cell, heading }));
                    cell = next;
                }
            }
            let mut expected: Vec<_> = last.into_values().collect();
            expected.sort_by_key(|&(number, _)| number);
            let expected: Vec<_> = expected.into_iter().map(|(_, passage)| passage).collect();
            prop_assert_eq!(trail.passages(), expected);
        }
    }
}
