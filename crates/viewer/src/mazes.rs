//! The mazes that the page lists.

use std::sync::OnceLock;

use mmsim_formats::{Catalogue, Entry};
use mmsim_maze::{Maze, MazeSize};
use mmsim_solvers::MazeFacts;
use serde::Serialize;

use crate::http::api_error::ApiError;

/// A catalogue of mazes, with the size and shortest path length of each maze.
pub(crate) struct MazeList {
    catalogue: Catalogue,
    entries: OnceLock<Vec<MazeEntry>>,
}

/// An entry in the page's list of mazes.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MazeEntry {
    path: String,
    name: String,
    width: Option<u8>,
    height: Option<u8>,
    /// The length of the shortest path in steps, or `None` if the goal is unreachable.
    shortest_path: Option<u16>,
    /// The error if the maze cannot be read.
    error: Option<String>,
}

impl MazeList {
    pub(crate) const fn new(catalogue: Catalogue) -> Self {
        Self { catalogue, entries: OnceLock::new() }
    }

    /// Returns all mazes, reading the maze files on the first call.
    pub(crate) fn entries(&self) -> &[MazeEntry] {
        let read = || self.catalogue.entries().iter().map(MazeEntry::new).collect();
        self.entries.get_or_init(read)
    }

    /// Reads the maze with the path `wanted`, which must be in the catalogue. Returns the name and
    /// the maze.
    pub(crate) fn read(&self, wanted: &str) -> Result<(String, Maze), ApiError> {
        let entry = self.catalogue.entries().iter().find(|entry| path(entry) == wanted);
        let not_found = || ApiError::not_found(format!("no listed maze has the path {wanted:?}"));
        let entry = entry.ok_or_else(not_found)?;
        Ok((entry.name(), entry.maze().map_err(ApiError::internal)?))
    }
}

impl MazeEntry {
    fn new(entry: &Entry) -> Self {
        let maze = entry.maze();
        let size = maze.as_ref().ok().map(Maze::size);
        Self {
            path: path(entry),
            name: entry.name(),
            width: size.map(MazeSize::width),
            height: size.map(MazeSize::height),
            shortest_path: maze.as_ref().ok().and_then(|maze| MazeFacts::new(maze).shortest_path),
            error: maze.err().map(|error| error.to_string()),
        }
    }
}

fn path(entry: &Entry) -> String {
    entry.path().display().to_string()
}

#[cfg(test)]
mod tests {
    use axum::http::StatusCode;

    use super::*;

    #[test]
    fn readable_mazes_have_facts_and_others_have_errors() {
        let list = MazeList::new(Catalogue::from_texts(&[
            ("a/open.txt", "o---o---o\n| S   G |\no---o---o\n"),
            ("a/closed.txt", "o---o---o\n| S | G |\no---o---o\n"),
            ("invalid.txt", "invalid"),
        ]));
        let [open, closed, invalid] = list.entries() else { panic!() };
        assert_eq!((open.path.as_str(), open.name.as_str()), ("a/open.txt", "open"));
        assert_eq!((open.width, open.height, open.shortest_path), (Some(2), Some(1), Some(1)));
        assert_eq!((closed.shortest_path, &closed.error), (None, &None));
        assert!(invalid.error.as_ref().unwrap().contains("invalid.txt: line 1"));
        assert_eq!(list.read("a/open.txt").unwrap().0, "open");
        for path in ["", "open", "../a/open.txt", "a/../a/open.txt", "/etc/passwd"] {
            let error = list.read(path).unwrap_err();
            assert_eq!(error.status, StatusCode::NOT_FOUND);
        }
        assert!(list.read("invalid.txt").is_err());
    }
}
