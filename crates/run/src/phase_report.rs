//! The figures of each phase for reports.

use serde::Serialize;

use crate::phases::{Phases, RunFigures, RunPhase};

/// The steps, turns and times of the phases up to a state. The field names are JSON keys. See
/// [`Phases`] for the meaning of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PhaseReport {
    /// The search run.
    pub search_run: RunReport,
    /// The latest return run, or `None` if there is none.
    pub return_run: Option<RunReport>,
    /// The latest fast run, or `None` if there is none.
    pub fast_run: Option<RunReport>,
    /// The best complete fast run, or `None` if there is none.
    pub best_run: Option<RunReport>,
    /// All runs together. The time is that since the first state.
    pub total: RunReport,
    /// The number of fast runs that have begun.
    pub fast_runs: u32,
    /// The number of times that the mouse was put back at the start.
    pub restarts: u32,
    /// The number of jumps to other cells.
    pub jumps: u32,
}

/// The figures of one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RunReport {
    /// The number of steps, in cells.
    pub steps: u64,
    /// The number of quarter turns.
    pub turns: u64,
    /// The time of the computer, in s.
    pub wall_time_s: f64,
}

impl PhaseReport {
    /// Creates the report on the phases up to a state. `seconds` returns the time in s between two
    /// states, which are numbered from 0.
    pub fn new(phases: &Phases, seconds: impl Fn(usize, usize) -> f64) -> Self {
        let run = |run: RunFigures| RunReport {
            steps: run.steps.into(),
            turns: run.turns.into(),
            wall_time_s: seconds(run.first as usize, run.last as usize),
        };
        let nonempty = |figures: RunFigures| (!figures.is_empty()).then(|| run(figures));
        Self {
            search_run: run(phases.search_run),
            return_run: nonempty(phases.return_run),
            fast_run: nonempty(phases.fast_run),
            best_run: phases.best_run.map(run),
            total: RunReport {
                steps: phases.total.steps,
                turns: phases.total.turns,
                wall_time_s: seconds(0, phases.states.saturating_sub(1) as usize),
            },
            fast_runs: phases.fast_runs,
            restarts: phases.restarts,
            jumps: phases.jumps,
        }
    }

    /// Returns each run with its name. The total is last, unless there is only a search run.
    pub fn rows(&self) -> Vec<(String, RunReport)> {
        let is_one = self.return_run.is_none() && self.fast_run.is_none();
        let fast_run = match self.fast_runs {
            0 | 1 => RunPhase::Fast.name(),
            number => format!("fast run {number}"),
        };
        [
            (RunPhase::Search.name(), Some(self.search_run)),
            (RunPhase::Return.name(), self.return_run),
            (fast_run, self.fast_run),
            ("best fast run".into(), self.best_run.filter(|_| self.fast_runs > 1)),
            ("total".into(), (!is_one).then_some(self.total)),
        ]
        .into_iter()
        .filter_map(|(name, run)| Some((name, run?)))
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_run_has_its_time() {
        let times = [5., 5.5, 7., 17., 20.];
        let seconds = |first: usize, last: usize| times[last] - times[first];
        let run = |first, last, steps, turns| RunFigures { first, last, steps, turns };
        let mut phases = Phases::default();
        (phases.states, phases.search_run) = (3, run(0, 1, 3, 1));
        phases.total.steps = 9;
        let text = |report: &PhaseReport| {
            let rows = report.rows().into_iter();
            rows.map(|(name, run)| format!("{name} {}", run.wall_time_s))
                .collect::<Vec<_>>()
                .join(", ")
        };
        let searched = PhaseReport::new(&phases, seconds);
        assert_eq!(searched.search_run, RunReport { steps: 3, turns: 1, wall_time_s: 0.5 });
        assert_eq!(text(&searched), "search run 0.5");
        (phases.return_run, phases.fast_run) = (run(1, 2, 3, 0), run(3, 4, 3, 0));
        (phases.best_run, phases.fast_runs) = (Some(phases.fast_run), 1);
        phases.states = 5;
        let report = PhaseReport::new(&phases, seconds);
        assert_eq!(text(&report), "search run 0.5, return run 1.5, fast run 3, total 15");
        phases.fast_runs = 2;
        let report = PhaseReport::new(&phases, seconds);
        assert_eq!(
            text(&report),
            "search run 0.5, return run 1.5, fast run 2 3, best fast run 3, total 15"
        );
    }
}
