//! The A* algorithm, which finds a shortest path between two cells.

use core::array::from_fn;

use mmsim_maze::{Cell, Heading, MazeSize, Row, Walls};

/// The number of 64-bit words that hold one bit for each cell of the largest maze.
const WORDS: usize = MazeSize::MAX_AREA / 64;

/// A shortest path between two cells, found by A* with the heuristic |dx| + |dy|.
///
/// # Ties
/// If there are several shortest paths, each step takes the first of the headings west, south, east
/// and north that leads along a shortest path.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Maze};
/// use mmsim_solvers::ShortestPath;
/// let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse()?;
/// let path = ShortestPath::find(maze.walls(), maze.start().cell, Cell::new(1, 1)).unwrap();
/// assert_eq!(path.length(), 2);
/// assert!(path.headings().eq([Heading::East, Heading::North]));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ShortestPath {
    from: Cell,
    length: u16,
    /// The offset from the bit of a cell to the bit of its northern neighbour.
    stride: usize,
    /// For each cell on the path, the heading of the next step as a 2-bit index into
    /// [`PREFERENCE`]. The first array holds the low bits of these indices, and the second array
    /// holds the high bits.
    towards: [[u64; WORDS]; 2],
}

/// The headings, in the order in which ties are broken.
const PREFERENCE: [Heading; 4] = [Heading::West, Heading::South, Heading::East, Heading::North];

impl ShortestPath {
    /// Finds a shortest path between two cells. Returns `None` if there is no path or if either
    /// cell is outside the maze.
    #[must_use]
    pub fn find(walls: &Walls, from: Cell, to: Cell) -> Option<Self> {
        let size = walls.size();
        if !size.contains(from) || !size.contains(to) {
            None
        } else if size.width() <= 16 && size.height() <= 16 {
            LayeredSearch::<4, 16>::new(walls, from).run(to)
        } else {
            LayeredSearch::<WORDS, 32>::new(walls, from).run(to)
        }
    }

    /// Returns the length of the path in steps.
    pub const fn length(&self) -> u16 {
        self.length
    }

    /// Returns the heading of each step, from the first step to the last.
    pub fn headings(&self) -> impl Iterator<Item = Heading> + '_ {
        let mut bit = usize::from(self.from.y) * self.stride + usize::from(self.from.x);
        // Offsets to the bit of the next cell, in a table, because branches would be unpredictable.
        let offsets = [usize::MAX, self.stride.wrapping_neg(), 1, self.stride];
        (0..self.length).map(move |_| {
            let [low, high] = self.towards.map(|plane| (plane[bit / 64 % WORDS] >> (bit % 64)) & 1);
            let towards = usize::from(low == 1) | usize::from(high == 1) << 1;
            bit = bit.wrapping_add(offsets[towards]);
            PREFERENCE[towards]
        })
    }
}

/// A set of cells. Bit x + s · y stands for the cell (x, y), where s is the number of bits per row.
type CellBits<const N: usize> = [u64; N];

/// An A* search that runs backwards: it begins at the last cell of the path and ends at the first
/// cell. For every visited cell, the search finds the heading towards the last cell, so the path
/// can be followed forwards.
///
/// The estimate of A* is the number of steps so far plus the heuristic distance to `end`. A step
/// towards `end` leaves the estimate unchanged, because it reduces the heuristic distance by 1. A
/// step away from `end` increases the estimate by 2. The search therefore needs no heap: a layer
/// consists of all cells with the same estimate, and bit operations expand all cells of a layer
/// together.
struct LayeredSearch<const N: usize, const STRIDE: usize> {
    /// The first cell of the path, at which the search ends.
    end: Cell,
    /// The cells with an open northern side, in two sets: those from which a step north leads
    /// towards `end`, and those from which it leads away from `end`.
    north: [CellBits<N>; 2],
    /// The cells with an open eastern side, in two sets: those from which a step east leads towards
    /// `end`, and those from which it leads away from `end`.
    east: [CellBits<N>; 2],
}

impl<const N: usize, const STRIDE: usize> LayeredSearch<N, STRIDE> {
    fn new(walls: &Walls, end: Cell) -> Self {
        let west_of_end: Row = (1 << end.x) - 1;
        let (mut north, mut east) = ([[0; N]; 2], [[0; N]; 2]);
        for y in 0..walls.size().height().into() {
            let (word, shift) = (y * STRIDE / 64, y * STRIDE % 64);
            let towards = usize::from(y >= end.y.into());
            north[towards][word] |= u64::from(!walls.north_rows()[y]) << shift;
            let open = !walls.east_rows()[y];
            east[0][word] |= u64::from(open & west_of_end) << shift;
            east[1][word] |= u64::from(open & !west_of_end) << shift;
        }
        Self { end, north, east }
    }

    fn run(&self, begin: Cell) -> Option<ShortestPath> {
        let Self { end, north: [north, south], east: [east, west] } = self;
        let guess = end.x.abs_diff(begin.x) + end.y.abs_diff(begin.y);
        let mut layer = [0; N];
        layer[Self::bit(begin) / 64] = 1 << (Self::bit(begin) % 64);
        let (mut settled, mut odd) = (layer, [0; N]);
        for more in 0_u16.. {
            let mut wave = layer;
            while wave != [0; N] {
                let found = Self::step(&wave, north, south, east, west);
                wave = from_fn(|i| found[i] & !settled[i]);
                settled = from_fn(|i| settled[i] | wave[i]);
                layer = from_fn(|i| layer[i] | wave[i]);
            }
            if more % 2 == 1 {
                odd = from_fn(|i| odd[i] | layer[i]);
            }
            if (settled[Self::bit(*end) / 64] >> (Self::bit(*end) % 64)) & 1 == 1 {
                let length = u16::from(guess) + 2 * more;
                let towards = self.towards(&settled, &odd);
                return Some(ShortestPath { from: *end, length, stride: STRIDE, towards });
            }
            let found = Self::step(&layer, south, north, west, east);
            layer = from_fn(|i| found[i] & !settled[i]);
            if layer == [0; N] {
                break;
            }
            settled = from_fn(|i| settled[i] | layer[i]);
        }
        None
    }

    /// Returns the cells that are one step away from `cells`. Steps north are taken only from the
    /// cells in `north`, and steps east only from the cells in `east`. Steps south are taken only
    /// to the cells in `south`, and steps west only to the cells in `west`.
    fn step(
        cells: &CellBits<N>,
        north: &CellBits<N>,
        south: &CellBits<N>,
        east: &CellBits<N>,
        west: &CellBits<N>,
    ) -> CellBits<N> {
        let (to_north, to_south) = (up::<N, STRIDE>(&and(cells, north)), down::<N, STRIDE>(cells));
        from_fn(|i| {
            to_north[i]
                | to_south[i] & south[i]
                | (cells[i] & east[i]) << 1
                | cells[i] >> 1 & west[i]
        })
    }

    /// For each cell in `settled`, returns the heading of the next step on a shortest path to the
    /// last cell. The headings are encoded as in [`ShortestPath`]. `odd` contains the cells of
    /// `settled` in the second, fourth, sixth, … layers.
    ///
    /// A step away from `end` is part of a shortest path to the last cell if both of its cells have
    /// the same A* estimate. A step towards `end` is part of a shortest path if the estimates of
    /// its two cells differ. Connected neighbours are in the same layer or in successive layers, so
    /// `odd` is enough to compare their estimates.
    fn towards(&self, settled: &CellBits<N>, odd: &CellBits<N>) -> [[u64; WORDS]; 2] {
        let Self { north: [north, south], east: [east, west], .. } = self;
        let (south_odd, south_settled) = (up::<N, STRIDE>(odd), up::<N, STRIDE>(settled));
        let (south_near, south_away) = (up::<N, STRIDE>(south), up::<N, STRIDE>(north));
        let on = |near: u64, away: u64, settled: u64, other: u64, odd: u64| {
            (near | away) & settled & (other ^ odd ^ away)
        };
        let mut towards = [[0; WORDS]; 2];
        for i in 0..N {
            let goes_west = on(west[i] << 1, east[i] << 1, settled[i] << 1, odd[i] << 1, odd[i]);
            let goes_south =
                on(south_near[i], south_away[i], south_settled[i], south_odd[i], odd[i]);
            let goes_east = on(east[i], west[i], settled[i] >> 1, odd[i] >> 1, odd[i]);
            towards[0][i] = !goes_west & (goes_south | !goes_east);
            towards[1][i] = !goes_west & !goes_south;
        }
        towards
    }

    const fn bit(cell: Cell) -> usize {
        cell.y as usize * STRIDE + cell.x as usize
    }
}

fn and<const N: usize>(cells: &CellBits<N>, others: &CellBits<N>) -> CellBits<N> {
    from_fn(|i| cells[i] & others[i])
}

/// Replaces each cell of a set with its northern neighbour.
fn up<const N: usize, const STRIDE: usize>(cells: &CellBits<N>) -> CellBits<N> {
    from_fn(|i| cells[i] << STRIDE | if i > 0 { cells[i - 1] >> (64 - STRIDE) } else { 0 })
}

/// Replaces each cell of a set with its southern neighbour.
fn down<const N: usize, const STRIDE: usize>(cells: &CellBits<N>) -> CellBits<N> {
    from_fn(|i| cells[i] >> STRIDE | if i + 1 < N { cells[i + 1] << (64 - STRIDE) } else { 0 })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::flood::Distances;

    /// Follows the path cell by cell and returns its length.
    fn follow(walls: &Walls, from: Cell, to: Cell) -> Option<u16> {
        let path = ShortestPath::find(walls, from, to)?;
        let mut here = from;
        for heading in path.headings() {
            assert!(!walls.has(here, heading), "through the {heading} side of {here}");
            here = here.neighbour(heading).unwrap();
        }
        assert_eq!((here, path.headings().count()), (to, path.length().into()));
        Some(path.length())
    }

    proptest! {
        #[test]
        fn a_path_is_as_long_as_the_flood_says(
            (width, height) in (1usize..=32, 1usize..=32),
            present in prop::collection::vec(prop::bool::weighted(0.35), 2 * MazeSize::MAX_AREA),
            (from, to) in ((0u8..32, 0u8..32), (0u8..32, 0u8..32)),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (wall, present) in size.walls().zip(present) {
                walls.set(wall.cell, wall.heading, present);
            }
            let (from, to) = (Cell::new(from.0, from.1), Cell::new(to.0, to.1));
            let flood = Distances::flood(&walls, &[to].into_iter().collect());
            prop_assert_eq!(follow(&walls, from, to), flood.at(from));
        }
    }

    #[test]
    fn finds_the_longest_path_of_a_32x32_maze() {
        let size = MazeSize::HALF_SIZE;
        let mut walls = Walls::open(size);
        for y in 0..31 {
            let gap = if y % 2 == 0 { 31 } else { 0 };
            for x in (0..32).filter(|&x| x != gap) {
                walls.set(Cell::new(x, y), Heading::North, true);
            }
        }
        assert_eq!(follow(&walls, Cell::new(0, 0), Cell::new(0, 31)), Some(1023));
        assert_eq!(follow(&walls, Cell::new(0, 31), Cell::new(0, 0)), Some(1023));
    }

    #[test]
    fn ties_are_broken_as_documented() {
        let walls = Walls::open(MazeSize::new(3, 3).unwrap());
        let path = |from, to| {
            let path = ShortestPath::find(&walls, from, to).unwrap();
            path.headings().map(Heading::letter).collect::<String>()
        };
        let (south_west, north_east) = (Cell::new(0, 0), Cell::new(2, 2));
        assert_eq!(path(south_west, north_east), "EENN");
        assert_eq!(path(north_east, south_west), "WWSS");
        assert_eq!(path(south_west, south_west), "");
        for outside in [Cell::new(3, 0), Cell::new(17, 0), Cell::new(0, 17)] {
            assert!(ShortestPath::find(&walls, south_west, outside).is_none());
            assert!(ShortestPath::find(&walls, outside, south_west).is_none());
            assert!(ShortestPath::find(&walls, outside, outside).is_none());
        }
    }
}
