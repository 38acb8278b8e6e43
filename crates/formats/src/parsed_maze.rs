//! The result of reading a maze file, and what the readers of all notations share.

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, Sides, Walls};

use crate::encoding::Encoding;
use crate::error::{Location, Note, ParseError, ParseErrorKind};

/// A maze read from a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ParsedMaze {
    /// The maze.
    pub maze: Maze,
    /// How the file describes the maze.
    pub notation: Notation,
    /// The encodings that give this maze, if the file has a number for each cell.
    pub encodings: Vec<Encoding>,
    /// What is unusual about the file, in the order of the file.
    pub notes: Vec<Note>,
}

/// How a file describes a maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Notation {
    /// Posts and walls drawn as text.
    Drawing,
    /// A number for each cell.
    Numbers,
    /// A line for each cell.
    Cells,
}

impl ParsedMaze {
    pub(crate) const fn new(maze: Maze, notation: Notation) -> Self {
        Self { maze, notation, encodings: Vec::new(), notes: Vec::new() }
    }
}

impl Notation {
    /// Returns the name: `drawing`, `numbers` or `cells`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Drawing => "drawing",
            Self::Numbers => "numbers",
            Self::Cells => "cells",
        }
    }
}

pub(crate) const MAX_SIDE: usize = MazeSize::MAX_SIDE as usize;

/// Returns the cell at these coordinates, which must be below 32.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn cell(x: usize, y: usize) -> Cell {
    Cell::new(x as u8, y as u8)
}

/// Creates a maze size. Callers check `width` and `height` beforehand in order to report errors
/// with an exact location.
pub(crate) fn size(width: usize, height: usize) -> Result<MazeSize, ParseError> {
    MazeSize::new(width, height).map_err(|error| {
        let found = format!("{}x{}", error.width, error.height);
        ParseError::new(1, 1, "a maze of 1x1 to 32x32 cells", found)
    })
}

/// Builds a maze. The start and the goals must be inside the maze. The default start is (0, 0).
pub(crate) fn maze(walls: Walls, start: Option<Cell>, goals: CellSet) -> Result<Maze, ParseError> {
    Maze::new(walls, start.unwrap_or(Cell::new(0, 0)), goals).map_err(|error| {
        ParseError::new(1, 1, "a start and goals inside the maze", error.cell.to_string())
    })
}

/// Returns all cells by column. The columns are listed from west to east, and the cells of a column
/// from south to north.
pub(crate) fn by_columns(size: MazeSize) -> impl Iterator<Item = Cell> {
    (0..size.width()).flat_map(move |x| (0..size.height()).map(move |y| Cell { x, y }))
}

/// Returns the sides on which a cell lacks an outer wall, or disagrees with the cell to its north or
/// east about the wall between them.
pub(crate) fn faults(
    size: MazeSize,
    sides: impl Fn(Cell) -> Sides,
) -> impl Iterator<Item = (Cell, Heading)> {
    by_columns(size).flat_map(move |cell| {
        let here = sides(cell);
        let is_fault = |heading: &Heading| match size.neighbour(cell, *heading) {
            None => !here.has(*heading),
            Some(_) if matches!(heading, Heading::South | Heading::West) => false,
            Some(neighbour) => here.has(*heading) != sides(neighbour).has(heading.back()),
        };
        let faulty = Heading::ALL.map(|heading| is_fault(&heading).then_some((cell, heading)));
        faulty.into_iter().flatten()
    })
}

/// Builds walls from the sides of all cells.
///
/// # Errors
/// Returns an error for each of the [`faults`]. `place` returns the location of a cell, and what
/// was found there.
pub(crate) fn walls(
    size: MazeSize,
    sides: impl Fn(Cell) -> Sides,
    place: impl Fn(Cell) -> (Location, String),
) -> Result<Walls, Vec<ParseError>> {
    let error = |(cell, heading)| {
        let (location, found) = place(cell);
        let Some(neighbour) = size.neighbour(cell, heading) else {
            let error = ParseError::at(
                location,
                format!("an outer wall to the {heading} of {cell}"),
                found,
            );
            return error.with_kind(ParseErrorKind::OpenPerimeter).with_cell(cell);
        };
        let wall = if sides(cell).has(heading) { "a wall" } else { "no wall" };
        let expected = format!("{wall} between {cell} and {neighbour} to match {location}");
        let (there, found) = place(neighbour);
        let error = ParseError::at(there, expected, found);
        error.with_kind(ParseErrorKind::Contradiction).with_cell(neighbour)
    };
    let errors: Vec<ParseError> = faults(size, &sides).map(error).collect();
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut walls = Walls::open(size);
    for cell in size.cells() {
        for heading in Heading::ALL {
            walls.set(cell, heading, sides(cell).has(heading));
        }
    }
    Ok(walls)
}
