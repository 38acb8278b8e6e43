//! The mazes that the page lists.

use mmsim_formats::{Catalogue, Entry};
use mmsim_maze::{Maze, MazeSize};
use mmsim_solvers::MazeFacts;
use serde::Serialize;

use crate::api_error::ApiError;
use crate::state::AppState;

/// A maze as the page lists it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Listed {
    path: String,
    name: String,
    width: Option<u8>,
    height: Option<u8>,
    /// In steps; null if the goal cannot be reached.
    shortest_path: Option<u16>,
    /// Why it cannot be read.
    error: Option<String>,
}

/// All mazes of a collection. They are read once, so that the list is quick after that.
pub(crate) fn list(state: &AppState) -> &[Listed] {
    state.listed.get_or_init(|| state.catalogue.entries().iter().map(Listed::of).collect())
}

impl Listed {
    fn of(entry: &Entry) -> Self {
        let (path, name, maze) = (path(entry), entry.name(), entry.maze());
        let (maze, error) = match maze {
            Ok(maze) => (Some(maze), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let size = maze.as_ref().map(Maze::size);
        Self {
            path,
            name,
            width: size.map(MazeSize::width),
            height: size.map(MazeSize::height),
            shortest_path: maze.as_ref().and_then(|maze| MazeFacts::new(maze).shortest_path),
            error,
        }
    }
}

/// The maze of this path, name and all. Only paths of the collection are known.
pub(crate) fn find(catalogue: &Catalogue, wanted: &str) -> Result<(String, Maze), ApiError> {
    let entry = catalogue.entries().iter().find(|entry| path(entry) == wanted);
    let entry = entry.ok_or_else(|| {
        ApiError::not_found(format!("expected the path of a maze of the list, found {wanted:?}"))
    })?;
    Ok((entry.name(), entry.maze().map_err(ApiError::failed)?))
}

fn path(entry: &Entry) -> String {
    entry.path().display().to_string()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use axum::http::StatusCode;

    use super::*;
    use crate::limits::Limits;

    #[test]
    fn mazes_are_listed_with_their_facts_or_faults() {
        let catalogue = Catalogue::from_texts(&[
            ("a/open.txt", "o---o---o\n| S   G |\no---o---o\n"),
            ("a/closed.txt", "o---o---o\n| S | G |\no---o---o\n"),
            ("rubbish.txt", "rubbish"),
        ]);
        let state = AppState::new(None, None, catalogue, Arc::default(), Limits::default());
        let [open, closed, rubbish] = list(&state) else { panic!() };
        assert_eq!((open.path.as_str(), open.name.as_str()), ("a/open.txt", "open"));
        assert_eq!((open.width, open.height, open.shortest_path), (Some(2), Some(1), Some(1)));
        assert_eq!((closed.shortest_path, &closed.error), (None, &None));
        assert!(rubbish.error.as_ref().unwrap().contains("rubbish.txt: line 1"));
        assert_eq!(find(&state.catalogue, "a/open.txt").unwrap().0, "open");
        for path in ["", "open", "../a/open.txt", "a/../a/open.txt", "/etc/passwd"] {
            let refusal = find(&state.catalogue, path).unwrap_err();
            assert_eq!(refusal.status, StatusCode::NOT_FOUND);
        }
        assert!(find(&state.catalogue, "rubbish.txt").is_err());
    }
}
