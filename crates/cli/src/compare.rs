//! `mmsim compare`: compare strategies over collections of mazes.

pub(crate) mod args;
mod cpu_time;
mod report;
mod search;

use args::CompareArgs;
use indicatif::ProgressBar;
use mmsim_solvers::BundledStrategy;
use rayon::ThreadPoolBuilder;
use report::{SearchReport, StrategyReport};

use crate::grid::aligned;
use crate::inputs::Inputs;
use crate::output::{print, print_pretty_json, progress};
use crate::parallel::map_each;
use crate::selection::Selected;
use crate::usage::CommandResult;

/// A strategy and the maze it is to search.
type Job<'a> = (BundledStrategy, &'a Selected);

pub(crate) fn run(args: &CompareArgs) -> CommandResult {
    let Inputs { mazes, all_readable } = Inputs::read_or_default(&args.mazes);
    let reports = compare(&args.strategies(), &mazes, args.jobs)?;
    if args.json {
        print_pretty_json(&reports)?;
    } else if args.csv {
        let mut csv = csv::Writer::from_writer(Vec::new());
        reports.iter().try_for_each(|report| report.write_csv(&mut csv))?;
        print(&String::from_utf8(csv.into_inner()?)?)?;
    } else if !mazes.is_empty() {
        let rows = reports.iter().map(StrategyReport::row);
        print(&aligned(&[StrategyReport::head()].into_iter().chain(rows).collect::<Vec<_>>()))?;
    }
    Ok(all_readable)
}

/// Runs each strategy in each maze, in `threads` threads or one per processor. A terminal shows
/// the progress.
fn compare(
    strategies: &[BundledStrategy],
    mazes: &[Selected],
    threads: Option<u16>,
) -> Result<Vec<StrategyReport>, rayon::ThreadPoolBuildError> {
    let jobs: Vec<Job<'_>> = (strategies.iter())
        .flat_map(|&strategy| mazes.iter().map(move |maze| (strategy, maze)))
        .collect();
    // No idle threads; 0 means one per processor to rayon.
    let threads = threads.map_or(0, |threads| usize::from(threads).min(jobs.len().max(1)));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let bar = progress(ProgressBar::new(jobs.len() as u64), "{wide_bar} {pos} of {len} searches");
    let searches = pool.install(|| {
        map_each(&jobs, |job| {
            let report = search(job);
            bar.inc(1);
            report
        })
    });
    bar.finish_and_clear();
    let mut searches = searches.into_iter();
    let mut next = || searches.by_ref().take(mazes.len()).collect();
    Ok(strategies.iter().map(|&strategy| StrategyReport::new(strategy, next())).collect())
}

/// Runs one search. The measured processor time covers creating the mouse and the search run, but not
/// the figures.
fn search(&(strategy, selected): &Job<'_>) -> SearchReport {
    let max_states = strategy.max_states();
    SearchReport::new(selected, search::search(&selected.maze, || strategy.strategy(), max_states))
}
