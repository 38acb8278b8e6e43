//! The steps, turns and times of the phases of a search, and their table.

use std::time::Instant;

use mmsim_maze::Pose;
use mmsim_recording::{Course, OutOfMemory, PhaseReport, Phases, RunReport, Times};

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

/// The phases of the states that a mouse sends, and their times.
pub(crate) struct PhaseTimes {
    course: Course,
    phases: Phases,
    times: Times,
    /// The time of the first state.
    began: Option<Instant>,
    /// The pose in the newest state.
    pose: Option<Pose>,
}

impl PhaseTimes {
    /// Creates the phases before the first state.
    pub(crate) fn new(course: Course) -> Self {
        Self { course, phases: Phases::default(), times: Times::new(1), began: None, pose: None }
    }

    /// Adds a state. Returns an error if memory runs out.
    pub(crate) fn add(&mut self, pose: Pose, now: Instant) -> Result<(), OutOfMemory> {
        let index = self.times.len();
        let began = *self.began.get_or_insert(now);
        let elapsed = now.saturating_duration_since(began).as_nanos();
        self.times.push(u64::try_from(elapsed).unwrap_or(u64::MAX))?;
        match self.pose.replace(pose) {
            Some(before) => {
                let transition = self.course.transition(before, pose);
                self.phases.add(&self.course, index, transition, pose);
            }
            None => self.phases.arrive(&self.course, pose),
        }
        Ok(())
    }

    /// Returns the figures of the phases, or `None` before the first state.
    pub(crate) fn report(&self) -> Option<PhaseReport> {
        let newest = self.times.len().checked_sub(1)?;
        Some(PhaseReport::new(&self.phases, newest, &self.times))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use mmsim_maze::{KnownMaze, Maze};
    use mmsim_solvers::{BundledStrategy, Mouse, SearchDriver};

    use super::*;

    #[test]
    fn the_time_of_each_step_belongs_to_its_phase() {
        let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse().unwrap();
        let strategy = BundledStrategy::ShortestPathSearch.strategy();
        let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(&maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, 100);
        let (mut times, mut now) = (PhaseTimes::new(Course::from_maze(&maze)), Instant::now());
        assert_eq!(times.report(), None);
        while driver.advance_in(&maze) == Ok(true) {
            times.add(driver.mouse().pose(), now).unwrap();
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
