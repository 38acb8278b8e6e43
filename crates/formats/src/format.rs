//! The formats in which mazes are written.

use std::path::Path;

use mmsim_maze::{Cell, Heading, Maze};

/// A format in which mazes can be written. [`Choice::read`](crate::Choice::read) reads them, and
/// many others.
///
/// ```
/// use mmsim_formats::Format;
/// use mmsim_maze::Maze;
/// let maze: Maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse()?;
/// assert!(Format::Num.write(&maze).is_err(), "num requires the central cells as the goal");
/// assert_eq!(Format::Text.write(&maze)?, maze.to_string().into_bytes());
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
    Text,
    /// The maze format of the two-run trial. The first line is the even side length n of the square
    /// maze. Each of the next n lines contains n comma-separated numbers for the cells of a column,
    /// from south to north. The columns are listed from west to east. In each number, the bits 1
    /// (north), 2 (east), 4 (south) and 8 (west) are set for open sides.
    Trial,
    /// A 16×16 or 32×32 maze as one byte for each cell. The columns are stored from west to east,
    /// and the cells of each column from south to north. In each byte, the bits 1 (north), 2
    /// (east), 4 (south) and 8 (west) are set for walls.
    Maz,
    /// One line for each cell with six numbers: x, y, and 1 (wall) or 0 (no wall) for north, east,
    /// south and west.
    Num,
}

/// An error while writing a maze in a [`Format`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the format {} requires {expected}, but {found}", format.name())]
#[non_exhaustive]
pub struct WriteError {
    /// The format.
    pub format: Format,
    /// The size, start or goal that the format supports.
    pub expected: &'static str,
    /// What the maze has instead.
    pub found: String,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Text, Self::Trial, Self::Maz, Self::Num];

    /// Returns the name of the format.
    pub const fn name(self) -> &'static str {
        ["text", "trial", "maz", "num"][self as usize]
    }

    /// Returns the format in which a file with this path is written, according to its extension:
    /// [`Text`](Self::Text) for `.txt`, and otherwise the format whose name is the extension.
    /// Ignores case.
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
        Self::ALL.into_iter().find(|format| {
            let name = if *format == Self::Text { "txt" } else { format.name() };
            extension.eq_ignore_ascii_case(name)
        })
    }

    /// Writes a maze in this format. Reading the written content returns the same maze.
    ///
    /// # Errors
    /// Returns an error if the format does not support the size, start or goal of the maze.
    ///
    /// ```
    /// use mmsim_formats::Format;
    /// use mmsim_maze::{Cell, CellSet, Maze, MazeSize, Walls};
    /// let walls = Walls::open(MazeSize::new(2, 1)?);
    /// let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY)?;
    /// assert_eq!(Format::Num.write(&maze)?, b"0 0 1 0 1 1\n1 0 1 1 1 0\n");
    /// let error = Format::Maz.write(&maze).unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "the format maz requires a 16x16 or 32x32 maze, but the maze is 2x1"
    /// );
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write(self, maze: &Maze) -> Result<Vec<u8>, WriteError> {
        let (size, start) = (maze.size(), maze.start().cell);
        let is_square = size.width() == size.height();
        let (is_possible, expected) = match self {
            Self::Text => return Ok(maze.to_string().into()),
            Self::Maz => (is_square && [16, 32].contains(&size.width()), "a 16x16 or 32x32 maze"),
            Self::Trial => {
                (is_square && size.width() % 2 == 0, "a square maze with an even side length")
            }
            Self::Num => (true, ""),
        };
        let (expected, found) = if !is_possible {
            (expected, format!("the maze is {size}"))
        } else if start != Cell::new(0, 0) {
            ("the start (0, 0)", format!("the start is {start}"))
        } else if *maze.goals() != size.central_cells() {
            let goals: Vec<String> = maze.goals().iter().map(|cell| cell.to_string()).collect();
            ("the central cells as the goal", format!("the goal is {}", goals.join(" ")))
        } else {
            return Ok(self.write_cells(maze));
        };
        Err(WriteError { format: self, expected, found })
    }

    /// Writes the cells by column.
    fn write_cells(self, maze: &Maze) -> Vec<u8> {
        let size = maze.size();
        let write = |cell: Cell| {
            let sides = maze.walls().sides(cell);
            let end = if cell.y + 1 < size.height() { "," } else { "\n" };
            let [north, east, south, west] = Heading::ALL.map(|side| u8::from(sides.has(side)));
            match self {
                Self::Maz => vec![sides.bits()],
                Self::Trial => format!("{}{end}", sides.bits() ^ 15).into(),
                _ => format!("{} {} {north} {east} {south} {west}\n", cell.x, cell.y).into(),
            }
        };
        let head = if self == Self::Trial { format!("{}\n", size.width()) } else { String::new() };
        let column = |x| (0..size.height()).map(move |y| Cell { x, y });
        let cells = (0..size.width()).flat_map(column);
        head.into_bytes().into_iter().chain(cells.flat_map(write)).collect()
    }
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
        insta::assert_snapshot!(written(Format::Maz, row), @"the format maz requires a 16x16 or 32x32 maze, but the maze is 2x1");
        insta::assert_snapshot!(written(Format::Trial, row), @"the format trial requires a square maze with an even side length, but the maze is 2x1");
        insta::assert_snapshot!(written(Format::Num, &row.replace("      |", "    S |")), @"the format num requires the start (0, 0), but the start is (1, 0)");
        insta::assert_snapshot!(written(Format::Num, &row.replace("|    ", "| G  ")), @"the format num requires the central cells as the goal, but the goal is (0, 0)");
    }
}
