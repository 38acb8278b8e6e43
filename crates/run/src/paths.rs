//! The shortest path of a maze and the bounds of its length, and the path that a mouse plans to take.

use mmsim_maze::{Cell, KnownMaze, Maze, Pose, Unknown, Walls};
use mmsim_solvers::{Distances, PathBounds};
use mmsim_trial::{RaceSteps, race_optimum};
use serde::Serialize;

/// The maximum number of sampled states of a run.
const MAX_SAMPLES: usize = 512;

/// Computes the bounds of the shortest path in cells or, in a two-run trial, of the fastest race in time
/// steps. The bounds are proven if they are equal.
///
/// ```
/// use mmsim_maze::{KnownMaze, Maze};
/// use mmsim_run::bounds;
/// let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse()?;
/// let map = KnownMaze::unexplored(&maze);
/// assert_eq!(bounds(&map, false).optimistic, Some(2));
/// assert_eq!(bounds(&map, true).optimistic, Some(1));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub fn bounds(map: &KnownMaze, is_trial: bool) -> PathBounds {
    if !is_trial {
        return PathBounds::new(map);
    }
    let race = |unknown| race_optimum(map.walls(unknown), map.start().cell, map.goals());
    PathBounds { optimistic: race(Unknown::Open), pessimistic: race(Unknown::Closed) }
}

/// The bounds at the states of a run whose index is a multiple of `stride`. The field names are JSON
/// keys.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BoundsHistory {
    /// The number of states of the run.
    states: usize,
    /// The number of states from one sample to the next, a power of two.
    stride: usize,
    optimistic: Vec<Option<u16>>,
    pessimistic: Vec<Option<u16>>,
}

impl Default for BoundsHistory {
    fn default() -> Self {
        Self { states: 0, stride: 1, optimistic: Vec::new(), pessimistic: Vec::new() }
    }
}

impl BoundsHistory {
    /// Extends the history to `states` states without recomputing existing samples.
    ///
    /// # Errors
    /// Returns the error of `sample`, which returns the bounds at a state.
    pub fn extend<E>(
        &mut self,
        states: usize,
        mut sample: impl FnMut(usize) -> Result<PathBounds, E>,
    ) -> Result<(), E> {
        self.states = states;
        while states.div_ceil(self.stride) > MAX_SAMPLES {
            self.stride *= 2;
            for samples in [&mut self.optimistic, &mut self.pessimistic] {
                *samples = samples.iter().copied().step_by(2).collect();
            }
        }
        for index in (0..states).step_by(self.stride).skip(self.optimistic.len()) {
            let bounds = sample(index)?;
            self.optimistic.push(bounds.optimistic);
            self.pessimistic.push(bounds.pessimistic);
        }
        Ok(())
    }
}

/// Returns the cells of a shortest path from the start to the goal or, in a two-run trial, the cells
/// in which the steps of a fastest race end. The path is empty if the goal is unreachable or if the
/// start is in the goal.
pub fn shortest_path(maze: &Maze, is_trial: bool) -> Vec<Cell> {
    if is_trial {
        return RaceSteps::flood(maze.walls(), maze.goals()).path(maze.walls(), maze.start());
    }
    let distances = Distances::flood(maze.walls(), maze.goals());
    descend(maze.walls(), maze.start(), |cell| distances.at(cell))
}

/// Returns the cells along which the weights lead: always to the neighbour with the lowest weight
/// among those with a lower weight and without a known wall in between. The path is empty if there is
/// no such neighbour.
pub fn planned_path(map: &KnownMaze, pose: Pose, weight: impl Fn(Cell) -> Option<u8>) -> Vec<Cell> {
    descend(map.walls(Unknown::Open), pose, |cell| weight(cell).map(u16::from))
}

/// Goes to the neighbour with the lowest number as long as it is lower than the number of the cell.
/// Prefers the heading of the last step.
fn descend(walls: &Walls, from: Pose, number: impl Fn(Cell) -> Option<u16>) -> Vec<Cell> {
    let next = |&Pose { cell, heading }: &Pose| {
        let headings = [heading, heading.left(), heading.right(), heading.back()];
        let open = headings.into_iter().filter(|&heading| !walls.has(cell, heading));
        let neighbours =
            open.filter_map(|heading| Some(Pose::new(cell.neighbour(heading)?, heading)));
        let lower = neighbours.filter_map(|pose| Some((number(pose.cell)?, pose)));
        let here = number(cell)?;
        let lower = lower.filter(|&(number, _)| number < here);
        lower.min_by_key(|&(number, _)| number).map(|(_, pose)| pose)
    };
    let path: Vec<Cell> = std::iter::successors(Some(from), next).map(|pose| pose.cell).collect();
    if path.len() > 1 { path } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, MazeSize, WallState};
    use mmsim_solvers::MazeFacts;

    use super::*;

    const MAZE: &str = "\
o---o---o---o---o
|             G |
o   o---o---o   o
|   |           |
o   o   o---o---o
|   |           |
o   o   o---o   o
| S |       |   |
o---o---o---o---o
";

    #[test]
    fn the_shortest_path_is_as_long_as_the_shortest_distance() {
        let maze: Maze = MAZE.parse().unwrap();
        let path = shortest_path(&maze, false);
        assert_eq!(path.len(), 7);
        assert_eq!(Some(path.len() - 1), MazeFacts::new(&maze).shortest_path.map(usize::from));
        let expected = [(0, 0), (0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (3, 3)];
        assert_eq!(path, expected.map(|(x, y)| Cell::new(x, y)));
        let race = shortest_path(&maze, true);
        assert_eq!(race, [(0, 0), (0, 3), (3, 3)].map(|(x, y)| Cell::new(x, y)));
        let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals());
        assert_eq!(optimum.map(usize::from), Some(race.len() - 1));
    }

    #[test]
    fn an_unreachable_goal_has_no_path() {
        let closed: Maze = "o---o---o\n| S | G |\no---o---o\n".parse().unwrap();
        let at_goal: Maze = "o---o---o\n|SG     |\no---o---o\n".parse().unwrap();
        for maze in [closed, at_goal] {
            assert_eq!((shortest_path(&maze, false), shortest_path(&maze, true)), (vec![], vec![]));
        }
    }

    #[test]
    fn the_planned_path_follows_the_weights_around_known_walls() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut map = KnownMaze::unexplored(&maze);
        let plan = |map: &KnownMaze, pose, weight: &dyn Fn(Cell) -> u16| {
            planned_path(map, pose, |cell| u8::try_from(weight(cell)).ok())
        };
        let to_goal = |cell: Cell| u16::from(3 - cell.x + 3 - cell.y);
        let start = maze.start();
        let cells = |list: &[(u8, u8)]| -> Vec<Cell> {
            list.iter().map(|&(x, y)| Cell::new(x, y)).collect()
        };
        // Straight ahead, since all neighbours are equally good.
        let expected = cells(&[(0, 0), (0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (3, 3)]);
        assert_eq!(plan(&map, start, &to_goal), expected);
        map.set_wall(start.cell, Heading::North, WallState::Present);
        let expected = cells(&[(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2), (3, 3)]);
        assert_eq!(plan(&map, start, &to_goal), expected);
        // A dead end of the weights, no lower weight, and the goal.
        let dead_end = |cell: Cell| if cell == Cell::new(1, 0) { 0 } else { 7 };
        assert_eq!(plan(&map, start, &dead_end), cells(&[(0, 0), (1, 0)]));
        assert_eq!(plan(&map, start, &|_| 0), []);
        assert_eq!(plan(&map, Pose::new(Cell::new(3, 3), Heading::East), &to_goal), []);
    }

    #[test]
    fn bounds_assume_unknown_walls_open_or_closed() {
        let size = MazeSize::new(3, 1).unwrap();
        let goals = [Cell::new(2, 0)].into_iter().collect();
        let mut map = KnownMaze::new(size, Cell::new(0, 0), goals);
        assert_eq!(bounds(&map, false), PathBounds { optimistic: Some(2), pessimistic: None });
        assert!(!bounds(&map, false).is_proven());
        for x in 0..2 {
            map.set_wall(Cell::new(x, 0), Heading::East, WallState::Absent);
        }
        assert_eq!(bounds(&map, false), PathBounds { optimistic: Some(2), pessimistic: Some(2) });
        assert!(bounds(&map, false).is_proven());
        map.set_wall(Cell::new(0, 0), Heading::East, WallState::Present);
        assert_eq!(bounds(&map, false), PathBounds { optimistic: None, pessimistic: None });
        assert!(!bounds(&map, false).is_proven(), "without a path, no path is optimal");
    }

    #[test]
    fn extending_equals_recomputing() {
        let sample = |index: usize| {
            let optimistic = u16::try_from(index % 60_000).ok();
            let pessimistic = optimistic.filter(|steps| steps % 3 == 0);
            Ok::<_, ()>(PathBounds { optimistic, pessimistic })
        };
        let mut grown = BoundsHistory::default();
        for states in [0, 1, 2, 511, 512, 513, 514, 1024, 1025, 5000, 100_000] {
            let mut fresh = BoundsHistory::default();
            fresh.extend(states, sample).unwrap();
            grown.extend(states, sample).unwrap();
            assert_eq!(grown, fresh);
            assert!(
                grown.optimistic.len() <= MAX_SAMPLES
                    && grown.optimistic.len() == grown.pessimistic.len()
            );
            assert_eq!(grown.optimistic.len(), states.div_ceil(grown.stride));
            if let Some(last) = grown.optimistic.len().checked_sub(1) {
                let expected = sample(last * grown.stride).unwrap();
                assert_eq!(grown.optimistic[last], expected.optimistic);
            }
        }
        assert_eq!(grown.stride, 256);
    }
}
