//! The maze file formats and their names.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// A file format for mazes.
///
/// If a file does not mark the start, the start is (0, 0). If a file does not mark the goal, the
/// goal consists of the central cells
/// ([`MazeSize::central_cells`](mmsim_maze::MazeSize::central_cells)). Lines may end in `\n`,
/// `\r\n` or `\r`.
///
/// ```
/// use mmsim_formats::Format;
/// use mmsim_maze::Maze;
/// let maze: Maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse()?;
/// assert!(Format::Num.write(&maze).is_err(), "num requires the central cells as the goal");
/// assert_eq!(Format::Text.write(&maze)?, maze.to_string().into_bytes());
/// assert_eq!("num".parse(), Ok(Format::Num));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Posts and walls drawn as text, with north at the top:
    ///
    /// ```text
    /// o---o---o
    /// |     G |
    /// o   o---o
    /// | S     |
    /// o---o---o
    /// ```
    ///
    /// Any character may represent a post, but all posts must use the same one. Adjacent posts are
    /// two, three or four columns apart. Blanks between two posts or two cells mean an opening;
    /// other characters mean a wall. `S` marks the start and `G` marks each goal cell; both marks
    /// are optional. Blank lines, trailing blanks and text after the last line of the maze are
    /// ignored.
    Text,
    /// The [`Text`](Self::Text) format, extended with unknown inner walls. Each unknown wall is
    /// drawn as a dot, alone or between two blanks. The `.maze` files of kerikun11's micromouse
    /// library use this format. Unknown walls are read as open. If the posts or outer walls are
    /// drawn as dots, a dot between two posts or two cells means a wall.
    Maze,
    /// The output of the OSHWDEM maze generator. The first line starts with `OSHWDEM`. A drawing
    /// follows, with `A` in the start cell and `B` in place of the post at the centre of the goal.
    /// The drawing is rotated: north is to the right and east is at the bottom.
    Oshwdem,
    /// The maze format of the two-run trial in the `mmsim-trial` crate. The first line contains an
    /// even number n, the side length of the square maze. Each of the next n lines contains n
    /// comma-separated numbers for the cells of a column, from south to north. The columns are
    /// listed from west to east. In each number, the bits 1 (north), 2 (east), 4 (south) and 8
    /// (west) are set for open sides.
    Trial,
    /// A 16×16 maze as 256 bytes, one for each cell. The columns are stored from west to east, and
    /// the cells of each column from south to north. In each byte, the bits 1 (north), 2 (east), 4
    /// (south) and 8 (west) are set for walls.
    Maz,
    /// One line for each cell, in any order. Each line contains six numbers separated by blanks: x,
    /// y, and 1 (wall) or 0 (no wall) for north, east, south and west. The largest x and y
    /// determine the size of the maze.
    Num,
    /// The table format of Python micromouse simulators. The rows run from north to south and
    /// contain a code for each cell. The codes are separated by commas, semicolons or blanks. The
    /// codes 1 to 16 stand for walls on these sides: W, N, E, S, SW, SE, NE, NW, WE, NS, SWE, NSE,
    /// NWE, NSW, none, all. Codes may be written as floating-point numbers.
    Csv,
    /// Lines of hex digits, with one digit for each cell. The digits may be separated by commas,
    /// semicolons or blanks. Each digit or each line may have the prefix `0x` or `0X`. If the
    /// digits are separated, each may also have a leading zero.
    ///
    /// The layout and the meaning of the bits are inferred. The bits 1, 2, 4 and 8 stand for the
    /// sides of a cell in one of two orders: either north, east, south, west, or east, north, west,
    /// south. In some files a set bit means a wall, in others an open side. Each line is either a
    /// row or a column of the maze. Rows may be listed from the north or from the south, and
    /// columns from the west or from the east. Each line may begin at either end of its row or
    /// column. There are 32 encodings in total.
    ///
    /// An encoding is valid if the resulting maze has no contradictions, no gaps in the outer wall,
    /// and a start (0, 0) that is open only to the north.
    ///
    /// If several encodings are valid, the first valid encoding with a reachable goal is used. If
    /// no valid encoding has a reachable goal, the first valid encoding is used. If another valid
    /// encoding gives a different maze,
    /// [`ParsedMaze::ambiguous_encoding`](crate::ParsedMaze::ambiguous_encoding) describes the
    /// encoding that was used. The encodings with the bit order north, east, south, west are tried
    /// first. For each bit order, the encodings in which a set bit means a wall come before those
    /// in which it means an open side. For each bit order and each meaning of a set bit, the
    /// layouts are tried in the order of this table:
    ///
    /// | lines | digits of a line |
    /// |---|---|
    /// | rows from the north | from the west |
    /// | columns from the west | from the south |
    /// | rows from the north | from the east |
    /// | rows from the south | from the west |
    /// | rows from the south | from the east |
    /// | columns from the west | from the north |
    /// | columns from the east | from the south |
    /// | columns from the east | from the north |
    Hex,
}

/// An error for an unknown format name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {}, found {found:?}", Format::ALL.map(Format::name).join(", "))]
#[non_exhaustive]
pub struct FormatNameError {
    /// The unknown name.
    pub found: String,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 8] = {
        use Format::{Csv, Hex, Maz, Maze, Num, Oshwdem, Text, Trial};
        [Text, Maze, Oshwdem, Trial, Maz, Num, Csv, Hex]
    };

    /// Returns the name of the format, which [`str::parse`] accepts.
    pub const fn name(self) -> &'static str {
        ["text", "maze", "oshwdem", "trial", "maz", "num", "csv", "hex"][self as usize]
    }

    /// Returns the format in which a file with this path is written, according to its extension:
    /// [`Text`](Self::Text) for `.txt`, and otherwise the writable format whose name is the
    /// extension. Ignores case.
    ///
    /// ```
    /// use mmsim_formats::Format;
    /// use std::path::Path;
    /// assert_eq!(Format::from_path(Path::new("a/maze.TXT")), Some(Format::Text));
    /// assert_eq!(Format::from_path(Path::new("maze.num")), Some(Format::Num));
    /// assert_eq!(Format::from_path(Path::new("maze.csv")), None);
    /// ```
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        Self::ALL.into_iter().filter(|format| format.is_writable()).find(|format| {
            let name = if *format == Self::Text { "txt" } else { format.name() };
            extension.eq_ignore_ascii_case(name)
        })
    }

    /// Returns true if mazes can be written in this format.
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
