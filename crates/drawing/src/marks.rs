//! The shapes that mark the start, the goals and the mouse.

use std::fmt::Write as _;

use mmsim_maze::{Cell, CellSet, Heading, MazeSize};

use crate::font::decimals;
use crate::geometry::{PITCH, centre};

/// Returns the part of the frame around `cells` that lies in `cell`. A line runs just inside each
/// side of `cell`, unless the cell beyond that side is also in `cells`.
pub(crate) fn frame(size: MazeSize, cell: Cell, cells: &CellSet) -> String {
    const INSET: f64 = 1.9;
    let (x, y) = centre(size, cell);
    let has = |cell: Option<Cell>| cell.is_some_and(|cell| cells.contains(cell));
    let mut path = String::new();
    for side in Heading::ALL.into_iter().filter(|&side| !has(cell.neighbour(side))) {
        let outside = cell.neighbour(side);
        // The length of the line from the middle of the side towards a corner. At the corner the
        // frame turns inwards, continues straight, or turns outwards in the next cell.
        let reach = |along: Heading| {
            let half = f64::from(PITCH) / 2.0;
            match (has(cell.neighbour(along)), has(outside.and_then(|cell| cell.neighbour(along))))
            {
                (false, _) => half - INSET,
                (true, false) => half,
                (true, true) => half + INSET,
            }
        };
        let out = f64::from(PITCH) / 2.0 - INSET;
        let (left, right) = (reach(side.left()), reach(side.right()));
        // Offsets to the east and to the south from the centre of the cell.
        let point = |way: f64| match side {
            Heading::North => (way, -out),
            Heading::East => (out, way),
            Heading::South => (-way, out),
            Heading::West => (-out, -way),
        };
        let (from, to) = (point(-left), point(right));
        let place = |(east, south): (f64, f64)| {
            let (x, y) = (f64::from(x) + east, f64::from(y) + south);
            format!("{} {}", decimals(x), decimals(y))
        };
        let _ = write!(path, "M{}L{}", place(from), place(to));
    }
    path
}

/// The path of the letter S, 3.4 units high, centred on the current point.
pub(crate) const LETTER_S: &str = "m1-1.2c-.2-.3-.6-.5-1.1-.5-.7 0-1.1.3-1.1.8 0 1.2 2.4.5 2.4 1.7 0 .6-.5.9-1.2.9-.5 0-1-.2-1.2-.5";
/// The path of the letter G, 3.4 units high, centred on the current point.
pub(crate) const LETTER_G: &str =
    "m1.2-1c-.2-.4-.6-.7-1.1-.7-.9 0-1.4.7-1.4 1.7s.5 1.7 1.4 1.7c.7 0 1.2-.5 1.2-1.4h-1.1";

/// The path of a mouse that faces north, seen from above: a tapering body, two ears and two eyes.
pub(crate) const MOUSE: &str = "M0-8.4C1.9-7 3.2-5.2 3.7-3.5A2.5 2.5 0 1 1 5.5.8C5.9 2 6 3.2 5.6 4.4 4.9 6.6 2.7 7.8 0 7.8S-4.9 6.6-5.6 4.4C-6 3.2-5.9 2-5.5.8A2.5 2.5 0 1 1-3.7-3.5C-3.2-5.2-1.9-7 0-8.4ZM-1.6-3.4a.3.3 0 1 0 .01 0zM1.6-3.4a.3.3 0 1 0 .01 0z";

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_frame_around_any_cells_is_closed(bits in any::<u32>()) {
            let size = MazeSize::new(6, 5).unwrap();
            let cells: CellSet =
                size.cells().enumerate().filter(|(bit, _)| bits >> bit & 1 == 1).map(|(_, cell)| cell).collect();
            let path: String = cells.iter().map(|cell| frame(size, cell, &cells)).collect();
            let mut ends = HashMap::new();
            for end in path.split(['M', 'L']).skip(1) {
                *ends.entry(end).or_insert(0) += 1;
            }
            prop_assert!(ends.values().all(|count| count % 2 == 0), "{path}");
        }
    }

    #[test]
    fn a_frame_stays_inside_the_walls() {
        let cells: CellSet = [Cell::new(0, 0), Cell::new(1, 0)].into_iter().collect();
        let size = MazeSize::new(2, 1).unwrap();
        insta::assert_snapshot!(frame(size, Cell::new(0, 0), &cells), @"M1.9 1.9L20 1.9M20 18.1L1.9 18.1M1.9 18.1L1.9 1.9");
    }
}
