//! The minimum number of time steps to the goal.

use mmsim_maze::{Cell, CellMap, CellSet, Heading, MazeSize, Pose, Walls};

use crate::robot::{Action, Rotation};

/// The height of the empty margins north and south of the maze, in rows. The margins make bounds
/// checks unnecessary.
const MARGIN: usize = Action::MAX_CELLS as usize;
const UNREACHABLE: u16 = u16::MAX;

/// The number of time steps from each cell to the nearest target cell.
///
/// A step is a straight move of 1 to 3 cells. The robot's heading does not affect the distance,
/// because a step may begin with a left or right turn, and a robot can move backwards. A target
/// counts as reached only if a step ends in it. Ignoring crossed targets makes no path longer,
/// because a step that would cross a target can end there instead.
///
/// The distances are computed by breadth-first search. Each round of the search takes a few bit
/// operations per row of the maze.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_trial::RaceSteps;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let race = RaceSteps::flood(&walls, &MazeSize::CLASSIC.central_cells());
/// assert_eq!(race.at(Cell::new(0, 0)), Some(6), "7 cells north and 7 east, 3 at a time");
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RaceSteps {
    size: MazeSize,
    steps: CellMap<u16>,
}

impl RaceSteps {
    /// Floods the maze from the targets. Targets outside the maze are ignored.
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        let size = walls.size();
        let mut race = Self { size, steps: CellMap::new(UNREACHABLE) };
        if size.height() <= 16 {
            Straights::<16, 22>::new(walls).flood(targets, &mut race.steps);
        } else {
            Straights::<32, 38>::new(walls).flood(targets, &mut race.steps);
        }
        race
    }

    /// Floods the maze from a single target.
    pub(crate) fn flood_from(walls: &Walls, target: Cell) -> Self {
        Self::flood(walls, &CellSet::from_iter([target]))
    }

    /// Returns the number of time steps from `cell` to the nearest target. The number is 0 if
    /// `cell` is a target. Returns `None` if no target is reachable or the cell is outside the
    /// maze.
    pub fn at(&self, cell: Cell) -> Option<u16> {
        let steps = self.size.contains(cell).then(|| self.steps[cell]);
        steps.filter(|&steps| steps != UNREACHABLE)
    }

    /// Returns the number of time steps from `cell` to the nearest target, but at least 1.
    pub(crate) fn at_least_one(&self, cell: Cell) -> Option<u16> {
        self.at(cell).map(|steps| steps.max(1))
    }

    /// Returns the first move of a fastest path from `pose` to a target. Returns `None` if `pose`
    /// is already in a target or if no target is reachable. Longer moves are preferred; ties are
    /// broken in the order ahead, left, right, back.
    pub fn next_move(&self, walls: &Walls, pose: Pose) -> Option<Action> {
        let (heading, cells) = self.next_straight(walls, pose)?;
        Action::towards(pose.heading, heading, cells)
    }

    /// Returns the cell of `pose` and the cells in which the steps of a fastest path from `pose` to a
    /// target end. Returns an empty list if `pose` is already in a target or if no target is
    /// reachable.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, Maze, Pose};
    /// use mmsim_trial::RaceSteps;
    /// let maze: Maze = "o---o---o---o---o---o\n| S               G |\no---o---o---o---o---o\n".parse()?;
    /// let path = RaceSteps::flood(maze.walls(), maze.goals()).path(maze.walls(), maze.start());
    /// assert_eq!(path, [Cell::new(0, 0), Cell::new(3, 0), Cell::new(4, 0)]);
    /// # Ok::<(), mmsim_maze::ParseMazeError>(())
    /// ```
    pub fn path(&self, walls: &Walls, pose: Pose) -> Vec<Cell> {
        let next = |&pose: &Pose| {
            let (heading, cells) = self.next_straight(walls, pose)?;
            let end = straight(walls, pose.cell, heading).nth(cells - 1)?;
            Some(Pose::new(end, heading))
        };
        let path: Vec<Cell> =
            std::iter::successors(Some(pose), next).map(|pose| pose.cell).collect();
        if path.len() > 1 { path } else { Vec::new() }
    }

    /// Returns the move of [`next_move`](Self::next_move) as a direction and a number of cells.
    pub(crate) fn next_straight(&self, walls: &Walls, pose: Pose) -> Option<(Heading, usize)> {
        let here = self.at(pose.cell)?;
        let towards =
            [pose.heading, pose.heading.left(), pose.heading.right(), pose.heading.back()];
        let mut best = None;
        for heading in towards {
            for (cells, cell) in (1..).zip(straight(walls, pose.cell, heading)) {
                let is_longer = best.is_none_or(|(_, longest)| cells > longest);
                if is_longer && self.at(cell).is_some_and(|there| there < here) {
                    best = Some((heading, cells));
                }
            }
        }
        best
    }
}

/// Returns the cells in which a step from `cell` towards `heading` may end, nearest first.
pub(crate) fn straight(
    walls: &Walls,
    cell: Cell,
    heading: Heading,
) -> impl Iterator<Item = Cell> + '_ {
    let next = move |&here: &Cell| here.neighbour(heading).filter(|_| !walls.has(here, heading));
    std::iter::successors(Some(cell), next).skip(1).take(MARGIN)
}

/// Returns the pose after a turn and a move. A move ends early at a wall. A negative number of
/// cells moves the robot backwards.
pub(crate) fn moved(walls: &Walls, pose: Pose, rotation: Rotation, cells: i8) -> Pose {
    let heading = rotation.turn(pose.heading);
    let towards = if cells < 0 { heading.back() } else { heading };
    let passed = straight(walls, pose.cell, towards).take(cells.unsigned_abs().into());
    Pose::new(passed.last().unwrap_or(pose.cell), heading)
}

/// Returns the minimum number of race steps, or `None` if the goal is unreachable. Returns 1 if the
/// start is in the goal, because a race has at least one step.
pub fn race_optimum(walls: &Walls, start: Cell, goals: &CellSet) -> Option<u16> {
    RaceSteps::flood(walls, goals).at_least_one(start)
}

/// Stores for each cell whether moves of 1, 2 and 3 cells to the north and to the east are
/// possible. Bit x of row `MARGIN` + y stands for cell (x, y). `PADDED` is `ROWS` plus both
/// margins. All moves stay inside the maze.
pub(crate) struct Straights<const ROWS: usize, const PADDED: usize> {
    north: [[u32; PADDED]; MARGIN],
    east: [[u32; PADDED]; MARGIN],
}

impl<const ROWS: usize, const PADDED: usize> Straights<ROWS, PADDED> {
    pub(crate) fn new(walls: &Walls) -> Self {
        let (mut north, mut east) = ([[0; PADDED]; MARGIN], [[0; PADDED]; MARGIN]);
        for y in 0..walls.size().height().into() {
            north[0][MARGIN + y] = !walls.north_rows()[y];
            east[0][MARGIN + y] = !walls.east_rows()[y];
        }
        for longer in 1..MARGIN {
            for y in MARGIN..MARGIN + ROWS {
                north[longer][y] = north[0][y] & north[longer - 1][y + 1];
                east[longer][y] = east[0][y] & east[longer - 1][y] >> 1;
            }
        }
        Self { north, east }
    }

    fn flood(&self, targets: &CellSet, steps: &mut CellMap<u16>) {
        let mut wave = Wave::from_cells(targets);
        let mut reached = wave;
        for time in 0.. {
            if wave.is_empty() {
                return;
            }
            wave.for_each(|cell| steps[cell] = time);
            wave = self.next(&wave, &reached);
            reached.add(&wave);
        }
    }

    /// Returns the cells that are one step away from a cell of `wave`, except the cells in
    /// `excluded`.
    pub(crate) fn next(&self, Wave(wave): &Wave<PADDED>, excluded: &Wave<PADDED>) -> Wave<PADDED> {
        // Slices of the same length need no bounds checks in the loop, so the compiler uses SIMD.
        fn inner<const ROWS: usize>(rows: &[u32], first: usize) -> &[u32] {
            &rows[first..][..ROWS]
        }
        let mut next = [0; PADDED];
        for (cells, (north, east)) in (1..).zip(self.north.iter().zip(&self.east)) {
            let [south, here, north_of] =
                [MARGIN - cells, MARGIN, MARGIN + cells].map(|first| inner::<ROWS>(wave, first));
            let [to_here, to_north] =
                [MARGIN - cells, MARGIN].map(|first| inner::<ROWS>(north, first));
            let to_east = inner::<ROWS>(east, MARGIN);
            for (y, row) in next[MARGIN..][..ROWS].iter_mut().enumerate() {
                *row |= south[y] & to_here[y] | north_of[y] & to_north[y];
                *row |= (here[y] & to_east[y]) << cells | here[y] >> cells & to_east[y];
            }
        }
        next.iter_mut().zip(&excluded.0).for_each(|(row, excluded)| *row &= !excluded);
        Wave(next)
    }

    /// Returns the cells in which a step from `cell` towards `heading` may end, nearest first.
    pub(crate) fn ends(&self, cell: Cell, heading: Heading) -> impl Iterator<Item = Cell> + '_ {
        let Cell { x, y } = cell;
        let row = MARGIN + usize::from(y);
        (1_u8..).zip(self.north.iter().zip(&self.east)).map_while(move |(cells, (north, east))| {
            let (bits, end) = match heading {
                Heading::North => (north[row] >> x, Cell::new(x, y + cells)),
                Heading::South => {
                    (north[row - usize::from(cells)] >> x, Cell::new(x, y.wrapping_sub(cells)))
                }
                Heading::East => (east[row] >> x, Cell::new(x + cells, y)),
                Heading::West => (east[row] << cells >> x, Cell::new(x.wrapping_sub(cells), y)),
            };
            Some(end).filter(|_| bits & 1 == 1)
        })
    }
}

/// A set of cells, in which bit x of row `MARGIN` + y stands for cell (x, y).
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wave<const PADDED: usize>([u32; PADDED]);

impl<const PADDED: usize> Wave<PADDED> {
    pub(crate) fn from_cells(cells: &CellSet) -> Self {
        let mut rows = [0; PADDED];
        let inner = PADDED - 2 * MARGIN;
        rows[MARGIN..MARGIN + inner].copy_from_slice(&cells.rows()[..inner]);
        Self(rows)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.iter().fold(0, |all, row| all | row) == 0
    }

    pub(crate) fn contains(&self, cell: Cell) -> bool {
        self.0[MARGIN + usize::from(cell.y)] >> cell.x & 1 == 1
    }

    pub(crate) fn add(&mut self, other: &Self) {
        for (row, other) in self.0.iter_mut().zip(&other.0) {
            *row |= other;
        }
    }

    /// Returns the set of all cells that are not in this set.
    pub(crate) fn complement(&self) -> Self {
        Self(self.0.map(|row| !row))
    }

    pub(crate) fn for_each(&self, mut visit: impl FnMut(Cell)) {
        for (y, &row) in (0_u8..).zip(&self.0[MARGIN..PADDED - MARGIN]) {
            let mut row = row;
            while row != 0 {
                // The value is at most 31.
                #[allow(clippy::cast_possible_truncation)]
                visit(Cell::new(row.trailing_zeros() as u8, y));
                row &= row - 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;
    use crate::trial::Trial;

    /// The reference implementation, a breadth-first search over poses in the environment.
    fn naive(maze: &Maze) -> Option<u16> {
        let mut queue = VecDeque::from([(Trial::new(maze), 0)]);
        let mut seen = vec![maze.start()];
        while let Some((trial, steps)) = queue.pop_front() {
            if steps > 0 && maze.goals().contains(trial.pose().cell) {
                return Some(steps);
            }
            for rotation in [-90, 0, 90] {
                for cells in -3..=3 {
                    let mut after = trial.clone();
                    after.act(Action::from_numbers(rotation, cells));
                    if !seen.contains(&after.pose()) || steps == 0 && cells == 0 {
                        seen.push(after.pose());
                        queue.push_back((after, steps + 1));
                    }
                }
            }
        }
        None
    }

    proptest! {
        #[test]
        fn race_steps_equal_the_reference(
            (width, height) in (1usize..=7, prop_oneof![1usize..=6, 17usize..20]),
            present in prop::collection::vec(prop::bool::weighted(0.3), 2 * 140),
            start in (0u8..7, 0u8..20),
            goals in prop::collection::vec((0u8..7, 0u8..20), 1..3),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (wall, present) in size.walls().zip(present) {
                walls.set(wall.cell, wall.heading, present);
            }
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let goals = goals.into_iter().map(inside).collect();
            let maze = Maze::new(walls, inside(start), goals).unwrap();
            let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals());
            prop_assert_eq!(optimum, naive(&maze));
            let race = RaceSteps::flood(maze.walls(), maze.goals());
            let mut trial = Trial::new(&maze);
            for _ in 0..race.at(maze.start().cell).unwrap_or(0) {
                trial.act(race.next_move(maze.walls(), trial.pose()).unwrap());
            }
            prop_assert!(optimum.is_none() || maze.goals().contains(trial.pose().cell));
            prop_assert_eq!(race.next_move(maze.walls(), trial.pose()), None);
        }
    }

    #[test]
    fn mazes_of_32_by_32_cells_are_covered() {
        let walls = Walls::open(MazeSize::HALF_SIZE);
        let corner = [Cell::new(31, 31)].into_iter().collect();
        let race = RaceSteps::flood(&walls, &corner);
        assert_eq!(race.at(Cell::new(0, 0)), Some(22));
        for outside in [Cell::new(32, 0), Cell::new(0, 32), Cell::new(255, 255)] {
            assert_eq!(race.at(outside), None);
        }
        let pose = Pose::new(Cell::new(5, 31), Heading::West);
        assert_eq!(race.next_move(&walls, pose), Some(Action::from_numbers(0, -3)));
    }

    #[test]
    fn ties_are_broken_by_length_then_ahead_left_right_back() {
        // The targets are one step away from the centre of an open maze.
        let walls = Walls::open(MazeSize::new(7, 7).unwrap());
        let centre = Cell::new(3, 3);
        let next = |heading: Heading, lengths: [i8; 4]| {
            let [ahead, left, right, back] = lengths;
            let end = |(towards, cells): (Heading, i8)| {
                std::iter::successors(Some(centre), |cell| cell.neighbour(towards))
                    .nth(cells.try_into().unwrap())
            };
            let sides = [
                (heading, ahead),
                (heading.left(), left),
                (heading.right(), right),
                (heading.back(), back),
            ];
            let targets: CellSet =
                sides.into_iter().filter(|&(_, cells)| cells > 0).filter_map(end).collect();
            let race = RaceSteps::flood(&walls, &targets);
            race.next_move(&walls, Pose::new(centre, heading)).unwrap()
        };
        for heading in Heading::ALL {
            let expect = |lengths, rotation, cells| {
                assert_eq!(
                    next(heading, lengths),
                    Action::from_numbers(rotation, cells),
                    "{heading} {lengths:?}"
                );
            };
            expect([2, 2, 2, 2], 0, 2);
            expect([0, 2, 2, 2], -90, 2);
            expect([0, 0, 2, 2], 90, 2);
            expect([0, 0, 0, 2], 0, -2);
            expect([1, 2, 2, 2], -90, 2);
            expect([1, 1, 2, 2], 90, 2);
            expect([1, 1, 1, 2], 0, -2);
            expect([3, 2, 2, 2], 0, 3);
        }
    }
}
