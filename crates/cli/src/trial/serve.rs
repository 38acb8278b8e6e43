//! `mmsim trial --serve`: show a trial in a browser. The robot is a client that sends states to a
//! simulator.

use std::error::Error;

use mmsim_client::{Exchange, RunError, Zmq};
use mmsim_maze::Unknown;
use mmsim_trial::RaceSteps;

use super::args::TrialArgs;
use super::outcome::{Contender, TrialResult};
use super::results::Results;
use crate::connection::report_waiting;
use crate::local_server;
use crate::output::note;
use crate::screen::pace;
use crate::selection::{Collection, Selected};
use crate::usage::{CommandResult, UsageError};

/// Runs one robot in one maze.
pub(crate) fn run(args: &TrialArgs, mazes: Vec<Selected>) -> CommandResult {
    let (contenders, paths) = (args.contenders(), mazes.len());
    let [contender] = &contenders[..] else {
        return Err(not_one("robot", contenders.len()).into());
    };
    let Ok([selected]) = <[Selected; 1]>::try_from(mazes) else {
        return Err(not_one("maze", paths).into());
    };
    let watch = &args.watch;
    // If the path is not a file, the maze is a bundled one.
    let collection = Collection::at(Some(&*selected.path).filter(|path| path.exists()))?;
    let viewer = (!watch.once).then_some(&watch.viewer);
    let (server, interrupt) = local_server::start(
        selected.clone(),
        collection.catalogue,
        watch.port,
        &watch.retention,
        viewer,
    )?;
    let pace = pace(watch.pace);
    let pause = || interrupt.wait_for(pace);
    let outcome = run_trial(server.address(), contender, &selected, pause);
    let mut succeeded = true;
    if let Some(outcome) = outcome? {
        let jobs = [(&selected, contender)];
        let mut results = Results::new(&jobs, args);
        results.add(vec![outcome])?;
        succeeded = results.finish()?;
        if !watch.once {
            note(format_args!("still serving at {}; press Ctrl-C to stop", server.address()));
            interrupt.wait();
        }
    }
    server.stop()?;
    Ok(succeeded || !watch.once)
}

/// Runs a robot and sends its states to the simulator. A state contains the pose, the walls that
/// the robot has seen, and for each cell a lower bound on the race steps to the goal. Calls `pause`
/// after each state, and returns `None` if `pause` returns true.
fn run_trial(
    address: &str,
    contender: &Contender,
    selected: &Selected,
    pause: impl Fn() -> bool,
) -> Result<Option<TrialResult>, Box<dyn Error>> {
    let transport = Zmq::connect(address, None, |waiting| report_waiting(&waiting, false))?;
    let mut simulator = Exchange::new(transport);
    simulator.reset()?;
    let outcome = contender.run_watched(&selected.maze, |trial, seen| {
        let steps = RaceSteps::flood(seen.walls(Unknown::Open), seen.goals());
        let number = |cell| steps.at(cell).unwrap_or(u16::MAX);
        simulator.state(trial.pose(), seen, number).map_err(Some)?;
        if pause() { Err(None::<RunError>) } else { Ok(()) }
    });
    match outcome {
        Ok(outcome) => Ok(Some(outcome)),
        Err(None) => Ok(None),
        Err(Some(error)) => Err(error.into()),
    }
}

fn not_one(thing: &str, found: usize) -> UsageError {
    UsageError::new("trial", format!("--serve takes one {thing}, found {found}"))
}
