//! Positions in half cells, and the eight directions of movement.

use mmsim_maze::{Cell, Heading, Wall};

/// A position in a maze, in half cells from the south-west corner of the maze.
///
/// ```text
///   o-----1,2-----o-----3,2-----o
///   |             |             |       odd, odd     the centre of a cell
///  0,1    1,1    2,1    3,1    4,1      one is even  between two cells, where a wall may be
///   |             |             |       even, even   a post
///   o-----1,0-----o-----3,0-----o
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridPoint {
    /// The number of half cells from the west edge.
    pub x: u8,
    /// The number of half cells from the south edge.
    pub y: u8,
}

/// The possible locations of a [`GridPoint`]: the centre of a cell, a post or a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridPointKind {
    /// The centre of a cell.
    Centre,
    /// A post.
    Post,
    /// The middle of a wall, which may be absent.
    Wall(Wall),
}

impl GridPoint {
    /// Returns the centre of a cell. If a coordinate of the cell is above 127, that coordinate of
    /// the result is 255.
    pub const fn centre(cell: Cell) -> Self {
        let Cell { x, y } = cell;
        Self { x: x.saturating_mul(2).saturating_add(1), y: y.saturating_mul(2).saturating_add(1) }
    }

    /// Returns the cell that contains the point. A point between two cells belongs to the northern
    /// or eastern cell, as in mms.
    pub const fn cell(self) -> Cell {
        Cell::new(self.x / 2, self.y / 2)
    }

    /// Returns the point half a step ahead, or `None` if a coordinate would be outside the range 0
    /// to 255. On a diagonal, both coordinates change.
    pub fn ahead(self, direction: CompassDirection) -> Option<Self> {
        let (east, north) = direction.half_step();
        Some(Self { x: self.x.checked_add_signed(east)?, y: self.y.checked_add_signed(north)? })
    }

    /// Returns whether the point is the centre of a cell, a post or the middle of a wall.
    pub const fn kind(self) -> GridPointKind {
        match (self.x % 2, self.y % 2) {
            (1, 1) => GridPointKind::Centre,
            (0, 0) => GridPointKind::Post,
            (0, _) => GridPointKind::Wall(Wall::new(self.cell(), Heading::West)),
            (..) => GridPointKind::Wall(Wall::new(self.cell(), Heading::South)),
        }
    }
}

/// One of eight directions: the four headings and the diagonals between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompassDirection {
    /// The angle in eighths of a turn clockwise from north, 0 to 7.
    eighths: u8,
}

impl CompassDirection {
    /// North, the initial direction of a mouse.
    pub const NORTH: Self = Self { eighths: 0 };

    /// Returns the direction after turning by `eighths` eighths of a turn, clockwise if positive.
    pub const fn turned(self, eighths: i8) -> Self {
        Self { eighths: self.eighths.wrapping_add_signed(eighths) % 8 }
    }

    /// Returns the heading. For a diagonal, returns the next heading counterclockwise.
    ///
    /// ```
    /// use mmsim_maze::Heading;
    /// use mmsim_mms::CompassDirection;
    /// assert_eq!(CompassDirection::NORTH.turned(2).heading(), Heading::East);
    /// assert_eq!(CompassDirection::NORTH.turned(1).heading(), Heading::North);
    /// assert_eq!(CompassDirection::NORTH.turned(-1).heading(), Heading::West);
    /// ```
    pub const fn heading(self) -> Heading {
        const CLOCKWISE: [Heading; 4] = Heading::ALL;
        CLOCKWISE[self.eighths as usize / 2 % 4]
    }

    /// Returns the east and north components of half a step, in half cells.
    const fn half_step(self) -> (i8, i8) {
        const HALF_STEPS: [(i8, i8); 8] =
            [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];
        HALF_STEPS[self.eighths as usize % 8]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_match_the_drawing() {
        let kind = |x, y| GridPoint { x, y }.kind();
        let wall = |x, y, side| GridPointKind::Wall(Wall::new(Cell::new(x, y), side));
        assert_eq!(kind(1, 1), GridPointKind::Centre);
        assert_eq!(kind(2, 0), GridPointKind::Post);
        assert_eq!(kind(0, 1), wall(0, 0, Heading::West));
        assert_eq!(kind(2, 1), wall(0, 0, Heading::East));
        assert_eq!(kind(4, 1), wall(1, 0, Heading::East));
        assert_eq!(kind(3, 0), wall(1, 0, Heading::South));
        assert_eq!(kind(3, 2), wall(1, 0, Heading::North));
        assert_eq!(GridPoint { x: 3, y: 2 }.cell(), Cell::new(1, 1), "the cell to the north");
        assert_eq!(GridPoint::centre(Cell::new(31, 0)), GridPoint { x: 63, y: 1 });
        assert_eq!(GridPoint { x: 0, y: 1 }.ahead(CompassDirection::NORTH.turned(-2)), None);
    }

    #[test]
    fn eight_turns_are_a_full_circle() {
        for eighths in [1, -1] {
            let mut direction = CompassDirection::NORTH;
            let (mut east, mut north) = (0, 0);
            for _ in 0..8 {
                let (x, y) = direction.half_step();
                (east, north) = (east + x, north + y);
                direction = direction.turned(eighths);
            }
            assert_eq!((direction, east, north), (CompassDirection::NORTH, 0, 0));
        }
        assert_eq!(CompassDirection::NORTH.turned(-2).turned(4), CompassDirection::NORTH.turned(2));
        assert_eq!(CompassDirection::NORTH.turned(i8::MIN), CompassDirection::NORTH);
    }
}
