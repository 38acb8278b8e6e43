//! Decides whether a mouse moved from one state to the next or was placed elsewhere.

use std::iter;

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Maze, Pose, Walls};

/// The maximum number of cells that a mouse drives backwards between two states, as in the two-run
/// trial.
const MAX_BACKWARDS: u8 = 3;

/// The rules by which a mouse moves and reaches the goal: the start, the goal cells and, if the true
/// maze is known, the walls that it cannot cross.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MovementRules {
    start: Pose,
    goals: CellSet,
    walls: Option<Walls>,
}

/// How a mouse got from the pose in one state to the pose in the next state.
///
/// A state contains no movement, only a pose. The mouse *moved* if it could have reached the new
/// pose in one movement that does not cross a wall of the true maze (if it is known):
///
/// - a turn on the spot,
/// - a straight line of any length in the direction of the old or the new heading: a mouse turns
///   before or after it drives, and some clients report only a few cells of a straight,
/// - a straight line of up to 3 cells backwards, with respect to the new heading,
/// - a step into any neighbouring cell: some clients do not report headings, or
/// - a step into a diagonal neighbour past one of the two cells between them: mice of mms drive
///   diagonals and report only some of the cells that they cross.
///
/// Only the first two of these movements can end in the start pose, and a straight line of more than
/// one cell only in the direction of the start heading. In other cases, a mouse in its start pose was
/// put back at the start, for example by the reset button of mms: a *restart*. A client can also say
/// that a state in the start cell is a restart. A change to any other pose is a *jump*.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Maze, Pose};
/// use mmsim_run::{MovementRules, Transition};
/// let maze: Maze = "o---o---o---o\n| S     | G |\no---o---o---o\n".parse()?;
/// let rules = MovementRules::from_maze(&maze);
/// let pose = |x, heading| Pose::new(Cell::new(x, 0), heading);
/// let moved = rules.transition(pose(0, Heading::North), pose(1, Heading::East));
/// assert_eq!(moved, Transition::Move { steps: 1, turns: 1 });
/// let through_wall = rules.transition(pose(1, Heading::East), pose(2, Heading::East));
/// assert_eq!(through_wall, Transition::Jump);
/// let restart = rules.transition(pose(2, Heading::East), pose(0, Heading::North));
/// assert_eq!(restart, Transition::Restart);
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transition {
    /// The mouse moved.
    Move {
        /// The number of cells that the mouse left: the Manhattan distance between the cells.
        steps: u8,
        /// The number of quarter turns. A U-turn counts as two.
        turns: u8,
    },
    /// The mouse was put back at its start pose.
    Restart,
    /// The mouse was placed in another cell, or the client corrected its position.
    Jump,
}

impl Transition {
    /// Returns true if the mouse moved.
    pub const fn is_move(self) -> bool {
        matches!(self, Self::Move { .. })
    }
}

impl MovementRules {
    /// Creates the rules for a maze. `walls` are those of the true maze, if it is known.
    pub const fn new(start: Pose, goals: CellSet, walls: Option<Walls>) -> Self {
        Self { start, goals, walls }
    }

    /// Creates the rules for a maze that is known.
    pub fn from_maze(maze: &Maze) -> Self {
        Self::new(maze.start(), *maze.goals(), Some(maze.walls().clone()))
    }

    /// Creates the rules for a maze of which a mouse knows the start and the goal. `truth` is the
    /// true maze, if it is known.
    pub fn from_map(unexplored: &KnownMaze, truth: Option<&Maze>) -> Self {
        let walls = truth.map(|maze| maze.walls().clone());
        Self::new(unexplored.start(), *unexplored.goals(), walls)
    }

    /// Returns the start pose.
    pub const fn start(&self) -> Pose {
        self.start
    }

    /// Returns the goal cells.
    pub const fn goals(&self) -> &CellSet {
        &self.goals
    }

    /// Returns the walls of the true maze, or `None` if they are unknown.
    pub const fn walls(&self) -> Option<&Walls> {
        self.walls.as_ref()
    }

    /// Returns how a mouse got from one pose to another. See [`Transition`].
    pub fn transition(&self, from: Pose, to: Pose) -> Transition {
        let steps = from.cell.x.abs_diff(to.cell.x).saturating_add(from.cell.y.abs_diff(to.cell.y));
        if self.is_movement(from, to, steps) {
            let turns = (to.heading as u8).wrapping_sub(from.heading as u8) % 4;
            Transition::Move { steps, turns: turns.min(4 - turns) }
        } else if to == self.start {
            Transition::Restart
        } else {
            Transition::Jump
        }
    }

    /// Returns how a mouse got from one pose to another if the client says that it was put back at
    /// the start.
    pub(crate) fn restart(&self, to: Pose) -> Transition {
        if to.cell == self.start.cell { Transition::Restart } else { Transition::Jump }
    }

    fn is_movement(&self, from: Pose, to: Pose, steps: u8) -> bool {
        if steps == 0 {
            return true;
        }
        let to_start = to == self.start;
        let Some(direction) = direction(from.cell, to.cell) else {
            return steps == 2 && !to_start && self.has_diagonal(from.cell, to.cell);
        };
        // A mouse that drives home reports the start before it turns.
        let is_home_run = to_start && steps > 1 && direction != to.heading;
        let is_forwards = !is_home_run && (direction == from.heading || direction == to.heading);
        let is_backwards = direction == to.heading.back() && steps <= MAX_BACKWARDS;
        (is_forwards || (!to_start && (is_backwards || steps == 1)))
            && self.is_open(from.cell, direction, steps)
    }

    /// Returns true if no wall stops a mouse that drives `steps` cells from `cell`.
    fn is_open(&self, cell: Cell, direction: Heading, steps: u8) -> bool {
        let Some(walls) = &self.walls else { return true };
        let mut next = Some(cell);
        (0..steps).all(|_| {
            let open = next.filter(|&cell| !walls.has(cell, direction));
            next = open.and_then(|cell| cell.neighbour(direction));
            open.is_some()
        })
    }

    /// Returns true if a mouse can get to a diagonal neighbour past one of the cells between.
    fn has_diagonal(&self, from: Cell, to: Cell) -> bool {
        corners(from, to).into_iter().any(|corner| self.is_passage(from, corner, to))
    }

    /// Returns true if no wall stops a mouse that drives past a cell to a diagonal neighbour.
    fn is_passage(&self, from: Cell, corner: Cell, to: Cell) -> bool {
        let side = |a, b| direction(a, b).is_some_and(|heading| self.is_open(a, heading, 1));
        side(from, corner) && side(corner, to)
    }

    /// Adds the cells from the last one of a path to another one, or the first cell of the path.
    pub fn extend_path(&self, path: &mut Vec<Cell>, to: Cell) {
        match path.last() {
            Some(&from) => path.extend(self.cells_between(from, to)),
            None => path.push(to),
        }
    }

    /// Returns the cells that a mouse enters when it moves from one cell to another, in a straight
    /// line or past a cell to a diagonal neighbour.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Maze};
    /// use mmsim_run::MovementRules;
    /// let maze: Maze = "o---o---o\n|       |\no   o---o\n| S | G |\no---o---o\n".parse()?;
    /// let rules = MovementRules::from_maze(&maze);
    /// let cells: Vec<Cell> = rules.cells_between(Cell::new(0, 0), Cell::new(1, 1)).collect();
    /// assert_eq!(cells, [Cell::new(0, 1), Cell::new(1, 1)]);
    /// # Ok::<(), mmsim_maze::ParseMazeError>(())
    /// ```
    pub fn cells_between(&self, from: Cell, to: Cell) -> impl Iterator<Item = Cell> + use<> {
        let corners = corners(from, to);
        let is_passage = |&corner: &Cell| self.is_passage(from, corner, to);
        let corner = corners.into_iter().find(is_passage).unwrap_or(corners[0]);
        straight(from, corner).chain(straight(corner, to))
    }
}

/// Returns the two cells beside the line between diagonal neighbours.
const fn corners(from: Cell, to: Cell) -> [Cell; 2] {
    [Cell::new(from.x, to.y), Cell::new(to.x, from.y)]
}

/// Returns the cells that a mouse enters on a straight line.
fn straight(from: Cell, to: Cell) -> impl Iterator<Item = Cell> {
    let next = move |&cell: &Cell| cell.neighbour(direction(cell, to)?);
    iter::successors(Some(from), next).skip(1)
}

/// Returns the direction from one cell to another in the same row or column.
fn direction(from: Cell, to: Cell) -> Option<Heading> {
    match (from.x == to.x, from.y == to.y) {
        (true, false) => Some(if to.y > from.y { Heading::North } else { Heading::South }),
        (false, true) => Some(if to.x > from.x { Heading::East } else { Heading::West }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Heading::{East, North, South, West};
    use mmsim_maze::MazeSize;
    use proptest::prelude::*;

    use super::*;

    fn pose(x: u8, y: u8, heading: Heading) -> Pose {
        Pose::new(Cell::new(x, y), heading)
    }

    fn moved(steps: u8, turns: u8) -> Transition {
        Transition::Move { steps, turns }
    }

    #[test]
    fn each_kind_of_movement_is_recognized() {
        let size = MazeSize::CLASSIC;
        let start = Pose::new(Cell::new(0, 0), North);
        let rules = MovementRules::new(start, size.central_cells(), None);
        for (from, to, expected) in [
            // A mouse that reports each step, each turn, or only some cells of a straight.
            (pose(3, 5, North), pose(3, 5, North), moved(0, 0)),
            (pose(3, 5, East), pose(3, 5, West), moved(0, 2)),
            (pose(3, 5, North), pose(3, 5, West), moved(0, 1)),
            (pose(3, 5, North), pose(3, 6, North), moved(1, 0)),
            (pose(3, 5, North), pose(2, 5, West), moved(1, 1)),
            (pose(3, 5, North), pose(3, 4, South), moved(1, 2)),
            (pose(3, 5, North), pose(3, 15, North), moved(10, 0)),
            (pose(3, 5, North), pose(15, 5, East), moved(12, 1)),
            (pose(3, 5, North), pose(3, 8, West), moved(3, 1)),
            // A mouse that drives backwards, as in the trial.
            (pose(3, 5, North), pose(3, 2, North), moved(3, 0)),
            (pose(3, 5, North), pose(6, 5, West), moved(3, 1)),
            (pose(3, 5, North), pose(3, 1, North), Transition::Jump),
            // A client that always reports the same heading.
            (pose(3, 5, North), pose(4, 5, North), moved(1, 0)),
            (pose(3, 5, North), pose(5, 5, North), Transition::Jump),
            // A diagonal of mms, which goes north-west past (2, 5).
            (pose(3, 5, West), pose(2, 6, West), moved(2, 0)),
            (pose(3, 5, West), pose(1, 6, West), Transition::Jump),
            (pose(3, 5, North), pose(1, 9, West), Transition::Jump),
            // A return to the start, and a mouse that is put back.
            (pose(0, 4, South), pose(0, 0, South), moved(4, 0)),
            (pose(0, 4, South), pose(0, 0, North), Transition::Restart),
            (pose(2, 0, West), pose(0, 0, North), Transition::Restart),
            (pose(0, 1, South), pose(0, 0, North), moved(1, 2)),
            (pose(1, 0, West), pose(0, 0, North), moved(1, 1)),
            (pose(0, 0, South), pose(0, 0, North), moved(0, 2)),
            (pose(0, 1, North), pose(0, 0, North), Transition::Restart),
            (pose(1, 0, East), pose(0, 0, North), Transition::Restart),
            (pose(1, 1, South), pose(0, 0, North), Transition::Restart),
            (pose(7, 7, East), pose(0, 0, North), Transition::Restart),
            (pose(7, 7, East), pose(0, 0, East), Transition::Jump),
        ] {
            assert_eq!(rules.transition(from, to), expected, "{from} to {to}");
        }
    }

    #[test]
    fn no_movement_crosses_a_wall() {
        let maze: Maze = "\
o---o---o---o
|   |     G |
o   o   o   o
|       |   |
o   o---o---o
| S         |
o---o---o---o
"
        .parse()
        .unwrap();
        let rules = MovementRules::from_maze(&maze);
        for (from, to, expected) in [
            (pose(0, 0, East), pose(2, 0, East), moved(2, 0)),
            (pose(2, 0, North), pose(2, 1, North), Transition::Jump),
            (pose(2, 0, North), pose(2, 2, North), Transition::Jump),
            (pose(0, 2, East), pose(1, 2, East), Transition::Jump),
            (pose(0, 2, South), pose(0, 0, North), Transition::Restart),
            (pose(1, 0, West), pose(0, 1, West), moved(2, 0)),
            (pose(0, 2, East), pose(1, 1, East), moved(2, 0)),
            (pose(1, 1, North), pose(2, 0, North), Transition::Jump),
        ] {
            assert_eq!(rules.transition(from, to), expected, "{from} to {to}");
        }
    }

    #[test]
    fn the_cells_between_two_cells_are_connected() {
        let maze: Maze = "o---o---o\n|       |\no   o---o\n| S | G |\no---o---o\n".parse().unwrap();
        let rules = MovementRules::from_maze(&maze);
        let cell = |(x, y)| Cell::new(x, y);
        for (from, to, expected) in [
            ((0, 0), (1, 1), &[(0, 1), (1, 1)][..]),
            ((1, 1), (0, 0), &[(0, 1), (0, 0)]),
            ((0, 0), (0, 0), &[]),
            ((0, 9), (0, 6), &[(0, 8), (0, 7), (0, 6)]),
        ] {
            let cells = rules.cells_between(cell(from), cell(to));
            assert!(cells.eq(expected.iter().copied().map(cell)), "{from:?} to {to:?}");
        }
    }

    /// Lists every pose that one movement can end in, by driving through the maze cell by cell.
    fn reachable(rules: &MovementRules, walls: &Walls, from: Pose) -> Vec<Pose> {
        let size = walls.size();
        let step = |cell: Cell, heading| {
            size.neighbour(cell, heading).filter(|_| !walls.has(cell, heading))
        };
        let (mut forwards, mut others) = (Vec::new(), Vec::new());
        for end in Heading::ALL {
            forwards.push(Pose::new(from.cell, end));
            for direction in Heading::ALL {
                let (mut cell, mut driven) = (from.cell, 0);
                while let Some(next) = step(cell, direction) {
                    (cell, driven) = (next, driven + 1);
                    let pose = Pose::new(cell, end);
                    let is_home = pose == rules.start() && driven > 1;
                    if end == direction || (from.heading == direction && !is_home) {
                        forwards.push(pose);
                    }
                    if driven == 1 || (driven <= 3 && end.back() == direction) {
                        others.push(Pose::new(cell, end));
                    }
                }
                for side in [direction.left(), direction.right()] {
                    let corner = step(from.cell, direction).and_then(|cell| step(cell, side));
                    others.extend(corner.map(|cell| Pose::new(cell, end)));
                }
            }
        }
        others.retain(|&pose| pose != rules.start());
        [forwards, others].concat()
    }

    proptest! {
        #[test]
        fn movements_equal_those_of_a_mouse_that_drives_cell_by_cell(
            (width, height) in (1usize..=9, 1usize..=9),
            rows in prop::array::uniform32(any::<(u32, u32)>()),
            density in 0u32..3,
            (from, to) in (any::<(u8, u8, u8)>(), any::<(u8, u8, u8)>()),
            start in any::<(u8, u8)>(),
            is_known in any::<bool>(),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let cell = |x: u8, y: u8| Cell::new(x % size.width(), y % size.height());
            let pose = |(x, y, heading): (u8, u8, u8)| {
                Pose::new(cell(x, y), Heading::ALL[usize::from(heading % 4)])
            };
            let thin = |row: u32| if density == 0 { 0 } else { row & (row >> 16 | density >> 1) };
            let walls = Walls::from_rows(size, rows.map(|row| thin(row.0)), rows.map(|row| thin(row.1)));
            let walls = if is_known { walls } else { Walls::open(size) };
            let start = Pose::new(cell(start.0, start.1), North);
            let rules =
                MovementRules::new(start, size.central_cells(), is_known.then(|| walls.clone()));
            // A random pose is rarely near another one.
            let (from, near) = (pose(from), to.0 % 2 == 0);
            let to = if near {
                let poses = reachable(&rules, &walls, from);
                poses[usize::from(to.1) % poses.len()]
            } else {
                pose(to)
            };
            let found = rules.transition(from, to);
            let is_move = matches!(found, Transition::Move { .. });
            prop_assert_eq!(is_move, reachable(&rules, &walls, from).contains(&to));
            match found {
                Transition::Move { steps, turns } => {
                    let (dx, dy) = (from.cell.x.abs_diff(to.cell.x), from.cell.y.abs_diff(to.cell.y));
                    prop_assert_eq!(steps, dx + dy);
                    let quarters = [to.heading, to.heading.left(), to.heading.right(), to.heading.back()];
                    let expected = [0, 1, 1, 2][quarters.iter().position(|&it| it == from.heading).unwrap()];
                    prop_assert_eq!(turns, expected);
                }
                Transition::Restart => prop_assert_eq!(to, rules.start()),
                Transition::Jump => prop_assert_ne!(to, rules.start()),
            }
        }
    }
}
