//! Flood: the distance of every cell to the nearest target.

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

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
    /// Row by row from the south, as wide as the maze.
    steps: [u16; MazeSize::MAX_AREA],
}

/// The distance of a cell from which no target can be reached.
const UNREACHABLE: u16 = u16::MAX;

impl Distances {
    /// Distances nowhere known: no target can be reached from any cell.
    pub const fn unreachable(size: MazeSize) -> Self {
        Self { size, steps: [UNREACHABLE; MazeSize::MAX_AREA] }
    }

    /// Floods the maze from its targets outwards, a breadth-first search. Targets outside of the
    /// maze do not count.
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        let size = walls.size();
        let mut distances = Self::unreachable(size);
        let mut queue = [Cell::new(0, 0); MazeSize::MAX_AREA];
        let (mut reached, mut done) = (0, 0);
        for cell in targets.iter().filter(|&cell| size.contains(cell)) {
            distances.set(cell, 0);
            queue[reached] = cell;
            reached += 1;
        }
        while done < reached {
            let cell = queue[done];
            done += 1;
            for neighbour in walls.open_neighbours(cell) {
                if distances.at(neighbour).is_none() {
                    distances.set(neighbour, distances.at(cell).unwrap_or(0) + 1);
                    queue[reached] = neighbour;
                    reached += 1;
                }
            }
        }
        distances
    }

    /// Steps from `cell` to the nearest target, `None` where there is no way and outside of the
    /// maze.
    pub fn at(&self, cell: Cell) -> Option<u16> {
        let index = self.index(cell)?;
        Some(self.steps[index]).filter(|&steps| steps != UNREACHABLE)
    }

    /// How many cells have a way to a target.
    pub fn reachable_cells(&self) -> usize {
        self.size.cells().filter(|&cell| self.at(cell).is_some()).count()
    }

    fn set(&mut self, cell: Cell, steps: u16) {
        if let Some(index) = self.index(cell) {
            self.steps[index] = steps;
        }
    }

    fn index(&self, cell: Cell) -> Option<usize> {
        let width = usize::from(self.size.width());
        self.size.contains(cell).then(|| usize::from(cell.y) * width + usize::from(cell.x))
    }
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
