//! The race: the fewest time steps to the goal.

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Pose, Walls};

use crate::{Action, Rotation};

const SIDE: usize = MazeSize::MAX_SIDE as usize;
/// Rows without a cell on either side of the maze, so that nobody checks bounds.
const MARGIN: usize = Action::MAX_CELLS as usize;
const UNREACHABLE: u16 = u16::MAX;

/// Time steps from each cell to the nearest of some target cells.
///
/// A step is a straight of 1 to 3 cells. The heading does not count: a robot turns left or right
/// before it moves, and where it wants to go back it reverses, all within the step. Targets count
/// where a step ends, not where it crosses them; since a straight may end after any cell, that
/// only ever costs a step, never the way.
///
/// This is a breadth-first search in which a wave is a few operations on the maze's rows as bits.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_trial::RaceSteps;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let race = RaceSteps::flood(&walls, &MazeSize::CLASSIC.central_cells());
/// assert_eq!(race.at(Cell::new(0, 0)), Some(6), "7 cells and 7 cells, 3 at a time");
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RaceSteps {
    size: MazeSize,
    /// Row by row from the south, 32 cells wide.
    steps: [u16; MazeSize::MAX_AREA],
}

impl RaceSteps {
    /// Floods the maze from its targets outwards. Targets outside of the maze do not count.
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        let size = walls.size();
        let mut race = Self { size, steps: [UNREACHABLE; MazeSize::MAX_AREA] };
        if size.height() <= 16 {
            Straights::<16, 22>::of(walls).flood(targets, &mut race.steps);
        } else {
            Straights::<32, 38>::of(walls).flood(targets, &mut race.steps);
        }
        race
    }

    /// Time steps from `cell` to the nearest target, 0 in a target; `None` where there is no way
    /// and outside of the maze.
    pub fn at(&self, cell: Cell) -> Option<u16> {
        let index = || usize::from(cell.y) * SIDE + usize::from(cell.x);
        let steps = self.size.contains(cell).then(|| self.steps[index()]);
        steps.filter(|&steps| steps != UNREACHABLE)
    }

    /// The first move of a fastest way from `pose`; `None` in a target and where there is no way.
    /// Of several it takes the longest, and of those the first of ahead, left, right and back.
    pub fn next_move(&self, walls: &Walls, pose: Pose) -> Option<Action> {
        let (heading, cells) = self.next_straight(walls, pose)?;
        Some(Action::towards(pose.heading, heading, i8::try_from(cells).ok()?))
    }

    /// The same as where it goes and how many cells.
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

impl Action {
    /// The move that takes a robot with its nose towards `nose` this many cells towards `heading`:
    /// backwards if that lies behind it.
    pub(crate) fn towards(nose: Heading, heading: Heading, cells: i8) -> Self {
        let turn = |rotation: &Rotation| rotation.turn(nose) == heading;
        match [Rotation::None, Rotation::Left, Rotation::Right].into_iter().find(turn) {
            Some(rotation) => Self::Move { rotation, cells },
            None => Self::Move { rotation: Rotation::None, cells: -cells },
        }
    }
}

/// The cells in which a step from `cell` towards `heading` may end, the nearest first.
pub(crate) fn straight(
    walls: &Walls,
    cell: Cell,
    heading: Heading,
) -> impl Iterator<Item = Cell> + '_ {
    let next = move |&here: &Cell| here.neighbour(heading).filter(|_| !walls.has(here, heading));
    std::iter::successors(Some(cell), next).skip(1).take(MARGIN)
}

/// The fewest steps of a race from the start, `None` where the goal cannot be reached. A robot that
/// starts in the goal needs a step that ends there all the same.
pub fn race_optimum(walls: &Walls, start: Cell, goals: &CellSet) -> Option<u16> {
    RaceSteps::flood(walls, goals).at(start).map(|steps| steps.max(1))
}

/// Where a robot can go straight on for 1, 2 and 3 cells: bit x of row `MARGIN` + y. `PADDED` is
/// `ROWS` with both margins. (Where there are no cells there is no way on.)
pub(crate) struct Straights<const ROWS: usize, const PADDED: usize> {
    north: [[u32; PADDED]; MARGIN],
    east: [[u32; PADDED]; MARGIN],
}

impl<const ROWS: usize, const PADDED: usize> Straights<ROWS, PADDED> {
    pub(crate) fn of(walls: &Walls) -> Self {
        let (width, height) = (u32::from(walls.size().width()), usize::from(walls.size().height()));
        let columns = u32::MAX >> (32 - width);
        let (mut north, mut east) = ([[0; PADDED]; MARGIN], [[0; PADDED]; MARGIN]);
        for y in 0..height {
            if y + 1 < height {
                north[0][MARGIN + y] = !walls.north_rows()[y] & columns;
            }
            east[0][MARGIN + y] = !walls.east_rows()[y] & columns >> 1;
        }
        for longer in 1..MARGIN {
            for y in MARGIN..MARGIN + ROWS {
                north[longer][y] = north[0][y] & north[longer - 1][y + 1];
                east[longer][y] = east[0][y] & east[longer - 1][y] >> 1;
            }
        }
        Self { north, east }
    }

    fn flood(&self, targets: &CellSet, steps: &mut [u16; MazeSize::MAX_AREA]) {
        let mut wave = Wave::of(targets);
        let mut reached = wave;
        for time in 0.. {
            if wave.is_empty() {
                return;
            }
            wave.for_each(|Cell { x, y }| steps[usize::from(y) * SIDE + usize::from(x)] = time);
            wave = self.next(&wave, &reached);
            reached.add(&wave);
        }
    }

    /// The cells one step from the wave that are not among the others.
    pub(crate) fn next(&self, Wave(wave): &Wave<PADDED>, others: &Wave<PADDED>) -> Wave<PADDED> {
        let mut next = [0; PADDED];
        for y in MARGIN..MARGIN + ROWS {
            let mut row = 0;
            for (longer, (north, east)) in self.north.iter().zip(&self.east).enumerate() {
                let cells = longer + 1;
                row |= wave[y - cells] & north[y - cells] | wave[y + cells] & north[y];
                row |= (wave[y] & east[y]) << cells | wave[y] >> cells & east[y];
            }
            next[y] = row & !others.0[y];
        }
        Wave(next)
    }

    /// The cells in which a step from there may end, the nearest first.
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

/// Cells as bits: bit x of row `MARGIN` + y.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wave<const PADDED: usize>([u32; PADDED]);

impl<const PADDED: usize> Wave<PADDED> {
    pub(crate) fn of(cells: &CellSet) -> Self {
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

    /// All cells that are not among these.
    pub(crate) fn others(&self) -> Self {
        Self(self.0.map(|row| !row))
    }

    pub(crate) fn for_each(&self, mut visit: impl FnMut(Cell)) {
        for (y, &row) in (0_u8..).zip(&self.0[MARGIN..PADDED - MARGIN]) {
            let mut row = row;
            while row != 0 {
                // At most 31.
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
    use crate::Trial;

    /// The naive twin: breadth first over cell and heading, each move tried in the environment.
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
        fn a_race_equals_its_naive_twin(
            (width, height) in (1usize..=7, prop_oneof![1usize..=6, 17usize..20]),
            present in prop::collection::vec(prop::bool::weighted(0.3), 2 * 140),
            start in (0u8..7, 0u8..20),
            goals in prop::collection::vec((0u8..7, 0u8..20), 1..3),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (cell, present) in size.cells().zip(present.chunks(2)) {
                walls.set(cell, Heading::North, present[0]);
                walls.set(cell, Heading::East, present[1]);
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
    fn the_longest_straights_reach_32_cells() {
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
}
