//! `mmsim demo`: a server and a flood-fill mouse in one command, over real ZeroMQ.

use std::error::Error;
use std::fmt::Write as _;
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::time::Duration;

use mmsim_client::{BrokenRun, RunError, SearchRun, Zmq, search_run};
use mmsim_server::Simulation;
use mmsim_solvers::{Bundled, Mouse, Strategy};
use terminal_size::{Height, Width, terminal_size};

use crate::Outcome;
use crate::args::DemoArgs;
use crate::interrupt::Interrupt;
use crate::output::{counted, own_command, print, say};
use crate::selection::Collection;
use crate::serve::{announce, bind};
use crate::solve::{ask_goals, drawing, say_waiting, summary};

/// Time between two steps that an eye can follow, in milliseconds.
const PACE_MS: u64 = 50;

const STRATEGY: Bundled = Bundled::FloodFill;

pub(crate) fn run(args: &DemoArgs) -> Outcome {
    let selected = Collection::at(None)?.select(&args.maze.words.join(" "))?;
    let server = bind("127.0.0.1", args.port)?;
    let interrupt = Interrupt::catch()?;
    say(announce(&selected, server.address()));
    let server = server.spawn(Simulation::new(&selected.name, selected.maze))?;
    let address = server.address();
    let ended = search(args, address, &interrupt);
    if !args.once && matches!(ended, Ok(Ended::GoalReached | Ended::GoalNotReached)) {
        let more = own_command(&format!("solve weight-increment --connect {address}"));
        say(format_args!(
            "still serving at {address}; try {more} in another terminal, or your own mouse"
        ));
        interrupt.wait();
    }
    server.stop()?;
    Ok(match ended? {
        Ended::GoalReached | Ended::Interrupted => true,
        Ended::GoalNotReached => !args.once,
    })
}

enum Ended {
    GoalReached,
    GoalNotReached,
    Interrupted,
}

/// Lets the mouse search the served maze and shows it.
fn search(args: &DemoArgs, address: &str, interrupt: &Interrupt) -> Result<Ended, Box<dyn Error>> {
    let mut transport = Zmq::connect(address, None, |waiting| say_waiting(&waiting, true))?;
    let (map, start) = ask_goals(&mut transport, None)?;
    let mut mouse = Mouse::new(STRATEGY.strategy(), map, start);
    let mut screen = Screen::new();
    let pace = args.pace.unwrap_or(if screen.is_terminal { PACE_MS } else { 0 });
    let (mut interrupted, mut shown) = (false, Ok(()));
    let result = search_run(&mut transport, &mut mouse, u32::MAX, |mouse, run| {
        shown = screen.show(mouse, run);
        interrupted = interrupt.wait_for(Duration::from_millis(pace));
        if interrupted || shown.is_err() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    shown?;
    let run = match result {
        Ok(run) => run,
        Err(BrokenRun { run, error: RunError::Search(error) }) => {
            screen.finish(&mouse, &run)?;
            say(format_args!("{STRATEGY}: {error}"));
            return Ok(Ended::GoalNotReached);
        }
        Err(error) => return Err(error.into()),
    };
    screen.finish(&mouse, &run)?;
    Ok(match run.goal_reached {
        _ if interrupted => Ended::Interrupted,
        true => Ended::GoalReached,
        false => Ended::GoalNotReached,
    })
}

/// Where the map is shown: redrawn in place on a terminal, else only once at the end.
struct Screen {
    is_terminal: bool,
    /// Whether something was drawn, which the next picture replaces.
    drawn: bool,
}

impl Screen {
    fn new() -> Self {
        Self { is_terminal: io::stdout().is_terminal(), drawn: false }
    }

    /// Shows the mouse on its way, as large as the terminal allows.
    fn show<S: Strategy>(&mut self, mouse: &Mouse<S>, run: &SearchRun) -> io::Result<()> {
        if self.is_terminal {
            let steps = counted(run.steps, "step");
            self.replace(&picture(mouse), &format!("{}: searching, {steps}", STRATEGY.name()))?;
        }
        Ok(())
    }

    /// Shows the last picture, which stays. A terminal too small for it scrolls.
    fn finish<S: Strategy>(&mut self, mouse: &Mouse<S>, run: &SearchRun) -> io::Result<()> {
        let last = if self.is_terminal { picture(mouse) } else { String::new() };
        let last = if last.is_empty() { drawing(mouse) } else { last };
        let summary = summary(STRATEGY.name(), run, mouse);
        if self.is_terminal {
            return self.replace(&last, &summary);
        }
        print(&format!("{last}{summary}\n"))
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

/// The map with numbers where the terminal has room for it, else without, else nothing.
fn picture<S: Strategy>(mouse: &Mouse<S>) -> String {
    let (Width(columns), Height(lines)) = terminal_size().unwrap_or((Width(80), Height(24)));
    let fits = |picture: &String| {
        let widest = picture.lines().map(str::len).max().unwrap_or(0);
        // A line for the summary, one for the cursor, and one for what is said at the end.
        picture.lines().count() + 3 <= lines.into() && widest <= columns.into()
    };
    let compact = || mouse.map().drawing().with_mouse(mouse.pose()).compact().to_string();
    Some(drawing(mouse)).filter(fits).or_else(|| Some(compact()).filter(fits)).unwrap_or_default()
}
