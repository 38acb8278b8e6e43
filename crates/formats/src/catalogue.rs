//! Collections of built-in mazes or of maze files in a folder.

use std::collections::HashMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::slice;

use mmsim_maze::Maze;
use walkdir::{DirEntry, WalkDir};

use crate::encoding::Encoding;
use crate::error::{Note, NoteKind, ParseErrorKind};
use crate::parsed_maze::ParsedMaze;
use crate::read::{Choice, ReadError, read_content};

/// A collection of mazes: built-in mazes, or files that may be unreadable.
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
    /// The folder of the entries, which is not part of what [`matching`](Self::matching) searches.
    folder: PathBuf,
}

/// An entry of a [`Catalogue`].
#[derive(Clone, Debug)]
pub struct Entry {
    path: PathBuf,
    parsed: Result<ParsedMaze, ReadError>,
}

impl Catalogue {
    /// Returns the bundled mazes, which are those of `mmsim-mazes`.
    ///
    /// ```
    /// let mazes = mmsim_formats::Catalogue::bundled();
    /// assert_eq!(mazes.entries()[0].name(), "01-harbour");
    /// ```
    pub fn bundled() -> Self {
        Self::from_texts(mmsim_mazes::FILES)
    }

    /// Creates a collection from the names and contents of built-in mazes.
    pub fn from_texts(texts: &[(&str, &str)]) -> Self {
        let contents = texts.iter().map(|(name, text)| (name.into(), Ok(text.as_bytes().to_vec())));
        let entries = read_together(contents, Choice::default());
        Self { entries, folder: PathBuf::new() }
    }

    /// Creates a collection from the files of a folder or an archive and their contents, sorted by
    /// path. Leaves out files that look like no maze. Numbers whose encoding is not clear from one
    /// file have the encoding that all such files in the same folder fit.
    pub fn from_contents(
        contents: impl Iterator<Item = (PathBuf, Result<Vec<u8>, ReadError>)>,
        choice: Choice,
    ) -> Self {
        let mut entries = read_together(contents, choice);
        entries.retain(|entry| !entry.is_other());
        entries.sort_by(|one, other| one.path.cmp(&other.path));
        Self { entries, folder: PathBuf::new() }
    }

    /// Creates a collection from the file `path` or, if `path` is a folder, from all mazes in it and
    /// its subfolders; see [`from_contents`](Self::from_contents). Hidden files are skipped, and
    /// symbolic links are followed. A subfolder that cannot be listed becomes an unreadable entry.
    ///
    /// # Errors
    /// Returns an error if `path` does not exist or cannot be listed.
    pub fn from_path(path: &Path) -> Result<Self, ReadError> {
        Self::from_encoded(path, Choice::default())
    }

    /// Creates a collection like [`from_path`](Self::from_path), with a choice of the encoding of
    /// numbers.
    ///
    /// # Errors
    /// See [`from_path`](Self::from_path).
    pub fn from_encoded(path: &Path, choice: Choice) -> Result<Self, ReadError> {
        let error = |source| ReadError::io(path, source);
        let read = |path: PathBuf| (path.clone(), read_content(&path));
        if !fs::metadata(path).map_err(error)?.is_dir() {
            let entries = read_together([read(path.into())].into_iter(), choice);
            return Ok(Self { entries, folder: path.parent().unwrap_or(path).into() });
        }
        fs::read_dir(path).map_err(error)?;
        let contents = list_folder(path).into_iter().map(read);
        Ok(Self { folder: path.into(), ..Self::from_contents(contents, choice) })
    }

    /// Returns all entries, including unreadable ones.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Returns the entries whose path, from the folder of the collection on, contains every word of
    /// `words`. The words are separated by blanks, and case is ignored.
    pub fn matching(&self, words: &str) -> impl Iterator<Item = &Entry> {
        let words: Vec<String> = words.split_whitespace().map(str::to_lowercase).collect();
        self.entries.iter().filter(move |entry| {
            let path = entry.path.strip_prefix(&self.folder).unwrap_or(&entry.path);
            let path = path.to_string_lossy().to_lowercase();
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

    /// Returns the maze and the notes about its file.
    ///
    /// # Errors
    /// Returns the errors of the file.
    pub fn parsed(&self) -> Result<&ParsedMaze, &ReadError> {
        self.parsed.as_ref()
    }

    /// Returns the maze.
    ///
    /// # Errors
    /// See [`read_maze`](crate::read_maze).
    pub fn maze(&self) -> Result<Maze, ReadError> {
        self.parsed().map(|parsed| parsed.maze.clone()).map_err(ReadError::clone)
    }

    /// Returns true for a file that looks like no maze.
    fn is_other(&self) -> bool {
        match &self.parsed {
            Err(ReadError::Parse { errors, .. }) => errors[0].kind == ParseErrorKind::NotAMaze,
            Err(ReadError::Io { source, .. }) => source.kind() == ErrorKind::FileTooLarge,
            // A few cells that were found in prose or code.
            Ok(parsed) => {
                let is_ignored = |note: &&Note| note.kind == NoteKind::Ignored;
                let ignored = parsed.notes.iter().filter(is_ignored).count();
                ignored > 2 * parsed.maze.size().area() + 8
            }
        }
    }

    /// Returns the mazes that the file could mean.
    fn readings(&self) -> &[ParsedMaze] {
        self.parsed.as_ref().map_or_else(ReadError::readings, slice::from_ref)
    }
}

/// Reads files. If the numbers of a file fit several mazes, the other files of its folder decide.
fn read_together(
    contents: impl Iterator<Item = (PathBuf, Result<Vec<u8>, ReadError>)>,
    choice: Choice,
) -> Vec<Entry> {
    let read = |(path, content): (PathBuf, Result<Vec<u8>, ReadError>)| {
        let error = |errors| ReadError::Parse { path: path.clone(), errors };
        let parsed = content.and_then(|content| choice.read(&content).map_err(error));
        Entry { path, parsed }
    };
    let mut entries: Vec<Entry> = contents.map(read).collect();
    let folder = |entry: &Entry| entry.path.parent().map(Path::to_path_buf);
    let mut shared: HashMap<Option<PathBuf>, Vec<Encoding>> = HashMap::new();
    for entry in &entries {
        let here: Vec<Encoding> =
            entry.readings().iter().flat_map(|reading| reading.encodings.clone()).collect();
        if !here.is_empty() {
            let shared = shared.entry(folder(entry)).or_insert_with(|| here.clone());
            shared.retain(|encoding| here.contains(encoding));
        }
    }
    for entry in entries.iter_mut().filter(|entry| entry.parsed.is_err()) {
        let shared = shared.get(&folder(entry)).map_or(&[][..], Vec::as_slice);
        let is_shared = |it: &&ParsedMaze| it.encodings.iter().any(|it| shared.contains(it));
        if let [decided] = entry.readings().iter().filter(is_shared).collect::<Vec<_>>()[..] {
            entry.parsed = Ok(decided.clone());
        }
    }
    entries
}

/// Lists the files in a folder and its subfolders, except hidden files. The result also contains
/// subfolders that cannot be listed; an attempt to read one as a maze file returns an
/// error.
fn list_folder(folder: &Path) -> Vec<PathBuf> {
    let is_hidden = |entry: &DirEntry| {
        entry.depth() > 0 && entry.file_name().as_encoded_bytes().starts_with(b".")
    };
    WalkDir::new(folder)
        .follow_links(true)
        .into_iter()
        .filter_entry(|entry| !is_hidden(entry))
        .filter_map(|entry| match entry {
            Ok(entry) => entry.file_type().is_file().then(|| entry.into_path()),
            // A link to a parent folder, whose files are listed already.
            Err(error) if error.loop_ancestor().is_some() => None,
            Err(error) => error.path().map(Path::to_path_buf),
        })
        .collect()
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
        write("deep/broken", "o---o\n| S \no---o\n");
        write("deep/README", "about these mazes");
        write("facts.json", "{\"a.maze\": 1}");
        write("tool.py", "import sys\nprint(\"hello\")\nprint(input(), file=sys.stderr)\n");
        write("a.png", "\u{89}PNG\r\n\u{1a}\n\0\0\0\rIHDR");
        write("large", &"o---o\n|   |\n".repeat(1 << 18));
        for hidden in [".hidden/c.txt", ".d.txt"] {
            write(hidden, MAZE);
        }
        let catalogue = Catalogue::from_path(folder.path()).unwrap();
        assert_eq!(names(catalogue.entries()), ["b", "broken", "a"]);
        assert_eq!(names(catalogue.matching("WINDING DEEP")), ["a"]);
        assert_eq!(names(catalogue.matching("a.maze")), ["a"]);
        let own_name = folder.path().file_name().unwrap().to_string_lossy();
        for words in ["no such maze", &own_name] {
            assert_eq!(names(catalogue.matching(words)), [""; 0], "{words}");
        }
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
