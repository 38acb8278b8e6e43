//! An animation of a search as a piece of HTML that needs no server and no other file.

use std::fmt::Write as _;
use std::hash::{BuildHasher, RandomState};

use mmsim_maze::{Cell, Heading, Maze, Pose, Wall};
use mmsim_protocol::{CellWalls, State};

/// The script that draws the states.
const SCRIPT: &str = include_str!("animation.js");

/// The width and height of a cell, as in the script.
const CELL: i32 = 20;

/// What the animation shows of a state.
pub(crate) struct AnimatedState {
    pose: Pose,
    /// The weight and the flags of each cell, in the order of [`MazeSize::cells`](mmsim_maze::MazeSize::cells).
    cells: Vec<[u8; 2]>,
}

impl AnimatedState {
    pub(crate) fn new(state: &State<'_>) -> Self {
        let cells = state.size().cells().map(|cell| {
            [state.weights(), state.walls()].map(|matrix| matrix.at(cell).unwrap_or(0))
        });
        Self { pose: state.pose(), cells: cells.collect() }
    }
}

/// Returns the animation of these states. Where scripts are disabled, it shows the last state.
pub(crate) fn html(maze: &Maze, states: &[AnimatedState]) -> String {
    // The identifier must be unique in the page, which may contain the output of several sessions.
    let id = format!("micromouse-{:016x}", RandomState::new().hash_one(()));
    let (picture, data) = (picture(maze, states), data(maze, states));
    format!(
        "<div id=\"{id}\">{picture}</div>\n\
         <script>({SCRIPT})(document.getElementById(\"{id}\"), {data});</script>\n",
        SCRIPT = SCRIPT.trim_end()
    )
}

/// Draws the known walls of the last state and the path of the mouse, without numbers, as an SVG of
/// a few kilobytes.
fn picture(maze: &Maze, states: &[AnimatedState]) -> String {
    let size = maze.size();
    let (width, height) = (CELL * i32::from(size.width()), CELL * i32::from(size.height()));
    let corner = |cell: Cell| (CELL * i32::from(cell.x), height - CELL - CELL * i32::from(cell.y));
    let last = states.last();
    let is_known = |cell: Cell, heading| {
        let flags = |cell| last.and_then(|last| last.cells.get(size.index(cell)?));
        let has =
            |cell, heading| flags(cell).is_some_and(|&[_, flags]| CellWalls(flags).wall(heading));
        let neighbour = size.neighbour(cell, heading);
        has(cell, heading) || neighbour.is_some_and(|cell| has(cell, heading.back()))
    };
    let [mut unknown, mut known] = [String::new(), String::new()];
    for Wall { cell, heading, .. } in size.walls() {
        let (left, top) = corner(cell);
        let line = match heading {
            Heading::North => format!("M{left} {top}h{CELL}"),
            _ => format!("M{} {top}v{CELL}", left + CELL),
        };
        if is_known(cell, heading) {
            known += &line;
        } else if maze.walls().has(cell, heading) {
            unknown += &line;
        }
    }
    let centres = states.iter().map(|state| {
        let (left, top) = corner(state.pose.cell);
        format!("{} {}", left + CELL / 2, top + CELL / 2)
    });
    let trail: Vec<String> = centres.collect();
    format!(
        "<svg viewBox=\"-2 -2 {} {}\" width=\"480\" fill=\"none\" stroke=\"#a22\">\
         <rect x=\"-2\" y=\"-2\" width=\"100%\" height=\"100%\" fill=\"#fff\" stroke=\"none\"/>\
         <path d=\"{unknown}\" stroke=\"#ccc\"/><path d=\"{known}\" stroke-width=\"2\"/>\
         <rect width=\"{width}\" height=\"{height}\" stroke-width=\"2\"/>\
         <polyline points=\"{}\" stroke=\"#27c\" stroke-width=\"2\"/></svg>",
        width + 4,
        height + 4,
        trail.join(" ")
    )
}

/// Returns the states as JSON. A number of a cell has two digits in base 36. Each state lists the
/// cells that it changes, each with its new weight and flags.
fn data(maze: &Maze, states: &[AnimatedState]) -> String {
    let size = maze.size();
    let mut poses = String::new();
    let mut changes: Vec<String> = Vec::new();
    let mut before = vec![[0; 2]; size.area()];
    for AnimatedState { pose: Pose { cell, heading }, cells } in states {
        push_digits(&mut poses, size.index(*cell).unwrap_or(0));
        poses.push(heading.letter());
        let mut text = String::new();
        for (index, (old, new)) in before.iter().zip(cells).enumerate() {
            if old != new {
                push_digits(&mut text, index);
                for &number in new {
                    push_digits(&mut text, number.into());
                }
            }
        }
        before.clone_from(cells);
        changes.push(text);
    }
    let mut walls = String::new();
    for cell in size.cells() {
        let north_and_east = maze.walls().sides(cell).bits() & 0b11;
        let _ = write!(walls, "{north_and_east}");
    }
    let goals: Vec<usize> = maze.goals().iter().filter_map(|cell| size.index(cell)).collect();
    let start = size.index(maze.start().cell);
    let (width, height) = (size.width(), size.height());
    serde_json::json!({
        "width": width, "height": height, "walls": walls, "start": start, "goals": goals,
        "poses": poses, "changes": changes,
    })
    .to_string()
}

/// Writes a number below 36² with two digits in base 36.
fn push_digits(text: &mut String, number: usize) {
    let digit = |number: usize| {
        u32::try_from(number % 36).ok().and_then(|number| char::from_digit(number, 36))
    };
    text.extend(digit(number / 36).into_iter().chain(digit(number)));
}
