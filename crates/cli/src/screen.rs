//! What the mouse knows, shown to the one who runs it.

use std::fmt::Write as _;
use std::io::{self, IsTerminal};

use mmsim_client::SearchRun;
use mmsim_maze::{Cell, KnownMaze, Maze, Pose};
use mmsim_solvers::{BundledStrategy, Mouse, Strategy};
use terminal_size::{Height, Width, terminal_size};

use crate::output::{counted, print};

/// Where the map is shown: at the end, and on a terminal also on the way, redrawn in place.
pub(crate) struct Screen {
    strategy: BundledStrategy,
    /// Whether to show the mouse on its way.
    is_live: bool,
    /// Whether something was drawn, which the next picture replaces.
    drawn: bool,
}

/// How a search ended, in the words of the summary.
pub(crate) fn ending(run: &SearchRun) -> &'static str {
    if run.stats.goal_reached() { "goal reached" } else { "goal not reached" }
}

impl Screen {
    /// A screen for a mouse of this strategy. Only a terminal shows it on its way.
    pub(crate) fn new(strategy: BundledStrategy, is_live: bool) -> Self {
        Self { strategy, is_live: is_live && io::stdout().is_terminal(), drawn: false }
    }

    /// Shows the mouse on its way, as well as the terminal has room.
    pub(crate) fn show<S: Strategy>(
        &mut self,
        mouse: &Mouse<S>,
        run: &SearchRun,
    ) -> io::Result<()> {
        if !self.is_live {
            return Ok(());
        }
        let (strategy, steps) = (self.strategy, counted(run.stats.steps(), "step"));
        let mut status = format!("{strategy}: searching, {steps}");
        let room = terminal();
        let map = pictures(mouse).into_iter().find(|map| fits(map, room)).unwrap_or_else(|| {
            let (width, height) = (mouse.map().size().width(), mouse.map().size().height());
            let (columns, lines) = (4 * u16::from(width) + 1, u16::from(height) + 4);
            let _ = write!(status, "; a window of {columns}x{lines} shows the map");
            String::new()
        });
        self.replace(&map, &status)
    }

    /// Shows the last picture, which stays, and a line that sums the run up.
    pub(crate) fn finish<S: Strategy>(
        &mut self,
        mouse: &Mouse<S>,
        run: &SearchRun,
        ending: &str,
    ) -> io::Result<()> {
        let [numbers, compact] = pictures(mouse);
        // What was shown on the way has the same form at the end.
        let is_compact = self.is_live && !fits(&numbers, terminal());
        let map = if is_compact && fits(&compact, (terminal().0, usize::MAX)) {
            compact
        } else {
            wide_or_compact([numbers, compact])
        };
        let steps = counted(run.stats.steps(), "step");
        let visited = counted(mouse.map().visited().len() as u64, "cell");
        let requests = counted(run.requests, "request");
        let strategy = self.strategy;
        let summary = format!("{strategy}: {ending} after {steps}, {visited} visited, {requests}");
        if self.is_live {
            self.replace(&map, &summary)
        } else {
            print(&format!("{map}{summary}\n"))
        }
    }

    /// Writes over what was drawn before, from the upper left corner of the screen.
    fn replace(&mut self, map: &str, status: &str) -> io::Result<()> {
        let mut frame = String::from(if self.drawn { "\x1b[H" } else { "\x1b[2J\x1b[H" });
        self.drawn = true;
        for line in map.lines().chain([status]) {
            // Writing to a string cannot fail. What is left of an old line is erased.
            let _ = write!(frame, "{line}\x1b[K\r\n");
        }
        frame += "\x1b[J";
        print(&frame)
    }
}

/// Columns and lines of the terminal.
fn terminal() -> (usize, usize) {
    let (Width(columns), Height(lines)) = terminal_size().unwrap_or((Width(80), Height(24)));
    (columns.into(), lines.into())
}

/// Whether the picture has room, with a line for the status, one for the cursor, and one for what
/// is said at the end.
fn fits(picture: &str, (columns, lines): (usize, usize)) -> bool {
    let widest = picture.lines().map(str::len).max().unwrap_or(0);
    picture.lines().count() + 3 <= lines && widest <= columns
}

/// The map as the mouse knows it: with its weights unless they are all zero, and small.
fn pictures<S: Strategy>(mouse: &Mouse<S>) -> [String; 2] {
    pictures_of(mouse.map(), mouse.pose(), &|cell| mouse.weight(cell).unwrap_or(u16::MAX))
}

fn pictures_of(map: &KnownMaze, pose: Pose, weight: &dyn Fn(Cell) -> u16) -> [String; 2] {
    let number = |cell| Some(weight(cell)).filter(|&weight| weight != u16::MAX);
    let drawing = map.picture().with_mouse(pose);
    let all_zero = map.size().cells().all(|cell| weight(cell) == 0);
    let numbers =
        if all_zero { drawing.to_string() } else { drawing.with_numbers(&number).to_string() };
    [numbers, drawing.compact().to_string()]
}

/// A map that is printed once, with its weights unless they are all zero or the terminal is too
/// narrow for them.
pub(crate) fn still(map: &KnownMaze, pose: Pose, weight: &dyn Fn(Cell) -> u16) -> String {
    wide_or_compact(pictures_of(map, pose, weight))
}

/// A maze that is printed once.
pub(crate) fn still_maze(maze: &Maze) -> String {
    wide_or_compact([maze.to_string(), maze.picture().compact().to_string()])
}

/// Only lines that are too long are a nuisance, the upper ones may scroll away.
pub(crate) fn wide_or_compact([wide, compact]: [String; 2]) -> String {
    let room = (terminal().0, usize::MAX);
    let is_better = !fits(&wide, room) && fits(&compact, room);
    if io::stdout().is_terminal() && is_better { compact } else { wide }
}
