//! Changes of files that can be taken back.

use std::path::{Path, PathBuf};
use std::{fs, io};

use tempfile::TempDir;

/// What was done, in order.
#[derive(Debug, Default)]
pub(super) struct Undo {
    done: Vec<Done>,
    /// Where old files are kept.
    staging: PathBuf,
}

#[derive(Debug)]
enum Done {
    CreatedFolder(PathBuf),
    CreatedFile(PathBuf),
    /// The file is another one now or none; here is the old one.
    Changed {
        file: PathBuf,
        old: PathBuf,
    },
    /// Goes with what is in it once nothing of it is needed.
    Staging(TempDir),
}

impl Undo {
    /// Keeps the old files in this folder from now on.
    pub(super) fn keep(&mut self, staging: TempDir) {
        self.staging = staging.path().into();
        self.done.push(Done::Staging(staging));
    }

    /// Creates a folder and those around it, as far as they are not there.
    pub(super) fn create_folders(&mut self, folder: &Path) -> io::Result<()> {
        let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
        for folder in missing.into_iter().rev() {
            fs::create_dir(folder)?;
            self.done.push(Done::CreatedFolder(folder.into()));
        }
        Ok(())
    }

    /// This file was created.
    pub(super) fn created(&mut self, file: PathBuf) {
        self.done.push(Done::CreatedFile(file));
    }

    /// Moves a file to its place, where another one may be.
    pub(super) fn put(&mut self, staged: PathBuf, file: &Path) -> io::Result<()> {
        let old = self.next_old();
        let is_there = file.symlink_metadata().is_ok();
        if is_there {
            // A copy, so that there is a file at any time.
            fs::copy(file, &old)?;
        }
        fs::rename(staged, file)?;
        let file = file.into();
        self.done.push(if is_there {
            Done::Changed { file, old }
        } else {
            Done::CreatedFile(file)
        });
        Ok(())
    }

    /// Removes a file.
    pub(super) fn remove(&mut self, file: &Path) -> io::Result<()> {
        let old = self.next_old();
        fs::rename(file, &old)?;
        self.done.push(Done::Changed { file: file.into(), old });
        Ok(())
    }

    /// Takes all back, as far as the system lets it.
    pub(super) fn all(&mut self) {
        while let Some(done) = self.done.pop() {
            let _ = match done {
                Done::CreatedFolder(folder) => fs::remove_dir(folder),
                Done::CreatedFile(file) => fs::remove_file(file),
                Done::Changed { file, old } => fs::rename(old, file),
                Done::Staging(staging) => staging.close(),
            };
        }
    }

    fn next_old(&self) -> PathBuf {
        self.staging.join(format!("old-{}", self.done.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_is_as_before() {
        let home = tempfile::tempdir().unwrap();
        let path = |name: &str| home.path().join(name);
        for name in ["changed", "removed"] {
            fs::write(path(name), "old").unwrap();
        }
        let mut undo = Undo::default();
        undo.create_folders(&path("a/b")).unwrap();
        undo.keep(TempDir::new_in(home.path()).unwrap());
        for name in ["changed", "a/b/new"] {
            fs::write(path("staged"), "new").unwrap();
            undo.put(path("staged"), &path(name)).unwrap();
            assert_eq!(fs::read_to_string(path(name)).unwrap(), "new");
        }
        undo.remove(&path("removed")).unwrap();
        assert!(!path("removed").exists());
        undo.all();
        for name in ["changed", "removed"] {
            assert_eq!(fs::read_to_string(path(name)).unwrap(), "old");
        }
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 2);
    }
}
