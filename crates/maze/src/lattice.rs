//! Lattice points, half a cell apart, and the eight directions between them.

use core::fmt;

use crate::cell::Cell;
use crate::heading::Heading;
use crate::walls::Walls;

/// A point of the lattice with a spacing of half a cell.
///
/// ```text
///    even i: a post or the middle of a west or east wall
///    odd i:  the middle of a north or south wall, or the centre of a cell
///
///   (0, 2) o---(1, 2)---o (2, 2)        The south-west corner of the maze is (0, 0), and the
///          |            |               centre of the cell (x, y) is (2x + 1, 2y + 1).
///       (0, 1) (1, 1) (2, 1)
///          |            |
///   (0, 0) o---(1, 0)---o (2, 0)
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Point {
    /// The number of half cells to the east of the maze's west wall.
    pub i: u8,
    /// The number of half cells to the north of the maze's south wall.
    pub j: u8,
}

impl Point {
    /// Returns the centre of a cell. If a coordinate of the cell is above 127, that coordinate of
    /// the result is 255.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Point};
    /// assert_eq!(Point::centre(Cell::new(3, 0)), Point { i: 7, j: 1 });
    /// ```
    #[inline]
    pub const fn centre(Cell { x, y }: Cell) -> Self {
        Self { i: x.saturating_mul(2).saturating_add(1), j: y.saturating_mul(2).saturating_add(1) }
    }

    /// Returns the cell whose centre is this point, if the point is a centre.
    #[inline]
    pub const fn cell(self) -> Option<Cell> {
        if self.i % 2 == 1 && self.j % 2 == 1 {
            Some(Cell::new(self.i / 2, self.j / 2))
        } else {
            None
        }
    }

    /// Returns the wall whose middle is this point, as the cell to the north or east of the wall
    /// and the side of that cell. Returns `None` for centres and posts.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, Point};
    /// assert_eq!(Point { i: 2, j: 1 }.wall(), Some((Cell::new(1, 0), Heading::West)));
    /// ```
    #[inline]
    pub const fn wall(self) -> Option<(Cell, Heading)> {
        let cell = Cell::new(self.i / 2, self.j / 2);
        match (self.i % 2, self.j % 2) {
            (0, 1) => Some((cell, Heading::West)),
            (1, 0) => Some((cell, Heading::South)),
            _ => None,
        }
    }

    /// Returns true if a mouse can be at this point: the centre of a cell of the maze, or the
    /// middle of an absent wall.
    #[inline]
    pub fn is_free(self, walls: &Walls) -> bool {
        match (self.cell(), self.wall()) {
            (Some(cell), _) => walls.size().contains(cell),
            (None, Some((cell, heading))) => !walls.has(cell, heading),
            (None, None) => false,
        }
    }

    /// Returns the point `steps` lattice steps away in the given direction, or `None` if a
    /// coordinate would be less than 0 or greater than 255.
    #[inline]
    pub fn advanced(self, direction: Direction, steps: u8) -> Option<Self> {
        let (east, north) = direction.vector();
        let steps = i16::from(steps);
        self.shifted(i16::from(east) * steps, i16::from(north) * steps)
    }

    /// Returns the point `east` half cells to the east and `north` half cells to the north, or `None`
    /// if a coordinate would be less than 0 or greater than 255.
    #[inline]
    pub fn shifted(self, east: i16, north: i16) -> Option<Self> {
        let i = u8::try_from(i16::from(self.i).checked_add(east)?).ok()?;
        let j = u8::try_from(i16::from(self.j).checked_add(north)?).ok()?;
        Some(Self { i, j })
    }
}

/// One of the eight directions in which a mouse drives straight. North, east, south and west are
/// *along* the rows and columns of cells, the others are *diagonal*.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// The direction of increasing y.
    North,
    /// Between north and east.
    NorthEast,
    /// The direction of increasing x.
    East,
    /// Between south and east.
    SouthEast,
    /// The direction of decreasing y.
    South,
    /// Between south and west.
    SouthWest,
    /// The direction of decreasing x.
    West,
    /// Between north and west.
    NorthWest,
}

impl Direction {
    /// All directions, clockwise from north.
    pub const ALL: [Self; 8] = [
        Self::North,
        Self::NorthEast,
        Self::East,
        Self::SouthEast,
        Self::South,
        Self::SouthWest,
        Self::West,
        Self::NorthWest,
    ];

    /// Returns true for north-east, south-east, south-west and north-west.
    #[inline]
    pub const fn is_diagonal(self) -> bool {
        self as u8 % 2 == 1
    }

    /// Returns the direction after a turn to the right by `eighths` times 45°. Negative numbers
    /// turn left.
    ///
    /// ```
    /// use mmsim_maze::Direction;
    /// assert_eq!(Direction::North.turned(3), Direction::SouthEast);
    /// assert_eq!(Direction::North.turned(-1), Direction::NorthWest);
    /// ```
    #[inline]
    #[must_use]
    pub const fn turned(self, eighths: i8) -> Self {
        Self::ALL[(self as i8).wrapping_add(eighths).rem_euclid(8) as usize]
    }

    /// Returns the lattice step in this direction as (east, north), each -1, 0 or 1.
    #[inline]
    pub const fn vector(self) -> (i8, i8) {
        const VECTORS: [(i8, i8); 8] =
            [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];
        VECTORS[self as usize]
    }

    /// Returns the angle in radians, counterclockwise from east.
    pub fn angle(self) -> f64 {
        core::f64::consts::FRAC_PI_4 * (2.0 - f64::from(self as u8))
    }

    /// Returns the abbreviation: `N`, `NE`, `E`, `SE`, `S`, `SW`, `W` or `NW`.
    pub const fn abbreviation(self) -> &'static str {
        ["N", "NE", "E", "SE", "S", "SW", "W", "NW"][self as usize]
    }
}

impl From<Heading> for Direction {
    #[inline]
    fn from(heading: Heading) -> Self {
        Self::ALL[2 * heading as usize]
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.abbreviation())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::MazeSize;

    #[test]
    fn points_are_free_where_there_is_no_wall() {
        let size = MazeSize::new(3, 2).unwrap();
        let mut walls = Walls::open(size);
        walls.set(Cell::new(1, 0), Heading::North, true);
        let free = |i, j| Point { i, j }.is_free(&walls);
        let picture: Vec<String> = (0..=4)
            .rev()
            .map(|j| (0..=6).map(|i| if free(i, j) { '.' } else { '#' }).collect())
            .collect();
        assert_eq!(picture, ["#######", "#.....#", "#.###.#", "#.....#", "#######"]);
        for (i, j) in [(7, 1), (8, 1), (1, 5), (1, 6), (255, 255), (64, 65)] {
            assert!(!free(i, j), "({i}, {j})");
        }
    }

    #[test]
    fn points_are_shifted_within_the_coordinates() {
        let point = Point { i: 3, j: 255 };
        assert_eq!(point.shifted(-3, -255), Some(Point { i: 0, j: 0 }));
        for (east, north) in
            [(-4, 0), (0, 1), (253, 0), (i16::MAX, 0), (0, i16::MAX), (i16::MIN, 0)]
        {
            assert_eq!(point.shifted(east, north), None, "{east} {north}");
        }
    }

    #[test]
    fn points_match_the_drawing() {
        let place = |i, j| (Point { i, j }.cell(), Point { i, j }.wall());
        assert_eq!(place(3, 1), (Some(Cell::new(1, 0)), None), "a centre");
        assert_eq!(place(2, 0), (None, None), "a post");
        assert_eq!(place(0, 1), (None, Some((Cell::new(0, 0), Heading::West))));
        assert_eq!(place(4, 1), (None, Some((Cell::new(2, 0), Heading::West))));
        assert_eq!(place(3, 2), (None, Some((Cell::new(1, 1), Heading::South))));
        assert_eq!(Point::centre(Cell::new(31, 0)), Point { i: 63, j: 1 });
    }

    #[test]
    fn directions_turn_and_point_clockwise() {
        for (index, direction) in Direction::ALL.into_iter().enumerate() {
            assert_eq!(direction as usize, index);
            for full_turns in [8, -8, 120, i8::MIN] {
                assert_eq!(direction.turned(full_turns), direction);
            }
            let (east, north) = direction.vector();
            let (sin, cos) = direction.angle().sin_cos();
            let scale = if direction.is_diagonal() { 2_f64.sqrt() } else { 1.0 };
            assert!((f64::from(east) - cos * scale).abs() < 1e-12, "{direction}");
            assert!((f64::from(north) - sin * scale).abs() < 1e-12, "{direction}");
        }
        assert_eq!(Direction::from(Heading::West), Direction::West);
    }

    #[test]
    fn points_advance_within_bounds() {
        let point = Point { i: 2, j: 1 };
        assert_eq!(point.advanced(Direction::NorthWest, 2), Some(Point { i: 0, j: 3 }));
        assert_eq!(point.advanced(Direction::South, 2), None);
        assert_eq!(Point { i: 255, j: 0 }.advanced(Direction::East, 1), None);
    }
}
