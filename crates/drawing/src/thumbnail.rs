//! Thumbnails of mazes.

use std::fmt::Write as _;

use mmsim_maze::{Cell, Heading, Maze, MazeSize};

/// Returns a small SVG of a maze, about 1.5 KB for a classic maze. All walls are drawn as one path,
/// and the goal cells are filled. The background is transparent, and the colours suit light and
/// dark pages.
///
/// ```
/// let maze: mmsim_maze::Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let svg = mmsim_drawing::thumbnail(&maze);
/// assert!(svg.contains(r#"viewBox="-.2 -.2 2.4 1.4""#));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub fn thumbnail(maze: &Maze) -> String {
    let (view_box, maze) = (view_box(maze.size()), walls_and_goal(maze, ".24"));
    format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{view_box}\">{maze}</svg>\n")
}

/// Returns the view box of a small picture, in which a cell is one unit wide.
pub(crate) fn view_box(size: MazeSize) -> String {
    format!("-.2 -.2 {}.4 {}.4", size.width(), size.height())
}

/// Draws the goal cells and the walls, in colours that suit light and dark pages.
pub(crate) fn walls_and_goal(maze: &Maze, wall_width: &str) -> String {
    let height = maze.size().height();
    let mut goals = String::new();
    for cell in maze.goals() {
        let _ = write!(goals, "M{} {}h1v1h-1z", cell.x, row(height, cell));
    }
    format!(
        "<path fill=\"{GOAL}\" d=\"{goals}\"/>\
         <path fill=\"none\" stroke=\"{WALL}\" stroke-width=\"{wall_width}\" stroke-linecap=\"square\" d=\"{}\"/>",
        walls(maze)
    )
}

/// A grey that is visible both on black and on white.
const WALL: &str = "#7b8794";
const GOAL: &str = "#b46be0";

/// Returns the number of rows north of a cell.
fn row(height: u8, cell: Cell) -> u8 {
    height - 1 - cell.y
}

/// Returns all walls as one path, in which a cell is one unit wide. The path contains the outer
/// walls, followed by the straight runs of inner walls. Each run is positioned relative to the end
/// of the previous run.
fn walls(maze: &Maze) -> String {
    let (width, height) = (maze.size().width(), maze.size().height());
    let mut path = format!("M0 0h{width}v{height}H0z");
    let mut pen = (0, 0);
    let mut draw = |x: u8, y: u8, letter: char, length: u8| {
        let to = (i16::from(x), i16::from(y));
        let (right, down) = (to.0 - pen.0, to.1 - pen.1);
        let gap = if down < 0 { "" } else { " " };
        let _ = write!(path, "m{right}{gap}{down}{letter}{length}");
        // A line moves the pen to its end.
        let length = i16::from(length);
        pen = if letter == 'h' { (to.0 + length, to.1) } else { (to.0, to.1 + length) };
    };
    for y in 1..height {
        let below = |x| maze.walls().has(Cell::new(x, height - 1 - y), Heading::North);
        for (x, length) in runs(width, below) {
            draw(x, y, 'h', length);
        }
    }
    for x in 1..width {
        let left = |y| maze.walls().has(Cell::new(x - 1, height - 1 - y), Heading::East);
        for (y, length) in runs(height, left) {
            draw(x, y, 'v', length);
        }
    }
    path
}

/// Returns the start and the length of each run of consecutive walls in a row or column.
fn runs(cells: u8, has: impl Fn(u8) -> bool) -> Vec<(u8, u8)> {
    let mut runs: Vec<(u8, u8)> = Vec::new();
    for cell in (0..cells).filter(|&cell| has(cell)) {
        match runs.last_mut() {
            Some((from, length)) if *from + *length == cell => *length += 1,
            _ => runs.push((cell, 1)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use mmsim_maze::{CellSet, Walls};
    use proptest::prelude::*;

    use super::*;

    /// A wall segment: its start, and whether it runs east (true) or south (false).
    type Piece = (i32, i32, bool);

    /// Parses a path into wall segments of one cell.
    fn pieces(path: &str) -> BTreeSet<Piece> {
        let mut pieces = BTreeSet::new();
        let (mut x, mut y) = (0, 0);
        let mut rest = path;
        while let Some(letter) = rest.chars().next() {
            let end =
                rest[1..].find(|c: char| c.is_ascii_alphabetic()).map_or(rest.len(), |at| at + 1);
            let numbers = rest[1..end].replace('-', " -");
            let numbers: Vec<i32> =
                numbers.split_whitespace().map(|number| number.parse().unwrap()).collect();
            rest = &rest[end..];
            let (to_x, to_y) = match (letter, &numbers[..]) {
                ('M', &[x, y]) => (x, y),
                ('m', &[east, south]) => (x + east, y + south),
                ('h', &[length]) => (x + length, y),
                ('v', &[length]) => (x, y + length),
                ('H', &[x]) => (x, y),
                ('z', []) => (0, 0),
                other => panic!("{other:?}"),
            };
            if !letter.eq_ignore_ascii_case(&'m') {
                pieces.extend((x.min(to_x)..x.max(to_x)).map(|x| (x, y, true)));
                pieces.extend((y.min(to_y)..y.max(to_y)).map(|y| (x, y, false)));
            }
            (x, y) = (to_x, to_y);
        }
        pieces
    }

    fn path(svg: &str) -> &str {
        svg.rsplit(" d=\"").next().unwrap().split('"').next().unwrap()
    }

    proptest! {
        #[test]
        fn the_path_contains_exactly_the_walls(
            (width, height) in (1usize..=32, 1usize..=32),
            stands in prop::collection::vec(any::<bool>(), 2 * MazeSize::MAX_AREA),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut walls = Walls::open(size);
            for (wall, stands) in size.walls().zip(stands) {
                walls.set(wall.cell, wall.heading, stands);
            }
            let mut expected = BTreeSet::new();
            for cell in size.cells() {
                let (x, y) = (i32::from(cell.x), i32::from(size.height() - 1 - cell.y));
                for (heading, piece) in [
                    (Heading::North, (x, y, true)),
                    (Heading::East, (x + 1, y, false)),
                    (Heading::South, (x, y + 1, true)),
                    (Heading::West, (x, y, false)),
                ] {
                    if walls.has(cell, heading) {
                        expected.insert(piece);
                    }
                }
            }
            let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
            prop_assert_eq!(pieces(path(&thumbnail(&maze))), expected);
        }
    }

    #[test]
    fn a_small_maze_is_a_small_text() {
        let maze: Maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse().unwrap();
        insta::assert_snapshot!(thumbnail(&maze), @r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="-.2 -.2 2.4 2.4"><path fill="#b46be0" d="M1 0h1v1h-1z"/><path fill="none" stroke="#7b8794" stroke-width=".24" stroke-linecap="square" d="M0 0h2v2H0zm1 1h1"/></svg>"##);
    }
}
