//! The formats and their names.

use std::fmt;
use std::str::FromStr;

/// A file format for mazes.
///
/// A file without a start mark starts at (0, 0). A file without a goal mark has its goal in the
/// central cells ([`MazeSize::central_cells`](mmsim_maze::MazeSize::central_cells)). Lines may end in
/// `\n`, `\r\n` or `\r`.
///
/// ```
/// use mmsim_formats::Format;
/// use mmsim_maze::Maze;
/// let maze: Maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse()?;
/// assert!(Format::Num.write(&maze).is_err(), "num cannot mark the goal");
/// assert_eq!(Format::Text.write(&maze)?, maze.to_string().into_bytes());
/// assert_eq!("num".parse(), Ok(Format::Num));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Posts and walls drawn as text, north on top:
    ///
    /// ```text
    /// o---o---o
    /// |     G |
    /// o   o---o
    /// | S     |
    /// o---o---o
    /// ```
    ///
    /// Posts may be any character, but the same one everywhere. They are two, three or four columns
    /// apart. A blank between posts or cells means no wall, any other character a wall. `S` marks the
    /// start and `G` each goal cell; both are optional. Blank lines and trailing blanks are ignored,
    /// and so is text after the last line of the maze.
    Text,
    /// [`Text`](Self::Text) with ` . ` or `.` for each unknown inner wall, as in the `.maze` files of
    /// kerikun11's micromouse library. Unknown walls are read as open. If posts or outer walls are
    /// dots, dots are walls.
    Maze,
    /// The output of the OSHWDEM maze generator: a first line that starts with `OSHWDEM`, then a
    /// drawing with `A` in the start cell and `B` in place of the post at the centre of the goal. The
    /// drawing is turned: right is north and down is east.
    Oshwdem,
    /// The format of the two-run trial: the side n, an even number, then n lines of n comma-separated
    /// numbers. Each line is a column from the west, each number a cell from the south. The bits 1
    /// north, 2 east, 4 south and 8 west are set for open sides.
    Trial,
    /// 256 bytes, one for each cell of a 16×16 maze: columns from the west, each from the south. The
    /// bits 1 north, 2 east, 4 south and 8 west are set for walls.
    Maz,
    /// One line for each cell, in any order: x, y, then 1 (wall) or 0 (no wall) for north, east,
    /// south and west, separated by blanks. The largest x and y give the size.
    Num,
    /// The table of the Python simulators: rows from the north, cells from the west, separated by
    /// commas, semicolons or blanks. The codes 1 to 16 mean walls W, N, E, S, SW, SE, NE, NW, WE, NS,
    /// SWE, NSE, NWE, NSW, none, all. Codes may be written as floats.
    Csv,
    /// Rows of hex digits, one digit for each cell, with or without commas, semicolons or blanks
    /// between. `0x` or `0X` may precede each digit or a whole row, and `0` each separate digit.
    ///
    /// Layout and bits are inferred. The bits 1, 2, 4, 8 stand for north, east, south, west or for
    /// east, north, west, south, and are set for walls or for openings. Lines are rows or columns,
    /// from either side, and so are the digits of a line: 32 encodings in total. A maze fits if it
    /// has no contradiction, all outer walls, and a start (0, 0) that is open to the north only.
    ///
    /// If several mazes fit, the first whose goal is reachable wins, else the first, and
    /// [`ParsedMaze::ambiguous_encoding`](crate::ParsedMaze::ambiguous_encoding) reports its
    /// encoding. The bits north, east, south, west come first; for each order walls, then openings;
    /// for each of these the layouts in this order: rows from the north, each from the west; columns
    /// from the west, each from the south; rows from the north, from the east; from the south, from
    /// the west; from the south, from the east; columns from the west, from the north; from the east,
    /// from the south; from the east, from the north.
    Hex,
}

/// A name that belongs to no [`Format`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {}, found {found:?}", Format::ALL.map(Format::name).join(", "))]
#[non_exhaustive]
pub struct FormatNameError {
    /// The name.
    pub found: String,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 8] = {
        use Format::{Csv, Hex, Maz, Maze, Num, Oshwdem, Text, Trial};
        [Text, Maze, Oshwdem, Trial, Maz, Num, Csv, Hex]
    };

    /// Returns the name, which [`str::parse`] accepts.
    pub const fn name(self) -> &'static str {
        ["text", "maze", "oshwdem", "trial", "maz", "num", "csv", "hex"][self as usize]
    }

    /// Returns whether mazes can also be written in this format.
    pub const fn is_writable(self) -> bool {
        matches!(self, Self::Text | Self::Trial | Self::Maz | Self::Num)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = FormatNameError;

    fn from_str(name: &str) -> Result<Self, FormatNameError> {
        let found = Self::ALL.into_iter().find(|format| format.name() == name);
        found.ok_or_else(|| FormatNameError { found: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_parse() {
        for format in Format::ALL {
            assert_eq!(format.name().parse(), Ok(format));
        }
        insta::assert_snapshot!("png".parse::<Format>().unwrap_err(), @r#"expected one of text, maze, oshwdem, trial, maz, num, csv, hex, found "png""#);
    }
}
