//! Which maze is meant.

use std::env;
use std::path::{Path, PathBuf};

use mmsim_formats::{Catalogue, CatalogueError, ReadError};
use mmsim_maze::{Escaped, Maze};
use mmsim_solvers::MazeFacts;
use tracing::info;

use crate::embedded;
use crate::output::{complain, own_command};

/// The folder below the user's own in which mazes are looked for.
const HOME_FOLDER: &str = ".mmsim";

/// Where mazes are looked for if nobody says where, `None` without a folder of the user's own.
pub(crate) fn home_folder() -> Option<PathBuf> {
    Some(env::home_dir()?.join(HOME_FOLDER))
}

/// A collection of mazes and what it is called in messages.
pub(crate) struct Collection {
    pub(crate) catalogue: Catalogue,
    place: String,
    /// Where it is, empty for the bundled mazes.
    path: PathBuf,
    /// Whether nobody named it: a maze that it lacks may be a bundled one then.
    is_default: bool,
}

/// A maze and its name.
#[derive(Clone, Debug)]
pub(crate) struct Selected {
    pub(crate) path: PathBuf,
    pub(crate) name: String,
    pub(crate) maze: Maze,
}

impl Selected {
    /// The path as people are shown it.
    pub(crate) fn shown_path(&self) -> String {
        Escaped(self.path.display()).to_string()
    }
}

/// Why there is no maze.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SelectionError {
    #[error(transparent)]
    Catalogue(#[from] CatalogueError),
    #[error(
        "expected a maze whose path holds {words:?}, found none of {count} in {place}; {list} shows them"
    )]
    NoMatch { words: String, count: usize, place: String, list: String },
    #[error("expected a maze in {place}, found none")]
    Empty { place: String },
    #[error("{0}")]
    Unreadable(#[from] ReadError),
}

impl Collection {
    /// The mazes at this path. Without one those in the user's own folder, and where that holds
    /// none the bundled ones.
    pub(crate) fn at(path: Option<&Path>) -> Result<Self, SelectionError> {
        let Some(path) = path else { return Ok(Self::of_the_user().unwrap_or_else(Self::bundled)) };
        let place = path.display().to_string();
        let catalogue = Catalogue::from_path(path)?;
        Ok(Self { catalogue, place, path: path.into(), is_default: false })
    }

    /// The mazes in which one is looked for by this name: the file itself, if it is one and no other
    /// place is given.
    pub(crate) fn with(name: &str, path: Option<&Path>) -> Result<Self, SelectionError> {
        let file = Path::new(name);
        Self::at(path.or_else(|| Some(file).filter(|file| file.is_file())))
    }

    fn of_the_user() -> Option<Self> {
        let path = home_folder()?;
        let catalogue = Catalogue::from_path(&path).ok()?;
        let place = path.display().to_string();
        if catalogue.entries().iter().any(|entry| entry.maze().is_ok()) {
            return Some(Self { catalogue, place, path, is_default: true });
        }
        complain(format_args!("expected mazes in {place}, found none; here are the bundled ones"));
        None
    }

    fn bundled() -> Self {
        Self {
            catalogue: embedded::catalogue(),
            place: "the bundled mazes".into(),
            path: PathBuf::new(),
            is_default: false,
        }
    }

    /// The first maze whose path holds these words, of the bundled ones if nobody said where to look
    /// and there is none; without a word, the first whose goal can be reached. Files that are no mazes are passed over and counted in a message.
    pub(crate) fn select(&self, words: &str) -> Result<Selected, SelectionError> {
        let any = words.trim().is_empty();
        let (mut unreadable, mut found, mut better_than_none) = (Vec::new(), None, None);
        info!("{} files in {}", self.catalogue.entries().len(), self.place);
        for entry in self.catalogue.matching(words) {
            let maze = match entry.maze() {
                Ok(maze) => maze,
                Err(error) => {
                    unreadable.push(error);
                    continue;
                }
            };
            let wanted = !any || MazeFacts::new(&maze).shortest_path.is_some();
            let selected = Selected { path: entry.path().into(), name: entry.name(), maze };
            if wanted {
                found = Some(selected);
                break;
            }
            better_than_none.get_or_insert(selected);
        }
        let Some(selected) = found.or(better_than_none) else {
            if self.is_default
                && unreadable.is_empty()
                && let Ok(bundled) = Self::bundled().select(words)
            {
                return Ok(bundled);
            }
            let (place, count) = (self.place.clone(), self.catalogue.entries().len());
            return Err(match unreadable.into_iter().next() {
                Some(error) => error.into(),
                None if count == 0 => SelectionError::Empty { place },
                None => {
                    let list = own_command(&format!("mazes list {}", self.path.display()));
                    SelectionError::NoMatch { words: words.into(), count, place, list }
                }
            });
        };
        if let Some(error) = unreadable.first() {
            let (count, place) = (unreadable.len(), &self.place);
            complain(format_args!(
                "passed over {count} of {place} that cannot be read, such as {error}"
            ));
        }
        Ok(selected)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn words_or_the_first_goal_within_reach_select() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        let closed = "o---o---o\n| S | G |\no---o---o\n";
        write("a-closed.txt", closed);
        write("b-rubbish.txt", "rubbish");
        let collection = || Collection::at(Some(folder.path())).unwrap();
        assert_eq!(collection().select("").unwrap().name, "a-closed", "better than none");
        write("c-open.txt", "o---o---o\n| S   G |\no---o---o\n");
        assert_eq!(collection().select("").unwrap().name, "c-open");
        assert_eq!(collection().select("A CLOSED").unwrap().name, "a-closed");
        let error = collection().select("rubbish").unwrap_err().to_string();
        assert!(error.contains("b-rubbish.txt: line 1, column 1: expected "), "{error}");
        let error = collection().select("no such").unwrap_err().to_string();
        assert!(
            error.starts_with(r#"expected a maze whose path holds "no such", found none of 3"#)
        );
    }

    #[test]
    fn an_empty_folder_has_no_maze() {
        let folder = tempfile::tempdir().unwrap();
        let error =
            Collection::at(Some(folder.path())).unwrap().select("").unwrap_err().to_string();
        assert!(error.starts_with("expected a maze in "), "{error}");
        assert!(Collection::at(Some(&folder.path().join("none"))).is_err());
    }
}
