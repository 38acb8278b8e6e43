//! Showing a mouse's map on the terminal.

use std::fmt::Write as _;
use std::io;
use std::time::Duration;

use mmsim_client::SearchRun;
use mmsim_maze::{Cell, KnownMaze, Pose, counted};
use mmsim_run::{Goal, PhaseReport};
use mmsim_solvers::{BundledStrategy, Mouse, Strategy};
use terminal_size::{Height, Width, terminal_size};

use crate::args::WATCHED_PACE_MS;
use crate::grid::wrapped;
use crate::output::print;
use crate::phase_table;
use crate::terminal::{can_redraw, columns};

/// A view of a mouse's map. A live view redraws the map in place during the search.
pub(crate) struct Screen {
    strategy: BundledStrategy,
    /// True if the map is shown during the search.
    is_live: bool,
    /// True if a map has already been drawn.
    drawn: bool,
}

/// Returns whether a search has reached the goal, as text for the summary line.
pub(crate) fn goal_text(run: &SearchRun) -> String {
    Goal { is_reached: run.stats.goal_reached(), error: None }.to_string()
}

/// Returns the delay after each step. For `None`, returns [`WATCHED_PACE_MS`] if stdout is a terminal
/// that shows each step, and zero otherwise.
pub(crate) fn pace(milliseconds: Option<u64>) -> Duration {
    let default = if can_redraw(&io::stdout()) { WATCHED_PACE_MS } else { 0 };
    Duration::from_millis(milliseconds.unwrap_or(default))
}

impl Screen {
    /// Creates a screen for a mouse with this strategy. If `is_live` is true and stdout is a
    /// terminal that can replace the map, the screen shows the map during the search.
    pub(crate) fn new(strategy: BundledStrategy, is_live: bool) -> Self {
        Self { strategy, is_live: is_live && can_redraw(&io::stdout()), drawn: false }
    }

    /// Draws the current map, with the weights if the terminal is large enough. Does nothing if
    /// maps are not shown during the search.
    pub(crate) fn show<S: Strategy>(
        &mut self,
        mouse: &Mouse<S>,
        run: &SearchRun,
    ) -> io::Result<()> {
        if !self.is_live {
            return Ok(());
        }
        let mut status = format!("{}: searching, {}", self.strategy, run.stats);
        let room = terminal();
        let map =
            mouse_pictures(mouse).into_iter().find(|map| fits(map, room)).unwrap_or_else(|| {
                let (width, height) = (mouse.map().size().width(), mouse.map().size().height());
                let (columns, lines) = (2 * u16::from(width) + 1, u16::from(height) + 4);
                let _ = write!(status, "; the map needs a window of {columns}x{lines}");
                String::new()
            });
        self.replace(&map, &status)
    }

    /// Shows the final map, a summary line and the figures of the phases.
    pub(crate) fn finish<S: Strategy>(
        &mut self,
        mouse: &Mouse<S>,
        run: &SearchRun,
        ending: &str,
        phases: Option<PhaseReport>,
    ) -> io::Result<()> {
        let pictures = mouse_pictures(mouse);
        // The map does not become larger than during the search.
        let is_smaller = self.is_live && !fits(&pictures[0], terminal());
        let map = fitting(&pictures[usize::from(is_smaller)..]);
        let phases = phases.map(|report| phase_table::table(report.rows())).unwrap_or_default();
        let visited = counted(mouse.map().visited().len(), "cell");
        let requests = counted(run.requests, "request");
        let (strategy, steps) = (self.strategy, run.stats);
        let summary = format!("{strategy}: {ending} after {steps}, {visited} visited, {requests}");
        let summary = wrapped(&summary, ", ", 2);
        if self.is_live {
            self.replace(map, &summary)?;
            print(&phases)
        } else {
            print(&format!("{map}{summary}\n{phases}"))
        }
    }

    /// Redraws the terminal from the upper left corner, replacing the previous map.
    fn replace(&mut self, map: &str, status: &str) -> io::Result<()> {
        let mut frame = String::from(if self.drawn { "\x1b[H" } else { "\x1b[2J\x1b[H" });
        self.drawn = true;
        for line in map.lines().chain(status.lines()) {
            // Writing to a string cannot fail. The escape sequence erases the rest of the old line.
            let _ = write!(frame, "{line}\x1b[K\r\n");
        }
        frame += "\x1b[J";
        print(&frame)
    }
}

/// Returns the width and height of the terminal, in columns and lines.
fn terminal() -> (usize, usize) {
    let (Width(columns), Height(lines)) = terminal_size().unwrap_or((Width(80), Height(24)));
    (columns.into(), lines.into())
}

/// Returns true if the picture and three further lines fit: the status, the cursor and a final
/// message.
fn fits(picture: &str, (columns, lines): (usize, usize)) -> bool {
    let widest = picture.lines().map(str::len).max().unwrap_or(0);
    picture.lines().count() + 3 <= lines && widest <= columns
}

fn mouse_pictures<S: Strategy>(mouse: &Mouse<S>) -> [String; 3] {
    pictures(mouse.map(), mouse.pose(), |cell| mouse.weight(cell).unwrap_or(u16::MAX))
}

/// Returns pictures of a mouse's map, the largest first. The largest one shows the weights unless all
/// of them are zero.
pub(crate) fn pictures(map: &KnownMaze, pose: Pose, weight: impl Fn(Cell) -> u16) -> [String; 3] {
    let number = |cell| Some(weight(cell)).filter(|&weight| weight != u16::MAX);
    let drawing = map.picture().with_mouse(pose);
    let all_zero = map.size().cells().all(|cell| weight(cell) == 0);
    let numbers =
        if all_zero { drawing.to_string() } else { drawing.with_numbers(&number).to_string() };
    [numbers, drawing.compact().to_string(), drawing.narrow().to_string()]
}

/// Returns the first of the pictures for which the terminal has enough columns, or else the first. The
/// height does not matter, because the terminal scrolls.
pub(crate) fn fitting(pictures: &[String]) -> &str {
    let room = (columns(), usize::MAX);
    pictures.iter().find(|picture| fits(picture, room)).unwrap_or(&pictures[0])
}
