//! `mmsim demo`: a server and a flood-fill mouse in one command, over real ZeroMQ.

use std::error::Error;
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::time::Duration;

use mmsim_client::{BrokenRun, RunError, Zmq, search_run};
use mmsim_solvers::{BundledStrategy, Mouse};

use crate::args::DemoArgs;
use crate::interrupt::Interrupt;
use crate::output::{complain, own_command, say};
use crate::screen::{Screen, ending};
use crate::selection::Collection;
use crate::solve::{ask_goals, say_waiting};
use crate::{Outcome, hosting};

/// Time between two steps that an eye can follow, in milliseconds.
pub(crate) const PACE_MS: u64 = 50;

const STRATEGY: BundledStrategy = BundledStrategy::FloodFill;

pub(crate) fn run(args: &DemoArgs) -> Outcome {
    let collection = Collection::at(args.mazes.as_deref())?;
    let selected = collection.select(&args.maze.words.join(" "))?;
    let viewer = (!args.once).then_some(&args.viewer);
    let (server, interrupt) =
        hosting::begin(selected, collection.catalogue, args.port, &args.keep, viewer)?;
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
    let mut screen = Screen::new(STRATEGY, true);
    let pace = args.pace.unwrap_or(if io::stdout().is_terminal() { PACE_MS } else { 0 });
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
            screen.finish(&mouse, &run, ending(&run))?;
            complain(format_args!("{STRATEGY}: {error}"));
            return Ok(Ended::GoalNotReached);
        }
        Err(error) => return Err(error.into()),
    };
    screen.finish(&mouse, &run, if interrupted { "interrupted" } else { ending(&run) })?;
    Ok(match run.stats.goal_reached() {
        _ if interrupted => Ended::Interrupted,
        true => Ended::GoalReached,
        false => Ended::GoalNotReached,
    })
}
