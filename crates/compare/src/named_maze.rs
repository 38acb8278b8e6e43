//! A maze of a collection.

use std::path::PathBuf;

use mmsim_maze::{Escaped, Maze};

/// A maze with its path and name.
#[derive(Clone, Debug)]
pub struct NamedMaze {
    /// The path of the file, or an empty path.
    pub path: PathBuf,
    /// The name.
    pub name: String,
    /// The maze.
    pub maze: Maze,
}

impl NamedMaze {
    /// Returns the path, escaped for messages.
    pub fn shown_path(&self) -> String {
        Escaped(self.path.display()).to_string()
    }

    /// Returns the path, or the name of a maze without a path.
    pub(crate) fn path_or_name(&self) -> String {
        let has_path = !self.path.as_os_str().is_empty();
        if has_path { self.path.display().to_string() } else { self.name.clone() }
    }
}

/// Returns the names of the mazes, or the path of a maze if another maze has the same name.
pub(crate) fn unique_names(mazes: &[NamedMaze]) -> Vec<String> {
    let name = |maze: &NamedMaze| {
        let is_unique = mazes.iter().filter(|other| other.name == maze.name).count() == 1;
        if is_unique { maze.name.clone() } else { maze.path_or_name() }
    };
    mazes.iter().map(name).collect()
}
