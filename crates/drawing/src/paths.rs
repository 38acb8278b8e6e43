//! Pictures of two paths through a maze.

use std::fmt::Write as _;

use mmsim_maze::{Maze, MazeSize};

use crate::font::decimals;
use crate::thumbnail::{view_box, walls_and_goal};

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
type GridPoint = (i32, i32);

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
    let to_grid = |&(x, y): &(f64, f64)| (hundredths(x), hundredths(height - y));
    let points: Vec<GridPoint> = points.iter().filter(inside).map(to_grid).collect();
    let (&first, &last) = (points.first()?, points.last()?);
    let place = |(x, y): GridPoint| [x, y].map(|place| decimals(cells(place) + offset));
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
fn line(points: &[GridPoint]) -> String {
    let mut corners: Vec<GridPoint> = Vec::new();
    for pair in points.windows(2) {
        let (east, south) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let continues = |(x, y): GridPoint| {
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
    use super::*;
    use crate::style::colour::Rgb;
    use crate::style::colour::tests::contrast;

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
