//! A one-line summary of a maze file.

use std::fmt::Display;
use std::path::Path;

use mmsim_formats::Entry;
use mmsim_maze::{Escaped, Maze, counted};
use mmsim_solvers::MazeFacts;
use serde::Serialize;

use crate::grid::wrapped;
use crate::output::goal_away;

/// The properties of the maze in a file, or the error if the file cannot be read. The field names
/// are JSON keys.
#[derive(Default, Serialize)]
pub(super) struct MazeRow {
    path: String,
    width: Option<u8>,
    height: Option<u8>,
    goals: Option<Vec<[u8; 2]>>,
    shortest_path: Option<u16>,
    reachable_cells: Option<usize>,
    pub(super) error: Option<String>,
}

impl MazeRow {
    pub(super) fn from_entry(entry: &Entry) -> Self {
        match entry.maze() {
            Ok(maze) => Self::from_maze(entry.path(), &maze),
            Err(error) => Self::from_error(entry.path(), &error),
        }
    }

    pub(super) fn from_maze(path: &Path, maze: &Maze) -> Self {
        let facts = MazeFacts::new(maze);
        Self {
            path: path.display().to_string(),
            width: Some(maze.size().width()),
            height: Some(maze.size().height()),
            goals: Some(maze.goals().iter().map(|cell| [cell.x, cell.y]).collect()),
            shortest_path: facts.shortest_path,
            reachable_cells: Some(facts.reachable_cells),
            error: None,
        }
    }

    pub(super) fn from_error(path: &Path, error: &impl Display) -> Self {
        Self { path: path.display().to_string(), error: Some(error.to_string()), ..Self::default() }
    }

    /// Formats the path and the properties of the maze as escaped text that fits the terminal. If the
    /// file cannot be read, formats only the error, which already contains the path, as one line.
    pub(super) fn line(&self) -> String {
        let Self { path, width: Some(width), height: Some(height), goals: Some(goals), .. } = self
        else {
            return Escaped(self.error.as_deref().unwrap_or_default()).to_string();
        };
        let size = format!("{width}x{height}");
        let goal = goal_away(self.shortest_path);
        let cells = usize::from(*width) * usize::from(*height);
        let unreachable = match cells - self.reachable_cells.unwrap_or(cells) {
            0 => String::new(),
            unreachable => format!(", {} unreachable", counted(unreachable, "cell")),
        };
        let goals = counted(goals.len(), "goal cell");
        let line = format!("{}: {size}, {goals}, {goal}{unreachable}", Escaped(path));
        wrapped(&line, ", ", 2)
    }
}
