//! Flood: the distance of every cell to the nearest target.

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

mod board;
mod bytes;
mod half;
mod waves;

use board::{Board, Chequered};
use half::Half;
use waves::Marks;

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
    bytes: [u8; SMALL_AREA],
    /// Whether `UNREACHABLE_BYTE` is a distance: where one is so long, the way passes through all
    /// cells.
    all_reached: bool,
}

const SMALL_SIDE: usize = 16;
const SMALL_AREA: usize = SMALL_SIDE * SMALL_SIDE;
const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The distance of a cell from which no target can be reached.
const UNREACHABLE: u16 = u16::MAX;
const UNREACHABLE_BYTE: u8 = u8::MAX;

impl Distances {
    /// Distances nowhere known: no target can be reached from any cell.
    pub const fn unreachable(size: MazeSize) -> Self {
        let bytes = [UNREACHABLE_BYTE; SMALL_AREA];
        let steps = if is_small(size) {
            Steps::Small(SmallSteps { bytes, all_reached: false })
        } else {
            Steps::Large([UNREACHABLE; MazeSize::MAX_AREA])
        };
        Self { size, steps }
    }

    /// Floods the maze from its targets outwards, a breadth-first search. Targets outside of the
    /// maze do not count.
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        let size = walls.size();
        let steps = if is_small(size) {
            Steps::Small(small::<[u64; 2]>(walls, targets))
        } else {
            Steps::Large(large::<[u64; 8]>(walls, targets))
        };
        Self { size, steps }
    }

    /// Steps from `cell` to the nearest target, `None` where there is no way and outside of the
    /// maze.
    pub fn at(&self, cell: Cell) -> Option<u16> {
        if !self.size.contains(cell) {
            return None;
        }
        let (x, y) = (usize::from(cell.x), usize::from(cell.y));
        match &self.steps {
            Steps::Small(SmallSteps { bytes, all_reached }) => {
                let steps = bytes[y * SMALL_SIDE + x];
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

#[inline(always)]
fn marks<const N: usize, H: Half<N>>(walls: &Walls, targets: &CellSet) -> Chequered<Marks<H>> {
    waves::flood(&Board::of(walls), Chequered::of(targets))
}

#[inline(always)]
fn small<H: Half<2>>(walls: &Walls, targets: &CellSet) -> SmallSteps {
    let marks = marks::<2, H>(walls, targets);
    let mut lines = [[[0; 16]; 8]; 2];
    bytes::write(&marks, 0, &mut lines);
    let mut bytes = [0; SMALL_AREA];
    for (bytes, line) in bytes.chunks_exact_mut(16).zip(lines.as_flattened()) {
        bytes.copy_from_slice(line);
    }
    let all_reached = marks.dark.dry.or(marks.light.dry).is_empty();
    SmallSteps { bytes, all_reached }
}

#[inline(always)]
fn large<H: Half<8>>(walls: &Walls, targets: &CellSet) -> [u16; MazeSize::MAX_AREA] {
    let marks = marks::<8, H>(walls, targets);
    let mut low = [[[0; 16]; 8]; 8];
    let mut high = low;
    bytes::write(&marks, 0, &mut low);
    bytes::write(&marks, 8, &mut high);
    let mut steps = [0; MazeSize::MAX_AREA];
    let bytes = low.as_flattened().as_flattened().iter().zip(high.as_flattened().as_flattened());
    for (steps, (&low, &high)) in steps.iter_mut().zip(bytes) {
        *steps = u16::from_le_bytes([low, high]);
    }
    steps
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, Maze};
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
