//! Where a mouse may stand, in half steps, and the eight ways it may go.

use mmsim_maze::{Cell, Heading};

/// A place in a maze, counted in half cells from its south-west post.
///
/// ```text
///   o-----1,2-----o-----3,2-----o
///   |             |             |       odd, odd     the centre of a cell
///  0,1    1,1    2,1    3,1    4,1      one is even  the place of a wall
///   |             |             |       even, even   a post
///   o-----1,0-----o-----3,0-----o
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridPoint {
    /// Half cells from the west edge.
    pub x: u8,
    /// Half cells from the south edge.
    pub y: u8,
}

/// What may stand at a [`GridPoint`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nothing: the centre of a cell.
    Centre,
    /// A post.
    Post,
    /// The wall at this side of this cell, if there is one.
    Wall(Cell, Heading),
}

impl GridPoint {
    /// The centre of a cell. Of cells beyond 127 there is none, which stands for the last of them.
    pub const fn centre(cell: Cell) -> Self {
        let Cell { x, y } = cell;
        Self { x: x.saturating_mul(2).saturating_add(1), y: y.saturating_mul(2).saturating_add(1) }
    }

    /// The cell it is counted to: of a wall's place the one to the north or east, as mms does.
    pub const fn cell(self) -> Cell {
        Cell::new(self.x / 2, self.y / 2)
    }

    /// Half a step on, to the side and ahead at once on a diagonal; `None` where a coordinate would
    /// leave 0 to 255.
    pub fn ahead(self, bearing: Bearing) -> Option<Self> {
        let (east, north) = bearing.half_step();
        Some(Self { x: self.x.checked_add_signed(east)?, y: self.y.checked_add_signed(north)? })
    }

    /// What may stand here.
    pub const fn place(self) -> Place {
        let Cell { x, y } = self.cell();
        match (self.x % 2, self.y % 2) {
            (1, 1) => Place::Centre,
            (0, 0) => Place::Post,
            // The wall belongs to the cell before it, unless it is the outer one.
            (0, _) if x == 0 => Place::Wall(Cell::new(x, y), Heading::West),
            (0, _) => Place::Wall(Cell::new(x - 1, y), Heading::East),
            (..) if y == 0 => Place::Wall(Cell::new(x, y), Heading::South),
            (..) => Place::Wall(Cell::new(x, y - 1), Heading::North),
        }
    }
}

/// One of eight directions: the four headings and the diagonals between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bearing {
    /// Eighths of a turn clockwise from north, 0 to 7.
    eighths: u8,
}

impl Bearing {
    /// Where a mouse heads at the start.
    pub const NORTH: Self = Self { eighths: 0 };

    /// The bearing after a turn of so many eighths clockwise, or where less than 0 the other way.
    pub const fn turned(self, eighths: i8) -> Self {
        Self { eighths: self.eighths.wrapping_add_signed(eighths) % 8 }
    }

    /// The heading, on a diagonal the one an eighth to its left: nothing is nearer.
    ///
    /// ```
    /// use mmsim_maze::Heading;
    /// use mmsim_mms::Bearing;
    /// assert_eq!(Bearing::NORTH.turned(2).heading(), Heading::East);
    /// assert_eq!(Bearing::NORTH.turned(1).heading(), Heading::North);
    /// assert_eq!(Bearing::NORTH.turned(-1).heading(), Heading::West);
    /// ```
    pub const fn heading(self) -> Heading {
        const CLOCKWISE: [Heading; 4] = Heading::ALL;
        CLOCKWISE[self.eighths as usize / 2 % 4]
    }

    /// Half cells to the east and to the north.
    const fn half_step(self) -> (i8, i8) {
        match self.eighths {
            0 => (0, 1),
            1 => (1, 1),
            2 => (1, 0),
            3 => (1, -1),
            4 => (0, -1),
            5 => (-1, -1),
            6 => (-1, 0),
            _ => (-1, 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_as_drawn() {
        let place = |x, y| GridPoint { x, y }.place();
        assert_eq!(place(1, 1), Place::Centre);
        assert_eq!(place(2, 0), Place::Post);
        assert_eq!(place(0, 1), Place::Wall(Cell::new(0, 0), Heading::West));
        assert_eq!(place(2, 1), Place::Wall(Cell::new(0, 0), Heading::East));
        assert_eq!(place(4, 1), Place::Wall(Cell::new(1, 0), Heading::East));
        assert_eq!(place(3, 0), Place::Wall(Cell::new(1, 0), Heading::South));
        assert_eq!(place(3, 2), Place::Wall(Cell::new(1, 0), Heading::North));
        assert_eq!(GridPoint { x: 3, y: 2 }.cell(), Cell::new(1, 1), "to the north of the wall");
        assert_eq!(GridPoint::centre(Cell::new(31, 0)), GridPoint { x: 63, y: 1 });
        assert_eq!(GridPoint { x: 0, y: 1 }.ahead(Bearing::NORTH.turned(-2)), None);
    }

    #[test]
    fn eight_turns_go_round() {
        for eighths in [1, -1] {
            let mut bearing = Bearing::NORTH;
            let (mut east, mut north) = (0, 0);
            for _ in 0..8 {
                let (x, y) = bearing.half_step();
                (east, north) = (east + x, north + y);
                bearing = bearing.turned(eighths);
            }
            assert_eq!((bearing, east, north), (Bearing::NORTH, 0, 0));
        }
        assert_eq!(Bearing::NORTH.turned(-2).turned(4), Bearing::NORTH.turned(2));
        assert_eq!(Bearing::NORTH.turned(i8::MIN), Bearing::NORTH);
    }
}
