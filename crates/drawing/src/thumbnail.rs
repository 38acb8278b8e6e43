//! Small pictures of mazes, and of two paths through a maze.

use std::fmt::Write as _;

use mmsim_maze::{Cell, Maze, MazeSize};

use crate::text::decimals;

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
        for run in maze.walls().row_runs(height - y) {
            draw(run.start, y, 'h', run.end - run.start);
        }
    }
    for x in 1..width {
        for run in maze.walls().column_runs(x).rev() {
            draw(x, height - run.end, 'v', run.end - run.start);
        }
    }
    path
}

/// The colours of the first and of the second path in [`two_paths`], for a legend. They suit light
/// and dark pages.
pub const PATH_COLOURS: [&str; 2] = ["#3b82f6", "#db6a15"];

/// The distance of the paths from the centres of the cells, to the north-west and to the south-east,
/// so that both paths are visible where they pass through the same cells. A cell is one unit wide.
const OFFSETS: [f64; 2] = [-0.13, 0.13];

/// The dashes of the paths. The second path is dashed, so that the paths differ without colours.
const DASHES: [&str; 2] = ["", " stroke-dasharray=\".4 .22\""];

/// Returns a small SVG of a maze with two paths, each given as points from start to end: their
/// distances to the east and to the north of the maze's south-west corner, in cells. A ring marks the
/// start of a path, and a disc marks its end. The second path is dashed. Points outside the maze are
/// ignored, and points are rounded to 1/100 of a cell.
///
/// ```
/// use mmsim_drawing::{PATH_COLOURS, two_paths};
/// use mmsim_maze::Maze;
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let path = [(0.5, 0.5), (1.5, 0.5)];
/// let svg = two_paths(&maze, [&path, &path[..1]]);
/// assert!(PATH_COLOURS.iter().all(|colour| svg.contains(colour)));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub fn two_paths(maze: &Maze, paths: [&[(f64, f64)]; 2]) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{}\" role=\"img\" \
         aria-label=\"two paths through a maze\"><g fill-opacity=\".4\">{}</g>",
        view_box(maze.size()),
        walls_and_goal(maze, ".14")
    );
    for (((points, offset), colour), dashes) in
        paths.into_iter().zip(OFFSETS).zip(PATH_COLOURS).zip(DASHES)
    {
        svg.push_str(&draw(maze.size(), points, offset, colour, dashes).unwrap_or_default());
    }
    svg + "</svg>\n"
}

/// A point in hundredths of a cell, to the east and to the south of the north-west corner.
type PicturePoint = (i32, i32);

/// Draws a path, or returns `None` if no point of the path is inside the maze.
fn draw(
    size: MazeSize,
    points: &[(f64, f64)],
    offset: f64,
    colour: &str,
    dashes: &str,
) -> Option<String> {
    let (width, height) = (f64::from(size.width()), f64::from(size.height()));
    let inside = |&&(x, y): &&(f64, f64)| (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
    #[expect(clippy::cast_possible_truncation, reason = "inside the maze")]
    let hundredths = |number: f64| (number * 100.0).round() as i32;
    let to_picture = |&(x, y): &(f64, f64)| (hundredths(x), hundredths(height - y));
    let points: Vec<PicturePoint> = points.iter().filter(inside).map(to_picture).collect();
    let (&first, &last) = (points.first()?, points.last()?);
    let place = |(x, y): PicturePoint| [x, y].map(|place| decimals(cells(place) + offset));
    let ([start_x, start_y], [end_x, end_y]) = (place(first), place(last));
    let line = line(&points);
    Some(format!(
        "<g stroke=\"{colour}\" stroke-width=\".15\" stroke-linejoin=\"round\">\
         <path fill=\"none\"{dashes} d=\"M{start_x} {start_y}{line}\"/>\
         <circle fill=\"none\" cx=\"{start_x}\" cy=\"{start_y}\" r=\".24\"/>\
         <circle fill=\"{colour}\" cx=\"{end_x}\" cy=\"{end_y}\" r=\".18\"/></g>"
    ))
}

fn cells(hundredths: i32) -> f64 {
    f64::from(hundredths) / 100.0
}

/// Returns the lines between the points as path commands relative to the first point. Each command
/// ends where the mouse turns.
fn line(points: &[PicturePoint]) -> String {
    let mut corners: Vec<PicturePoint> = Vec::new();
    for pair in points.windows(2) {
        let (east, south) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let continues = |(x, y): PicturePoint| {
            // The lines are parallel, and neither is a step back.
            x * south == y * east && x * east + y * south > 0
        };
        match corners.last_mut().filter(|last| continues(**last)) {
            Some((x, y)) => (*x, *y) = (*x + east, *y + south),
            None if (east, south) != (0, 0) => corners.push((east, south)),
            None => {}
        }
    }
    let mut path = String::new();
    for (east, south) in corners {
        let [x, y] = [east, south].map(|length| decimals(cells(length)));
        // Writing to a string cannot fail.
        let _ = match (east, south) {
            (_, 0) => write!(path, "h{x}"),
            (0, _) => write!(path, "v{y}"),
            _ => write!(path, "l{x} {y}"),
        };
    }
    path
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use mmsim_maze::{CellSet, Heading, Walls};
    use proptest::prelude::*;

    use super::*;
    use crate::style::colour::Rgb;
    use crate::style::colour::contrast;

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

    /// Returns the centres of cells.
    fn centres(cells: &[(u8, u8)]) -> Vec<(f64, f64)> {
        cells.iter().map(|&(x, y)| (f64::from(x) + 0.5, f64::from(y) + 0.5)).collect()
    }

    #[test]
    fn lines_end_where_the_mouse_turns() {
        for (path, expected) in [
            (&[][..], ""),
            (&[(0, 0)], ""),
            (&[(0, 0), (0, -100), (0, -200), (100, -200), (200, -200), (200, -100)], "v-2h2v1"),
            (&[(0, 0), (0, -100), (0, -100), (0, -300)], "v-3"),
            (&[(0, 0), (0, -200), (0, -100), (0, -200)], "v-2v1v-1"),
            (&[(0, 0), (100, -100), (300, -300), (300, 0)], "l3 -3v3"),
            (&[(50, 50), (57, 50), (60, 51)], "h0.07l0.03 0.01"),
        ] {
            assert_eq!(line(path), expected, "{path:?}");
        }
    }

    #[test]
    fn both_paths_are_drawn_side_by_side() {
        let maze: Maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse().unwrap();
        let path = centres(&[(0, 0), (0, 1), (1, 1)]);
        let svg = two_paths(&maze, [&path, &centres(&[(0, 0), (1, 0)])]);
        insta::assert_snapshot!(svg.replace("><", ">\n<"), @r##"
        <svg xmlns="http://www.w3.org/2000/svg" viewBox="-.2 -.2 2.4 2.4" role="img" aria-label="two paths through a maze">
        <g fill-opacity=".4">
        <path fill="#b46be0" d="M1 0h1v1h-1z"/>
        <path fill="none" stroke="#7b8794" stroke-width=".14" stroke-linecap="square" d="M0 0h2v2H0zm1 1h1"/>
        </g>
        <g stroke="#3b82f6" stroke-width=".15" stroke-linejoin="round">
        <path fill="none" d="M0.37 1.37v-1h1"/>
        <circle fill="none" cx="0.37" cy="1.37" r=".24"/>
        <circle fill="#3b82f6" cx="1.37" cy="0.37" r=".18"/>
        </g>
        <g stroke="#db6a15" stroke-width=".15" stroke-linejoin="round">
        <path fill="none" stroke-dasharray=".4 .22" d="M0.63 1.63h1"/>
        <circle fill="none" cx="0.63" cy="1.63" r=".24"/>
        <circle fill="#db6a15" cx="1.63" cy="1.63" r=".18"/>
        </g>
        </svg>
        "##);
        resvg::usvg::Tree::from_str(&svg, &resvg::usvg::Options::default()).unwrap();
        let outside = two_paths(&maze, [&centres(&[(2, 9), (200, 0)]), &[]]);
        assert!(!outside.contains("<g stroke"), "{outside}");
        let partly = two_paths(&maze, [&centres(&[(9, 9), (0, 0), (9, 0), (0, 1)]), &[]]);
        assert!(partly.contains("d=\"M0.37 1.37v-1\""), "{partly}");
    }

    #[test]
    fn the_colours_suit_light_and_dark_pages() {
        let rgb = |hex: &str| {
            let [_, red, green, blue] = u32::from_str_radix(&hex[1..], 16).unwrap().to_be_bytes();
            Rgb(red, green, blue)
        };
        for colour in PATH_COLOURS {
            for background in ["#ffffff", "#131820"] {
                let contrast = contrast(rgb(colour), rgb(background));
                assert!(contrast >= 3.0, "{colour} on {background}: {contrast:.2}");
            }
        }
    }
}
