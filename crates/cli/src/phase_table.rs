//! The steps, turns and times of the phases of a search, and their table.

use mmsim_maze::{Pose, counted};
use mmsim_recording::{OutOfMemory, Times};
use mmsim_run::{MovementRules, PhaseReport, Phases, RunReport};

use crate::grid::aligned;

/// Formats runs with their names as a table with one line for each run.
pub(crate) fn table(rows: impl IntoIterator<Item = (String, RunReport)>) -> String {
    let row = |(name, RunReport { steps, turns, wall_time_s }): (String, RunReport)| {
        let [steps, turns] =
            [counted(steps, "step"), counted(turns, "turn")].map(|count| count.to_string());
        vec![name, steps, turns, format!("{wall_time_s:.3} s")]
    };
    aligned(&rows.into_iter().map(row).collect::<Vec<_>>())
}

/// The phases of the states that a mouse sends, and their times.
pub(crate) struct PhaseTimes {
    rules: MovementRules,
    phases: Phases,
    times: Times,
}

impl PhaseTimes {
    /// Creates the phases before the first state.
    pub(crate) fn new(rules: MovementRules) -> Self {
        Self { rules, phases: Phases::default(), times: Times::new(1) }
    }

    /// Adds a state at a time in nanoseconds. Returns an error if memory runs out.
    pub(crate) fn add(&mut self, pose: Pose, now: u64) -> Result<(), OutOfMemory> {
        self.times.push(now)?;
        self.phases.add(&self.rules, pose, false);
        Ok(())
    }

    /// Returns the figures of the phases, or `None` before the first state.
    pub(crate) fn report(&self) -> Option<PhaseReport> {
        let seconds = |first, last| self.times.seconds(first, last);
        (self.phases.states > 0).then(|| PhaseReport::new(&self.phases, seconds))
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
        let (mut times, mut now) = (PhaseTimes::new(MovementRules::from_maze(&maze)), 0);
        assert_eq!(times.report(), None);
        while driver.advance_in(&maze) == Ok(true) {
            times.add(driver.mouse().pose(), now).unwrap();
            now += 1_000_000 * u64::from(driver.stats().steps());
        }
        insta::assert_snapshot!(table(times.report().unwrap().rows()), @r"
        search run  2 steps   1 turn  0.001 s
        return run  2 steps  2 turns  0.005 s
        fast run    2 steps  2 turns  0.009 s
        total       6 steps  5 turns  0.015 s
        ");
    }
}
