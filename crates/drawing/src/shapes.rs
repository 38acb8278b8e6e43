//! The positions of cells in a drawing, and the shapes of marks, mice and trails.

use std::fmt::Write as _;

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Pose};

use crate::text::pair;

/// The width of a cell, in units.
pub(crate) const PITCH: u32 = 20;

/// The margin around the maze, in units.
pub(crate) const MARGIN: u32 = 2;

/// A rectangle, given by the coordinates of its west, north, east and south edges, in units.
pub(crate) type Area = [i32; 4];

/// Returns the width and height of the drawing of a maze, in units.
pub(crate) fn units(size: MazeSize) -> (u32, u32) {
    let length = |cells: u8| u32::from(cells) * PITCH + 2 * MARGIN;
    (length(size.width()), length(size.height()))
}

/// Returns the area of the cell with this north-west corner.
pub(crate) fn cell_area((x, y): (u32, u32)) -> Area {
    let (west, north, pitch) = (x.cast_signed(), y.cast_signed(), PITCH.cast_signed());
    [west, north, west + pitch, north + pitch]
}

/// Returns the bounding box of two areas.
pub(crate) fn around(one: Area, other: Area) -> Area {
    [one[0].min(other[0]), one[1].min(other[1]), one[2].max(other[2]), one[3].max(other[3])]
}

/// Returns the north-west corner of a cell, in units.
pub(crate) fn corner(size: MazeSize, cell: Cell) -> (u32, u32) {
    let row = u32::from(size.height()) - 1 - u32::from(cell.y);
    (u32::from(cell.x) * PITCH, row * PITCH)
}

/// Returns the centre of a cell, in units.
pub(crate) fn centre(size: MazeSize, cell: Cell) -> (u32, u32) {
    let (x, y) = corner(size, cell);
    (x + PITCH / 2, y + PITCH / 2)
}

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
        let place = |(east, south)| pair(f64::from(x) + east, f64::from(y) + south);
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

/// The number of shades of a trail, from the oldest (0) to the newest passages.
pub(crate) const AGES: usize = 6;

/// The minimum number of passages over which a trail fades, so that a short trail is not faint.
pub(crate) const MIN_FADE: usize = 48;

/// The lines of passages that head north, east, south and west, starting at the centre of a cell.
pub(crate) const PASSAGE_LINES: [&str; 4] = ["v-20", "h20", "v20", "h-20"];

/// The arrowheads of passages that head north, east, south and west, starting at the end of the
/// line.
pub(crate) const PASSAGE_ARROWS: [&str; 4] = [
    "m-2.4 10.9l2.4-2.4 2.4 2.4",
    "m-10.9-2.4l2.4 2.4-2.4 2.4",
    "m-2.4-10.9l2.4 2.4 2.4-2.4",
    "m10.9-2.4l-2.4 2.4 2.4 2.4",
];

/// Returns the shade of a passage, given its position in a list of `count` passages in which the
/// oldest passage comes first.
pub(crate) const fn trail_age(position: usize, count: usize) -> usize {
    let fade = if count > MIN_FADE { count } else { MIN_FADE };
    AGES - 1 - (count - 1 - position) * AGES / fade
}

/// Returns the path of a passage. Every second passage of a path has an arrowhead.
pub(crate) fn passage_path(size: MazeSize, Pose { cell: from, heading }: Pose) -> String {
    let ((x, y), index) = (centre(size, from), heading as usize);
    let arrow = if has_arrow(from) { PASSAGE_ARROWS[index] } else { "" };
    format!("M{x} {y}{}{arrow}", PASSAGE_LINES[index])
}

/// Returns true if a passage that leaves this cell has an arrowhead. Neighbouring cells differ, so
/// on any path, every second passage has one.
const fn has_arrow(from: Cell) -> bool {
    from.x % 2 == from.y % 2
}

/// Returns the ID of the gradient with which a passage is drawn.
pub(crate) fn trail_ink(heading: Heading, age: usize) -> String {
    let axis = if matches!(heading, Heading::East | Heading::West) { 'h' } else { 'v' };
    format!("trail-{axis}{age}")
}

/// Returns the gradients with which passages are drawn. A passage is faint where numbers are, in
/// the middle of each cell.
pub(crate) fn trail_gradients() -> String {
    let mut text = String::from("<defs>\n");
    for (heading, end, stops) in [
        (Heading::East, format!("x2=\"{PITCH}\" y2=\"0\""), [".1", ".16", ".84", ".9"]),
        (Heading::North, format!("x2=\"0\" y2=\"{PITCH}\""), [".23", ".29", ".71", ".77"]),
    ] {
        for age in 0..AGES {
            let _ = write!(
                text,
                "<linearGradient id=\"{}\" class=\"ink{age}\" gradientUnits=\"userSpaceOnUse\" \
                 spreadMethod=\"repeat\" x1=\"0\" y1=\"0\" {end}>",
                trail_ink(heading, age)
            );
            for (stop, class) in
                stops.into_iter().zip(["", " class=\"faint\"", " class=\"faint\"", ""])
            {
                let _ = write!(text, "<stop{class} offset=\"{stop}\"/>");
            }
            text.push_str("</linearGradient>\n");
        }
    }
    text + "</defs>\n"
}

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

    #[test]
    fn a_trail_fades_from_its_newest_passage() {
        for count in 1..200 {
            let ages: Vec<usize> = (0..count).map(|position| trail_age(position, count)).collect();
            assert!(ages.is_sorted() && ages[count - 1] == AGES - 1, "{ages:?}");
            assert_eq!(
                ages[0],
                if count >= MIN_FADE { 0 } else { AGES - 1 - (count - 1) * AGES / MIN_FADE }
            );
        }
    }

    #[test]
    fn every_second_passage_has_an_arrowhead() {
        let size = MazeSize::CLASSIC;
        let mut from = Cell::new(3, 4);
        let mut arrows = Vec::new();
        for heading in
            [Heading::North, Heading::North, Heading::East, Heading::South, Heading::West]
        {
            let path = passage_path(size, Pose::new(from, heading));
            arrows.push(path.contains('l'));
            from = from.neighbour(heading).unwrap();
        }
        assert_eq!(arrows, [false, true, false, true, false]);
    }
}
