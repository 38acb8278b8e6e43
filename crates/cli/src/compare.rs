//! `mmsim compare`: compare mice on collections of mazes.

pub(crate) mod args;
pub(crate) mod candidate;
mod commands;
mod cpu_time;
pub(crate) mod figures;
mod measures;
mod own_search;
mod report;
mod requests;
pub(crate) mod search;
pub(crate) mod search_speed;
mod text;
pub(crate) mod times;
mod track;
mod workers;

use std::error::Error;
use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use args::CompareArgs;
use candidate::{Candidate, NamedMouse};
use figures::{Ending, Figures};
use indicatif::ProgressBar;
use measures::{MEASURES, TIMED_MEASURES};
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{Escaped, Maze};
use mmsim_solvers::BundledStrategy;
pub(crate) use own_search::SearchLimits;
use report::Report;
pub(crate) use report::unique_names;
use search::search;
use times::Timing;
use track::Track;
use workers::map_waiting;

use crate::exploration::Exploration;
use crate::inputs::Inputs;
use crate::interrupt::StopFlag;
use crate::local_server::raise_file_limit;
use crate::output::{
    check_folder, create_folder, print, print_csv, print_pretty_json, replace, write_charts,
};
use crate::parallel::{map_each, map_on};
use crate::progress::progress_bar;
use crate::selection::Selected;
use crate::usage::CommandResult;
use crate::vehicle::warn_about;

/// The limit of open files to request from the system.
const MAX_FILES: u64 = 4096;

/// If a mouse reaches the time limit in each of its first mazes, its further searches are skipped.
const FIRST_MAZES: usize = 3;

pub(crate) fn run(args: &CompareArgs) -> CommandResult {
    let candidates = args.candidates.select("compare")?;
    let Inputs { mazes, all_readable } = Inputs::read_distinct_or_default(&args.mazes);
    prepare_files(args)?;
    let report = compare(&candidates, &mazes, args)?;
    if args.json {
        print_pretty_json(&report.candidates)?;
    } else if args.csv {
        print_csv(|csv| report.candidates.iter().try_for_each(|one| one.write_csv(csv)))?;
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
        replace(file, report.html(&mazes, args.vehicle.as_ref()).as_bytes())?;
    }
    Ok(all_readable)
}

/// Creates the folder for charts and checks that of the report, before searches that may take
/// minutes.
fn prepare_files(args: &CompareArgs) -> Result<(), String> {
    args.charts.as_deref().map_or(Ok(()), create_folder)?;
    match &args.html {
        Some(file) => check_folder(file),
        None => Ok(()),
    }
}

/// Runs each candidate in each maze, and compares the figures.
fn compare(
    candidates: &[Candidate],
    mazes: &[Selected],
    args: &CompareArgs,
) -> Result<Report, Box<dyn Error>> {
    let vehicle = args.vehicle.clone().unwrap_or_else(Vehicle::expert);
    let exploration = Exploration::new(vehicle, args.candidates.tolerance());
    let mut figures = search_all(candidates, mazes, args.limits(), &exploration, args.jobs)?;
    let (mut measures, mut note) = (MEASURES.to_vec(), None);
    if let Some(vehicle) = args.vehicle.clone() {
        warn_about(&vehicle);
        let timing = Timing { vehicle, search_speed: args.search_speed };
        measure_times(&mut figures, mazes, &timing);
        measures.splice(..0, TIMED_MEASURES);
        let Timing { vehicle, search_speed } = &timing;
        let name = Escaped(vehicle.name());
        note = Some(format!("Fast runs with the vehicle {name}; searches at {search_speed}."));
    }
    Ok(Report::new(candidates, mazes, figures, measures, note))
}

/// Calculates the times of all searches. Each maze has one figure of each candidate.
fn measure_times(figures: &mut [Vec<Figures>], mazes: &[Selected], timing: &Timing) {
    let planner = Planner::new(timing.vehicle.clone());
    let indices: Vec<usize> = (0..mazes.len()).collect();
    let times = map_each(&indices, |&maze| {
        let searches = figures.iter().map(|figures| &figures[maze]);
        timing.measure(&mut planner.clone(), &mazes[maze].maze, searches)
    });
    for (maze, times) in times.into_iter().enumerate() {
        for (figures, times) in figures.iter_mut().zip(times) {
            figures[maze].times = Some(times);
        }
    }
}

/// Runs each candidate in each maze and shows a progress bar on a terminal. Returns the figures of
/// each candidate in each maze.
pub(crate) fn search_all(
    candidates: &[Candidate],
    mazes: &[Selected],
    limits: SearchLimits,
    exploration: &Exploration,
    jobs: Option<u16>,
) -> Result<Vec<Vec<Figures>>, Box<dyn Error>> {
    let searches = candidates.len() * mazes.len();
    let progress = progress_bar(Some(searches as u64), "{pos} of {len} searches, {eta} left");
    let (mut bundled, mut own) = (Vec::new(), Vec::new());
    for candidate in candidates {
        match candidate {
            Candidate::Bundled(strategy) => bundled.push(*strategy),
            Candidate::Own(mouse) => own.push(mouse),
        }
    }
    let mut own = search_own(&own, mazes, limits, jobs, &progress)?.into_iter();
    let mut bundled = search_bundled(&bundled, mazes, exploration, jobs, &progress).into_iter();
    drop(progress);
    let figures = candidates.iter().map(|candidate| {
        let figures: &mut dyn Iterator<Item = Figures> = match candidate {
            Candidate::Bundled(_) => &mut bundled,
            Candidate::Own(_) => &mut own,
        };
        figures.take(mazes.len()).collect()
    });
    Ok(figures.collect())
}

/// Runs each strategy in each maze. Uses `threads` threads, or one thread per processor if
/// `threads` is `None`. Returns the figures in the order of the strategies.
fn search_bundled(
    strategies: &[BundledStrategy],
    mazes: &[Selected],
    exploration: &Exploration,
    threads: Option<u16>,
    progress: &ProgressBar,
) -> Vec<Figures> {
    let jobs: Vec<(BundledStrategy, &Selected)> = (strategies.iter())
        .flat_map(|&strategy| mazes.iter().map(move |maze| (strategy, maze)))
        .collect();
    // The measured processor time includes creating the mouse and the search run, but not the
    // figures.
    let work = |&(strategy, selected): &(BundledStrategy, &Selected)| {
        let mouse = || exploration.strategy(strategy);
        let figures = search(&selected.maze, mouse, strategy.max_states());
        progress.inc(1);
        figures
    };
    match threads {
        Some(threads) => map_on(threads.into(), &jobs, work),
        None => map_each(&jobs, work),
    }
}

/// Runs each of the user's mice in each maze. Returns the figures in the order of the mice. After
/// Ctrl-C, stops the mice and exits.
fn search_own(
    mice: &[&NamedMouse],
    mazes: &[Selected],
    limits: SearchLimits,
    jobs: Option<u16>,
    progress: &ProgressBar,
) -> Result<Vec<Figures>, Box<dyn Error>> {
    if mice.is_empty() || mazes.is_empty() {
        return Ok(Vec::new());
    }
    // Each search needs about twelve open files. If the request fails, the limit may still suffice.
    raise_file_limit(MAX_FILES);
    let slots = match jobs {
        Some(jobs) => jobs.into(),
        None => thread::available_parallelism().map_or(1, NonZero::get),
    };
    let jobs: Vec<(usize, usize)> =
        (0..mice.len()).flat_map(|mouse| (0..mazes.len()).map(move |maze| (mouse, maze))).collect();
    // The number of the first mazes in which each mouse has reached the time limit.
    let stuck: Vec<AtomicUsize> = mice.iter().map(|_| AtomicUsize::new(0)).collect();
    let is_skipped = |(mouse, maze): (usize, usize)| {
        maze >= FIRST_MAZES && stuck[mouse].load(Ordering::Relaxed) == FIRST_MAZES
    };
    let stop = StopFlag::catch()?;
    let mut figures = map_waiting(&jobs, slots, |&(mouse, maze), slot| {
        let selected = &mazes[maze];
        if stop.is_set() || is_skipped((mouse, maze)) {
            progress.inc(1);
            return skip(&selected.maze);
        }
        let program = &mice[mouse].program;
        let found = own_search::search(program, &selected.maze, limits, slot, stop.get());
        let is_stuck = found.ending == Ending::TimeLimit && !found.goal_reached;
        if is_stuck && maze < FIRST_MAZES {
            stuck[mouse].fetch_add(1, Ordering::Relaxed);
        }
        progress.inc(1);
        found
    });
    // Some searches may have begun before the mouse was known to be stuck.
    for (figures, &job) in figures.iter_mut().zip(&jobs).filter(|(_, job)| is_skipped(**job)) {
        *figures = skip(&mazes[job.1].maze);
    }
    stop.end();
    Ok(figures)
}

/// Returns the figures of a search that was not run.
fn skip(maze: &Maze) -> Figures {
    let reason =
        format!("skipped: stopped by the time limit in each of the first {FIRST_MAZES} mazes");
    Figures { ending: Ending::Skipped, error: Some(reason), ..Track::new(maze).figures() }
}
