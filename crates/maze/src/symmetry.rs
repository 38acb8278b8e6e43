//! The rotations and reflections of a maze.

use core::fmt;

use crate::cell::{Cell, MazeSize};

/// A rotation or reflection of a maze, or its identity.
///
/// ```
/// use mmsim_maze::{Maze, Symmetry};
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let turned: Maze = "o---o\n| S |\no   o\n| G |\no---o\n".parse()?;
/// assert_eq!(maze.transformed(Symmetry::Clockwise), turned);
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Symmetry {
    /// Changes nothing.
    Identity,
    /// Rotates by 90° clockwise.
    Clockwise,
    /// Rotates by 180°.
    HalfTurn,
    /// Rotates by 90° anticlockwise.
    Anticlockwise,
    /// Swaps east and west.
    MirrorEastWest,
    /// Swaps north and south.
    MirrorNorthSouth,
    /// Swaps north and east, and south and west.
    MirrorNorthEast,
    /// Swaps north and west, and south and east.
    MirrorNorthWest,
}

impl Symmetry {
    /// All rotations and reflections. The identity is first, the reflections are last.
    pub const ALL: [Self; 8] = [
        Self::Identity,
        Self::Clockwise,
        Self::HalfTurn,
        Self::Anticlockwise,
        Self::MirrorEastWest,
        Self::MirrorNorthSouth,
        Self::MirrorNorthEast,
        Self::MirrorNorthWest,
    ];

    /// Returns the size of a maze after the transformation.
    pub const fn size(self, size: MazeSize) -> MazeSize {
        match self {
            Self::Identity | Self::HalfTurn | Self::MirrorEastWest | Self::MirrorNorthSouth => size,
            _ => size.transposed(),
        }
    }

    /// Returns the position of a cell after the transformation. The cell must be inside a maze of
    /// this size.
    pub(crate) const fn cell(self, Cell { x, y }: Cell, size: MazeSize) -> Cell {
        let (from_east, from_north) = (size.width() - 1 - x, size.height() - 1 - y);
        match self {
            Self::Identity => Cell::new(x, y),
            Self::Clockwise => Cell::new(y, from_east),
            Self::HalfTurn => Cell::new(from_east, from_north),
            Self::Anticlockwise => Cell::new(from_north, x),
            Self::MirrorEastWest => Cell::new(from_east, y),
            Self::MirrorNorthSouth => Cell::new(x, from_north),
            Self::MirrorNorthEast => Cell::new(y, x),
            Self::MirrorNorthWest => Cell::new(from_north, from_east),
        }
    }
}

impl fmt::Display for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Identity => "unchanged",
            Self::Clockwise => "rotated by 90° clockwise",
            Self::HalfTurn => "rotated by 180°",
            Self::Anticlockwise => "rotated by 90° anticlockwise",
            Self::MirrorEastWest => "mirrored, east and west swapped",
            Self::MirrorNorthSouth => "mirrored, north and south swapped",
            Self::MirrorNorthEast => "mirrored, north and east swapped",
            Self::MirrorNorthWest => "mirrored, north and west swapped",
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::Maze;

    const MAZE: &str = "\
o---o---o---o
| G     |   |
o   o---o   o
| S         |
o---o---o---o
";

    fn maze() -> Maze {
        MAZE.parse().unwrap()
    }

    #[test]
    fn each_symmetry_gives_another_maze() {
        let all: HashSet<Maze> = Symmetry::ALL.map(|to| maze().transformed(to)).into();
        assert_eq!(all.len(), 8);
        insta::assert_snapshot!(maze().transformed(Symmetry::Clockwise), @r"
        o---o---o
        | S   G |
        o   o   o
        |   |   |
        o   o---o
        |       |
        o---o---o
        ");
        insta::assert_snapshot!(maze().transformed(Symmetry::MirrorEastWest), @r"
        o---o---o---o
        |   |     G |
        o   o---o   o
        |         S |
        o---o---o---o
        ");
        insta::assert_snapshot!(maze().transformed(Symmetry::MirrorNorthEast), @r"
        o---o---o
        |       |
        o   o---o
        |   |   |
        o   o   o
        | S   G |
        o---o---o
        ");
    }

    #[test]
    fn each_symmetry_has_an_inverse() {
        for symmetry in Symmetry::ALL {
            let inverse = match symmetry {
                Symmetry::Clockwise => Symmetry::Anticlockwise,
                Symmetry::Anticlockwise => Symmetry::Clockwise,
                own => own,
            };
            let moved = maze().transformed(symmetry);
            assert_eq!(moved.size(), symmetry.size(maze().size()));
            assert_eq!(moved.transformed(inverse), maze(), "{symmetry}");
        }
    }

    #[test]
    fn two_symmetries_in_turn_are_one_symmetry() {
        let images = Symmetry::ALL.map(|to| maze().transformed(to));
        for (first, second) in Symmetry::ALL.into_iter().flat_map(|a| Symmetry::ALL.map(|b| (a, b)))
        {
            let moved = maze().transformed(first).transformed(second);
            assert!(images.contains(&moved), "{first}, {second}");
        }
    }
}
