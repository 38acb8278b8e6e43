//! Writing mazes.

use mmsim_maze::{Cell, Maze, MazeSize};

use crate::format::Format;
use crate::{maz, num, trial};

/// An error while writing a maze in a [`Format`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// Mazes cannot be written in this format.
    #[error("the format {format} is read-only (use {})", writable())]
    ReadOnly {
        /// The format.
        format: Format,
    },
    /// The format does not support mazes of this size.
    #[error("the format {format} supports only {expected}, but the maze is {found}")]
    Size {
        /// The format.
        format: Format,
        /// The sizes that the format supports.
        expected: &'static str,
        /// The size of the maze.
        found: MazeSize,
    },
    /// The format cannot mark the start cell, and the start is not (0, 0).
    #[error("the format {format} requires the start (0, 0), but the start is {found}")]
    Start {
        /// The format.
        format: Format,
        /// The start of the maze.
        found: Cell,
    },
    /// The format cannot mark the goal, and the goal cells are not the central cells.
    #[error("the format {format} requires the central cells as the goal, but the goal is {found}")]
    Goal {
        /// The format.
        format: Format,
        /// The goal cells of the maze.
        found: String,
    },
}

impl Format {
    /// Writes a maze in this format. Reading the written content returns the same maze.
    ///
    /// # Errors
    /// Returns an error if the format is read-only or does not support the size, start or goal of
    /// the maze.
    ///
    /// ```
    /// use mmsim_formats::Format;
    /// use mmsim_maze::{Cell, CellSet, Maze, MazeSize, Walls};
    /// let walls = Walls::open(MazeSize::new(2, 1)?);
    /// let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY)?;
    /// assert_eq!(Format::Num.write(&maze)?, b"0 0 1 0 1 1\n1 0 1 1 1 0\n");
    /// let error = Format::Maz.write(&maze).unwrap_err();
    /// assert_eq!(error.to_string(), "the format maz supports only 16x16 mazes, but the maze is 2x1");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write(self, maze: &Maze) -> Result<Vec<u8>, WriteError> {
        let size = maze.size();
        let is_even_square = size.width() == size.height() && size.width().is_multiple_of(2);
        let (write, holds, expected): (fn(&Maze) -> Vec<u8>, _, _) = match self {
            Self::Text => return Ok(maze.to_string().into()),
            Self::Maz => (maz::write, size == MazeSize::CLASSIC, "16x16 mazes"),
            Self::Trial => {
                let write = |maze: &Maze| trial::write(maze).into();
                (write, is_even_square, "square mazes with an even side length")
            }
            Self::Num => (|maze| num::write(maze).into(), true, "any size"),
            Self::Maze | Self::Oshwdem | Self::Csv | Self::Hex => {
                return Err(WriteError::ReadOnly { format: self });
            }
        };
        if !holds {
            return Err(WriteError::Size { format: self, expected, found: size });
        }
        let start = maze.start().cell;
        if start != Cell::new(0, 0) {
            return Err(WriteError::Start { format: self, found: start });
        }
        if *maze.goals() != size.central_cells() {
            let found: Vec<String> = maze.goals().iter().map(|cell| cell.to_string()).collect();
            return Err(WriteError::Goal { format: self, found: found.join(" ") });
        }
        Ok(write(maze))
    }
}

/// Returns the names of the writable formats.
fn writable() -> String {
    let writable = Format::ALL.into_iter().filter(|format| format.is_writable());
    writable.map(Format::name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_limit_of_the_format() {
        let written = |format: Format, text: &str| {
            let maze: Maze = text.parse().unwrap();
            format.write(&maze).map_or_else(|error| error.to_string(), |_| "written".into())
        };
        let row = "o---o---o\n|       |\no---o---o\n";
        insta::assert_snapshot!(written(Format::Num, row), @"written");
        insta::assert_snapshot!(written(Format::Maz, row), @"the format maz supports only 16x16 mazes, but the maze is 2x1");
        insta::assert_snapshot!(written(Format::Trial, row), @"the format trial supports only square mazes with an even side length, but the maze is 2x1");
        insta::assert_snapshot!(written(Format::Num, &row.replace("      |", "    S |")), @"the format num requires the start (0, 0), but the start is (1, 0)");
        insta::assert_snapshot!(written(Format::Num, &row.replace("|    ", "| G  ")), @"the format num requires the central cells as the goal, but the goal is (0, 0)");
        insta::assert_snapshot!(written(Format::Hex, row), @"the format hex is read-only (use text, trial, maz, num)");
    }
}
