//! Flood: the distance of every cell to the nearest target.

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Walls};

mod board;
mod both;
mod bytes;
mod downhill;
mod half;
mod waves;
#[cfg(target_arch = "x86_64")]
mod x86;

use board::{Board, Chequered};
use bytes::Line;
pub use downhill::Downhill;
use half::Half;
use waves::Marks;
#[cfg(target_arch = "x86_64")]
use x86::run;

/// Distances in steps from each cell to the nearest of some target cells, along ways without a
/// wall.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_solvers::Distances;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let distances = Distances::flood(&walls, &MazeSize::CLASSIC.central_cells());
/// assert_eq!(distances.at(Cell::new(0, 0)), Some(14));
/// assert_eq!(distances.at(Cell::new(8, 7)), Some(0));
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Distances {
    size: MazeSize,
    steps: Steps,
}

#[derive(Clone, PartialEq, Eq, Debug)]
enum Steps {
    /// Of a maze of up to 16×16 cells: row by row from the south, 16 to a row.
    Small(SmallSteps),
    /// Of a larger one, 32 to a row.
    Large([u16; MazeSize::MAX_AREA]),
}

#[derive(Clone, PartialEq, Eq, Debug)]
struct SmallSteps {
    lines: [[Line; 8]; 2],
    /// Whether `UNREACHABLE_BYTE` is a distance: where one is so long, the way passes through all
    /// cells.
    all_reached: bool,
}

const SMALL_SIDE: usize = 16;
const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The distance of a cell from which no target can be reached.
const UNREACHABLE: u16 = u16::MAX;
const UNREACHABLE_BYTE: u8 = u8::MAX;

impl Distances {
    /// Distances nowhere known: no target can be reached from any cell.
    pub const fn unreachable(size: MazeSize) -> Self {
        let lines = [[[UNREACHABLE_BYTE; SMALL_SIDE]; 8]; 2];
        let steps = if is_small(size) {
            Steps::Small(SmallSteps { lines, all_reached: false })
        } else {
            Steps::Large([UNREACHABLE; MazeSize::MAX_AREA])
        };
        Self { size, steps }
    }

    /// Floods the maze from its targets outwards, a breadth-first search. Targets outside of the
    /// maze do not count.
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        let mut distances = Self::unreachable(walls.size());
        run(Flood { walls, targets, distances: &mut distances }, walls.size());
        distances
    }

    /// Floods anew, in the same place.
    pub(crate) fn refill(&mut self, walls: &Walls, targets: &CellSet) {
        if self.size != walls.size() {
            *self = Self::unreachable(walls.size());
        }
        run(Flood { walls, targets, distances: self }, walls.size());
    }

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
        let changes = !self.stays_right(walls, targets, seen);
        if changes {
            self.refill(walls, targets);
        }
        changes
    }

    /// Whether walls around this cell leave everything as it is.
    fn stays_right(&self, walls: &Walls, targets: &CellSet, seen: Cell) -> bool {
        let is_open = |cell, heading| !walls.has(cell, heading);
        // Whether a cell is a target or has a neighbour that is a step nearer.
        let has_way_on = |cell: Cell, steps: u16| {
            let mut neighbours = Heading::ALL.into_iter().filter(|&heading| is_open(cell, heading));
            targets.contains(cell) && steps == 0
                || neighbours.any(|heading| self.beyond(cell, heading) == steps.wrapping_sub(1))
        };
        let steps = self.raw(seen);
        let (mut is_right, mut loses_way) = (true, false);
        for heading in Heading::ALL {
            let beyond = self.beyond(seen, heading);
            if is_open(seen, heading) {
                // Nobody reaches one of two neighbours alone.
                let is_reached = (steps == UNREACHABLE) == (beyond == UNREACHABLE);
                is_right &= is_reached && steps.abs_diff(beyond) <= 1;
            } else if beyond != UNREACHABLE && steps != UNREACHABLE {
                loses_way |= steps == beyond + 1;
                let loses = beyond == steps + 1;
                let neighbour = seen.neighbour(heading).filter(|_| loses);
                is_right &= neighbour.is_none_or(|neighbour| has_way_on(neighbour, beyond));
            }
        }
        is_right && (!loses_way || has_way_on(seen, steps))
    }

    /// The steps of a cell's neighbour.
    fn beyond(&self, cell: Cell, heading: Heading) -> u16 {
        cell.neighbour(heading).map_or(UNREACHABLE, |neighbour| self.raw(neighbour))
    }

    /// Steps, or [`UNREACHABLE`].
    fn raw(&self, cell: Cell) -> u16 {
        self.at(cell).unwrap_or(UNREACHABLE)
    }

    /// Steps from `cell` to the nearest target, `None` where there is no way and outside of the
    /// maze.
    pub fn at(&self, cell: Cell) -> Option<u16> {
        if !self.size.contains(cell) {
            return None;
        }
        let (x, y) = (usize::from(cell.x), usize::from(cell.y));
        match &self.steps {
            Steps::Small(SmallSteps { lines, all_reached }) => {
                let steps = lines[y / 8][y % 8][x];
                (steps != UNREACHABLE_BYTE || *all_reached).then_some(steps.into())
            }
            Steps::Large(steps) => Some(steps[y * SIDE + x]).filter(|&steps| steps != UNREACHABLE),
        }
    }

    /// How many cells have a way to a target.
    pub fn reachable_cells(&self) -> usize {
        self.size.cells().filter(|&cell| self.at(cell).is_some()).count()
    }
}

const fn is_small(size: MazeSize) -> bool {
    size.width() as usize <= SMALL_SIDE && size.height() as usize <= SMALL_SIDE
}

/// Steps from a cell to the nearest target, `None` where there is no way and where the cell lies
/// outside of the maze. This is a flood that ends as soon as it comes to a target, and writes nothing
/// down on its way.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_solvers::steps_between;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let goals = MazeSize::CLASSIC.central_cells();
/// assert_eq!(steps_between(&walls, Cell::new(0, 0), &goals), Some(14));
/// ```
pub fn steps_between(walls: &Walls, from: Cell, targets: &CellSet) -> Option<u16> {
    let size = walls.size();
    let is_inside = size.contains(from);
    is_inside.then(|| run(StepsBetween { walls, from, targets }, size)).flatten()
}

/// Something to be done with halves of a maze, of the kind that the processor is best at.
trait Task {
    type Output;

    /// `N` is 2 in mazes of up to 16×16 cells, 8 in larger ones.
    fn run<const N: usize, H: Half<N>>(self) -> Self::Output;
}

/// Does this with halves that any processor has.
#[cfg(not(target_arch = "x86_64"))]
fn run<T: Task>(task: T, size: MazeSize) -> T::Output {
    if is_small(size) { task.run::<2, [u64; 2]>() } else { task.run::<8, [u64; 8]>() }
}

struct Flood<'a> {
    walls: &'a Walls,
    targets: &'a CellSet,
    /// Of the same size.
    distances: &'a mut Distances,
}

impl Task for Flood<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) {
        let Self { walls, targets, distances } = self;
        distances.write(&waves::flood(&Board::<H>::of(walls), Chequered::of(targets)));
    }
}

struct StepsBetween<'a> {
    walls: &'a Walls,
    from: Cell,
    targets: &'a CellSet,
}

impl Task for StepsBetween<'_> {
    type Output = Option<u16>;

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) -> Option<u16> {
        let Self { walls, from, targets } = self;
        waves::steps(&Board::<H>::of(walls), Chequered::of_cell(from), Chequered::of(targets))
    }
}

impl Distances {
    /// Takes over what waves have left behind in a maze of this size.
    #[inline(always)]
    fn write<const N: usize, H: Half<N>>(&mut self, marks: &Chequered<Marks<H>>) {
        match &mut self.steps {
            Steps::Small(steps) => {
                bytes::write(marks, 0, &mut steps.lines);
                steps.all_reached = marks.dark.dry.or(marks.light.dry).is_empty();
            }
            Steps::Large(steps) => {
                let mut low = [[[0; 16]; 8]; 8];
                let mut high = low;
                bytes::write(marks, 0, &mut low);
                bytes::write(marks, 8, &mut high);
                let low = low.as_flattened().as_flattened();
                let high = high.as_flattened().as_flattened();
                for (steps, (&low, &high)) in steps.iter_mut().zip(low.iter().zip(high)) {
                    *steps = u16::from_le_bytes([low, high]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn distances_go_round_walls() {
        let maze: Maze = "\
o---o---o---o
|     G |   |
o   o---o---o
| S |       |
o---o---o---o
"
        .parse()
        .unwrap();
        let distances = Distances::flood(maze.walls(), maze.goals());
        let numbers = |cell| distances.at(cell);
        insta::assert_snapshot!(maze.drawing().with_numbers(&numbers), @"
        o---o---o---o
        | 1   0 |   |
        o   o---o---o
        | 2 |       |
        o---o---o---o
        ");
        assert_eq!(distances.reachable_cells(), 3);
        assert_eq!(distances.at(Cell::new(3, 0)), None);
    }

    #[test]
    fn the_longest_way_of_a_32x32_maze_is_counted() {
        let size = MazeSize::HALF_SIZE;
        let mut walls = Walls::open(size);
        for y in 0..31 {
            let gap = if y % 2 == 0 { 31 } else { 0 };
            for x in (0..32).filter(|&x| x != gap) {
                walls.set(Cell::new(x, y), Heading::North, true);
            }
        }
        let targets = [Cell::new(0, 31)].into_iter().collect();
        let distances = Distances::flood(&walls, &targets);
        assert_eq!(distances.at(Cell::new(0, 0)), Some(1023));
    }

    #[test]
    fn targets_outside_do_not_count() {
        let walls = Walls::open(MazeSize::new(2, 2).unwrap());
        let targets = [Cell::new(2, 0)].into_iter().collect();
        assert_eq!(Distances::flood(&walls, &targets).reachable_cells(), 0);
    }

    /// The naive twin: relax every way until nothing changes.
    fn naive(walls: &Walls, targets: &CellSet) -> Vec<Option<u16>> {
        let size = walls.size();
        let mut steps: Vec<Option<u16>> =
            size.cells().map(|cell| targets.contains(cell).then_some(0)).collect();
        let index =
            |cell: Cell| usize::from(cell.y) * usize::from(size.width()) + usize::from(cell.x);
        loop {
            let before = steps.clone();
            for cell in size.cells() {
                for heading in Heading::ALL.into_iter().filter(|&heading| !walls.has(cell, heading))
                {
                    let next = cell.neighbour(heading).and_then(|next| steps[index(next)]);
                    let through = next.map(|steps| steps + 1);
                    let here = &mut steps[index(cell)];
                    *here = [*here, through].into_iter().flatten().min();
                }
            }
            if steps == before {
                return steps;
            }
        }
    }

    proptest! {
        #[test]
        fn a_flood_equals_its_naive_twin(
            (width, height) in (1usize..=32, 1usize..=32),
            present in prop::collection::vec(prop::bool::weighted(0.4), 2 * MazeSize::MAX_AREA),
            targets in prop::collection::vec((0u8..32, 0u8..32), 0..5),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (cell, present) in size.cells().zip(present.chunks(2)) {
                walls.set(cell, Heading::North, present[0]);
                walls.set(cell, Heading::East, present[1]);
            }
            let targets: CellSet = targets.into_iter().map(|(x, y)| Cell::new(x, y)).collect();
            let distances = Distances::flood(&walls, &targets);
            let flooded: Vec<_> = size.cells().map(|cell| distances.at(cell)).collect();
            prop_assert_eq!(flooded, naive(&walls, &targets));
        }
    }
}
