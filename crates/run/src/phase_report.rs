//! The figures of each phase for reports.

use mmsim_fastrun::Planner;
use mmsim_maze::{Cell, MazeSize, Pose};
use serde::Serialize;

use crate::movement::MovementRules;
use crate::phases::{Phases, RunFigures, RunPhase};
use crate::times::{MouseClock, tenth_of_ms};

/// The steps, turns and times of the phases up to a state. The field names are JSON keys. See
/// [`Phases`] for the meaning of the runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseReport {
    /// The search run.
    pub search_run: RunReport,
    /// The latest return run, or `None` if there is none.
    pub return_run: Option<RunReport>,
    /// The latest fast run, or `None` if there is none.
    pub fast_run: Option<RunReport>,
    /// The best complete fast run, or `None` if there is none.
    pub best_run: Option<RunReport>,
    /// All runs together. The time never falls from state to state. It contains no turns in the start
    /// cell before a fast run.
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
    /// The time of the mouse in s. `None` in a two-run trial, which counts time steps, if the vehicle
    /// cannot drive the run, and for all runs together after a second fast run.
    pub time_s: Option<f64>,
    /// The time of the computer in s.
    pub wall_time_s: f64,
}

impl PhaseReport {
    /// Creates the report on the phases up to a state. Without a clock, no run has a time of the mouse.
    /// `cells` returns the cells of a run, and `wall_time_s` the time of the computer in s between two
    /// states, which are numbered from 0.
    pub fn new(
        phases: &Phases,
        mut clock: Option<MouseClock<'_>>,
        cells: impl Fn(RunFigures) -> Vec<Cell>,
        wall_time_s: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let report = |run: RunFigures, time_s| RunReport {
            steps: run.steps.into(),
            turns: run.turns.into(),
            time_s,
            wall_time_s: wall_time_s(run.first as usize, run.last as usize),
        };
        let search = |run: RunFigures, clock: &Option<MouseClock<'_>>| {
            let time = clock.as_ref().map(|it| it.search_time(run.steps.into(), run.turns.into()));
            report(run, time)
        };
        let mut fast =
            |run| report(run, clock.as_mut().and_then(|it| it.fast_run_time(&cells(run))));
        let fast_run = Some(phases.fast_run).filter(|run| !run.is_empty()).map(&mut fast);
        let best_run = phases.best_run.map(|run| match fast_run {
            Some(report) if run == phases.fast_run => report,
            _ => fast(run),
        });
        let total = phases.total;
        let driven = fast_run.unwrap_or_default();
        // The turns of a fast run include those in the start cell.
        let turns = total.turns - driven.turns - u64::from(phases.turns_at_start);
        let explored = clock.as_ref().map(|it| it.search_time(total.steps - driven.steps, turns));
        let last = fast_run.map_or(Some(0.0), |run| run.time_s);
        Self {
            search_run: search(phases.search_run, &clock),
            return_run: Some(phases.return_run)
                .filter(|run| !run.is_empty())
                .map(|run| search(run, &clock)),
            fast_run,
            best_run,
            total: RunReport {
                steps: total.steps,
                turns: total.turns,
                time_s: explored
                    .zip(last)
                    .filter(|_| phases.fast_runs <= 1)
                    .map(|(explored, last)| tenth_of_ms(explored + last)),
                wall_time_s: wall_time_s(0, phases.states.saturating_sub(1) as usize),
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

/// The poses and the phases of a mouse, state by state.
#[derive(Clone, Debug)]
pub struct PhaseLog {
    rules: MovementRules,
    phases: Phases,
    poses: Vec<Pose>,
}

impl PhaseLog {
    /// Creates the log of a mouse that has not begun.
    pub fn new(rules: MovementRules) -> Self {
        Self { rules, phases: Phases::default(), poses: Vec::new() }
    }

    /// Adds the pose in the next state.
    pub fn add(&mut self, pose: Pose) {
        self.poses.push(pose);
        self.phases.add(&self.rules, pose, false);
    }

    /// Returns the report on the phases in a maze of this size, or `None` before the first state. The
    /// vehicle of the planner times the runs. See [`PhaseReport::new`] for `wall_time_s`.
    pub fn report(
        &self,
        planner: &mut Planner,
        size: MazeSize,
        wall_time_s: impl Fn(usize, usize) -> f64,
    ) -> Option<PhaseReport> {
        let cells = |run: RunFigures| {
            let mut cells = Vec::new();
            for pose in &self.poses[run.first as usize..=run.last as usize] {
                self.rules.extend_path(&mut cells, pose.cell);
            }
            cells
        };
        let clock = Some(MouseClock::new(planner, size));
        (!self.poses.is_empty()).then(|| PhaseReport::new(&self.phases, clock, cells, wall_time_s))
    }
}

#[cfg(test)]
mod tests {
    use mmsim_fastrun::Vehicle;
    use mmsim_maze::{Heading, Maze, Walls};
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn each_run_has_its_times() {
        let times = [5., 5.5, 7., 17., 20.];
        let run = |first, last, steps, turns| RunFigures { first, last, steps, turns };
        let mut planner = Planner::new(Vehicle::expert());
        // All fast runs lead three cells to the north.
        let cells = |_| (0..4).map(|y| Cell::new(0, y)).collect::<Vec<_>>();
        let mut report = |phases: &Phases| {
            let clock = Some(MouseClock::new(&mut planner, MazeSize::CLASSIC));
            PhaseReport::new(phases, clock, cells, |first, last| times[last] - times[first])
        };
        let text = |report: &PhaseReport| {
            let rows = report.rows().into_iter().map(|(name, run)| {
                let time = run.time_s.map_or("-".into(), |time| format!("{time:.4}"));
                format!("{name} {time} {}", run.wall_time_s)
            });
            rows.collect::<Vec<_>>().join(", ")
        };
        let mut phases = Phases::default();
        (phases.states, phases.search_run) = (3, run(0, 1, 3, 1));
        (phases.total.steps, phases.total.turns) = (3, 1);
        // 3 cells of 0.3 s and a quarter turn of 0.2 s.
        assert_eq!(text(&report(&phases)), "search run 1.1000 0.5");
        (phases.return_run, phases.fast_run) = (run(1, 2, 3, 2), run(3, 4, 3, 2));
        (phases.best_run, phases.fast_runs) = (Some(phases.fast_run), 1);
        (phases.states, phases.total.steps, phases.total.turns) = (5, 9, 5);
        // 3 cells and 90 mm with 17 m/s² and at most 2.5 m/s: 2.5 / 17 s + 630 mm / 2.5 m/s.
        assert_eq!(
            text(&report(&phases)),
            "search run 1.1000 0.5, return run 1.3000 1.5, fast run 0.3991 3, total 2.7991 15"
        );
        phases.fast_runs = 2;
        assert_eq!(
            text(&report(&phases)),
            "search run 1.1000 0.5, return run 1.3000 1.5, fast run 2 0.3991 3, \
             best fast run 0.3991 3, total - 15"
        );
        let untimed = PhaseReport::new(&phases, None, cells, |_, _| 0.0);
        assert!(untimed.rows().iter().all(|(_, run)| run.time_s.is_none()));
    }

    proptest! {
        #[test]
        fn the_total_time_never_falls(
            (start, goal) in (any::<(u8, u8)>(), any::<(u8, u8)>()),
            moves in prop::collection::vec((0u8..8, 0usize..4), 1..80),
        ) {
            let size = MazeSize::new(4, 3).unwrap();
            let cell = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let goals = [cell(goal)].into_iter().collect();
            let maze = Maze::new(Walls::open(size), cell(start), goals);
            prop_assume!(maze.is_ok());
            let maze = maze.unwrap();
            let mut log = PhaseLog::new(MovementRules::from_maze(&maze));
            let mut planner = Planner::new(Vehicle::expert());
            let (mut pose, mut before) = (maze.start(), 0.0);
            log.add(pose);
            for (kind, heading) in moves {
                let heading = Heading::ALL[heading];
                pose = match kind {
                    0 => maze.start(),
                    1..4 => Pose::new(pose.cell, heading),
                    _ => Pose::new(size.neighbour(pose.cell, heading).unwrap_or(pose.cell), heading),
                };
                log.add(pose);
                let report = log.report(&mut planner, size, |_, _| 0.0).unwrap();
                let Some(time) = report.total.time_s else { continue };
                prop_assert!(time >= before, "{} s after {} s: {:?}", time, before, log.phases);
                before = time;
            }
        }
    }
}
