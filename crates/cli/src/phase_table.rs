//! The steps, turns and times of the phases of a search, and their table.

use std::time::{Duration, Instant};

use mmsim_recording::{PhaseReport, RunReport};
use mmsim_solvers::{PhaseStats, SearchStats};

use crate::grid::aligned;
use crate::output::counted;

/// Formats the phases as a table with one line for each run.
pub(crate) fn table(report: &PhaseReport) -> String {
    run_table(report.rows())
}

/// Formats runs with their names as a table with one line for each run.
pub(crate) fn run_table(rows: impl IntoIterator<Item = (String, RunReport)>) -> String {
    let row = |(name, RunReport { steps, turns, ms }): (String, RunReport)| {
        vec![name, counted(steps, "step"), counted(turns, "turn"), format!("{:.3} s", ms / 1e3)]
    };
    aligned(&rows.into_iter().map(row).collect::<Vec<_>>())
}

/// Measures the time of each phase of a search.
#[derive(Default)]
pub(crate) struct PhaseTimes {
    /// The figures in the newest state, and the time of this state.
    newest: Option<(SearchStats, Instant)>,
    /// The times of the search run, the return run and the fast run.
    times: [Duration; 3],
}

impl PhaseTimes {
    /// Adds the time since the previous state to the phase in which the mouse has moved.
    pub(crate) fn add(&mut self, stats: &SearchStats, now: Instant) {
        if let Some((before, then)) = self.newest {
            let phases = before.phases().into_iter().zip(stats.phases());
            for (time, (before, after)) in self.times.iter_mut().zip(phases) {
                if before != after {
                    *time += now.saturating_duration_since(then);
                }
            }
        }
        self.newest = Some((*stats, now));
    }

    /// Returns the figures of the phases, or `None` before the first state.
    pub(crate) fn report(&self) -> Option<PhaseReport> {
        let (stats, _) = self.newest?;
        let run = |PhaseStats { steps, turns, .. }, time: Duration| {
            let ms = time.as_secs_f64() * 1e3;
            RunReport { steps: u64::from(steps), turns: u64::from(turns), ms }
        };
        let [search, back, fast] = self.times;
        let begun = |run: RunReport| (run.steps > 0).then_some(run);
        let fast_run = begun(run(stats.fast_run, fast));
        Some(PhaseReport {
            search_run: run(stats.search_run, search),
            return_run: begun(run(stats.return_run, back)),
            fast_run,
            best_run: None,
            total: RunReport {
                steps: stats.steps().into(),
                turns: stats.turns().into(),
                ms: self.times.iter().sum::<Duration>().as_secs_f64() * 1e3,
            },
            fast_runs: fast_run.is_some().into(),
            restarts: 0,
            jumps: 0,
        })
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{KnownMaze, Maze};
    use mmsim_solvers::{BundledStrategy, Mouse, SearchDriver};

    use super::*;

    #[test]
    fn the_time_of_each_step_belongs_to_its_phase() {
        let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse().unwrap();
        let strategy = BundledStrategy::ShortestPathSearch.strategy();
        let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(&maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, 100);
        let (mut times, mut now) = (PhaseTimes::default(), Instant::now());
        assert_eq!(times.report(), None);
        while driver.advance_in(&maze) == Ok(true) {
            times.add(driver.stats(), now);
            now += Duration::from_millis(driver.stats().steps().into());
        }
        insta::assert_snapshot!(table(&times.report().unwrap()), @r"
        search run  2 steps   1 turn  0.001 s
        return run  2 steps  2 turns  0.005 s
        fast run    2 steps  2 turns  0.009 s
        total       6 steps  5 turns  0.015 s
        ");
    }
}
