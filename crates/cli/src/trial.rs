//! `mmsim trial`: run robots in the two-run trial.

pub(crate) mod args;
mod compare;
mod picture;
mod results;
mod serve;

pub(crate) use args::DEFAULT_ANSWER_LIMIT;
use args::TrialArgs;
use mmsim_compare::{NamedMaze, RunContext, TrialJob, TrialRobot, run_trials};
pub(crate) use results::ResultForm;
use results::ResultPrinter;
pub(crate) use serve::run_watched;

use crate::args::{CommandResult, UsageError};
use crate::interrupt::StopFlag;
use crate::searches::explain_shortage;
use crate::selection::Inputs;

/// The number of trials in a batch. The results are printed after each batch.
const BATCH: usize = 32;

pub(crate) fn run(args: &TrialArgs) -> CommandResult {
    if args.watch.is_set() && !args.serve {
        return Err(UsageError::new(
            "trial",
            "recording, history and viewer options require --serve",
        )
        .into());
    }
    let Inputs { mazes, all_readable } = Inputs::read(&args.mazes);
    let succeeded = if args.compare {
        compare::run(args, &mazes)?
    } else if args.serve {
        mazes.is_empty() || serve::run(args, mazes)?
    } else {
        run_all(args, &mazes)?
    };
    Ok(succeeded && all_readable)
}

fn run_all(args: &TrialArgs, mazes: &[NamedMaze]) -> CommandResult {
    let robots = args.robots()?;
    picture::check(args, mazes, &robots)?;
    let jobs: Vec<TrialJob<'_>> =
        (mazes.iter()).flat_map(|maze| robots.iter().map(move |robot| (maze, robot))).collect();
    let mut results = ResultPrinter::new(&jobs, args.form());
    let stop = StopFlag::catch_if(robots.iter().any(TrialRobot::is_own))?;
    let shows_stderr = jobs.len() == 1 && !args.json;
    let context = RunContext { must_stop: stop.check(), shows_stderr };
    for batch in jobs.chunks(BATCH) {
        let outcomes =
            run_trials(batch, &context).map_err(|shortage| explain_shortage(&shortage))?;
        let Some(outcomes) = outcomes else { break };
        results.add(outcomes)?;
    }
    stop.end();
    picture::write(args, &jobs, results.outcomes())?;
    results.finish()
}
