//! Mazes as text.

use core::fmt::{self, Formatter, Result, Write};

use crate::cell::{Cell, MazeSize, Pose};
use crate::cell_set::CellSet;
use crate::heading::Heading;
use crate::known::{KnownMaze, Unknown, WallState};
use crate::maze::Maze;
use crate::walls::Walls;

/// A text picture of a maze or of a mouse's map, with north at the top.
///
/// ```text
/// o---o---o
/// | 3   G |     o  a post                     S  the start      G  a goal cell
/// o   o . o     --- and |  a wall             blank  no wall
/// | ^ . 1 |     " . " and .  unknown          ^ > v <  the mouse
/// o---o---o
/// ```
///
/// A cell shows at most one of the following items, in this order of priority: the mouse, a letter,
/// a number, or the marks `S` and `G`. Cells are three characters wide, or wider if a number needs
/// more space. [`str::parse`] can read a picture of a [`Maze`] if the picture contains no numbers,
/// letters or mouse.
///
/// ```
/// use mmsim_maze::{Maze, MazeSize, Walls, Cell, CellSet};
/// let walls = Walls::open(MazeSize::new(2, 1)?);
/// let maze = Maze::new(walls, Cell::new(0, 0), [Cell::new(1, 0)].into_iter().collect())?;
/// let distance = |cell: Cell| Some(1 - u16::from(cell.x));
/// assert_eq!(maze.picture().with_numbers(&distance).to_string(), "\
/// o---o---o
/// | 1   0 |
/// o---o---o
/// ");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
#[must_use]
pub struct TextPicture<'a> {
    /// The walls that are known to be present.
    certain: &'a Walls,
    /// The walls that are known to be present, and the unknown walls.
    possible: &'a Walls,
    start: Cell,
    goals: &'a CellSet,
    numbers: Option<&'a dyn Fn(Cell) -> Option<u16>>,
    letters: Option<&'a dyn Fn(Cell) -> Option<char>>,
    mouse: Option<Pose>,
    /// The width of a cell of a compact picture.
    compact_width: Option<usize>,
}

impl Maze {
    /// Returns a text picture of the maze. Numbers, letters and a mouse can be added to the
    /// picture.
    pub const fn picture(&self) -> TextPicture<'_> {
        TextPicture::new(self.walls(), self.walls(), self.start().cell, self.goals())
    }
}

impl KnownMaze {
    /// Returns a text picture of the map. Numbers, letters and the mouse can be added to the
    /// picture.
    pub const fn picture(&self) -> TextPicture<'_> {
        let (certain, possible) = (self.walls(Unknown::Open), self.walls(Unknown::Closed));
        TextPicture::new(certain, possible, self.start().cell, self.goals())
    }
}

impl fmt::Display for Maze {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        self.picture().fmt(f)
    }
}

impl<'a> TextPicture<'a> {
    const fn new(certain: &'a Walls, possible: &'a Walls, start: Cell, goals: &'a CellSet) -> Self {
        let (numbers, letters, mouse) = (None, None, None);
        let compact_width = None;
        Self { certain, possible, start, goals, numbers, letters, mouse, compact_width }
    }

    /// Shows the numbers that `numbers` returns, such as distances in steps.
    pub const fn with_numbers(mut self, numbers: &'a dyn Fn(Cell) -> Option<u16>) -> Self {
        self.numbers = Some(numbers);
        self
    }

    /// Shows the letters that `letters` returns, such as the directions of a path.
    pub const fn with_letters(mut self, letters: &'a dyn Fn(Cell) -> Option<char>) -> Self {
        self.letters = Some(letters);
        self
    }

    /// Shows the mouse.
    pub const fn with_mouse(mut self, pose: Pose) -> Self {
        self.mouse = Some(pose);
        self
    }

    /// Draws each row of cells on one line, for small screens. South walls are drawn as
    /// underscores; posts and numbers are omitted.
    ///
    /// ```text
    ///  ___ ___
    /// |___  G |
    /// |_^_..._|
    /// ```
    pub const fn compact(mut self) -> Self {
        self.compact_width = Some(3);
        self
    }

    /// Draws a [`compact`](Self::compact) picture of half the width: cells are one character wide,
    /// and a letter or mark hides the south wall of its cell.
    ///
    /// ```text
    ///  _ _
    /// |_ G|
    /// |^._|
    /// ```
    pub const fn narrow(mut self) -> Self {
        self.compact_width = Some(1);
        self
    }

    const fn size(&self) -> MazeSize {
        self.certain.size()
    }

    fn wall(&self, cell: Cell, heading: Heading) -> WallState {
        WallState::from_bounds(self.certain.has(cell, heading), self.possible.has(cell, heading))
    }

    fn number(&self, cell: Cell) -> Option<u16> {
        self.numbers.and_then(|number| number(cell))
    }

    fn has_mouse(&self, cell: Cell) -> bool {
        self.mouse.is_some_and(|pose| pose.cell == cell)
    }

    /// Returns the letter to draw in `cell`. Returns `None` if the cell has no letter or if the
    /// mouse is in the cell.
    fn letter(&self, cell: Cell) -> Option<char> {
        self.letters.and_then(|letter| letter(cell)).filter(|_| !self.has_mouse(cell))
    }

    /// Returns the number of characters between two adjacent posts.
    fn cell_width(&self) -> usize {
        match self.size().cells().filter_map(|cell| self.number(cell)).max() {
            Some(10_000..) => 5,
            Some(1_000..) => 4,
            _ => 3,
        }
    }

    /// Writes a line of posts and walls: the walls on the `heading` side of the cells in row `y`.
    fn write_posts(&self, f: &mut Formatter<'_>, y: u8, heading: Heading, width: usize) -> Result {
        for x in 0..self.size().width() {
            match self.wall(Cell::new(x, y), heading) {
                WallState::Present => write!(f, "o{:-<width$}", "")?,
                WallState::Absent => write!(f, "o{:width$}", "")?,
                WallState::Unknown => write!(f, "o{:^width$}", ".")?,
            }
        }
        f.write_str("o\n")
    }

    fn write_cells(&self, f: &mut Formatter<'_>, y: u8, width: usize) -> Result {
        f.write_char(self.side(Cell::new(0, y), Heading::West))?;
        for x in 0..self.size().width() {
            let cell = Cell::new(x, y);
            match (self.letter(cell), self.number(cell).filter(|_| !self.has_mouse(cell))) {
                (Some(letter), _) => write!(f, "{letter:^width$}")?,
                (None, Some(number)) => write!(f, "{number:^width$}")?,
                (None, None) => write!(f, "{:^width$}", self.mark(cell))?,
            }
            f.write_char(self.side(cell, Heading::East))?;
        }
        f.write_char('\n')
    }

    fn write_compact(&self, f: &mut Formatter<'_>, width: usize) -> Result {
        for _ in 0..self.size().width() {
            write!(f, " {:_<width$}", "")?;
        }
        for y in (0..self.size().height()).rev() {
            f.write_char('\n')?;
            f.write_char(self.side(Cell::new(0, y), Heading::West))?;
            for x in 0..self.size().width() {
                let cell = Cell::new(x, y);
                let east = self.side(cell, Heading::East);
                let mut letter = [0; 4];
                let letter = self.letter(cell).map(|found| &*found.encode_utf8(&mut letter));
                match (self.wall(cell, Heading::South), letter.unwrap_or_else(|| self.mark(cell))) {
                    (WallState::Present, mark) => write!(f, "{mark:_^width$.width$}{east}")?,
                    (WallState::Absent, mark) => write!(f, "{mark:^width$.width$}{east}")?,
                    (WallState::Unknown, mark) => write!(f, "{mark:.^width$.width$}{east}")?,
                }
            }
        }
        f.write_char('\n')
    }

    /// Returns the character for the east or west wall of `cell`.
    fn side(&self, cell: Cell, heading: Heading) -> char {
        match self.wall(cell, heading) {
            WallState::Present => '|',
            WallState::Absent => ' ',
            WallState::Unknown => '.',
        }
    }

    /// Returns the text to draw in a cell that shows no letter and no number.
    fn mark(&self, cell: Cell) -> &'static str {
        if let Some(pose) = self.mouse.filter(|pose| pose.cell == cell) {
            return match pose.heading {
                Heading::North => "^",
                Heading::East => ">",
                Heading::South => "v",
                Heading::West => "<",
            };
        }
        match (self.start == cell, self.goals.contains(cell)) {
            (true, true) => "SG",
            (true, false) => "S",
            (false, true) => "G",
            (false, false) => "",
        }
    }
}

impl fmt::Display for TextPicture<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if let Some(width) = self.compact_width {
            return self.write_compact(f, width);
        }
        let width = self.cell_width();
        for y in (0..self.size().height()).rev() {
            self.write_posts(f, y, Heading::North, width)?;
            self.write_cells(f, y, width)?;
        }
        self.write_posts(f, 0, Heading::South, width)
    }
}

impl fmt::Debug for TextPicture<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::WallsAround;

    fn maze() -> Maze {
        let mut walls = Walls::open(MazeSize::new(3, 2).unwrap());
        walls.set(Cell::new(0, 0), Heading::East, true);
        walls.set(Cell::new(1, 1), Heading::South, true);
        Maze::new(walls, Cell::new(0, 0), [Cell::new(2, 0)].into_iter().collect()).unwrap()
    }

    #[test]
    fn a_maze_is_drawn_with_start_and_goal() {
        insta::assert_snapshot!(maze(), @r"
        o---o---o---o
        |           |
        o   o---o   o
        | S |     G |
        o---o---o---o
        ");
    }

    #[test]
    fn unknown_walls_are_dotted_and_the_mouse_is_an_arrow() {
        let maze = maze();
        let mut map = KnownMaze::unexplored(&maze);
        let pose = Pose::new(Cell::new(0, 1), Heading::East);
        map.observe(maze.start(), maze.walls().around(maze.start())).unwrap();
        map.observe(pose, WallsAround { left: true, front: false, right: false }).unwrap();
        insta::assert_snapshot!(map.picture().with_mouse(pose), @r"
        o---o---o---o
        | >     .   |
        o   o . o . o
        | S |   . G |
        o---o---o---o
        ");
    }

    #[test]
    fn large_numbers_widen_the_cells() {
        let maze = maze();
        let small = |cell: Cell| (cell.y == 0).then(|| u16::from(cell.x) * 60);
        insta::assert_snapshot!(maze.picture().with_numbers(&small), @r"
        o---o---o---o
        |           |
        o   o---o   o
        | 0 |60  120|
        o---o---o---o
        ");
        let large = |cell: Cell| (cell.y == 0).then(|| 7 + u16::from(cell.x) * 12_000);
        let drawing = maze.picture().with_numbers(&large).to_string();
        assert_eq!(drawing.lines().nth(3), Some("|  7  |12007 24007|"));
    }

    #[test]
    fn cells_have_room_for_the_longest_number() {
        let maze = maze();
        for (number, line) in [
            (999, "|999 999 999|"),
            (1000, "|1000 1000 1000|"),
            (9999, "|9999 9999 9999|"),
            (10_000, "|10000 10000 10000|"),
        ] {
            let numbers = |_| Some(number);
            let picture = maze.picture().with_numbers(&numbers);
            let text = picture.to_string();
            assert_eq!(text.lines().nth(1), Some(line));
            assert!(text.lines().all(|row| row.len() == line.len()), "{text}");
            assert_eq!(format!("{picture:?}"), text);
        }
    }

    #[test]
    fn the_arrow_points_where_the_mouse_faces() {
        let maze = maze();
        for (heading, arrow) in Heading::ALL.into_iter().zip(["^", ">", "v", "<"]) {
            let pose = Pose::new(Cell::new(1, 0), heading);
            let picture = maze.picture().with_mouse(pose).to_string();
            let line = format!("| S | {arrow}   G |");
            assert_eq!(picture.lines().nth(3), Some(line.as_str()));
        }
    }

    #[test]
    fn a_compact_picture_has_one_line_per_row() {
        let maze = maze();
        let mut map = KnownMaze::unexplored(&maze);
        map.observe(maze.start(), maze.walls().around(maze.start())).unwrap();
        insta::assert_snapshot!(maze.picture().compact(), @"
         ___ ___ ___
        |    ___    |
        |_S_|___ _G_|
        ");
        insta::assert_snapshot!(map.picture().with_mouse(maze.start()).compact(), @"
         ___ ___ ___
        |   ........|
        |_^_|___._G_|
        ");
    }

    #[test]
    fn a_narrow_picture_has_one_character_per_cell() {
        let maze = maze();
        let mut map = KnownMaze::unexplored(&maze);
        map.observe(maze.start(), maze.walls().around(maze.start())).unwrap();
        insta::assert_snapshot!(maze.picture().narrow(), @"
         _ _ _
        |  _  |
        |S|_ G|
        ");
        insta::assert_snapshot!(map.picture().with_mouse(maze.start()).narrow(), @"
         _ _ _
        | ....|
        |^|_.G|
        ");
    }

    #[test]
    fn the_mouse_replaces_letters_and_letters_replace_numbers() {
        let maze = maze();
        let letter = |cell: Cell| (cell.y == 0).then_some(['R', 'U', 'X'][usize::from(cell.x)]);
        let number = |cell: Cell| Some(u16::from(cell.x));
        let drawing = maze.picture().with_letters(&letter);
        insta::assert_snapshot!(drawing.with_numbers(&number).with_mouse(maze.start()), @r"
        o---o---o---o
        | 0   1   2 |
        o   o---o   o
        | ^ | U   X |
        o---o---o---o
        ");
        insta::assert_snapshot!(drawing.compact(), @"
         ___ ___ ___
        |    ___    |
        |_R_|_U_ _X_|
        ");
    }

    #[test]
    fn a_start_in_the_goal_shows_both_marks() {
        let walls = Walls::open(MazeSize::new(1, 1).unwrap());
        let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
        assert_eq!(maze.to_string(), "o---o\n|SG |\no---o\n");
        assert_eq!(maze.picture().narrow().to_string(), " _\n|S|\n");
    }
}
