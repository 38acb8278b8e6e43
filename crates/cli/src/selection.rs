//! Selecting mazes by their paths or by words.

use std::collections::BTreeSet;
use std::env;
use std::path::{Path, PathBuf};

use mmsim_compare::NamedMaze;
use mmsim_formats::{Catalogue, Choice, Entry, ReadError};
use mmsim_maze::{Maze, counted};
use mmsim_solvers::MazeFacts;
use tracing::info;

use crate::output::{own_command, warn, warn_error};

/// The name of the maze folder in the user's home folder.
const HOME_FOLDER: &str = ".mmsim";

/// Returns the default folder of mazes, or `None` if the user has no home folder.
pub(crate) fn home_folder() -> Option<PathBuf> {
    Some(env::home_dir()?.join(HOME_FOLDER))
}

/// A collection of mazes.
pub(crate) struct Collection {
    pub(crate) catalogue: Catalogue,
    /// The path of the collection, or an empty path for the bundled mazes.
    path: PathBuf,
    /// True for the collection in the user's home folder. If this collection has no matching maze,
    /// the bundled mazes are searched.
    is_default: bool,
}

/// Returns a maze that was read from an entry, with its path and name.
fn named(entry: &Entry, maze: Maze) -> NamedMaze {
    NamedMaze { path: entry.path().into(), name: entry.name(), maze }
}

/// The reason why no maze was selected.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SelectionError {
    #[error(
        "no maze matches {words:?} in {location} (list the {} with {list})",
        counted(*count, "file")
    )]
    NoMatch { words: String, count: usize, location: String, list: String },
    #[error("no mazes in {location}")]
    Empty { location: String },
    #[error("{0}")]
    Unreadable(#[from] ReadError),
}

impl Collection {
    /// Returns the mazes at `path`. Without a path, returns the mazes in the user's folder, or the
    /// bundled mazes if that folder has none.
    pub(crate) fn at(path: Option<&Path>) -> Result<Self, SelectionError> {
        Self::encoded(path, Choice::default())
    }

    /// Returns the same mazes as [`at`](Self::at), with a choice of the encoding of numbers.
    fn encoded(path: Option<&Path>, choice: Choice) -> Result<Self, SelectionError> {
        let Some(path) = path else {
            return Ok(Self::from_home(choice).unwrap_or_else(Self::bundled));
        };
        let catalogue = Catalogue::from_encoded(path, choice)?;
        Ok(Self { catalogue, path: path.into(), is_default: false })
    }

    /// Returns the maze with this name in the collection at `path`. Without a path, returns the maze
    /// in the file `name` if it exists, else a maze of the default collection.
    pub(crate) fn find(
        name: &str,
        path: Option<&Path>,
        choice: Choice,
    ) -> Result<NamedMaze, SelectionError> {
        let file = Some(Path::new(name)).filter(|file| file.exists() && !file.is_dir());
        Self::encoded(path.or(file), choice)?.select(name)
    }

    fn from_home(choice: Choice) -> Option<Self> {
        let path = home_folder()?;
        let catalogue = Catalogue::from_encoded(&path, choice).ok()?;
        if catalogue.entries().iter().any(|entry| entry.maze().is_ok()) {
            return Some(Self { catalogue, path, is_default: true });
        }
        warn(format_args!("no mazes in {}; using the bundled mazes", path.display()));
        None
    }

    fn bundled() -> Self {
        Self { catalogue: Catalogue::bundled(), path: PathBuf::new(), is_default: false }
    }

    /// Returns true for the bundled mazes.
    pub(crate) fn is_bundled(&self) -> bool {
        self.path.as_os_str().is_empty()
    }

    /// Returns the name of the collection for use in messages.
    fn location(&self) -> String {
        match self.path.to_str() {
            Some("") => "the bundled mazes".into(),
            _ => self.path.display().to_string(),
        }
    }

    /// Returns the first maze whose path contains all `words`. If `words` is empty, returns the
    /// first maze with a reachable goal, or the first maze if no goal is reachable. If the user's
    /// folder has no such maze, searches the bundled mazes. Skips unreadable files and prints a
    /// warning with the number of skipped files.
    pub(crate) fn select(&self, words: &str) -> Result<NamedMaze, SelectionError> {
        let any = words.trim().is_empty();
        let (mut unreadable, mut fallback) = (Vec::new(), None);
        let (location, count) = (self.location(), self.catalogue.entries().len());
        info!("{count} files in {location}");
        let found = self.catalogue.matching(words).find_map(|entry| {
            let maze = entry.maze().map_err(|error| unreadable.push(error)).ok()?;
            let is_wanted = !any || MazeFacts::new(&maze).shortest_path.is_some();
            let selected = named(entry, maze);
            if is_wanted {
                return Some(selected);
            }
            fallback.get_or_insert(selected);
            None
        });
        let Some(selected) = found.or(fallback) else {
            if self.is_default
                && unreadable.is_empty()
                && let Ok(bundled) = Self::bundled().select(words)
            {
                return Ok(bundled);
            }
            return Err(match unreadable.into_iter().next() {
                Some(error) => error.into(),
                None if count == 0 => SelectionError::Empty { location },
                None => {
                    let list = own_command(&format!("mazes list {}", self.path.display()));
                    SelectionError::NoMatch { words: words.into(), count, location, list }
                }
            });
        };
        if let Some(error) = unreadable.first() {
            let count = counted(unreadable.len(), "unreadable file");
            warn(format_args!("skipped {count} in {location}; first error: {error}"));
        }
        Ok(selected)
    }
}

/// The readable mazes, in the order in which the command line names them.
pub(crate) struct Inputs {
    pub(crate) mazes: Vec<NamedMaze>,
    /// True if no maze was skipped.
    pub(crate) all_readable: bool,
}

impl Inputs {
    /// Reads the mazes that `names` select. Each name is a file, a folder, or words from the path
    /// of a maze. Unreadable mazes are reported on stderr and skipped.
    pub(crate) fn read(names: &[PathBuf]) -> Self {
        let mut inputs = Self { mazes: Vec::new(), all_readable: true };
        for name in names {
            let read = if name.exists() { inputs.read_path(name) } else { inputs.find(name) };
            if let Err(error) = read {
                inputs.skip(&error);
            }
        }
        inputs
    }

    /// Reads the named mazes, each once, or all mazes of the default collection if there are no
    /// names.
    pub(crate) fn read_distinct_or_default(names: &[PathBuf]) -> Self {
        let mut inputs = Self::read(names);
        if names.is_empty() {
            match Collection::at(None) {
                Ok(collection) => inputs.read_all(&collection.catalogue),
                Err(error) => inputs.skip(&error),
            }
        }
        let mut paths = BTreeSet::new();
        inputs.mazes.retain(|selected| paths.insert(selected.path.clone()));
        inputs
    }

    fn read_path(&mut self, path: &Path) -> Result<(), SelectionError> {
        let catalogue = Catalogue::from_path(path)?;
        if catalogue.entries().is_empty() {
            return Err(SelectionError::Empty { location: path.display().to_string() });
        }
        self.read_all(&catalogue);
        Ok(())
    }

    fn read_all(&mut self, catalogue: &Catalogue) {
        for entry in catalogue.entries() {
            match entry.maze() {
                Ok(maze) => self.mazes.push(named(entry, maze)),
                Err(error) => self.skip(&error.into()),
            }
        }
    }

    fn find(&mut self, words: &Path) -> Result<(), SelectionError> {
        self.mazes.push(Collection::at(None)?.select(&words.to_string_lossy())?);
        Ok(())
    }

    fn skip(&mut self, error: &SelectionError) {
        self.all_readable = false;
        warn_error(error);
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn selects_by_words_or_the_first_reachable_goal() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        let closed = "o---o---o\n| S | G |\no---o---o\n";
        write("a-closed.txt", closed);
        write("b-damaged.txt", "o---o\n| S \no---o\n");
        let collection = || Collection::at(Some(folder.path())).unwrap();
        assert_eq!(collection().select("").unwrap().name, "a-closed", "fallback");
        write("c-open.txt", "o---o---o\n| S   G |\no---o---o\n");
        assert_eq!(collection().select("").unwrap().name, "c-open");
        assert_eq!(collection().select("A CLOSED").unwrap().name, "a-closed");
        let error = collection().select("damaged").unwrap_err().to_string();
        assert!(error.contains("b-damaged.txt: line 2, column 5: expected "), "{error}");
        let error = collection().select("no such").unwrap_err().to_string();
        assert!(error.starts_with(r#"no maze matches "no such" in "#), "{error}");
    }

    #[test]
    fn empty_folder_has_no_maze() {
        let folder = tempfile::tempdir().unwrap();
        let error =
            Collection::at(Some(folder.path())).unwrap().select("").unwrap_err().to_string();
        assert!(error.starts_with("no mazes in "), "{error}");
        assert!(Collection::at(Some(&folder.path().join("none"))).is_err());
    }
}
