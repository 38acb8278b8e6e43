//! `mmsim compare`: compare mice on collections of mazes.

pub(crate) mod args;
mod candidate;
mod commands;
mod cpu_time;
mod figures;
mod measures;
mod own_search;
mod report;
mod requests;
mod search;
mod text;
mod track;
mod workers;

use std::error::Error;
use std::num::NonZero;
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use args::CompareArgs;
use candidate::{Candidate, NamedMouse};
use figures::{Ending, Figures};
use indicatif::ProgressBar;
use mmsim_maze::Maze;
use mmsim_solvers::BundledStrategy;
use own_search::SearchLimits;
use rayon::ThreadPoolBuilder;
use report::Report;
use search::search;
use track::Track;
use workers::map_waiting;

use crate::inputs::Inputs;
use crate::interrupt::Interrupt;
use crate::output::{print, print_pretty_json, progress, replace, write_charts};
use crate::parallel::map_each;
use crate::selection::Selected;
use crate::stderr;
use crate::usage::CommandResult;

/// If a mouse reaches the time limit in each of its first mazes, its further searches are skipped.
const FIRST_MAZES: usize = 3;

pub(crate) fn run(args: &CompareArgs) -> CommandResult {
    let candidates = args.candidates()?;
    let Inputs { mazes, all_readable } = Inputs::read_or_default(&args.mazes);
    let report = compare(&candidates, &mazes, args)?;
    if args.json {
        print_pretty_json(&report.candidates)?;
    } else if args.csv {
        let mut csv = csv::Writer::from_writer(Vec::new());
        report.candidates.iter().try_for_each(|candidate| candidate.write_csv(&mut csv))?;
        print(&String::from_utf8(csv.into_inner()?)?)?;
    } else if !mazes.is_empty() {
        print(&report.text())?;
    }
    if mazes.is_empty() {
        return Ok(all_readable);
    }
    if let Some(folder) = &args.charts {
        write_charts(folder, &report.comparison)?;
    }
    if let Some(file) = &args.html {
        replace(file, report.html(&mazes).as_bytes())?;
    }
    Ok(all_readable)
}

/// Runs each candidate in each maze and shows a progress bar on a terminal.
fn compare(
    candidates: &[Candidate],
    mazes: &[Selected],
    args: &CompareArgs,
) -> Result<Report, Box<dyn Error>> {
    let bar = ProgressBar::new((candidates.len() * mazes.len()) as u64);
    let bar = progress(bar, "{wide_bar} {pos} of {len} searches, {eta} left");
    let (mut bundled, mut own) = (Vec::new(), Vec::new());
    for candidate in candidates {
        match candidate {
            Candidate::Bundled(strategy) => bundled.push(*strategy),
            Candidate::Own(mouse) => own.push(mouse),
        }
    }
    let mut own = search_own(&own, mazes, args.limits(), args.jobs, &bar)?.into_iter();
    let mut bundled = search_bundled(&bundled, mazes, args.jobs, &bar)?.into_iter();
    bar.finish_and_clear();
    Ok(Report::new(candidates, mazes, |candidate| {
        let figures: &mut dyn Iterator<Item = Figures> = match candidate {
            Candidate::Bundled(_) => &mut bundled,
            Candidate::Own(_) => &mut own,
        };
        figures.take(mazes.len()).collect()
    }))
}

/// Runs each strategy in each maze. Uses `threads` threads, or one thread per processor if
/// `threads` is `None`. Returns the figures in the order of the strategies.
fn search_bundled(
    strategies: &[BundledStrategy],
    mazes: &[Selected],
    threads: Option<u16>,
    bar: &ProgressBar,
) -> Result<Vec<Figures>, rayon::ThreadPoolBuildError> {
    let jobs: Vec<(BundledStrategy, &Selected)> = (strategies.iter())
        .flat_map(|&strategy| mazes.iter().map(move |maze| (strategy, maze)))
        .collect();
    // More threads than jobs would be idle. For rayon, 0 means one thread per processor.
    let threads = threads.map_or(0, |threads| usize::from(threads).min(jobs.len().max(1)));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    // The measured processor time includes creating the mouse and the search run, but not the
    // figures.
    Ok(pool.install(|| {
        map_each(&jobs, |&(strategy, selected)| {
            let figures = search(&selected.maze, || strategy.strategy(), strategy.max_states());
            bar.inc(1);
            figures
        })
    }))
}

/// Runs each of the user's mice in each maze. Returns the figures in the order of the mice. After
/// Ctrl-C, stops the mice and exits.
fn search_own(
    mice: &[&NamedMouse],
    mazes: &[Selected],
    limits: SearchLimits,
    jobs: Option<u16>,
    bar: &ProgressBar,
) -> Result<Vec<Figures>, Box<dyn Error>> {
    if mice.is_empty() || mazes.is_empty() {
        return Ok(Vec::new());
    }
    let is_interrupted = Arc::new(AtomicBool::new(false));
    let (interrupt, interrupted) = (Interrupt::catch()?, Arc::clone(&is_interrupted));
    thread::spawn(move || {
        interrupt.wait();
        interrupted.store(true, Ordering::Relaxed);
    });
    let slots = match jobs {
        Some(jobs) => jobs.into(),
        None => thread::available_parallelism().map_or(1, NonZero::get),
    };
    let run = |mice: &[&NamedMouse], mazes: &[Selected]| {
        let jobs: Vec<_> =
            mice.iter().flat_map(|&mouse| mazes.iter().map(move |maze| (mouse, maze))).collect();
        map_waiting(&jobs, slots, |&(mouse, Selected { maze, .. }), slot| {
            if is_interrupted.load(Ordering::Relaxed) {
                return skip(maze);
            }
            let figures = own_search::search(&mouse.program, maze, limits, slot, &is_interrupted);
            bar.inc(1);
            figures
        })
    };
    let (first, rest) = mazes.split_at(mazes.len().min(FIRST_MAZES));
    let searched = run(mice, first);
    let is_stuck = |figures: &[Figures]| {
        figures.iter().all(|search| search.ending == Ending::TimeLimit && !search.goal_reached)
    };
    let searched: Vec<(&NamedMouse, &[Figures])> =
        mice.iter().copied().zip(searched.chunks(first.len())).collect();
    let others: Vec<_> = (searched.iter())
        .filter_map(|&(mouse, figures)| (!is_stuck(figures)).then_some(mouse))
        .collect();
    let mut more = run(&others, rest).into_iter();
    let figures = searched.into_iter().flat_map(|(_, figures)| {
        let rest: Vec<Figures> = if is_stuck(figures) {
            bar.inc(rest.len() as u64);
            rest.iter().map(|selected| skip(&selected.maze)).collect()
        } else {
            more.by_ref().take(rest.len()).collect()
        };
        figures.iter().cloned().chain(rest).collect::<Vec<_>>()
    });
    let figures = figures.collect();
    if is_interrupted.load(Ordering::Relaxed) {
        bar.finish_and_clear();
        stderr::flush();
        process::exit(Interrupt::CODE);
    }
    Ok(figures)
}

/// Returns the figures of a search that was not run.
fn skip(maze: &Maze) -> Figures {
    let reason =
        format!("skipped: stopped by the time limit in each of the first {FIRST_MAZES} mazes");
    Figures { ending: Ending::Skipped, error: Some(reason), ..Track::new(maze).figures() }
}
