//! Reading maze files.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mmsim_maze::Maze;

use crate::error::ParseError;
use crate::read::parse_maze;

/// The maximum size of a maze file, in bytes. The largest maze (32×32) drawn as text takes only
/// 8,385 bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// An error while reading a file or folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file or folder could not be opened or read, or the file is too large.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The path of the file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The content of the file is not a valid maze.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The path of the file.
        path: PathBuf,
        /// The first error in the content.
        source: ParseError,
    },
}

/// Reads a maze file in any [`Format`](crate::Format).
///
/// # Errors
/// Returns an error if the file is unreadable, too large or not a valid maze. The error contains
/// the path.
pub fn read_maze(path: &Path) -> Result<Maze, ReadError> {
    parse_maze(&read_content(path)?)
        .map_err(|source| ReadError::Parse { path: path.into(), source })
}

/// Reads the content of a maze file. The result can be passed to
/// [`Format::detect`](crate::Format::detect) and [`Format::read`](crate::Format::read).
///
/// # Errors
/// Returns an error if the file is unreadable or larger than [`MAX_FILE_BYTES`]. The error contains
/// the path.
pub fn read_content(path: &Path) -> Result<Vec<u8>, ReadError> {
    let file = File::open(path).map_err(|source| ReadError::Io { path: path.into(), source })?;
    read_content_from(file, path)
}

/// Reads the content of a maze file from an open reader, such as standard input. `path` identifies
/// the reader in error messages.
///
/// # Errors
/// See [`read_content`].
pub fn read_content_from(reader: impl Read, path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut content = Vec::new();
    let read = reader.take(MAX_FILE_BYTES + 1).read_to_end(&mut content);
    read.map_err(|source| ReadError::Io { path: path.into(), source })?;
    if content.len() as u64 > MAX_FILE_BYTES {
        let source = io::Error::other(format!("the file is larger than {MAX_FILE_BYTES} bytes"));
        return Err(ReadError::Io { path: path.into(), source });
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
            let error = read_maze(&folder.path().join(name)).unwrap_err().to_string();
            error.replace(&*folder.path().to_string_lossy(), "FOLDER").replace('\\', "/")
        };
        fs::write(folder.path().join("maze.txt"), "o---o\n| S |\no-- o\n").unwrap();
        fs::write(folder.path().join("large"), vec![b' '; (1 << 20) + 1]).unwrap();
        insta::assert_snapshot!(error("maze.txt"), @r#"FOLDER/maze.txt: line 3, column 2: expected "---" or three spaces between posts, found "-- ""#);
        insta::assert_snapshot!(error("large"), @"cannot read FOLDER/large: the file is larger than 1048576 bytes");
        assert!(error("missing").starts_with("cannot read FOLDER/missing: "));
        assert!(error("").starts_with("cannot read "), "a folder is not a file");
    }
}
