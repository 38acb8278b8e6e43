//! Mazes in files.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::{Maze, ParseError};

/// The largest maze file that is read, in bytes; a 32×32 maze drawn as text takes 8,385.
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// A file from which no maze could be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The content is no maze.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Where in the file, what was expected and what was found.
        source: ParseError,
    },
}

impl Maze {
    /// Reads a maze file, telling its [`Format`](crate::Format) from the content.
    ///
    /// # Errors
    /// A file that cannot be read, is too large or holds no maze; the error names the file.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let content = maze_content(path)?;
        Self::parse(&content).map_err(|source| ReadError::Parse { path: path.into(), source })
    }
}

/// The content of a maze file, for [`Format::detect`](crate::Format::detect) and
/// [`Format::read`](crate::Format::read).
///
/// # Errors
/// A file that cannot be read or has more than [`MAX_FILE_BYTES`]; the error names the file.
pub fn maze_content(path: &Path) -> Result<Vec<u8>, ReadError> {
    let file = File::open(path).map_err(|source| ReadError::Io { path: path.into(), source })?;
    maze_content_of(file, path)
}

/// The same from a reader that is open already, such as the standard input; `path` stands for it in
/// errors.
///
/// # Errors
/// As for [`maze_content`].
pub fn maze_content_of(reader: impl Read, path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut content = Vec::new();
    let read = reader.take(MAX_FILE_BYTES + 1).read_to_end(&mut content);
    read.map_err(|source| ReadError::Io { path: path.into(), source })?;
    if content.len() as u64 > MAX_FILE_BYTES {
        let source = ParseError::too_large(&content);
        return Err(ReadError::Parse { path: path.into(), source });
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn errors_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = |name: &str| {
            let error = Maze::read(&folder.path().join(name)).unwrap_err().to_string();
            error.replace(&*folder.path().to_string_lossy(), "FOLDER").replace('\\', "/")
        };
        fs::write(folder.path().join("maze.txt"), "o---o\n| S |\no-- o\n").unwrap();
        fs::write(folder.path().join("large"), vec![b' '; (1 << 20) + 1]).unwrap();
        insta::assert_snapshot!(error("maze.txt"), @r#"FOLDER/maze.txt: line 3, column 2: expected "---" or three spaces between posts, found "-- ""#);
        insta::assert_snapshot!(error("large"), @"FOLDER/large: line 1, column 1048578: expected the end of the file before byte 1048577, found more");
        assert!(error("missing").starts_with("FOLDER/missing: cannot be read: "));
        assert!(error("").contains("cannot be read: "), "a folder is no file");
    }
}
