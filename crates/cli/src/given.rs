//! The mazes that are named on the command line.

use std::path::{Path, PathBuf};

use mmsim_formats::Catalogue;

use crate::output::complain;
use crate::selection::{Collection, Selected, SelectionError};

/// The mazes that can be read, in order, and whether that is all of them.
pub(crate) struct Given {
    pub(crate) mazes: Vec<Selected>,
    pub(crate) are_all: bool,
}

impl Given {
    /// Reads the mazes of these files and folders, and those found by words. Says what is wrong with
    /// the others.
    pub(crate) fn read(names: &[PathBuf]) -> Self {
        let mut given = Self { mazes: Vec::new(), are_all: true };
        for name in names {
            let read = if name.exists() { given.read_path(name) } else { given.find(name) };
            if let Err(error) = read {
                given.miss(&error);
            }
        }
        given
    }

    /// The same, but without a name all mazes of the collection in which words are looked for.
    pub(crate) fn read_or_default(names: &[PathBuf]) -> Self {
        let mut given = Self::read(names);
        if names.is_empty() {
            match Collection::at(None) {
                Ok(collection) => given.read_all(&collection.catalogue),
                Err(error) => given.miss(&error),
            }
        }
        given
    }

    fn read_path(&mut self, path: &Path) -> Result<(), SelectionError> {
        let catalogue = Catalogue::from_path(path)?;
        if catalogue.entries().is_empty() {
            return Err(SelectionError::Empty { place: path.display().to_string() });
        }
        self.read_all(&catalogue);
        Ok(())
    }

    fn read_all(&mut self, catalogue: &Catalogue) {
        for entry in catalogue.entries() {
            match entry.maze() {
                Ok(maze) => {
                    let (path, name) = (entry.path().into(), entry.name());
                    self.mazes.push(Selected { path, name, maze });
                }
                Err(error) => self.miss(&error.into()),
            }
        }
    }

    fn find(&mut self, words: &Path) -> Result<(), SelectionError> {
        self.mazes.push(Collection::at(None)?.select(&words.to_string_lossy())?);
        Ok(())
    }

    fn miss(&mut self, error: &SelectionError) {
        self.are_all = false;
        complain(format_args!("mmsim: {error}"));
    }
}
