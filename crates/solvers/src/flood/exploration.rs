//! Selection of the cell that a mouse explores next while it searches for a proven shortest path.

use mmsim_maze::{Cell, CellSet, KnownMaze};

use super::Distances;
use super::bytes::{FloodMemory, exploration::TargetSelection};
use super::dispatch::{Instructions, Task, run};
use super::steps::Steps;
use super::wide::{self, plane::ParityPlane};

/// True if [`exploration_target`] does not overwrite distances.
pub(crate) const KEEPS_DISTANCES: bool = !Instructions::PREFERS_BYTES;

/// Selects the cell that a mouse at `mouse` should explore next. Returns `None` if one of the
/// optimistic shortest paths is known to be open, or if there is no path.
///
/// A layer consists of all cells on the optimistic shortest paths that have the same distance
/// from the start. A candidate is an unvisited cell with an unknown wall that an optimistic
/// shortest path crosses. If some layers contain candidates but no visited cell, only the
/// candidates in the narrowest of these layers (those with the fewest cells) are considered.
/// The target is the candidate nearest to the mouse. If several candidates are equally near,
/// the target is the candidate farthest from the start, because the mouse can visit the other
/// candidates on its way back.
///
/// Writes all cells on the optimistic shortest paths to `paths`. Overwrites `memory`. Also overwrites
/// `distances`, which must belong to a maze of the same size, unless [`KEEPS_DISTANCES`] is true.
pub(crate) fn exploration_target(
    map: &KnownMaze,
    mouse: Cell,
    paths: &mut CellSet,
    memory: &mut FloodMemory,
    distances: &mut Distances,
) -> Option<Cell> {
    run(FindTarget { map, mouse, paths, memory, distances }, map.size())
}

struct FindTarget<'a> {
    map: &'a KnownMaze,
    mouse: Cell,
    paths: &'a mut CellSet,
    /// Memory for [`run_on_bytes`](Task::run_on_bytes).
    memory: &'a mut FloodMemory,
    /// More memory for [`run_on_bytes`](Task::run_on_bytes).
    distances: &'a mut Distances,
}

impl Task for FindTarget<'_> {
    type Output = Option<Cell>;

    #[inline(always)]
    fn run<H: ParityPlane>(self) -> Option<Cell> {
        wide::exploration::find::<H>(self.map, self.mouse, self.paths)
    }

    fn run_on_bytes(self) -> Option<Cell> {
        let Self { map, mouse, paths, memory, distances } = self;
        let Steps::Small(steps) = &mut distances.steps else { return None };
        TargetSelection { map, mouse, paths, memory, bytes: steps.bytes()? }.find()
    }
}

#[cfg(test)]
mod tests {
    use core::cmp::Reverse;
    use core::ops::Range;

    use mmsim_maze::{Heading, Maze, MazeSize, Pose, Unknown, WallState};
    use proptest::prelude::*;

    use super::*;
    use crate::flood::dispatch::run_with;
    use crate::flood::only;
    use crate::flood::tests::{any_targets, any_walls, available};

    #[test]
    fn explores_narrow_layers_without_a_visited_cell() {
        let maze: Maze = "\
o---o---o---o---o---o
|       |   |     G |
o   o   o---o   o   o
|                   |
o   o   o---o   o   o
| S     |   |       |
o---o---o---o---o---o
"
        .parse()
        .unwrap();
        let mut map = KnownMaze::unexplored(&maze);
        for y in [0, 2] {
            for heading in Heading::ALL {
                map.set_wall(Cell::new(2, y), heading, WallState::Present);
            }
        }
        let mut see = |x, y| {
            for heading in [Heading::North, Heading::South] {
                let pose = Pose::new(Cell::new(x, y), heading);
                map.observe(pose, maze.walls().around(pose)).unwrap();
            }
            let from_start = Distances::flood(map.walls(Unknown::Open), &only(map.start().cell));
            let candidates = candidates(&map, &from_start);
            let mouse = Cell::new(x, y);
            let mut memory = FloodMemory::NEW;
            let mut distances = Distances::unreachable(map.size());
            let mut paths = CellSet::EMPTY;
            let found = exploration_target(&map, mouse, &mut paths, &mut memory, &mut distances);
            assert_eq!(found.map(|cell| (cell, paths)), naive(&map, mouse));
            candidates
                .map(|(cells, _)| cells.iter().map(|cell| (cell.x, cell.y)).collect::<Vec<_>>())
        };
        assert_eq!(see(0, 0), Some(vec![(1, 1), (2, 1), (3, 1), (4, 2)]), "layers of one cell");
        assert_eq!(see(4, 2), Some(vec![(1, 1), (2, 1), (3, 1)]));
        assert_eq!(see(2, 1), Some(vec![(1, 1), (3, 1)]), "unknown on their other sides");
        assert_eq!(see(1, 1), Some(vec![(3, 1)]));
        assert_eq!(see(3, 1), None, "a path is known to be open");
    }

    proptest! {
        // Most random maps have few candidates.
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn the_target_equals_the_naive_one(
            walls in any_walls(),
            goals in any_targets(),
            seen in prop::collection::vec((0u8..32, 0u8..32, 0usize..4), 0..200),
            (start, mouse) in ((0u8..32, 0u8..32), (0u8..32, 0u8..32)),
        ) {
            let size = walls.size();
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let mut map = KnownMaze::new(size, inside(start), goals);
            for (x, y, heading) in seen {
                let pose = Pose::new(inside((x, y)), Heading::ALL[heading]);
                map.observe(pose, walls.around(pose)).unwrap();
            }
            let (map, mouse) = (&map, inside(mouse));
            let expected = naive(map, mouse);
            let mut memory = FloodMemory::NEW;
            let mut distances = Distances::unreachable(size);
            for instructions in available() {
                let (mut paths, memory) = (CellSet::EMPTY, &mut memory);
                let distances = &mut distances;
                let task = FindTarget { map, mouse, paths: &mut paths, memory, distances };
                let found = run_with(instructions, task, size).map(|cell| (cell, paths));
                prop_assert_eq!(found, expected);
            }
        }
    }

    /// Finds the target naively, by comparing distances cell by cell.
    fn naive(map: &KnownMaze, mouse: Cell) -> Option<(Cell, CellSet)> {
        let open = map.walls(Unknown::Open);
        let from_start = Distances::flood(open, &only(map.start().cell));
        let (candidates, paths) = candidates(map, &from_start)?;
        let from_mouse = Distances::flood(open, &only(mouse));
        let near_and_far_out = |&cell: &Cell| (from_mouse.at(cell), Reverse(from_start.at(cell)));
        let reachable = candidates.iter().filter(|&cell| from_mouse.at(cell).is_some());
        Some((reachable.min_by_key(near_and_far_out)?, paths))
    }

    /// Follows the optimistic shortest paths from goal to start. Returns the candidates that
    /// [`exploration_target`] considers, and all cells on the optimistic shortest paths, or
    /// `None` if one of these paths is known to be open.
    fn candidates(map: &KnownMaze, from_start: &Distances) -> Option<(CellSet, CellSet)> {
        let mut paths = NaivePaths::to_goals(map, from_start);
        let (mut width, mut narrowest, mut others) = (usize::MAX, CellSet::EMPTY, CellSet::EMPTY);
        let mut layer = 0..paths.count;
        while !layer.is_empty() {
            let nearer = paths.go_back(map, from_start, layer.clone());
            let cells = &paths.cells[layer];
            let is_unvisited = |&cell: &Cell| !map.visited().contains(cell);
            let is_candidate = |&cell: &Cell| is_unvisited(&cell) && paths.doubtful.contains(cell);
            let mut candidates = cells.iter().copied().filter(is_candidate).peekable();
            if candidates.peek().is_none() || !cells.iter().all(is_unvisited) {
                others.extend(candidates);
            } else if cells.len() < width {
                (width, narrowest) = (cells.len(), candidates.collect());
            } else if cells.len() == width {
                narrowest.extend(candidates);
            }
            layer = nearer;
        }
        let candidates = if narrowest.is_empty() { others } else { narrowest };
        Some((candidates, paths.found)).filter(|_| !paths.sure.contains(map.start().cell))
    }

    /// The cells on the optimistic shortest paths, found layer by layer from the goal back to the
    /// start.
    struct NaivePaths {
        cells: [Cell; MazeSize::MAX_AREA],
        count: usize,
        found: CellSet,
        /// The cells from which a path to the goal is known to be open.
        sure: CellSet,
        /// The cells on both sides of each unknown wall that an optimistic shortest path crosses.
        doubtful: CellSet,
    }

    impl NaivePaths {
        /// Creates a list of the goal cells nearest to the start.
        fn to_goals(map: &KnownMaze, from_start: &Distances) -> Self {
            let nearest = map.goals().iter().filter_map(|goal| from_start.at(goal)).min();
            let is_end = |&goal: &Cell| nearest.is_some() && from_start.at(goal) == nearest;
            let ends = map.goals().iter().filter(is_end).collect();
            let cells = [Cell::new(0, 0); MazeSize::MAX_AREA];
            let mut paths =
                Self { cells, count: 0, found: ends, sure: ends, doubtful: CellSet::EMPTY };
            for (place, end) in paths.cells.iter_mut().zip(ends.iter()) {
                *place = end;
                paths.count += 1;
            }
            paths
        }

        /// Adds the path cells that are one step nearer to the start than the cells of `layer`.
        /// Returns the indices of the added cells.
        fn go_back(
            &mut self,
            map: &KnownMaze,
            from_start: &Distances,
            layer: Range<usize>,
        ) -> Range<usize> {
            for index in layer.clone() {
                let cell = self.cells[index];
                let steps = from_start.at(cell).and_then(|steps| steps.checked_sub(1));
                let is_nearer = |&next: &Cell| steps.is_some() && from_start.at(next) == steps;
                for heading in Heading::ALL {
                    let Some(next) = cell.neighbour(heading).filter(is_nearer) else { continue };
                    match map.wall(cell, heading) {
                        WallState::Present => continue,
                        WallState::Absent if !self.sure.contains(cell) => {}
                        WallState::Absent => self.sure.extend([next]),
                        WallState::Unknown => self.doubtful.extend([cell, next]),
                    }
                    if self.found.insert(next) {
                        self.cells[self.count] = next;
                        self.count += 1;
                    }
                }
            }
            layer.end..self.count
        }
    }
}
