//! `mmsim demo`: a server and a flood-fill mouse in one process, connected by ZeroMQ.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use mmsim_client::{BUNDLED_MOUSE_NAME, BrokenRun, Named, RunError, search_run_with};
use mmsim_solvers::{BundledStrategy, Mouse, SearchDriver, WallVotes};
use mmsim_viewer::ViewerConfig;

use crate::args::{CommandResult, ServerArgs};
use crate::connection::{KnownSimulator, ask_maze, connect};
use crate::interrupt::Interrupt;
use crate::local_server::{HOST, prepare};
use crate::output::{note, own_command, warn};
use crate::screen::{Screen, goal_text, pace};
use crate::selection::{DEFAULT_MAZES, MAZE_HELP, Selection, join};

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    #[arg(value_name = "MAZE", help = format!("{MAZE_HELP} [default: {DEFAULT_MAZES}]"))]
    maze: Vec<PathBuf>,
    #[command(flatten)]
    server: ServerArgs,
    /// Wait MS milliseconds after each step [default: 50 on a terminal, else 0]
    #[arg(long, value_name = "MS")]
    pace: Option<u64>,
    /// Exit after the search, without serving a viewer page
    #[arg(long, conflicts_with_all = ["viewer_port", "open", "vehicle"])]
    once: bool,
}

const STRATEGY: BundledStrategy = BundledStrategy::FloodFill;

pub(crate) fn run(args: &DemoArgs) -> CommandResult {
    let selection = Selection::read(&join(&args.maze))?;
    let selected = selection.first()?;
    let ServerArgs { port, retention, viewer, misread, .. } = &args.server;
    let viewer = (!args.once).then_some(viewer);
    let config = ViewerConfig::default().with_mazes(selection.catalogue);
    let (misreadings, address) = (misread.misreadings(), (HOST, *port));
    let ready = prepare(selected, misreadings, config, address, retention, viewer, None)?;
    let (server, interrupt) = (ready.server.spawn(ready.simulation), ready.interrupt);
    let address = server.address();
    let result = search(args, address, &interrupt);
    if !args.once && matches!(result, Ok(Some(_))) {
        let more = own_command(&format!("solve weight-increment --connect {address}"));
        note(format_args!(
            "still serving at {address}; in another terminal, run {more} or your own mouse"
        ));
        interrupt.wait();
    }
    server.stop()?;
    Ok(result?.unwrap_or(true) || !args.once)
}

/// Runs the mouse in the served maze and shows the search. Returns whether the mouse reached the
/// goal, or `None` after an interrupt.
fn search(
    args: &DemoArgs,
    address: &str,
    interrupt: &Interrupt,
) -> Result<Option<bool>, Box<dyn Error>> {
    let mut transport = connect(address, None, true)?;
    let KnownSimulator { map, start, .. } = ask_maze(&mut transport, None)?;
    let mut transport = Named::new(transport, BUNDLED_MOUSE_NAME, STRATEGY.name())?;
    let mut mouse = Mouse::new(STRATEGY.strategy(), map, start);
    let mut screen = Screen::new(STRATEGY, true);
    let pace = pace(args.pace);
    let (mut interrupted, mut shown) = (false, Ok(()));
    let misreads = args.server.misread.misreadings().probability > 0.0;
    let mut votes = misreads.then(WallVotes::new);
    let driver = SearchDriver::new(&mut mouse, STRATEGY.max_states()).recovering(votes.as_mut());
    let result = search_run_with(&mut transport, driver, |mouse, run| {
        shown = screen.show(mouse, run);
        interrupted = interrupt.wait_for(pace);
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
            screen.finish(&mouse, &run, &goal_text(&run), None)?;
            warn(format_args!("{STRATEGY}: {error}"));
            return Ok(Some(false));
        }
        Err(error) => return Err(error.into()),
    };
    if run.is_at_limit {
        warn(format_args!("gave up at the limit of {} states", run.states));
    }
    let ending = if interrupted { "interrupted".into() } else { goal_text(&run) };
    screen.finish(&mouse, &run, &ending, None)?;
    Ok((!interrupted).then(|| run.stats.goal_reached()))
}
