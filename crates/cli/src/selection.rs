//! The argument MAZE, which every command reads in the same way.

use std::collections::BTreeSet;
use std::env;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf, is_separator};
use std::sync::Once;

use mmsim_compare::NamedMaze;
use mmsim_formats::{Catalogue, Choice, Entry, Format, ReadError};
use mmsim_maze::{Maze, counted};
use mmsim_solvers::MazeFacts;
use tracing::info;

use crate::args::{ReadingArgs, extension};
use crate::output::{own_command, warn, warn_error};
use crate::recordings::{known_walls, recording_budget};

/// The help for the MAZE of a command that takes one maze.
pub(crate) const MAZE_HELP: &str = "\
    Maze file, folder (its first maze with a reachable goal), words from the path of a maze, or a \
    folder and words";

/// The help for the MAZE of a command that takes several mazes.
pub(crate) const MAZES_HELP: &str = "\
    Maze files, folders to search recursively, words from the path of a maze, or a folder and words \
    in quotes";

/// The mazes that a command uses without MAZE, for its help.
pub(crate) const DEFAULT_MAZES: &str = "~/.mmsim if it has mazes, else the bundled mazes";

/// The name of the maze folder in the user's home folder.
const HOME_FOLDER: &str = ".mmsim";

/// The bundled maze to start with. Its path with the fewest turns is not its shortest path, so mice
/// have a choice.
const FIRST_MAZE: &str = "10-two-roads";

/// The first bytes of a recording.
const RECORDING_START: &[u8] = b"\x89MCAP0\r\n";

/// Returns the default folder of mazes, or `None` if the user has no home folder.
pub(crate) fn home_folder() -> Option<PathBuf> {
    Some(env::home_dir()?.join(HOME_FOLDER))
}

/// Joins the words of a MAZE.
pub(crate) fn join(words: &[impl AsRef<OsStr>]) -> OsString {
    words.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(OsStr::new(" "))
}

/// What MAZE selects: a collection, and the words that the paths of its selected mazes contain.
pub(crate) struct Selection {
    /// The mazes of the file or folder, or the default mazes.
    pub(crate) catalogue: Catalogue,
    /// The path of the collection, or an empty path for the bundled mazes.
    path: PathBuf,
    /// True for the collection in the user's home folder. If this collection has no matching maze,
    /// the bundled mazes are searched.
    is_default: bool,
    words: String,
}

/// Returns a maze that was read from an entry, with its path and name.
fn named(entry: &Entry, maze: Maze) -> NamedMaze {
    NamedMaze { path: entry.path().into(), name: entry.name(), maze }
}

/// The reason why no maze was selected.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SelectionError {
    #[error("no maze matches {words:?} in {location} ({hint})")]
    NoMatch { words: String, location: String, hint: String },
    #[error("no mazes in {location}")]
    Empty { location: String },
    #[error("no such file or folder: {path}")]
    Missing { path: String },
    #[error(
        "{file} is a file, so {words:?} cannot follow it (only a folder can be followed by words)"
    )]
    WordsAfterFile { file: String, words: String },
    #[error("{} is a recording, not a maze (view it with {replay})", path.display())]
    Recording { path: PathBuf, replay: String },
    #[error("{} is a program, not a maze (run it as a mouse with {run})", path.display())]
    Program { path: PathBuf, run: String },
    #[error("{0}")]
    Unreadable(#[from] ReadError),
}

impl Selection {
    /// Returns what MAZE selects: the path of a file or a folder, words from the path of a maze in the
    /// default collection, or a folder followed by words. An empty MAZE selects the default
    /// collection: the mazes in the user's folder, or the bundled mazes if that folder has none.
    pub(crate) fn read(maze: &OsStr) -> Result<Self, SelectionError> {
        Self::encoded(maze, Choice::default())
    }

    /// Returns the same selection as [`read`](Self::read), with a choice of the encoding of numbers.
    pub(crate) fn encoded(maze: &OsStr, choice: Choice) -> Result<Self, SelectionError> {
        if Path::new(maze).exists() {
            return Self::at(Path::new(maze), choice);
        }
        let text = maze.to_string_lossy();
        let splits = || text.match_indices(' ').rev().map(|(at, _)| (&text[..at], &text[at + 1..]));
        if let Some((folder, words)) = splits().find(|(folder, _)| Path::new(folder).is_dir()) {
            return Ok(Self { words: words.into(), ..Self::at(Path::new(folder), choice)? });
        }
        if let Some((file, words)) = splits().find(|(file, _)| Path::new(file).exists()) {
            return Err(SelectionError::WordsAfterFile { file: file.into(), words: words.into() });
        }
        let default = Self::from_home(choice).unwrap_or_else(Self::bundled);
        if is_path(&text) && !default.has_file(&text) {
            let ends = |at: usize| text[..at].ends_with(is_separator);
            let end = text.match_indices(' ').map(|(at, _)| at).find(|&at| ends(at));
            return Self::at(Path::new(&text[..end.unwrap_or(text.len())]), choice);
        }
        Ok(Self { words: text.into(), ..default })
    }

    /// Returns the mazes of a file or folder.
    fn at(path: &Path, choice: Choice) -> Result<Self, SelectionError> {
        let catalogue = Catalogue::from_encoded(path, choice).map_err(|error| match &error {
            ReadError::Io { source, .. }
                if [ErrorKind::NotFound, ErrorKind::NotADirectory].contains(&source.kind()) =>
            {
                SelectionError::Missing { path: path.display().to_string() }
            }
            _ => error.into(),
        })?;
        if let [entry] = catalogue.entries()
            && entry.path() == path
            && entry.parsed().is_err()
        {
            if is_recording(path) {
                let replay = own_command(&format!("replay {}", path.display()));
                return Err(SelectionError::Recording { path: path.into(), replay });
            }
            if is_program(path) {
                let run = own_command(&format!("run {}", path.display()));
                return Err(SelectionError::Program { path: path.into(), run });
            }
        }
        Ok(Self { catalogue, path: path.into(), is_default: false, words: String::new() })
    }

    fn from_home(choice: Choice) -> Option<Self> {
        static WARNING: Once = Once::new();
        let path = home_folder()?;
        let catalogue = Catalogue::from_encoded(&path, choice).ok()?;
        if catalogue.entries().iter().any(|entry| entry.maze().is_ok()) {
            return Some(Self { catalogue, path, is_default: true, words: String::new() });
        }
        WARNING.call_once(|| {
            warn(format_args!("no mazes in {}; using the bundled mazes", path.display()));
        });
        None
    }

    fn bundled() -> Self {
        let (catalogue, path) = (Catalogue::bundled(), PathBuf::new());
        Self { catalogue, path, is_default: false, words: String::new() }
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

    /// Returns true if a maze of the collection, or a bundled maze, is in a file with this name.
    fn has_file(&self, name: &str) -> bool {
        let all = self.all_entries();
        all.iter().any(|entry| entry.path().file_name() == Some(OsStr::new(name)))
    }

    /// Returns all entries of the collection and, for the default collection, the bundled mazes.
    fn all_entries(&self) -> Vec<Entry> {
        let bundled = self.is_default.then(Catalogue::bundled).unwrap_or_default();
        self.catalogue.entries().iter().chain(bundled.entries()).cloned().collect()
    }

    /// Returns the entries whose path contains all words, including unreadable ones. If the user's
    /// folder has none, returns those of the bundled mazes.
    pub(crate) fn matching(&self) -> Result<Vec<Entry>, SelectionError> {
        let (location, count) = (self.location(), self.catalogue.entries().len());
        info!("{count} files in {location}");
        // Punctuation alone would match nearly every path.
        let is_word = !self.has_words() || self.words.contains(char::is_alphanumeric);
        let find = |catalogue: &Catalogue| {
            catalogue.matching(&self.words).filter(|_| is_word).cloned().collect()
        };
        let mut found: Vec<Entry> = find(&self.catalogue);
        if found.is_empty() && self.is_default {
            found = find(&Catalogue::bundled());
        }
        match found.is_empty() {
            false => Ok(found),
            true if count == 0 => Err(SelectionError::Empty { location }),
            true => {
                let hint = self.similar().map(|name| format!("did you mean {name}?"));
                let hint = hint.unwrap_or_else(|| {
                    let list = own_command(&format!("mazes list {}", self.path.display()));
                    format!("list the {} with {list}", counted(count, "file"))
                });
                Err(SelectionError::NoMatch { words: self.words.clone(), location, hint })
            }
        }
    }

    /// Returns words that are similar to the given ones and match a maze.
    fn similar(&self) -> Option<String> {
        let all = self.all_entries();
        let names: Vec<String> = all.iter().map(|entry| entry.name().to_lowercase()).collect();
        let known = || names.iter().flat_map(|name| name.split(|c: char| !c.is_alphanumeric()));
        let correct = |word: &str| {
            let word = word.to_lowercase();
            if names.iter().any(|name| name.contains(&word)) {
                return Some(word);
            }
            let typos = |other: &&str| strsim::damerau_levenshtein(&word, other);
            let nearest = known().min_by_key(typos)?;
            (typos(&nearest) <= 2.min(word.chars().count() / 3)).then(|| nearest.into())
        };
        let words: Vec<String> =
            self.words.split_whitespace().map(correct).collect::<Option<_>>()?;
        names
            .iter()
            .any(|name| words.iter().all(|word| name.contains(word)))
            .then(|| words.join(" "))
    }

    /// Returns the first maze whose path contains all words. Without words, returns `FIRST_MAZE` of the
    /// bundled mazes, else the first maze with a reachable goal, or the first maze. Skips unreadable files and
    /// prints a warning with the number of skipped files.
    pub(crate) fn first(&self) -> Result<NamedMaze, SelectionError> {
        let entry = self.first_entry()?;
        Ok(named(&entry, entry.maze()?))
    }

    /// Returns the entry of the [`first`](Self::first) maze, or an unreadable one if no other matches.
    pub(crate) fn first_entry(&self) -> Result<Entry, SelectionError> {
        let mut entries = self.matching()?;
        let is_readable = |entry: &Entry| entry.parsed().is_ok();
        let has_path = |entry: &Entry| {
            let parsed = entry.parsed();
            parsed.is_ok_and(|parsed| MazeFacts::new(&parsed.maze).shortest_path.is_some())
        };
        let is_first = |entry: &Entry| self.is_bundled() && entry.name() == FIRST_MAZE;
        let with_path = if self.has_words() {
            None
        } else {
            entries.iter().position(is_first).or_else(|| entries.iter().position(has_path))
        };
        let first = with_path.or_else(|| entries.iter().position(is_readable)).unwrap_or(0);
        let mut skipped = entries[..first].iter().filter_map(|entry| entry.parsed().err());
        if let Some(error) = skipped.next() {
            let (count, location) = (1 + skipped.count(), self.location());
            let count = counted(count, "unreadable file");
            warn(format_args!("skipped {count} in {location}; first error: {error}"));
        }
        Ok(entries.swap_remove(first))
    }

    /// Returns the entries that a command for many mazes uses: all of the collection or, if there are
    /// words, the first one.
    pub(crate) fn entries(&self) -> Result<Vec<Entry>, SelectionError> {
        if self.has_words() { Ok(vec![self.first_entry()?]) } else { self.matching() }
    }

    fn has_words(&self) -> bool {
        !self.words.trim().is_empty()
    }
}

/// Returns true if a text is meant as a path, not as words.
fn is_path(text: &str) -> bool {
    let path = Path::new(text);
    let is_known = Format::from_path(path).is_some()
        || ["maze", "csv", "mcap"].contains(&&extension(path)[..]);
    is_known || text.contains(is_separator) || text.starts_with('~') || [".", ".."].contains(&text)
}

/// Returns true if a file begins like a recording.
pub(crate) fn is_recording(file: &Path) -> bool {
    begins_with(file, RECORDING_START)
}

/// Returns true for scripts, and for executable files of Linux and Windows.
fn is_program(file: &Path) -> bool {
    let starts: [&[u8]; 3] = [b"#!", b"\x7fELF", b"MZ"];
    ["py", "jar", "js"].contains(&&extension(file)[..])
        || starts.iter().any(|start| begins_with(file, start))
}

/// Returns true if a file begins with these bytes. Reads nothing from a pipe, whose bytes can be read only
/// once.
fn begins_with(file: &Path, start: &[u8]) -> bool {
    let mut found = vec![0; start.len()];
    let mut read = || File::open(file)?.read_exact(&mut found);
    file.is_file() && read().is_ok() && found == start
}

/// The readable mazes, in the order in which the command line names them.
pub(crate) struct Inputs {
    pub(crate) mazes: Vec<NamedMaze>,
    /// True if no maze was skipped.
    pub(crate) all_readable: bool,
}

impl Inputs {
    /// Reads the mazes that the MAZEs `names` select. Names that are words of the path of one maze
    /// select this maze. Unreadable mazes are reported on stderr and skipped.
    pub(crate) fn read(names: &[PathBuf]) -> Self {
        let mut inputs = Self { mazes: Vec::new(), all_readable: true };
        let is_word = |name: &PathBuf| !name.exists() && !is_path(&name.to_string_lossy());
        if names.len() > 1
            && names.iter().all(is_word)
            && let Ok(maze) = Selection::read(&join(names)).and_then(|selection| selection.first())
        {
            inputs.mazes.push(maze);
            return inputs;
        }
        for name in names {
            inputs.read_one(name.as_os_str());
        }
        inputs
    }

    /// Reads the named mazes like [`read_distinct_or_default`](Self::read_distinct_or_default). A
    /// recording stands for the walls that its mouse knows in the last state. A damaged one is read as
    /// far as it is intact.
    pub(crate) fn read_with_recordings(names: &[PathBuf]) -> Self {
        if !names.iter().any(|name| is_recording(name)) {
            return Self::read_distinct_or_default(names);
        }
        let budget = recording_budget(&ReadingArgs::default());
        let mut inputs = Self { mazes: Vec::new(), all_readable: true };
        for name in names {
            if !is_recording(name) {
                inputs.read_one(name.as_os_str());
                continue;
            }
            match known_walls(name, &budget) {
                Ok((maze, is_undamaged)) => {
                    inputs.mazes.push(maze);
                    inputs.all_readable &= is_undamaged;
                }
                Err(error) => {
                    inputs.all_readable = false;
                    warn_error(&*error);
                }
            }
        }
        inputs
    }

    /// Reads the named mazes, each once, or all mazes of the default collection if there are no
    /// names.
    pub(crate) fn read_distinct_or_default(names: &[PathBuf]) -> Self {
        let mut inputs = Self::read(names);
        if names.is_empty() {
            inputs.read_one(OsStr::new(""));
        }
        let mut paths = BTreeSet::new();
        inputs.mazes.retain(|selected| paths.insert(selected.path.clone()));
        inputs
    }

    fn read_one(&mut self, name: &OsStr) {
        match Selection::read(name).and_then(|selection| selection.entries()) {
            Ok(entries) => entries.iter().for_each(|entry| match entry.maze() {
                Ok(maze) => self.mazes.push(named(entry, maze)),
                Err(error) => self.skip(&error.into()),
            }),
            Err(error) => self.skip(&error),
        }
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
        let path = folder.path().as_os_str();
        let first = |words: &str| {
            let maze = if words.is_empty() { path.into() } else { join(&[path, words.as_ref()]) };
            Selection::read(&maze).and_then(|selection| selection.first())
        };
        assert_eq!(first("").unwrap().name, "a-closed", "fallback");
        write("c-open.txt", "o---o---o\n| S   G |\no---o---o\n");
        assert_eq!(first("").unwrap().name, "c-open");
        assert_eq!(first("A CLOSED").unwrap().name, "a-closed");
        let error = first("damaged").unwrap_err().to_string();
        assert!(error.contains("b-damaged.txt: line 2, column 5: expected "), "{error}");
        let error = first("no such").unwrap_err().to_string();
        assert!(error.starts_with(r#"no maze matches "no such" in "#), "{error}");
        assert!(first("oepn").unwrap_err().to_string().ends_with(" (did you mean open?)"));
        let error = first("-").unwrap_err().to_string();
        assert!(error.starts_with(r#"no maze matches "-""#), "{error}");
    }

    #[test]
    fn the_first_bundled_maze_has_two_roads() {
        let first = |words: &str| {
            let words = words.into();
            let selection = Selection { words, ..Selection::bundled() };
            selection.first().unwrap().name
        };
        assert_eq!(["", "harbour"].map(first), [FIRST_MAZE, "01-harbour"]);
    }

    #[test]
    fn empty_folder_has_no_maze() {
        let folder = tempfile::tempdir().unwrap();
        let read = |path: &Path| Selection::read(path.as_os_str())?.first();
        let error = read(folder.path()).unwrap_err().to_string();
        assert!(error.starts_with("no mazes in "), "{error}");
        let error = read(&folder.path().join("none")).unwrap_err().to_string();
        assert!(error.starts_with("no such file or folder: "), "{error}");
    }
}
