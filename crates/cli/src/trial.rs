//! `mmsim trial`: run robots in the two-run trial.

pub(crate) mod args;
mod charts;
mod compare;
mod conclusion;
mod contender;
mod outcome;
mod picture;
mod report;
mod results;
mod robot_process;
mod serve;
mod table;

use std::error::Error;
use std::sync::Arc;

use args::TrialArgs;
use contender::{Contender, Job, RunContext, run_trials};
use results::Results;

use crate::inputs::Inputs;
use crate::interrupt::StopFlag;
use crate::selection::Selected;
use crate::usage::{CommandResult, UsageError};

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

fn run_all(args: &TrialArgs, mazes: &[Selected]) -> CommandResult {
    let contenders = args.contenders()?;
    picture::check(args, mazes, &contenders)?;
    let jobs: Vec<Job<'_>> = (mazes.iter())
        .flat_map(|maze| contenders.iter().map(move |contender| (maze, contender)))
        .collect();
    let mut results = Results::new(&jobs, args);
    let stop = stop_flag(&contenders)?;
    let context = RunContext {
        is_interrupted: Arc::clone(stop.get()),
        shows_stderr: jobs.len() == 1 && !args.json,
    };
    for batch in jobs.chunks(BATCH) {
        let outcomes = run_trials(batch, &context);
        if stop.is_set() {
            break;
        }
        results.add(outcomes)?;
    }
    stop.end();
    picture::write(args, &jobs, results.outcomes())?;
    results.finish()
}

/// Catches Ctrl-C if there are robots of the user, so that they can be killed.
fn stop_flag<'a>(
    contenders: impl IntoIterator<Item = &'a Contender>,
) -> Result<StopFlag, Box<dyn Error>> {
    let has_own = contenders.into_iter().any(Contender::is_own);
    if has_own { StopFlag::catch() } else { Ok(StopFlag::default()) }
}
