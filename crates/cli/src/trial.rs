//! `mmsim trial`: robots on the two-run trial.

mod args;
mod compare;
mod report;
mod results;
mod serve;
mod table;
mod tried;

pub(crate) use args::TrialArgs;

use results::Results;
use tried::{Contender, Tried};

use crate::Outcome;
use crate::args::wrong_usage;
use crate::given::Given;
use crate::parallel::map_each;
use crate::selection::Selected;

/// How many trials run before what came of them is printed.
const AT_A_TIME: usize = 32;

/// A robot to be put on trial in a maze.
type Job<'a> = (&'a Selected, &'a Contender);

pub(crate) fn run(args: &TrialArgs) -> Outcome {
    if args.watch.is_told() && !args.serve {
        wrong_usage("trial", "expected --serve with an option that concerns it, found none");
    }
    let Given { mazes, are_all } = Given::read(&args.mazes);
    let is_done = if args.compare {
        compare::run(args, &mazes)?
    } else if args.serve {
        mazes.is_empty() || serve::run(args, mazes)?
    } else {
        try_all(args, &mazes)?
    };
    Ok(is_done && are_all)
}

fn try_all(args: &TrialArgs, mazes: &[Selected]) -> Outcome {
    let contenders = args.contenders();
    let jobs: Vec<Job<'_>> = (mazes.iter())
        .flat_map(|maze| contenders.iter().map(move |contender| (maze, contender)))
        .collect();
    let mut results = Results::new(&jobs, args);
    for some in jobs.chunks(AT_A_TIME) {
        results.add(stand_trial(some))?;
    }
    results.finish()
}

/// Runs trials on all processors; gives what came of them in the same order.
fn stand_trial(jobs: &[Job<'_>]) -> Vec<Tried> {
    map_each(jobs, |(given, contender)| contender.stand_trial(&given.maze))
}
