//! The walls of a maze, each stored once, and their names and numbers.

use core::ops::Range;

use crate::cell::{Cell, MazeSize, Pose};
use crate::cell_set::Row;
use crate::heading::Heading;

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// All walls of a maze. Each wall is stored once, as the north or east wall of a cell.
///
/// ```text
///    o--north--o
///              |        The walls to the south and west are the north and east walls of the
///       (x, y) east     neighbours there. The outer walls always stand, and a cell outside the
///              |        maze has walls on all sides.
///    o         o
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Walls {
    size: MazeSize,
    /// Bit x of `north[y]` stands for the wall between (x, y) and (x, y + 1). The bits of outer
    /// walls and of cells outside the maze are set, so the last row is always full.
    north: [Row; SIDE],
    /// Bit x of `east[y]` stands for the wall between (x, y) and (x + 1, y). The bits of outer
    /// walls and of cells outside the maze are set, so the last bit of each row is always set.
    east: [Row; SIDE],
}

impl Walls {
    /// Creates the walls of a maze that has only outer walls.
    pub const fn open(size: MazeSize) -> Self {
        Self::from_rows(size, [0; SIDE], [0; SIDE])
    }

    /// Creates the walls of a maze in which every wall is present.
    pub const fn closed(size: MazeSize) -> Self {
        Self { size, north: [Row::MAX; SIDE], east: [Row::MAX; SIDE] }
    }

    /// Creates walls from bits in the layout that [`north_rows`](Self::north_rows) and
    /// [`east_rows`](Self::east_rows) return. Bits for outer walls and for cells outside the maze
    /// are ignored.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
    /// let walls = Walls::from_rows(MazeSize::CLASSIC, [u32::MAX; 32], [0; 32]);
    /// assert!(walls.has(Cell::new(3, 4), Heading::North) && !walls.has(Cell::new(3, 4), Heading::East));
    /// ```
    pub const fn from_rows(size: MazeSize, mut north: [Row; SIDE], mut east: [Row; SIDE]) -> Self {
        let columns = Row::MAX >> (Row::BITS - size.width() as u32);
        let height = size.height() as usize;
        let mut y = 0;
        while y < SIDE {
            north[y] |= if y + 1 < height { !columns } else { Row::MAX };
            east[y] |= if y < height { !(columns >> 1) } else { Row::MAX };
            y += 1;
        }
        Self { size, north, east }
    }

    /// Returns the size.
    pub const fn size(&self) -> MazeSize {
        self.size
    }

    /// Returns the north walls as bits: bit x of element y is set if there is a wall between (x, y)
    /// and (x, y + 1), or if one of these cells is outside the maze.
    pub const fn north_rows(&self) -> &[Row; SIDE] {
        &self.north
    }

    /// Returns the east walls as bits: bit x of element y is set if there is a wall between (x, y)
    /// and (x + 1, y), or if one of these cells is outside the maze.
    pub const fn east_rows(&self) -> &[Row; SIDE] {
        &self.east
    }

    /// Returns true if `cell` has a wall on its `heading` side. Outer walls are always present, and
    /// a cell outside the maze has walls on all sides.
    pub fn has(&self, cell: Cell, heading: Heading) -> bool {
        self.sides(cell).has(heading)
    }

    /// Adds the wall on the `heading` side of `cell` if `present` is true, and removes it
    /// otherwise. Outer walls and walls outside the maze cannot be changed.
    pub fn set(&mut self, cell: Cell, heading: Heading, present: bool) {
        let is_inner = self.size.contains(cell) && self.size.neighbour(cell, heading).is_some();
        if is_inner && self.has(cell, heading) != present {
            self.toggle(cell, Sides(1 << heading as u8));
        }
    }

    /// Returns the sides of `cell` that have a wall. A cell outside the maze has walls on all
    /// sides.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
    /// let sides = Walls::open(MazeSize::CLASSIC).sides(Cell::new(0, 5));
    /// assert!(sides.has(Heading::West) && !sides.has(Heading::East));
    /// ```
    // Avoids branches on walls, because walls are unpredictable.
    pub fn sides(&self, Cell { x, y }: Cell) -> Sides {
        if usize::from(x | y) >= SIDE {
            return Sides::ALL;
        }
        // The last row, which is always full, also stands for the walls to the south of row 0.
        let (row, south) = (usize::from(y) % SIDE, usize::from(y).wrapping_sub(1) % SIDE);
        let bit = |rows: Row| (rows.wrapping_shr(x.into()) & 1) as u8;
        let (north, south) = (bit(self.north[row]), bit(self.north[south]));
        let (east, west) = (bit(self.east[row]), bit(self.east[row] << 1 | 1));
        Sides(north | east << 1 | south << 2 | west << 3)
    }

    /// Toggles the walls on the given sides of a cell. The given sides must not be outer walls.
    pub(crate) fn toggle(&mut self, Cell { x, y }: Cell, sides: Sides) {
        let bit = |heading| Row::from(sides.has(heading)).wrapping_shl(x.into());
        let (row, south) = (usize::from(y) % SIDE, usize::from(y).wrapping_sub(1) % SIDE);
        self.north[row] ^= bit(Heading::North);
        self.north[south] ^= bit(Heading::South);
        // The west wall is the east wall of the neighbour.
        self.east[row] ^= bit(Heading::East) | bit(Heading::West) >> 1;
    }

    /// Returns the walls that a mouse observes at `pose`. A cell outside the maze has walls on all
    /// sides.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Pose, Walls, WallsAround};
    /// let walls = Walls::open(MazeSize::CLASSIC);
    /// let start = Pose::new(Cell::new(0, 0), Heading::North);
    /// assert_eq!(walls.around(start), WallsAround { left: true, front: false, right: false });
    /// ```
    pub fn around(&self, pose: Pose) -> WallsAround {
        self.sides(pose.cell).around(pose.heading)
    }

    /// Returns true if a wall ends at the south-west corner of a cell.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
    /// let mut walls = Walls::open(MazeSize::CLASSIC);
    /// assert!(walls.has_wall_at_corner(Cell::new(0, 3)) && !walls.has_wall_at_corner(Cell::new(3, 3)));
    /// walls.set(Cell::new(2, 3), Heading::South, true);
    /// assert!(walls.has_wall_at_corner(Cell::new(3, 3)));
    /// ```
    pub fn has_wall_at_corner(&self, cell: Cell) -> bool {
        let beyond = Cell::new(cell.x.wrapping_sub(1), cell.y.wrapping_sub(1));
        let has = |cell, [one, other]: [Heading; 2]| self.has(cell, one) || self.has(cell, other);
        has(cell, [Heading::South, Heading::West]) || has(beyond, [Heading::North, Heading::East])
    }

    /// Returns true if the cells are neighbours with a wall between them.
    ///
    /// ```
    /// use mmsim_maze::{Cell, MazeSize, Walls};
    /// let walls = Walls::closed(MazeSize::CLASSIC);
    /// assert!(walls.separate(Cell::new(1, 0), Cell::new(0, 0)));
    /// assert!(!walls.separate(Cell::new(2, 0), Cell::new(0, 0)), "they are not neighbours");
    /// ```
    pub fn separate(&self, one: Cell, other: Cell) -> bool {
        let mut sides = Heading::ALL.into_iter();
        sides.any(|side| one.neighbour(side) == Some(other) && self.has(one, side))
    }

    /// Returns the straight runs of walls between posts in row `y`, from west to east. Post (x, y) is
    /// the south-west corner of cell (x, y); a run leads from the post in column `start` to the post in
    /// column `end`.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
    /// let mut walls = Walls::open(MazeSize::new(3, 2)?);
    /// walls.set(Cell::new(1, 0), Heading::North, true);
    /// walls.set(Cell::new(2, 0), Heading::North, true);
    /// assert!(walls.row_runs(0).eq([0..3]));
    /// assert!(walls.row_runs(1).eq([1..3]));
    /// # Ok::<(), mmsim_maze::SizeError>(())
    /// ```
    pub fn row_runs(&self, y: u8) -> impl DoubleEndedIterator<Item = Range<u8>> + '_ {
        // The cells to the south of row 0 are outside the maze, so they have walls on all sides.
        runs(self.size.width(), move |x| self.has(Cell::new(x, y.wrapping_sub(1)), Heading::North))
    }

    /// Returns the straight runs of walls between posts in column `x`, from south to north, like
    /// [`row_runs`](Self::row_runs).
    pub fn column_runs(&self, x: u8) -> impl DoubleEndedIterator<Item = Range<u8>> + '_ {
        runs(self.size.height(), move |y| self.has(Cell::new(x.wrapping_sub(1), y), Heading::East))
    }

    /// Combines the walls of two mazes, as rows of bits. The result has the size of `self`, and its
    /// outer walls are present.
    ///
    /// ```
    /// use mmsim_maze::{MazeSize, Walls};
    /// let (open, closed) = (Walls::open(MazeSize::CLASSIC), Walls::closed(MazeSize::CLASSIC));
    /// assert_eq!(open.combine(&closed, |one, other| one & other), open);
    /// ```
    #[must_use]
    pub fn combine(&self, other: &Self, bits: impl Fn(Row, Row) -> Row) -> Self {
        let rows = |one: &[Row; SIDE], other: &[Row; SIDE]| {
            core::array::from_fn(|y| bits(one[y], other[y]))
        };
        Self::from_rows(self.size, rows(&self.north, &other.north), rows(&self.east, &other.east))
    }

    /// Returns the neighbours of `cell` on the sides without a wall, in the order north, east,
    /// south, west.
    pub fn open_neighbours(&self, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
        let sides = self.sides(cell);
        Heading::ALL
            .into_iter()
            .filter(move |&heading| !sides.has(heading))
            .filter_map(move |heading| cell.neighbour(heading))
    }
}

/// Returns each run of consecutive walls. `has` returns true if there is a wall between two posts,
/// given the number of the first post.
fn runs(length: u8, has: impl Fn(u8) -> bool + Copy) -> impl DoubleEndedIterator<Item = Range<u8>> {
    let starts = (0..length).filter(move |&at| has(at) && (at == 0 || !has(at - 1)));
    starts.map(move |start| start..(start..length).find(|&at| !has(at)).unwrap_or(length))
}

/// A set of sides of a cell. There is one bit for each side, in the order of [`Heading::ALL`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Sides(u8);

impl Sides {
    pub(crate) const NONE: Self = Self(0);
    const ALL: Self = Self(0b1111);

    /// Creates a set of sides from bits: 1 for north, 2 for east, 4 for south, 8 for west. Other
    /// bits are ignored.
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & Self::ALL.0)
    }

    /// Returns the set as bits: 1 for north, 2 for east, 4 for south, 8 for west.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Returns the sides of a cell that have a wall, given the heading of a mouse and the walls
    /// that it observes. The side behind the mouse is never included.
    // Rotates the bits instead of branching, because the turns of a mouse are unpredictable.
    pub(crate) const fn from_walls_around(heading: Heading, walls: WallsAround) -> Self {
        let WallsAround { left, front, right } = walls;
        let clockwise_from_nose = front as u8 | (right as u8) << 1 | (left as u8) << 3;
        let twice = clockwise_from_nose << 4 | clockwise_from_nose;
        Self(twice >> (4 - heading as u8) & 0b1111)
    }

    /// Returns the walls that a mouse with this heading observes in a cell that has walls on these
    /// sides.
    const fn around(self, heading: Heading) -> WallsAround {
        let clockwise_from_nose = (self.0 << 4 | self.0) >> heading as u8;
        WallsAround {
            left: clockwise_from_nose >> 3 & 1 == 1,
            front: clockwise_from_nose & 1 == 1,
            right: clockwise_from_nose >> 1 & 1 == 1,
        }
    }

    /// Returns true if the set contains the `heading` side.
    pub const fn has(self, heading: Heading) -> bool {
        self.0 >> heading as u8 & 1 == 1
    }

    pub(crate) const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    pub(crate) const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

/// The walls that a mouse observes in its cell. A mouse cannot observe the wall behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WallsAround {
    /// True if there is a wall to the left.
    pub left: bool,
    /// True if there is a wall in front.
    pub front: bool,
    /// True if there is a wall to the right.
    pub right: bool,
}

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

    #[test]
    fn gaps_separate_runs() {
        let walls = [true, false, false, true, true];
        assert!(runs(5, |at| walls[usize::from(at)]).eq([0..1, 3..5]));
        assert!(runs(5, |at| walls[usize::from(at)]).rev().eq([3..5, 0..1]));
        assert_eq!(runs(5, |_| false).count(), 0);
    }

    #[test]
    fn outer_walls_are_fixed_and_outside_is_walled() {
        let mut walls = Walls::open(MazeSize::new(3, 2).unwrap());
        walls.set(Cell::new(0, 0), Heading::South, false);
        walls.set(Cell::new(2, 1), Heading::East, false);
        walls.set(Cell::new(9, 9), Heading::North, false);
        walls.set(Cell::new(3, 1), Heading::West, false);
        assert!(walls.has(Cell::new(0, 0), Heading::South));
        assert!(walls.has(Cell::new(0, 0), Heading::West));
        assert!(walls.has(Cell::new(2, 1), Heading::East));
        assert!(walls.has(Cell::new(2, 1), Heading::North));
        assert!(walls.has(Cell::new(3, 1), Heading::West), "seen from outside");
        assert!(!walls.has(Cell::new(0, 0), Heading::North));
        let largest = Walls::open(MazeSize::HALF_SIZE);
        for (x, y) in [(3, 0), (0, 2), (31, 1), (31, 31), (32, 0), (0, 32), (33, 34), (255, 255)] {
            let cell = Cell::new(x, y);
            assert_eq!(walls.sides(cell), Sides::ALL, "{cell}");
            assert!(x < 32 && y < 32 || largest.sides(cell) == Sides::ALL, "{cell}");
        }
    }

    #[test]
    fn each_side_around_a_pose_is_the_wall_in_its_direction() {
        let cell = Cell::new(1, 1);
        for present in Heading::ALL {
            let mut walls = Walls::open(MazeSize::new(3, 3).unwrap());
            walls.set(cell, present, true);
            for heading in Heading::ALL {
                let WallsAround { left, front, right } = walls.around(Pose::new(cell, heading));
                assert_eq!(left, heading.left() == present, "{heading:?}, {present:?}");
                assert_eq!(front, heading == present, "{heading:?}, {present:?}");
                assert_eq!(right, heading.right() == present, "{heading:?}, {present:?}");
            }
        }
    }

    #[test]
    fn a_mouse_observes_the_walls_that_it_records() {
        for heading in Heading::ALL {
            for bits in 0..8 {
                let [left, front, right] = [1, 2, 4].map(|bit| bits & bit != 0);
                let around = WallsAround { left, front, right };
                let sides = Sides::from_walls_around(heading, around);
                assert_eq!(sides.around(heading), around);
                assert_eq!(sides.has(heading.left()), left);
                assert!(!sides.has(heading.back()), "{heading}");
            }
        }
    }

    #[test]
    fn sides_are_bits_from_north_clockwise() {
        let mut walls = Walls::open(MazeSize::new(3, 3).unwrap());
        walls.set(Cell::new(0, 0), Heading::East, true);
        let bits = |x, y| walls.sides(Cell::new(x, y)).bits();
        assert_eq!([bits(0, 0), bits(1, 0), bits(2, 2), bits(1, 1)], [0b1110, 0b1100, 0b0011, 0]);
        assert_eq!([bits(3, 0), bits(0, 3)], [0b1111; 2]);
        assert_eq!(Sides::from_bits(0b11_0101).bits(), 0b0101);
        let headings = Heading::ALL.map(|heading| Sides::from_bits(0b0110).has(heading));
        assert_eq!(headings, [false, true, true, false]);
        let (first, second) = (Sides::from_bits(0b0011), Sides::from_bits(0b0110));
        assert_eq!(first.or(second).bits(), 0b0111);
        assert_eq!(first.and(second).bits(), 0b0010);
        assert_eq!(first.without(second).bits(), 0b0001);
    }

    #[test]
    fn rows_contain_the_outer_walls_and_the_cells_outside() {
        let size = MazeSize::new(3, 2).unwrap();
        let walls = Walls::from_rows(size, [u32::MAX; SIDE], [u32::MAX; SIDE]);
        assert_eq!(walls.size(), size);
        assert_eq!(walls, Walls::closed(size));
        let (mut north, mut east) = ([u32::MAX; SIDE], [u32::MAX; SIDE]);
        assert_eq!((walls.north_rows(), walls.east_rows()), (&north, &east));
        (north[0], east[0], east[1]) = (!0b111, !0b11, !0b11);
        let walls = Walls::open(size);
        assert_eq!((walls.north_rows(), walls.east_rows()), (&north, &east));
        let walls = Walls::from_rows(size, [0b010; SIDE], {
            let mut rows = [0; SIDE];
            (rows[0], rows[1]) = (0b01, 0b10);
            rows
        });
        assert!(walls.has(Cell::new(1, 0), Heading::North));
        assert!(walls.has(Cell::new(0, 0), Heading::East));
        assert!(walls.has(Cell::new(2, 1), Heading::West));
        assert!(!walls.has(Cell::new(0, 1), Heading::East));
    }

    #[test]
    fn open_neighbours_are_listed_from_north_clockwise() {
        let (mut walls, cell) = (Walls::open(MazeSize::new(3, 3).unwrap()), Cell::new(1, 1));
        let neighbours = [(1, 2), (2, 1), (1, 0), (0, 1)].map(|(x, y)| Cell::new(x, y));
        assert!(walls.open_neighbours(cell).eq(neighbours));
        walls.set(cell, Heading::East, true);
        assert!(walls.open_neighbours(cell).eq([neighbours[0], neighbours[2], neighbours[3]]));
    }

    #[test]
    fn a_closed_maze_has_every_wall() {
        let walls = Walls::closed(MazeSize::HALF_SIZE);
        for cell in MazeSize::HALF_SIZE.cells() {
            assert_eq!(walls.open_neighbours(cell).count(), 0);
        }
    }

    proptest! {
        #[test]
        fn both_cells_agree_on_the_wall_between_them(
            (width, height) in (1usize..=32, 1usize..=32),
            changes in prop::collection::vec((any::<u8>(), any::<u8>(), 0usize..4, any::<bool>()), 0..100),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (x, y, heading, present) in changes {
                let (cell, heading) = (Cell::new(x % 33, y % 33), Heading::ALL[heading]);
                let before = walls.clone();
                walls.set(cell, heading, present);
                if let Some(neighbour) = size.neighbour(cell, heading).filter(|_| size.contains(cell)) {
                    prop_assert_eq!(walls.has(cell, heading), present);
                    prop_assert_eq!(walls.has(neighbour, heading.back()), present);
                    walls.set(neighbour, heading.back(), before.has(cell, heading));
                    prop_assert_eq!(&walls, &before, "other walls are unchanged");
                    walls.set(cell, heading, present);
                } else {
                    prop_assert_eq!(&walls, &before);
                }
            }
        }
    }

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
