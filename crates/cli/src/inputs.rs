//! The mazes named on the command line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use mmsim_compare::NamedMaze;
use mmsim_formats::Catalogue;

use crate::output::warn;
use crate::selection::{Collection, SelectionError, named};

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
        warn(format_args!("mmsim: {error}"));
    }
}
