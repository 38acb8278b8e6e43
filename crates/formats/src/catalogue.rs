//! Collections of built-in mazes or of maze files in a folder.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use walkdir::{DirEntry, WalkDir};

use mmsim_maze::Maze;

use crate::read::{ReadError, parse_maze, read_content};

/// A collection of mazes.
///
/// Creating a catalogue does not read the maze files. Call [`Entry::maze`] to read a maze.
///
/// ```
/// use mmsim_formats::Catalogue;
/// let catalogue = Catalogue::from_texts(&[("small.txt", "o---o\n|   |\no---o\n")]);
/// let entry = catalogue.matching("SMALL").next().unwrap();
/// assert_eq!(entry.maze()?.size().area(), 1);
/// # Ok::<(), mmsim_formats::ReadError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Catalogue {
    entries: Vec<Entry>,
}

/// An entry of a [`Catalogue`]: a built-in maze, or a file that may be unreadable.
#[derive(Clone, Debug)]
pub struct Entry {
    path: PathBuf,
    /// The content of a built-in maze, or `None` for a file.
    text: Option<&'static str>,
}

impl Catalogue {
    /// Lists the bundled mazes, which are those of `mmsim-mazes`.
    ///
    /// ```
    /// let mazes = mmsim_formats::Catalogue::bundled();
    /// assert_eq!(mazes.entries()[0].name(), "01-harbour");
    /// ```
    pub fn bundled() -> Self {
        Self::from_texts(mmsim_mazes::FILES)
    }

    /// Creates a collection from the names and contents of built-in mazes.
    pub fn from_texts(texts: &[(&'static str, &'static str)]) -> Self {
        let paths = texts.iter().map(|&(name, text)| (name.into(), Some(text)));
        Self { entries: paths.map(|(path, text)| Entry { path, text }).collect() }
    }

    /// Creates a collection from the file `path` or, if `path` is a folder, from all files in it
    /// and its subfolders. The entries are sorted by path. In folders, hidden files and files with
    /// the extension `.md` or `.json` are skipped, and symbolic links are followed. A subfolder
    /// that cannot be listed becomes an unreadable entry.
    ///
    /// # Errors
    /// Returns an error if `path` does not exist or cannot be listed.
    pub fn from_path(path: &Path) -> Result<Self, ReadError> {
        let error = |source| ReadError::Io { path: path.into(), source };
        let paths = if fs::metadata(path).map_err(error)?.is_dir() {
            fs::read_dir(path).map_err(error)?;
            list_folder(path)
        } else {
            vec![path.to_path_buf()]
        };
        let entries = paths.into_iter().map(|path| Entry { path, text: None }).collect();
        Ok(Self { entries })
    }

    /// Returns true if `path` has an extension that [`Self::from_path`] skips in folders.
    pub fn skips(path: &Path) -> bool {
        let extension = path.extension().unwrap_or_default();
        ["md", "json"].iter().any(|skipped| extension.eq_ignore_ascii_case(skipped))
    }

    /// Returns all entries, including unreadable ones.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns the entries whose path contains every word of `words`. The words are separated by
    /// blanks, and case is ignored.
    pub fn matching(&self, words: &str) -> impl Iterator<Item = &Entry> {
        let words: Vec<String> = words.split_whitespace().map(str::to_lowercase).collect();
        self.entries.iter().filter(move |entry| {
            let path = entry.path.to_string_lossy().to_lowercase();
            words.iter().all(|word| path.contains(word.as_str()))
        })
    }
}

impl Entry {
    /// Returns the path of a maze file, or the name of a built-in maze.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the name of the maze: the file name without the extension.
    pub fn name(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().to_string()
    }

    /// Reads the maze.
    ///
    /// # Errors
    /// See [`read_maze`](crate::read_maze).
    pub fn maze(&self) -> Result<Maze, ReadError> {
        parse_maze(&self.content()?)
            .map_err(|source| ReadError::Parse { path: self.path.clone(), source })
    }

    /// Returns the content of a built-in maze, or reads the maze file.
    ///
    /// # Errors
    /// See [`read_content`].
    pub fn content(&self) -> Result<Cow<'static, [u8]>, ReadError> {
        match self.text {
            Some(text) => Ok(Cow::Borrowed(text.as_bytes())),
            None => read_content(&self.path).map(Cow::Owned),
        }
    }
}

/// Lists the files in a folder and its subfolders, except hidden and skipped files. The result also
/// contains subfolders that cannot be listed; an attempt to read one as a maze file returns an
/// error.
fn list_folder(folder: &Path) -> Vec<PathBuf> {
    let is_hidden = |entry: &DirEntry| {
        entry.depth() > 0 && entry.file_name().as_encoded_bytes().starts_with(b".")
    };
    let mut paths: Vec<PathBuf> = WalkDir::new(folder)
        .follow_links(true)
        .into_iter()
        .filter_entry(|entry| !is_hidden(entry))
        .filter_map(|entry| match entry {
            Ok(entry) => entry.file_type().is_file().then(|| entry.into_path()),
            // A link to a parent folder, whose files are listed already.
            Err(error) if error.loop_ancestor().is_some() => None,
            Err(error) => error.path().map(Path::to_path_buf),
        })
        .filter(|path| !Catalogue::skips(path))
        .collect();
    paths.sort();
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAZE: &str = "o---o\n| S |\no---o\n";

    fn names(entries: impl IntoIterator<Item = impl std::borrow::Borrow<Entry>>) -> Vec<String> {
        entries.into_iter().map(|entry| entry.borrow().name()).collect()
    }

    #[test]
    fn subfolders_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        write("b.txt", MAZE);
        write("deep/winding/a.maze", MAZE);
        write("deep/Rubbish", "rubbish");
        for skipped in ["README.md", "facts.json", ".hidden/c.txt", ".d.txt"] {
            write(skipped, MAZE);
        }
        let catalogue = Catalogue::from_path(folder.path()).unwrap();
        assert_eq!(names(catalogue.entries()), ["b", "Rubbish", "a"]);
        assert_eq!(names(catalogue.matching("WINDING DEEP")), ["a"]);
        assert_eq!(names(catalogue.matching("a.maze")), ["a"]);
        assert_eq!(names(catalogue.matching("no such maze")), [""; 0]);
        let readable = catalogue.entries().iter().map(|entry| entry.maze().is_ok());
        assert!(readable.eq([true, false, true]));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_without_loops() {
        use std::os::unix::fs::symlink;
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        fs::write(elsewhere.path().join("a.txt"), MAZE).unwrap();
        symlink(elsewhere.path(), folder.path().join("link")).unwrap();
        symlink(folder.path(), folder.path().join("circle")).unwrap();
        symlink(folder.path().join("nowhere"), folder.path().join("broken.txt")).unwrap();
        let catalogue = Catalogue::from_path(folder.path()).unwrap();
        assert_eq!(names(catalogue.entries()), ["broken", "a"]);
        assert!(catalogue.entries()[0].maze().is_err());
    }

    #[test]
    fn a_file_is_a_collection_of_one_maze() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("one.md");
        fs::write(&path, MAZE).unwrap();
        assert_eq!(names(Catalogue::from_path(&path).unwrap().entries()), ["one"]);
        let error = Catalogue::from_path(&folder.path().join("none")).unwrap_err().to_string();
        assert!(error.starts_with("cannot read ") && error.contains("none: "), "{error}");
    }
}
