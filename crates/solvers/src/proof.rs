//! Proven bounds on the length of the shortest path.

use mmsim_maze::{KnownMaze, Maze, Pose, Unknown, WallState};

use crate::flood::steps_between;

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
    /// The optimistic distance in steps, with unknown walls open; `None` if known walls block every
    /// path.
    pub optimistic: Option<u16>,
    /// The pessimistic distance in steps, with unknown walls closed; `None` if no path is known.
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

/// Returns the number of steps after which a search of `maze` has proven the shortest path, or
/// `None` if it never does. `poses` holds the poses in which the mouse read the walls: the start
/// pose, and one pose for each step.
///
/// A search does not need this number, so it is computed after the search.
#[must_use]
pub fn steps_until_proven(maze: &Maze, poses: &[Pose]) -> Option<u32> {
    let mut map = KnownMaze::unexplored(maze);
    // True walls never contradict each other.
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
        // A cell that was visited before shows no new walls.
        let is_new = steps == 0 || !map.visited().contains(pose.cell);
        observe(&mut map, pose);
        (is_new && PathBounds::new(&map).is_proven()).then_some(steps)
    })
}
