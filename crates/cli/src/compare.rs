//! `mmsim compare`: compare strategies on collections of mazes.

pub(crate) mod args;
mod cpu_time;
mod report;
mod search;

use args::CompareArgs;
use indicatif::ProgressBar;
use mmsim_solvers::BundledStrategy;
use rayon::ThreadPoolBuilder;
use report::{SearchReport, StrategyReport};
use search::search;

use crate::grid::aligned;
use crate::inputs::Inputs;
use crate::output::{print, print_pretty_json, progress};
use crate::parallel::map_each;
use crate::selection::Selected;
use crate::usage::CommandResult;

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

/// Runs each strategy in each maze. Uses `threads` threads, or one thread per processor if
/// `threads` is `None`. Shows a progress bar on a terminal.
fn compare(
    strategies: &[BundledStrategy],
    mazes: &[Selected],
    threads: Option<u16>,
) -> Result<Vec<StrategyReport>, rayon::ThreadPoolBuildError> {
    let jobs: Vec<(BundledStrategy, &Selected)> = (strategies.iter())
        .flat_map(|&strategy| mazes.iter().map(move |maze| (strategy, maze)))
        .collect();
    // More threads than jobs would be idle. For rayon, 0 means one thread per processor.
    let threads = threads.map_or(0, |threads| usize::from(threads).min(jobs.len().max(1)));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let bar = progress(ProgressBar::new(jobs.len() as u64), "{wide_bar} {pos} of {len} searches");
    // The measured processor time includes creating the mouse and the search run, but not the
    // figures.
    let searches = pool.install(|| {
        map_each(&jobs, |&(strategy, selected)| {
            let max_states = strategy.max_states();
            let figures = search(&selected.maze, || strategy.strategy(), max_states);
            bar.inc(1);
            SearchReport::new(selected, figures)
        })
    });
    bar.finish_and_clear();
    let mut searches = searches.into_iter();
    let mut next = || searches.by_ref().take(mazes.len()).collect();
    Ok(strategies.iter().map(|&strategy| StrategyReport::new(strategy, next())).collect())
}
