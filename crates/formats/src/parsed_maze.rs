//! The result of reading a maze file, and what the readers of all notations share.

use std::fmt;

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeError, MazeSize, Sides, Wall, Walls};

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

/// Writes the options that select the maze, if it has an encoding, and draws the maze below them.
impl fmt::Display for ParsedMaze {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(encoding) = self.encodings.first() {
            writeln!(f, "{encoding}")?;
        }
        self.maze.fmt(f)
    }
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

impl Notation {
    /// Returns the name: `drawing`, `numbers` or `cells`.
    pub const fn name(self) -> &'static str {
        ["drawing", "numbers", "cells"][self as usize]
    }
}

pub(crate) const MAX_SIDE: usize = MazeSize::MAX_SIDE as usize;

/// Returns the size of a maze that begins at `at`.
pub(crate) fn size(at: Location, width: usize, height: usize) -> Result<MazeSize, ParseError> {
    let error = |_| ParseError::new(at, "at most 32x32 cells", format!("{width}x{height}"));
    MazeSize::new(width, height).map_err(error)
}

/// Builds a maze. The start and the goals must be inside the maze. The default start is (0, 0).
pub(crate) fn maze(walls: Walls, start: Option<Cell>, goals: CellSet) -> Result<Maze, ParseError> {
    let outside = |error: MazeError| {
        let expected = "a start and goals inside the maze";
        ParseError::new(Location::FIRST, expected, error.cell.to_string())
    };
    Maze::new(walls, start.unwrap_or(Cell::new(0, 0)), goals).map_err(outside)
}

/// Returns the outer walls that are missing, and the walls about which two adjacent cells disagree.
pub(crate) fn faults(size: MazeSize, sides: impl Fn(Cell) -> Sides) -> impl Iterator<Item = Wall> {
    let walls = size.cells().flat_map(|cell| {
        let walls = Heading::ALL.map(|heading| Wall::new(cell, heading));
        walls.into_iter().filter(move |wall| wall.cell == cell)
    });
    walls.filter(move |&Wall { cell, heading, .. }| {
        let is_wall = sides(cell).has(heading);
        let behind = size.neighbour(cell, heading);
        is_wall != behind.is_none_or(|behind| sides(behind).has(heading.back()))
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
    let error = |Wall { cell, heading, .. }| {
        let (at, found) = place(cell);
        let Some(neighbour) = size.neighbour(cell, heading) else {
            let error =
                ParseError::new(at, format!("an outer wall to the {heading} of {cell}"), found);
            return ParseError { kind: ParseErrorKind::OpenPerimeter, cell: Some(cell), ..error };
        };
        let wall = if sides(cell).has(heading) { "a wall" } else { "no wall" };
        let expected = format!("{wall} between {cell} and {neighbour} to match {at}");
        let (there, found) = place(neighbour);
        let error = ParseError::new(there, expected, found);
        ParseError { kind: ParseErrorKind::Contradiction, cell: Some(neighbour), ..error }
    };
    let errors: Vec<ParseError> = faults(size, &sides).map(error).collect();
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut walls = Walls::open(size);
    for Wall { cell, heading, .. } in size.inner_walls() {
        walls.set(cell, heading, sides(cell).has(heading));
    }
    Ok(walls)
}
