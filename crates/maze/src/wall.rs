//! The names and numbers of walls.

use crate::cell::{Cell, MazeSize};
use crate::heading::Heading;

/// The name of a wall, whether the wall is present or not.
///
/// Each wall has one name, although both cells beside it have a side there. The name is the north
/// or east side of a cell. Outer walls to the south and west have no cell on their other side, so
/// their names are the south and west sides of the cells in the maze.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Wall};
/// let wall = Wall::new(Cell::new(3, 4), Heading::South);
/// assert_eq!(wall, Wall::new(Cell::new(3, 3), Heading::North));
/// assert_eq!((wall.cell, wall.heading), (Cell::new(3, 3), Heading::North));
/// assert!(wall.cells().eq([Cell::new(3, 3), Cell::new(3, 4)]));
///
/// let outer = Wall::new(Cell::new(3, 0), Heading::South);
/// assert_eq!((outer.cell, outer.heading), (Cell::new(3, 0), Heading::South));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Wall {
    /// The cell that has the wall on its `heading` side.
    pub cell: Cell,
    /// The side of `cell`: north or east, or south in row 0, or west in column 0.
    pub heading: Heading,
}

impl Wall {
    /// Returns the wall on the `heading` side of `cell`.
    #[inline]
    pub const fn new(cell: Cell, heading: Heading) -> Self {
        let Cell { x, y } = cell;
        match heading {
            Heading::South if y > 0 => Self { cell: Cell::new(x, y - 1), heading: Heading::North },
            Heading::West if x > 0 => Self { cell: Cell::new(x - 1, y), heading: Heading::East },
            _ => Self { cell, heading },
        }
    }

    /// Returns the cells on both sides of the wall. The second cell may be outside the maze; it is
    /// missing if one of its coordinates would be less than 0 or greater than 255.
    pub fn cells(self) -> impl Iterator<Item = Cell> {
        [Some(self.cell), self.cell.neighbour(self.heading)].into_iter().flatten()
    }
}

impl MazeSize {
    /// Returns the walls on the north and east side of each cell, in the order of
    /// [`cells`](Self::cells), north before east. The outer walls to the south and west are not
    /// included.
    pub fn walls(self) -> impl Iterator<Item = Wall> + Clone {
        let wall = |cell, heading| Wall { cell, heading };
        self.cells().flat_map(move |cell| [wall(cell, Heading::North), wall(cell, Heading::East)])
    }

    /// Returns the walls between two cells of the maze, in the order of [`walls`](Self::walls).
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Wall};
    /// let size = MazeSize::new(2, 1)?;
    /// assert!(size.inner_walls().eq([Wall::new(Cell::new(0, 0), Heading::East)]));
    /// assert_eq!(size.walls().count(), 4);
    /// # Ok::<(), mmsim_maze::SizeError>(())
    /// ```
    pub fn inner_walls(self) -> impl Iterator<Item = Wall> + Clone {
        self.walls().filter(move |&wall| self.wall_index(wall).is_some())
    }

    /// Returns the number of a wall in the order of [`walls`](Self::walls): 2 · i for the north
    /// side and 2 · i + 1 for the east side of the cell with the [number](Self::index) i. Returns
    /// `None` for an outer wall and for a wall outside the maze.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Wall};
    /// let size = MazeSize::new(3, 2)?;
    /// assert_eq!(size.wall_index(Wall::new(Cell::new(2, 0), Heading::West)), Some(3));
    /// assert_eq!(size.wall_index(Wall::new(Cell::new(2, 0), Heading::East)), None);
    /// # Ok::<(), mmsim_maze::SizeError>(())
    /// ```
    #[inline]
    pub fn wall_index(self, Wall { cell, heading }: Wall) -> Option<usize> {
        let side = match heading {
            Heading::North if cell.y < self.height() - 1 => 0,
            Heading::East if cell.x < self.width() - 1 => 1,
            _ => return None,
        };
        Some(2 * self.index(cell)? + side)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn each_wall_has_one_name_and_one_number(
            (width, height) in (1usize..=32, 1usize..=32),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut names = HashSet::new();
            for cell in size.cells() {
                for heading in Heading::ALL {
                    let wall = Wall::new(cell, heading);
                    names.insert(wall);
                    prop_assert!(wall.cells().any(|beside| beside == cell));
                    let Some(neighbour) = size.neighbour(cell, heading) else {
                        prop_assert_eq!(size.wall_index(wall), None);
                        continue;
                    };
                    prop_assert_eq!(wall, Wall::new(neighbour, heading.back()));
                    prop_assert!(wall.cells().eq([cell.min(neighbour), cell.max(neighbour)]));
                    let index = size.wall_index(wall).unwrap();
                    prop_assert_eq!(size.walls().nth(index), Some(wall));
                }
            }
            prop_assert_eq!(names.len(), width * (height + 1) + height * (width + 1));
            let is_inner = |wall: &Wall| size.neighbour(wall.cell, wall.heading).is_some();
            let inner: Vec<_> = size.walls().filter(is_inner).collect();
            prop_assert!(size.inner_walls().eq(inner));
            prop_assert_eq!(size.inner_walls().count(), 2 * width * height - width - height);
        }
    }

    #[test]
    fn walls_at_the_ends_of_the_coordinates_have_one_cell() {
        for (at, heading) in
            [(0, Heading::South), (0, Heading::West), (255, Heading::North), (255, Heading::East)]
        {
            let wall = Wall::new(Cell::new(at, at), heading);
            assert_eq!((wall.cell, wall.heading), (Cell::new(at, at), heading));
            assert!(wall.cells().eq([wall.cell]));
            assert_eq!(MazeSize::HALF_SIZE.wall_index(wall), None);
        }
    }
}
