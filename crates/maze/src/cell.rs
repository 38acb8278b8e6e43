//! Cell coordinates, poses and maze sizes.

use core::fmt;

use crate::cell_set::CellSet;
use crate::heading::{Heading, Step};

/// The coordinates of a cell. The south-west cell is (0, 0); x grows to the east and y to the
/// north.
///
/// The coordinates may be outside the maze; [`MazeSize::contains`] checks them.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// The column; column 0 is the westernmost.
    pub x: u8,
    /// The row; row 0 is the southernmost.
    pub y: u8,
}

impl Cell {
    /// Creates the cell in column `x` and row `y`.
    pub const fn new(x: u8, y: u8) -> Self {
        Self { x, y }
    }

    /// Returns the neighbour in the direction `heading`, or `None` if a coordinate of the neighbour
    /// would be less than 0 or greater than 255.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading};
    /// assert_eq!(Cell::new(0, 0).neighbour(Heading::North), Some(Cell::new(0, 1)));
    /// assert_eq!(Cell::new(0, 0).neighbour(Heading::West), None);
    /// ```
    pub const fn neighbour(self, heading: Heading) -> Option<Self> {
        const BACK: u16 = u16::MAX;
        const EAST: &[u16; 4] = &[0, 1, 0, BACK];
        const NORTH: &[u16; 4] = &[1, 0, BACK, 0];
        // Avoids a branch on the heading, because the turns of a mouse are unpredictable.
        let x = (self.x as u16).wrapping_add(EAST[heading as usize]).to_le_bytes();
        let y = (self.y as u16).wrapping_add(NORTH[heading as usize]).to_le_bytes();
        // A coordinate outside 0 to 255 changes its high byte.
        if let ([x, 0], [y, 0]) = (x, y) { Some(Self { x, y }) } else { None }
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}

/// The width and height of a maze, each from 1 to [`MAX_SIDE`](Self::MAX_SIDE) cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "(usize, usize)", into = "(u8, u8)"))]
pub struct MazeSize {
    width: u8,
    height: u8,
}

/// The error for a width or height that is not between 1 and [`MazeSize::MAX_SIDE`] cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a maze of 1x1 to {max}x{max} cells, found {width}x{height}", max = MazeSize::MAX_SIDE)]
#[non_exhaustive]
pub struct SizeError {
    /// The requested width, in cells.
    pub width: usize,
    /// The requested height, in cells.
    pub height: usize,
}

impl MazeSize {
    /// The maximum width or height of a maze, in cells: 32 with the feature `half-size`, otherwise
    /// 16.
    pub const MAX_SIDE: u8 = if cfg!(feature = "half-size") { 32 } else { 16 };
    /// The maximum number of cells in a maze.
    pub const MAX_AREA: usize = Self::MAX_SIDE as usize * Self::MAX_SIDE as usize;
    /// The size of classic contest mazes, 16×16.
    pub const CLASSIC: Self = Self { width: 16, height: 16 };
    /// The size of mazes for half-size micromice, 32×32.
    #[cfg(feature = "half-size")]
    pub const HALF_SIZE: Self = Self { width: 32, height: 32 };
    /// The largest possible size.
    pub const LARGEST: Self = Self { width: Self::MAX_SIDE, height: Self::MAX_SIDE };

    /// Creates a size of `width` × `height` cells.
    ///
    /// # Errors
    /// Returns an error if `width` or `height` is 0 or greater than [`MAX_SIDE`](Self::MAX_SIDE).
    pub fn new(width: usize, height: usize) -> Result<Self, SizeError> {
        let side = |cells: usize| {
            u8::try_from(cells).ok().filter(|cells| (1..=Self::MAX_SIDE).contains(cells))
        };
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Self { width, height }),
            _ => Err(SizeError { width, height }),
        }
    }

    /// Returns the width: the number of cells from west to east.
    pub const fn width(self) -> u8 {
        self.width
    }

    /// Returns the height: the number of cells from south to north.
    pub const fn height(self) -> u8 {
        self.height
    }

    /// Returns the size with width and height swapped.
    pub(crate) const fn transposed(self) -> Self {
        Self { width: self.height, height: self.width }
    }

    /// Returns the total number of cells.
    pub const fn area(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns true if `cell` is inside a maze of this size.
    pub const fn contains(self, cell: Cell) -> bool {
        cell.x < self.width && cell.y < self.height
    }

    /// Returns the neighbour of `cell` in the direction `heading`, or `None` if the neighbour is
    /// outside the maze.
    pub fn neighbour(self, cell: Cell, heading: Heading) -> Option<Cell> {
        cell.neighbour(heading).filter(|&neighbour| self.contains(neighbour))
    }

    /// Returns the number of `cell` in the order of [`cells`](Self::cells), y · width + x, or `None`
    /// if the cell is outside the maze.
    ///
    /// ```
    /// use mmsim_maze::{Cell, MazeSize};
    /// let size = MazeSize::new(3, 2)?;
    /// assert_eq!(size.index(Cell::new(2, 1)), Some(5));
    /// assert_eq!(size.index(Cell::new(3, 0)), None);
    /// # Ok::<(), mmsim_maze::SizeError>(())
    /// ```
    pub const fn index(self, cell: Cell) -> Option<usize> {
        let index = cell.y as usize * self.width as usize + cell.x as usize;
        if self.contains(cell) { Some(index) } else { None }
    }

    /// Returns all cells of the maze, row by row from south to north, each row from west to east.
    pub fn cells(self) -> impl DoubleEndedIterator<Item = Cell> + Clone {
        (0..self.height).flat_map(move |y| (0..self.width).map(move |x| Cell { x, y }))
    }

    /// Returns the central cells, which are the default goal. There are two central columns if the
    /// width is even, and one if it is odd. There are two central rows if the height is even, and
    /// one if it is odd.
    pub const fn central_cells(self) -> CellSet {
        let mut rows = [0; Self::MAX_SIDE as usize];
        let row = 1 << ((self.width - 1) / 2) | 1 << (self.width / 2);
        rows[(self.height as usize - 1) / 2] = row;
        rows[self.height as usize / 2] = row;
        CellSet::from_rows(rows)
    }
}

impl TryFrom<(usize, usize)> for MazeSize {
    type Error = SizeError;

    fn try_from((width, height): (usize, usize)) -> Result<Self, SizeError> {
        Self::new(width, height)
    }
}

impl From<MazeSize> for (u8, u8) {
    fn from(size: MazeSize) -> Self {
        (size.width, size.height)
    }
}

impl fmt::Display for MazeSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// The cell and heading of a mouse.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pose {
    /// The cell of the mouse.
    pub cell: Cell,
    /// The direction in which the mouse faces.
    pub heading: Heading,
}

impl Pose {
    /// Creates a pose from a cell and a heading.
    pub const fn new(cell: Cell, heading: Heading) -> Self {
        Self { cell, heading }
    }

    /// Returns the pose after `step`, ignoring walls. Returns `None` if a coordinate of the new
    /// cell would be less than 0 or greater than 255.
    #[must_use]
    pub fn after(self, step: Step) -> Option<Self> {
        let heading = self.heading.turned(step);
        self.cell.neighbour(heading).map(|cell| Self { cell, heading })
    }
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} heading {}", self.cell, self.heading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_from_1_to_32_are_accepted() {
        for width in 0..40 {
            for height in 0..40 {
                let possible = (1..=32).contains(&width) && (1..=32).contains(&height);
                assert_eq!(MazeSize::new(width, height).is_ok(), possible, "{width}x{height}");
            }
        }
        assert!(MazeSize::new(256 + 16, 16).is_err());
        let error = MazeSize::new(33, 0).unwrap_err().to_string();
        assert_eq!(error, "expected a maze of 1x1 to 32x32 cells, found 33x0");
        assert_eq!(MazeSize::MAX_AREA, 1024);
    }

    #[test]
    fn sizes_convert_from_and_to_pairs() {
        let size = MazeSize::try_from((3, 2)).unwrap();
        assert_eq!((size.width(), size.height(), size.area()), (3, 2, 6));
        assert_eq!(<(u8, u8)>::from(size), (3, 2));
        assert_eq!(size.to_string(), "3x2");
        assert!(MazeSize::try_from((3, 33)).is_err());
        assert_eq!(<(u8, u8)>::from(MazeSize::CLASSIC), (16, 16));
        assert_eq!(<(u8, u8)>::from(MazeSize::HALF_SIZE), (32, 32));
    }

    #[cfg(feature = "serde")]
    #[test]
    fn deserialized_sizes_are_checked() {
        let size = MazeSize::new(3, 2).unwrap();
        assert_eq!(serde_json::to_string(&size).unwrap(), "[3,2]");
        assert_eq!(serde_json::from_str::<MazeSize>("[3,2]").unwrap(), size);
        assert!(serde_json::from_str::<MazeSize>("[0,33]").is_err());
    }

    #[test]
    fn the_centre_follows_the_parity_of_each_side() {
        let centre = |width, height| {
            MazeSize::new(width, height).unwrap().central_cells().iter().collect::<Vec<_>>()
        };
        let cells =
            |list: &[(u8, u8)]| list.iter().map(|&(x, y)| Cell { x, y }).collect::<Vec<_>>();
        assert_eq!(centre(16, 16), cells(&[(7, 7), (8, 7), (7, 8), (8, 8)]));
        assert_eq!(centre(5, 5), cells(&[(2, 2)]));
        assert_eq!(centre(5, 2), cells(&[(2, 0), (2, 1)]));
        assert_eq!(centre(1, 1), cells(&[(0, 0)]));
        assert_eq!(centre(2, 1), cells(&[(0, 0), (1, 0)]));
    }

    #[test]
    fn neighbours_are_inside_the_maze() {
        let size = MazeSize::new(3, 2).unwrap();
        assert_eq!(size.neighbour(Cell::new(2, 1), Heading::East), None);
        assert_eq!(size.neighbour(Cell::new(2, 1), Heading::North), None);
        assert_eq!(size.neighbour(Cell::new(2, 1), Heading::South), Some(Cell::new(2, 0)));
        assert_eq!(Cell::new(255, 255).neighbour(Heading::North), None);
        for (heading, x, y) in [
            (Heading::North, 7, 10),
            (Heading::East, 8, 9),
            (Heading::South, 7, 8),
            (Heading::West, 6, 9),
        ] {
            assert_eq!(Cell::new(7, 9).neighbour(heading), Some(Cell::new(x, y)));
        }
        assert_eq!(Cell::new(255, 255).neighbour(Heading::East), None);
        assert_eq!(Cell::new(0, 0).neighbour(Heading::South), None);
        assert_eq!(Cell::new(0, 0).neighbour(Heading::West), None);
    }

    #[test]
    fn cells_are_listed_row_by_row() {
        let size = MazeSize::new(3, 2).unwrap();
        let cells = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)].map(|(x, y)| Cell::new(x, y));
        assert!(size.cells().eq(cells));
        assert!(size.cells().rev().eq(cells.into_iter().rev()));
        assert!(size.cells().map(|cell| size.index(cell).unwrap()).eq(0..6));
        assert!(size.contains(Cell::new(2, 1)));
        assert!(!size.contains(Cell::new(3, 0)) && !size.contains(Cell::new(0, 2)));
    }

    #[test]
    fn a_step_is_a_turn_and_one_cell() {
        let pose = Pose::new(Cell::new(5, 5), Heading::East);
        let ends: Vec<_> = Step::ALL.into_iter().map(|step| pose.after(step).unwrap()).collect();
        assert_eq!(ends[0], Pose::new(Cell::new(6, 5), Heading::East));
        assert_eq!(ends[1], Pose::new(Cell::new(5, 6), Heading::North));
        assert_eq!(ends[2], Pose::new(Cell::new(5, 4), Heading::South));
        assert_eq!(ends[3], Pose::new(Cell::new(4, 5), Heading::West));
        assert_eq!(Pose::new(Cell::new(0, 0), Heading::North).after(Step::Left), None);
        assert_eq!(pose.to_string(), "(5, 5) heading east");
    }
}
