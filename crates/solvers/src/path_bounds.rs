//! The length of the shortest path in a maze, and proven bounds on it in a partly known maze.

use mmsim_maze::{KnownMaze, Maze, Pose, Unknown, WallState};

use crate::flood::{Distances, only, steps_between};

/// Bounds on the length of the shortest path from the start to the goal.
///
/// ```
/// use mmsim_maze::{KnownMaze, Maze};
/// use mmsim_solvers::PathBounds;
/// let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse()?;
/// let mut map = KnownMaze::unexplored(&maze);
/// let bounds = PathBounds::new(&map);
/// assert_eq!((bounds.optimistic, bounds.pessimistic), (Some(2), None));
/// map.observe(maze.start(), maze.walls().around(maze.start()))?;
/// assert!(!PathBounds::new(&map).is_proven());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathBounds {
    /// The optimistic distance in steps, which treats unknown walls as open, or `None` if known
    /// walls block every path.
    pub optimistic: Option<u16>,
    /// The pessimistic distance in steps, which treats unknown walls as closed, or `None` if no
    /// path is known.
    pub pessimistic: Option<u16>,
}

impl PathBounds {
    /// Computes the bounds from the known walls.
    #[must_use]
    pub fn new(map: &KnownMaze) -> Self {
        let [optimistic, pessimistic] = [Unknown::Open, Unknown::Closed]
            .map(|unknown| steps_between(map.walls(unknown), map.start().cell, map.goals()));
        Self { optimistic, pessimistic }
    }

    /// Returns true if a path is known and no unknown wall can hide a shorter path.
    pub fn is_proven(&self) -> bool {
        self.pessimistic.is_some() && self.optimistic == self.pessimistic
    }
}

/// Returns the number of steps that the mouse has taken when its map first proves that a known path
/// is shortest, or `None` if the map never proves it. `poses` holds the poses at which the mouse
/// read the walls: the start pose, and then the pose after each step.
///
/// The search itself does not need this number, so callers can compute it afterwards.
#[must_use]
pub fn steps_until_proven(maze: &Maze, poses: &[Pose]) -> Option<u32> {
    let mut map = KnownMaze::unexplored(maze);
    // Readings of the actual walls never contradict each other.
    let observe = |map: &mut KnownMaze, pose| {
        let _ = map.observe(pose, maze.walls().around(pose));
    };
    if let Some(&start) = poses.first() {
        let behind = Pose::new(start.cell, start.heading.back());
        if map.wall(behind.cell, behind.heading) == WallState::Unknown {
            observe(&mut map, behind);
        }
    }
    (0..).zip(poses).find_map(|(steps, &pose)| {
        // A cell that was visited before reveals no new walls.
        let is_new = steps == 0 || !map.visited().contains(pose.cell);
        observe(&mut map, pose);
        (is_new && PathBounds::new(&map).is_proven()).then_some(steps)
    })
}

/// Facts about a maze that do not depend on a strategy.
///
/// ```
/// use mmsim_solvers::MazeFacts;
/// let maze = "o---o---o---o\n| S   G |   |\no---o---o---o\n".parse()?;
/// let facts = MazeFacts::new(&maze);
/// assert_eq!((facts.shortest_path, facts.reachable_cells), (Some(1), 2));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MazeFacts {
    /// The number of steps from the start to the nearest goal cell, or `None` if the goal is
    /// unreachable.
    pub shortest_path: Option<u16>,
    /// The number of cells that can be reached from the start, including the start.
    pub reachable_cells: usize,
}

impl MazeFacts {
    /// Computes the facts about a maze.
    #[must_use]
    pub fn new(maze: &Maze) -> Self {
        let start = maze.start().cell;
        Self {
            shortest_path: Distances::flood(maze.walls(), maze.goals()).at(start),
            reachable_cells: Distances::flood(maze.walls(), &only(start)).reachable_cells(),
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading};

    use super::*;

    const MAZE: &str = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n";

    fn pose(x: u8, y: u8, heading: Heading) -> Pose {
        Pose::new(Cell::new(x, y), heading)
    }

    /// For each pose, returns the optimistic and the pessimistic distance after the mouse has read
    /// the walls.
    fn bounds(maze: &str, poses: &[Pose]) -> Vec<(Option<u16>, Option<u16>)> {
        let maze: Maze = maze.parse().unwrap();
        let mut map = KnownMaze::unexplored(&maze);
        let mut after = |&pose| {
            map.observe(pose, maze.walls().around(pose)).unwrap();
            let PathBounds { optimistic, pessimistic } = PathBounds::new(&map);
            (optimistic, pessimistic)
        };
        poses.iter().map(&mut after).collect()
    }

    #[test]
    fn bounds_follow_from_the_known_walls() {
        let poses = [pose(0, 0, Heading::North), pose(1, 0, Heading::East)];
        assert_eq!(bounds(MAZE, &poses), [(Some(2), None), (Some(2), Some(2))]);
        let detour = "\
o---o---o---o
| S     | G |
o   o---o   o
|           |
o---o---o---o
";
        let poses = [
            pose(0, 1, Heading::South),
            pose(0, 0, Heading::South),
            pose(1, 0, Heading::East),
            pose(2, 0, Heading::East),
            pose(1, 1, Heading::East),
        ];
        let (two, four) = (Some(2), Some(4));
        let expected = [(two, None), (two, None), (two, None), (two, four), (four, four)];
        assert_eq!(bounds(detour, &poses), expected);
        let closed = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";
        let poses = [pose(0, 1, Heading::North), pose(1, 0, Heading::East)];
        assert_eq!(bounds(closed, &poses), [(Some(2), None), (None, None)]);
    }

    #[test]
    fn only_equal_bounds_of_a_known_path_are_a_proof() {
        for (optimistic, pessimistic, is_proven) in [
            (None, None, false),
            (Some(0), None, false),
            (Some(3), Some(4), false),
            (Some(5), Some(4), false),
            (Some(4), Some(4), true),
            (Some(0), Some(0), true),
        ] {
            assert_eq!(PathBounds { optimistic, pessimistic }.is_proven(), is_proven);
        }
    }

    fn until_proven(maze: &str, poses: &[Pose]) -> Option<u32> {
        steps_until_proven(&maze.parse().unwrap(), poses)
    }

    #[test]
    fn the_steps_of_the_proof_are_counted_from_the_start() {
        let start = pose(0, 0, Heading::North);
        let east = pose(1, 0, Heading::East);
        assert_eq!(until_proven(MAZE, &[start, east]), Some(1));
        let later = [start, pose(0, 1, Heading::North), pose(0, 0, Heading::South), east];
        assert_eq!(until_proven(MAZE, &later), Some(3));
        assert_eq!(until_proven(MAZE, &later[..3]), None);
        assert_eq!(until_proven(MAZE, &[]), None);
    }

    #[test]
    fn the_walls_behind_the_start_are_read_first() {
        let maze = "o---o\n|   |\no   o\n| S |\no   o\n| G |\no---o\n";
        assert_eq!(until_proven(maze, &[pose(0, 1, Heading::North)]), Some(0));
        let beside = "o---o---o\n|   | G |\no   o   o\n| S |   |\no---o---o\n";
        assert_eq!(until_proven(beside, &[pose(0, 0, Heading::North)]), None);
    }
}
