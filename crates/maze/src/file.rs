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
        let io_error = |source| ReadError::Io { path: path.into(), source };
        let mut content = Vec::new();
        let file = File::open(path).map_err(io_error)?;
        file.take(MAX_FILE_BYTES + 1).read_to_end(&mut content).map_err(io_error)?;
        let maze = if content.len() as u64 > MAX_FILE_BYTES {
            Err(ParseError::too_large(&content))
        } else {
            Self::parse(&content)
        };
        maze.map_err(|source| ReadError::Parse { path: path.into(), source })
    }
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
