//! Writing mazes.

use super::{Format, WriteError, maz, num, trial};
use crate::{Cell, CellSet, Maze, MazeSize};

impl Format {
    /// Writes a maze, such that it reads back as it is.
    ///
    /// # Errors
    /// The format is one that is only read, or cannot hold this maze: for its size, or because it
    /// marks no start and goal and they are not where readers look for them, at (0, 0) and in the
    /// centre.
    ///
    /// ```
    /// use mmsim_maze::{Cell, CellSet, Format, Maze, MazeSize, Walls};
    /// let walls = Walls::open(MazeSize::new(2, 1)?);
    /// let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY)?;
    /// assert_eq!(Format::Num.write(&maze)?, b"0 0 1 0 1 1\n1 0 1 1 1 0\n");
    /// let error = Format::Maz.write(&maze).unwrap_err();
    /// assert_eq!(error.to_string(), "maz holds mazes of 16x16 cells, found one of 2x1");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write(self, maze: &Maze) -> Result<Vec<u8>, WriteError> {
        let size = maze.size();
        let (holds, expected) = match self {
            Self::Text => return Ok(maze.to_string().into()),
            Self::Maz => (size == MazeSize::CLASSIC, "16x16 cells"),
            Self::Trial => (
                size.width() == size.height() && size.width().is_multiple_of(2),
                "as many cells each way, an even number",
            ),
            Self::Num => (true, "any size"),
            Self::Maze | Self::Oshwdem | Self::Csv | Self::Hex => {
                return Err(WriteError::ReadOnly { format: self });
            }
        };
        if !holds {
            return Err(WriteError::Size { format: self, expected, found: size });
        }
        let (start, centre) = (maze.start().cell, size.central_cells());
        if start != Cell::new(0, 0) {
            return Err(WriteError::Start { format: self, found: start });
        }
        if *maze.goals() != centre {
            let (expected, found) = (listed(&centre), listed(maze.goals()));
            return Err(WriteError::Goal { format: self, expected, found });
        }
        Ok(match self {
            Self::Maz => maz::write(maze),
            Self::Trial => trial::write(maze).into(),
            _ => num::write(maze).into(),
        })
    }
}

fn listed(cells: &CellSet) -> String {
    cells.iter().map(|cell| cell.to_string()).collect::<Vec<_>>().join(" ")
}
