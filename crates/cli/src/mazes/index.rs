//! Mazes by their walls, to find those that are equal after a rotation or reflection.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use mmsim_maze::{Maze, Symmetry, Walls};

/// Mazes that are found by their walls.
#[derive(Default)]
pub(super) struct MazeIndex {
    mazes: Vec<(PathBuf, Maze)>,
    by_walls: HashMap<Walls, Vec<usize>>,
}

/// A maze in the index that has the walls of another one after a rotation or reflection of the other.
pub(super) struct EqualMaze<'a> {
    pub(super) path: &'a Path,
    pub(super) symmetry: Symmetry,
    pub(super) same_start: bool,
    pub(super) same_goals: bool,
}

impl MazeIndex {
    pub(super) fn add(&mut self, path: &Path, maze: &Maze) {
        self.by_walls.entry(maze.walls().clone()).or_default().push(self.mazes.len());
        self.mazes.push((path.into(), maze.clone()));
    }

    /// Returns the mazes that are equal to `maze`, in the order in which they were added. If several
    /// symmetries lead to one, prefers the first with the same start and goals.
    pub(super) fn find(&self, maze: &Maze) -> Vec<EqualMaze<'_>> {
        let mut best = BTreeMap::new();
        for symmetry in Symmetry::ALL {
            let image = maze.transformed(symmetry);
            for &index in self.by_walls.get(image.walls()).into_iter().flatten() {
                let (path, other) = &self.mazes[index];
                let same_start = image.start() == other.start();
                let same_goals = image.goals() == other.goals();
                let found = EqualMaze { path, symmetry, same_start, same_goals };
                let is_better =
                    |it: &EqualMaze<'_>| (same_start, same_goals) > (it.same_start, it.same_goals);
                if best.get(&index).is_none_or(is_better) {
                    best.insert(index, found);
                }
            }
        }
        best.into_values().collect()
    }
}

/// Returns the path of the file without links, if it is a file.
pub(super) fn real_path(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.into())
}
