//! The drawing of a trail: a line with arrowheads that fades with age.

use std::fmt::Write as _;

use mmsim_maze::{Cell, Heading, MazeSize, Pose};

use crate::geometry::{PITCH, centre};

/// The number of shades of a trail, from the oldest (0) to the newest passages.
pub(crate) const AGES: usize = 6;

/// The minimum number of passages over which a trail fades, so that a short trail is not faint.
pub(crate) const MIN_FADE: usize = 48;

/// The lines of passages that head north, east, south and west, starting at the centre of a cell.
pub(crate) const LINES: [&str; 4] = ["v-20", "h20", "v20", "h-20"];

/// The arrowheads of passages that head north, east, south and west, starting at the end of the
/// line.
pub(crate) const ARROWS: [&str; 4] = [
    "m-2.4 10.9l2.4-2.4 2.4 2.4",
    "m-10.9-2.4l2.4 2.4-2.4 2.4",
    "m-2.4-10.9l2.4 2.4 2.4-2.4",
    "m10.9-2.4l-2.4 2.4 2.4 2.4",
];

/// Returns the shade of a passage, given its position in a list of `count` passages in which the
/// oldest passage comes first.
pub(crate) const fn age(position: usize, count: usize) -> usize {
    let fade = if count > MIN_FADE { count } else { MIN_FADE };
    AGES - 1 - (count - 1 - position) * AGES / fade
}

/// Returns the path of a passage. Every second passage of a path has an arrowhead.
pub(crate) fn path(size: MazeSize, Pose { cell: from, heading }: Pose) -> String {
    let ((x, y), index) = (centre(size, from), heading as usize);
    let arrow = if has_arrow(from) { ARROWS[index] } else { "" };
    format!("M{x} {y}{}{arrow}", LINES[index])
}

/// Returns true if a passage that leaves this cell has an arrowhead. Neighbouring cells differ, so
/// on any path, every second passage has one.
const fn has_arrow(from: Cell) -> bool {
    from.x % 2 == from.y % 2
}

/// Returns the ID of the gradient with which a passage is drawn.
pub(crate) fn ink(heading: Heading, age: usize) -> String {
    let axis = if matches!(heading, Heading::East | Heading::West) { 'h' } else { 'v' };
    format!("trail-{axis}{age}")
}

/// Returns the gradients with which passages are drawn. A passage is faint where numbers are, in
/// the middle of each cell.
pub(crate) fn gradients() -> String {
    let mut text = String::from("<defs>\n");
    for (heading, end, stops) in [
        (Heading::East, format!("x2=\"{PITCH}\" y2=\"0\""), [".13", ".19", ".81", ".87"]),
        (Heading::North, format!("x2=\"0\" y2=\"{PITCH}\""), [".23", ".29", ".71", ".77"]),
    ] {
        for age in 0..AGES {
            let _ = write!(
                text,
                "<linearGradient id=\"{}\" class=\"ink{age}\" gradientUnits=\"userSpaceOnUse\" \
                 spreadMethod=\"repeat\" x1=\"0\" y1=\"0\" {end}>",
                ink(heading, age)
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
    use super::*;

    #[test]
    fn a_trail_fades_from_its_newest_passage() {
        for count in 1..200 {
            let ages: Vec<usize> = (0..count).map(|position| age(position, count)).collect();
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
            let path = path(size, Pose::new(from, heading));
            arrows.push(path.contains('l'));
            from = from.neighbour(heading).unwrap();
        }
        assert_eq!(arrows, [false, true, false, true, false]);
    }
}
