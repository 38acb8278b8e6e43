//! An animation of a search as a piece of HTML that needs no server and no other file.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use mmsim_maze::{Cell, Heading, Maze, MazeSize, Pose};
use mmsim_protocol::State;

/// The script that draws the states.
const SCRIPT: &str = include_str!("animation.js");

/// What the animation shows of a state.
pub(crate) struct Frame {
    pose: Pose,
    /// The weight and the flags of each cell, in the order of [`MazeSize::cells`].
    cells: Vec<[u8; 2]>,
}

impl Frame {
    pub(crate) fn new(state: &State<'_>) -> Self {
        let cells = state.size().cells().map(|cell| {
            [state.weights(), state.walls()].map(|matrix| matrix.at(cell).unwrap_or(0))
        });
        Self { pose: state.pose(), cells: cells.collect() }
    }
}

/// Returns the animation of these states. `fallback` is the picture that is shown where scripts are
/// disabled.
pub(crate) fn html(maze: &Maze, frames: &[Frame], fallback: &str) -> String {
    // The identifier must be unique in the page, which may contain the output of several sessions.
    let id = format!("micromouse-{:016x}", fastrand::u64(..));
    let picture = STANDARD.encode(fallback);
    let data = data(maze, frames);
    format!(
        "<div id=\"{id}\"><img alt=\"last state of the search\" width=\"480\" \
         src=\"data:image/svg+xml;base64,{picture}\"></div>\n\
         <script>({SCRIPT})(document.getElementById(\"{id}\"), {data});</script>\n",
        SCRIPT = SCRIPT.trim_end()
    )
}

/// Returns the states as JSON. A number of a cell has two digits in base 36. Each state lists the
/// cells that it changes, each with its new weight and flags.
fn data(maze: &Maze, frames: &[Frame]) -> String {
    let size = maze.size();
    let mut poses = String::new();
    let mut changes: Vec<String> = Vec::new();
    let mut before = vec![[0; 2]; size.area()];
    for Frame { pose: Pose { cell, heading }, cells } in frames {
        push_digits(&mut poses, index(size, *cell));
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
        let bits = [Heading::North, Heading::East].map(|side| maze.walls().has(cell, side));
        let _ = write!(walls, "{}", u8::from(bits[0]) | u8::from(bits[1]) << 1);
    }
    let goals: Vec<usize> = maze.goals().iter().map(|cell| index(size, cell)).collect();
    let start = index(size, maze.start().cell);
    let (width, height) = (size.width(), size.height());
    serde_json::json!({
        "width": width, "height": height, "walls": walls, "start": start, "goals": goals,
        "poses": poses, "changes": changes,
    })
    .to_string()
}

/// Returns the index of a cell in the order of [`MazeSize::cells`].
fn index(size: MazeSize, cell: Cell) -> usize {
    usize::from(cell.y) * usize::from(size.width()) + usize::from(cell.x)
}

/// Writes a number below 36² with two digits in base 36.
fn push_digits(text: &mut String, number: usize) {
    let digit = |number: usize| {
        u32::try_from(number % 36).ok().and_then(|number| char::from_digit(number, 36))
    };
    text.extend(digit(number / 36).into_iter().chain(digit(number)));
}
