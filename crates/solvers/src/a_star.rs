//! A*: a shortest way between two cells.

use mmsim_maze::{Cell, Heading, MazeSize, Walls};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// A shortest way between two cells, found by A* with the heuristic |dx| + |dy|.
///
/// # Ties
/// The search goes from the target back, so it guesses the steps to the cell where the way begins.
/// Of the cells that look equally near it takes the one found last, and it looks at the neighbours
/// to the south, east, west and north, in this order. The first way found to a cell stays.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Maze};
/// use mmsim_solvers::ShortestPath;
/// let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse()?;
/// let path = ShortestPath::find(maze.walls(), maze.start().cell, Cell::new(1, 1)).unwrap();
/// assert_eq!(path.length(), 2);
/// assert!(path.headings().eq([Heading::East, Heading::North]));
/// # Ok::<(), mmsim_maze::ParseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ShortestPath {
    from: Cell,
    length: u16,
    /// For each cell on the way where it goes on; row by row from the south, 32 cells wide.
    towards: [Heading; MazeSize::MAX_AREA],
}

impl ShortestPath {
    /// A shortest way between the cells; `None` where there is none and where a cell lies outside
    /// of the maze.
    pub fn find(walls: &Walls, from: Cell, to: Cell) -> Option<Self> {
        let size = walls.size();
        if !size.contains(from) || !size.contains(to) {
            return None;
        }
        let mut search = Search::new(walls, from);
        let guess = from.x.abs_diff(to.x) + from.y.abs_diff(to.y);
        let more = search.run(to)?;
        Some(Self { from, length: u16::from(guess) + more, towards: search.towards })
    }

    /// Its length in steps.
    pub const fn length(&self) -> u16 {
        self.length
    }

    /// Where each step goes, from the first to the last.
    pub fn headings(&self) -> impl Iterator<Item = Heading> + '_ {
        let mut cell = Some(self.from);
        (0..self.length).map_while(move |_| {
            let here = cell?;
            let heading = self.towards[number(here)];
            cell = here.neighbour(heading);
            Some(heading)
        })
    }
}

/// With a consistent heuristic and steps of 1, a step either comes nearer to the end by the guess,
/// and the length of the way through it stays what it was, or it does not, and the way becomes
/// longer by 2. So what others keep in a heap are two stacks here: the cells on ways of the length
/// now tried, each of which is settled as soon as it is found, and those on ways longer by 2.
struct Search {
    end: Cell,
    /// Bit x of row y + 1: the way from (x, y) to the north is open.
    north: [u32; SIDE + 1],
    /// Bit x of row y: the way from (x, y) to the east is open.
    east: [u32; SIDE],
    /// Bit x of row y: a shortest way to the cell is known.
    settled: [u32; SIDE],
    /// Bit x of row y: the cell is, or was, among those for later.
    queued: [u32; SIDE],
    towards: [Heading; MazeSize::MAX_AREA],
    now: Stack<Cell>,
    later: Stack<(Cell, Heading)>,
}

impl Search {
    fn new(walls: &Walls, end: Cell) -> Self {
        let (width, height) = (u32::from(walls.size().width()), usize::from(walls.size().height()));
        let columns = u32::MAX >> (32 - width);
        let mut north = [0; SIDE + 1];
        for (open, walls) in north[1..height].iter_mut().zip(walls.north_rows()) {
            *open = !walls & columns;
        }
        Self {
            end,
            north,
            east: walls.east_rows().map(|walls| !walls & columns >> 1),
            settled: [0; SIDE],
            queued: [0; SIDE],
            towards: [Heading::North; MazeSize::MAX_AREA],
            now: Stack::new(Cell::new(0, 0)),
            later: Stack::new((Cell::new(0, 0), Heading::North)),
        }
    }

    /// Steps more than guessed from `begin` to the end, `None` where there is no way.
    fn run(&mut self, begin: Cell) -> Option<u16> {
        let mut more = 0;
        self.settle(begin, Heading::North);
        loop {
            while let Some(cell) = self.now.pop() {
                if cell == self.end {
                    return Some(more);
                }
                self.look_around(cell);
            }
            if self.later.count == 0 {
                return None;
            }
            more += 2;
            // In the order in which they were found, so that the one found last is on top.
            for index in 0..core::mem::take(&mut self.later.count) {
                let (cell, from) = self.later.items[index];
                if self.settled[row(cell)] >> cell.x & 1 == 0 {
                    self.settle(cell, from);
                }
            }
        }
    }

    fn look_around(&mut self, cell: Cell) {
        let Cell { x, y } = cell;
        let is_open = |row: u32, x: u8| row >> x & 1 == 1;
        if is_open(self.north[usize::from(y) % SIDE], x) {
            self.find(Cell::new(x, y.wrapping_sub(1)), Heading::South, y > self.end.y);
        }
        if is_open(self.east[row(cell)], x) {
            self.find(Cell::new(x + 1, y), Heading::East, x < self.end.x);
        }
        if x > 0 && is_open(self.east[row(cell)], x - 1) {
            self.find(Cell::new(x - 1, y), Heading::West, x > self.end.x);
        }
        if is_open(self.north[usize::from(y) + 1], x) {
            self.find(Cell::new(x, y + 1), Heading::North, y < self.end.y);
        }
    }

    /// Takes note of a cell that was found by going this way.
    #[inline]
    fn find(&mut self, cell: Cell, heading: Heading, is_nearer: bool) {
        let bit = 1 << cell.x;
        if self.settled[row(cell)] & bit != 0 {
            return;
        }
        if is_nearer {
            self.settle(cell, heading);
        } else if self.queued[row(cell)] & bit == 0 {
            self.queued[row(cell)] |= bit;
            self.later.push((cell, heading));
        }
    }

    #[inline]
    fn settle(&mut self, cell: Cell, heading: Heading) {
        self.settled[row(cell)] |= 1 << cell.x;
        self.towards[number(cell)] = heading.back();
        self.now.push(cell);
    }
}

/// Cells, each at most once.
struct Stack<T> {
    items: [T; MazeSize::MAX_AREA],
    count: usize,
}

impl<T: Copy> Stack<T> {
    const fn new(filler: T) -> Self {
        Self { items: [filler; MazeSize::MAX_AREA], count: 0 }
    }

    #[inline]
    fn push(&mut self, item: T) {
        self.items[self.count % MazeSize::MAX_AREA] = item;
        self.count += 1;
    }

    #[inline]
    fn pop(&mut self) -> Option<T> {
        self.count = self.count.checked_sub(1)?;
        Some(self.items[self.count % MazeSize::MAX_AREA])
    }
}

const fn row(cell: Cell) -> usize {
    cell.y as usize % SIDE
}

const fn number(cell: Cell) -> usize {
    row(cell) * SIDE + cell.x as usize % SIDE
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Distances;

    /// The length of the way, followed cell by cell.
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
        fn a_way_is_as_long_as_the_flood_says(
            (width, height) in (1usize..=32, 1usize..=32),
            present in prop::collection::vec(prop::bool::weighted(0.35), 2 * MazeSize::MAX_AREA),
            (from, to) in ((0u8..32, 0u8..32), (0u8..32, 0u8..32)),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (cell, present) in size.cells().zip(present.chunks(2)) {
                walls.set(cell, Heading::North, present[0]);
                walls.set(cell, Heading::East, present[1]);
            }
            let (from, to) = (Cell::new(from.0, from.1), Cell::new(to.0, to.1));
            let flood = Distances::flood(&walls, &[to].into_iter().collect());
            prop_assert_eq!(follow(&walls, from, to), flood.at(from));
        }
    }

    #[test]
    fn the_longest_way_of_a_32x32_maze_is_found() {
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
        let way = |from, to| {
            let path = ShortestPath::find(&walls, from, to).unwrap();
            path.headings().map(Heading::letter).collect::<String>()
        };
        let (south_west, north_east) = (Cell::new(0, 0), Cell::new(2, 2));
        assert_eq!(way(south_west, north_east), "NNEE");
        assert_eq!(way(north_east, south_west), "WWSS");
        assert_eq!(way(south_west, south_west), "");
        let outside = Cell::new(3, 0);
        assert!(ShortestPath::find(&walls, south_west, outside).is_none());
        assert!(ShortestPath::find(&walls, outside, outside).is_none());
    }
}
