//! Pictures of two paths through a maze.

use std::fmt::Write as _;

use mmsim_maze::{Cell, Maze, MazeSize};

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

/// Returns a small SVG of a maze with two paths, each given as the cells from start to end. A ring
/// marks the start of a path, and a disc marks its end. The second path is dashed. Cells outside the
/// maze are ignored. Cells that are not neighbours are connected by a straight line.
///
/// ```
/// use mmsim_drawing::{PATH_COLOURS, two_paths};
/// use mmsim_maze::{Cell, Maze};
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let path = [Cell::new(0, 0), Cell::new(1, 0)];
/// let svg = two_paths(&maze, [&path, &path[..1]]);
/// assert!(PATH_COLOURS.iter().all(|colour| svg.contains(colour)));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub fn two_paths(maze: &Maze, paths: [&[Cell]; 2]) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{}\" role=\"img\" \
         aria-label=\"two paths through a maze\"><g fill-opacity=\".4\">{}</g>",
        view_box(maze.size()),
        walls_and_goal(maze, ".14")
    );
    for (((cells, offset), colour), dashes) in
        paths.into_iter().zip(OFFSETS).zip(PATH_COLOURS).zip(DASHES)
    {
        svg.push_str(&draw(maze.size(), cells, offset, colour, dashes).unwrap_or_default());
    }
    svg + "</svg>\n"
}

/// Draws a path, or returns `None` if no cell of the path is inside the maze.
fn draw(size: MazeSize, cells: &[Cell], offset: f64, colour: &str, dashes: &str) -> Option<String> {
    let cells: Vec<Cell> = cells.iter().copied().filter(|&cell| size.contains(cell)).collect();
    let (&first, &last) = (cells.first()?, cells.last()?);
    let point = |cell: Cell| {
        let row = f64::from(size.height() - 1 - cell.y);
        [f64::from(cell.x), row].map(|place| decimals(place + 0.5 + offset))
    };
    let ([start_x, start_y], [end_x, end_y]) = (point(first), point(last));
    let line = line(&cells);
    Some(format!(
        "<g stroke=\"{colour}\" stroke-width=\".15\" stroke-linejoin=\"round\">\
         <path fill=\"none\"{dashes} d=\"M{start_x} {start_y}{line}\"/>\
         <circle fill=\"none\" cx=\"{start_x}\" cy=\"{start_y}\" r=\".24\"/>\
         <circle fill=\"{colour}\" cx=\"{end_x}\" cy=\"{end_y}\" r=\".18\"/></g>"
    ))
}

/// Returns the lines between the cells as path commands relative to the first cell. Each command
/// ends where the mouse turns.
fn line(cells: &[Cell]) -> String {
    let mut corners: Vec<(i16, i16)> = Vec::new();
    for pair in cells.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|cell| (i16::from(cell.x), -i16::from(cell.y)));
        let (east, south) = (to.0 - from.0, to.1 - from.1);
        let continues = |(x, y): (i16, i16)| {
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
        // Writing to a string cannot fail.
        let _ = match (east, south) {
            (east, 0) => write!(path, "h{east}"),
            (0, south) => write!(path, "v{south}"),
            (east, south) => write!(path, "l{east} {south}"),
        };
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heat::Rgb;
    use crate::heat::tests::contrast;

    fn cells(cells: &[(u8, u8)]) -> Vec<Cell> {
        cells.iter().map(|&(x, y)| Cell::new(x, y)).collect()
    }

    #[test]
    fn lines_end_where_the_mouse_turns() {
        for (path, expected) in [
            (&[][..], ""),
            (&[(0, 0)], ""),
            (&[(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1)], "v-2h2v1"),
            (&[(0, 0), (0, 1), (0, 1), (0, 3)], "v-3"),
            (&[(0, 0), (0, 2), (0, 1), (0, 2)], "v-2v1v-1"),
            (&[(0, 0), (1, 1), (3, 3), (3, 0)], "l3 -3v3"),
        ] {
            assert_eq!(line(&cells(path)), expected, "{path:?}");
        }
    }

    #[test]
    fn both_paths_are_drawn_side_by_side() {
        let maze: Maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse().unwrap();
        let path = cells(&[(0, 0), (0, 1), (1, 1)]);
        let svg = two_paths(&maze, [&path, &cells(&[(0, 0), (1, 0)])]);
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
        let outside = two_paths(&maze, [&cells(&[(2, 9), (200, 0)]), &[]]);
        assert!(!outside.contains("<g stroke"), "{outside}");
        let partly = two_paths(&maze, [&cells(&[(9, 9), (0, 0), (9, 0), (0, 1)]), &[]]);
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
