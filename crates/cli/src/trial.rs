//! `mmsim trial`: run robots in the two-run trial.

pub(crate) mod args;
mod compare;
mod outcome;
mod report;
mod results;
mod serve;
mod table;

use args::TrialArgs;
use outcome::{Job, run_trials};
use results::Results;

use crate::inputs::Inputs;
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
    let contenders = args.contenders();
    let jobs: Vec<Job<'_>> = (mazes.iter())
        .flat_map(|maze| contenders.iter().map(move |contender| (maze, contender)))
        .collect();
    let mut results = Results::new(&jobs, args);
    for batch in jobs.chunks(BATCH) {
        results.add(run_trials(batch))?;
    }
    results.finish()
}
