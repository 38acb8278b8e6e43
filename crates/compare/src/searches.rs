//! The searches of several mice in several mazes.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use mmsim_fastrun::Planners;
use mmsim_maze::{Maze, counted};
use mmsim_mouse::{
    ENDPOINT_VARIABLE, MAX_INVALID_BYTES, MouseKind, Program, SearchEnd, SearchLimits,
    SearchReport, Shortage, exit_failure, exit_text,
};
use mmsim_run::{EndFacts, Ending, Judge, SearchFigures, SearchTimes, Senses, Verdict, search};

use crate::compared_mouse::ComparedMouse;
use crate::exploration::Exploration;
use crate::named_maze::NamedMaze;
use crate::parallel::{Gate, Slot, map_each, map_waiting};

/// If a mouse reaches the time limit in each of its first mazes, its further searches are skipped.
const FIRST_MAZES: usize = 3;

/// How mice search.
pub struct Searches<'a> {
    /// The vehicle and the tolerance of strategies that explore for the fastest run.
    pub exploration: &'a Exploration,
    /// How mice read walls. The user's mice recover by themselves.
    pub senses: Senses,
    /// The limits of the user's mice.
    pub limits: SearchLimits,
    /// The limit of states of a strategy, or `None` for its usual limit.
    pub max_states: Option<u32>,
    /// The number of searches at a time, or `None` for one on each processor.
    pub jobs: Option<u16>,
}

impl Searches<'_> {
    /// Runs each mouse in each maze. Returns the figures of each mouse in each maze. Calls `progress`
    /// after each search. Once `must_stop` returns true, the remaining searches end early, and the
    /// figures mean nothing. If the system lacks something for so many searches at a time, runs fewer.
    ///
    /// # Errors
    /// The system lacks something even for one search at a time.
    pub fn run(
        &self,
        mice: &[ComparedMouse],
        mazes: &[NamedMaze],
        progress: &(dyn Fn() + Sync),
        must_stop: impl Fn() -> bool + Sync,
    ) -> Result<Vec<Vec<SearchFigures>>, Shortage> {
        let searches: Vec<(usize, usize)> = (0..mice.len())
            .flat_map(|mouse| (0..mazes.len()).map(move |maze| (mouse, maze)))
            .collect();
        // The number of the first mazes in which each mouse has reached the time limit.
        let stuck: Vec<AtomicUsize> = mice.iter().map(|_| AtomicUsize::new(0)).collect();
        let is_skipped = |(mouse, maze): (usize, usize)| {
            maze >= FIRST_MAZES && stuck[mouse].load(Ordering::Relaxed) == FIRST_MAZES
        };
        let gate = Gate::new();
        let search = |&(mouse, maze): &(usize, usize), slot: &mut Slot| {
            let selected = &mazes[maze].maze;
            let found = match &mice[mouse] {
                _ if must_stop() || is_skipped((mouse, maze)) => skip(selected),
                // The measured processor time includes creating the mouse and the search run, but not the
                // figures.
                ComparedMouse::Bundled(strategy) => {
                    let new = || self.exploration.strategy(*strategy, selected.size());
                    let max_states = self.max_states.unwrap_or(strategy.max_states());
                    search(selected, new, max_states, self.senses, thread_time, &must_stop)
                        .unwrap_or_default()
                }
                ComparedMouse::Own(mouse) => {
                    let slot = RefCell::new(slot);
                    let run = || {
                        let release = &mut || slot.borrow_mut().release();
                        self.search_own(&mouse.program, selected, release, &must_stop)
                    };
                    gate.run(run)?
                }
            };
            let is_stuck = found.ending == Ending::TimeLimit && !found.goal_reached;
            if is_stuck && maze < FIRST_MAZES {
                stuck[mouse].fetch_add(1, Ordering::Relaxed);
            }
            progress();
            Ok(found)
        };
        let may_wait = mice.iter().any(ComparedMouse::is_own);
        let figures = map_waiting(&searches, self.jobs, may_wait, search);
        let mut figures = figures.into_iter().collect::<Result<Vec<_>, _>>()?;
        // Some searches may have begun before the mouse was known to be stuck.
        for (figures, &(mouse, maze)) in figures.iter_mut().zip(&searches) {
            if is_skipped((mouse, maze)) {
                *figures = skip(&mazes[maze].maze);
            }
        }
        let mut figures = figures.into_iter();
        Ok(mice.iter().map(|_| figures.by_ref().take(mazes.len()).collect()).collect())
    }

    /// Runs the mouse in the maze until it exits or reaches a limit. Calls `release` if the mouse needs
    /// no processor, so that another search can use it.
    fn search_own(
        &self,
        program: &Program,
        maze: &Maze,
        release: &mut dyn FnMut(),
        must_stop: &dyn Fn() -> bool,
    ) -> Result<SearchFigures, Shortage> {
        let (limits, misreadings) = (self.limits, self.senses.misreadings);
        let mut report =
            mmsim_mouse::search(program, maze, limits, misreadings, release, must_stop);
        let verdict = verdict(&report, limits)?;
        let figures = own_figures(&mut report.judge, verdict);
        let knows_crashes = report.kind != Some(MouseKind::Client) || misreadings.probability > 0.0;
        Ok(SearchFigures {
            crashes: figures.crashes.filter(|_| knows_crashes),
            // A program that does nothing does not know that the goal is unreachable.
            is_rightly_given_up: figures.is_rightly_given_up && report.kind.is_some(),
            ..figures
        })
    }
}

/// Returns the figures of a search that was not run.
fn skip(maze: &Maze) -> SearchFigures {
    let reason =
        format!("skipped: stopped by the time limit in each of the first {FIRST_MAZES} mazes");
    SearchFigures { ending: Ending::Skipped, error: Some(reason), ..Judge::new(maze).figures() }
}

/// Returns the figures of a mouse of the user from what a judge has seen of its search.
pub fn own_figures(judge: &mut Judge, verdict: Verdict) -> SearchFigures {
    let ending = verdict.ending;
    let figures = judge.figures().with_verdict(verdict);
    SearchFigures {
        is_rightly_given_up: figures.shortest_path.is_none() && ending == Ending::GaveUp,
        is_complete: figures.is_complete || ending == Ending::Finished,
        ..figures
    }
}

/// Returns the verdict on the mouse. There is none if the system lacked something.
fn verdict(report: &SearchReport, limits: SearchLimits) -> Result<Verdict, Shortage> {
    let SearchReport { judge, end, kind, fault, sent } = report;
    let unheard =
        format!(" (it has neither written mms commands nor connected to {ENDPOINT_VARIABLE})");
    let unheard = if kind.is_none() { unheard } else { String::new() };
    let fault = fault.as_ref().filter(|_| !judge.phases().is_goal_reached());
    let mut hint = unheard + &fault.map(|fault| format!("; {fault}")).unwrap_or_default();
    let (ending, error) = match end {
        SearchEnd::Exited(status, line) if !status.success() => {
            if !line.is_empty() {
                hint = format!(": {line}");
            }
            (Ending::Failed, exit_text(*status))
        }
        SearchEnd::Exited(..) | SearchEnd::Idle | SearchEnd::Goal => {
            (Ending::Finished, String::new())
        }
        SearchEnd::TimeLimit => {
            let seconds = limits.time.as_secs_f64();
            (Ending::TimeLimit, format!("stopped after {seconds} s"))
        }
        SearchEnd::StepLimit => {
            let limit = counted(judge.phases().states, "state");
            (Ending::StepLimit, format!("stopped after {limit}"))
        }
        SearchEnd::Flood => {
            let limit = MAX_INVALID_BYTES >> 20;
            (Ending::Failed, format!("wrote {limit} MiB without a valid command"))
        }
        SearchEnd::Failed(reason) => (Ending::Failed, reason.clone()),
        SearchEnd::Shortage(shortage) => return Err(shortage.clone()),
        SearchEnd::Interrupted => (Ending::Stopped, "interrupted".into()),
    };
    let exit = match end {
        SearchEnd::Exited(status, _) => exit_failure(*status),
        _ => None,
    };
    let cause = judge.cause(&EndFacts { ending, exit, ..*sent });
    let verdict = Verdict::new(judge.phases(), ending, Some(error), cause);
    let has_hint = judge.phases().first_jump.is_none()
        && !matches!(end, SearchEnd::StepLimit | SearchEnd::Failed(_) | SearchEnd::Interrupted);
    let error = verdict.error.map(|error| if has_hint { error + &hint } else { error });
    Ok(Verdict { error, ..verdict })
}

/// Returns the processor time that this thread has used so far.
#[cfg(unix)]
fn thread_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};

    clock_gettime(ClockId::ThreadCPUTime).try_into().unwrap_or_default()
}

/// Returns the wall-clock time since the first call, because Windows measures the processor time
/// only in steps of 16 ms.
#[cfg(not(unix))]
fn thread_time() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;

    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed()
}

/// Adds the times of all searches to their figures, with the vehicle for the size of each maze. Each
/// mouse has figures in each maze.
pub fn measure_times(figures: &mut [Vec<SearchFigures>], mazes: &[NamedMaze], planners: &Planners) {
    let indices: Vec<usize> = (0..mazes.len()).collect();
    let times = map_each(&indices, |&maze| {
        let searches = figures.iter().map(|figures| &figures[maze]);
        let maze = &mazes[maze].maze;
        SearchTimes::measure(&mut planners.for_size(maze.size()).clone(), maze, searches)
    });
    for (maze, times) in times.into_iter().enumerate() {
        for (figures, times) in figures.iter_mut().zip(times) {
            figures[maze].times = Some(times);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use mmsim_solvers::{BundledStrategy, Tolerance};

    use super::*;

    fn run(max_states: Option<u32>, is_stopped: bool) -> (Vec<Vec<SearchFigures>>, usize) {
        let exploration = Exploration::new(None, Tolerance::ZERO);
        let limits = SearchLimits { time: Duration::from_secs(1), states: 1, stops_at_goal: false };
        let searches = Searches {
            exploration: &exploration,
            senses: Senses::default(),
            limits,
            max_states,
            jobs: Some(2),
        };
        let mice = [BundledStrategy::FloodFill, BundledStrategy::LeftWall];
        let mice = mice.map(ComparedMouse::Bundled);
        let (count, mazes) = (AtomicUsize::new(0), mazes());
        let progress = || {
            count.fetch_add(1, Ordering::Relaxed);
        };
        let mut figures = searches.run(&mice, &mazes, &progress, || is_stopped).unwrap();
        measure_times(&mut figures, &mazes, &Planners::new(None));
        (figures, count.into_inner())
    }

    fn mazes() -> Vec<NamedMaze> {
        let drawings = ["o---o---o\n| S   G |\no---o---o\n", "o---o---o\n| S | G |\no---o---o\n"];
        let maze = |drawing: &str| NamedMaze {
            path: PathBuf::new(),
            name: "maze".into(),
            maze: drawing.parse().unwrap(),
        };
        drawings.map(maze).into()
    }

    #[test]
    fn each_mouse_has_figures_and_times_in_each_maze() {
        let (figures, count) = run(None, false);
        assert_eq!(count, 4);
        for figures in figures {
            assert_eq!([0, 1].map(|maze: usize| figures[maze].goal_reached), [true, false]);
            let run = |maze: usize| figures[maze].times.and_then(|times| times.fast_run_time_s);
            assert!(run(0).is_some() && run(1).is_none());
        }
    }

    #[test]
    fn a_limit_of_states_and_a_stop_end_the_searches() {
        let endings = |figures: Vec<Vec<SearchFigures>>| -> Vec<Ending> {
            figures.iter().map(|figures| figures[0].ending).collect()
        };
        assert_eq!(endings(run(Some(1), false).0), [Ending::StepLimit; 2]);
        assert_eq!(endings(run(None, true).0), [Ending::Skipped; 2]);
    }

    #[cfg(unix)]
    #[test]
    fn waiting_for_another_thread_does_not_count() {
        let spent = Duration::from_millis(50);
        let begin = thread_time();
        std::thread::spawn(move || while thread_time() < spent {}).join().unwrap();
        let time = thread_time().saturating_sub(begin);
        assert!(time < spent, "{time:?}");
    }

    #[cfg(unix)]
    #[test]
    fn computing_counts() {
        let spent = Duration::from_millis(1);
        let begin = thread_time();
        while thread_time() < begin + spent {}
        assert!(thread_time() >= begin + spent);
    }
}
