//! The steps, turns and times of the phases of a search, and their table.

use mmsim_fastrun::Planner;
use mmsim_maze::{MazeSize, Pose, counted};
use mmsim_recording::{OutOfMemory, Times};
use mmsim_run::{MovementRules, PhaseLog, PhaseReport, RunReport};

use crate::grid::aligned;

/// Formats runs with their names as a table with one line for each run. Times are those of the mouse.
pub(crate) fn table(rows: impl IntoIterator<Item = (String, RunReport)>) -> String {
    let row = |(name, RunReport { steps, turns, time_s, .. }): (String, RunReport)| {
        let [steps, turns] =
            [counted(steps, "step"), counted(turns, "turn")].map(|count| count.to_string());
        let time = time_s.map_or_else(String::new, |time| format!("{time:.3} s"));
        vec![name, steps, turns, time]
    };
    aligned(&rows.into_iter().map(row).collect::<Vec<_>>())
}

/// The phases of the states that a mouse sends, and their times.
pub(crate) struct PhaseTimes {
    log: PhaseLog,
    times: Times,
}

impl PhaseTimes {
    /// Creates the phases before the first state.
    pub(crate) fn new(rules: MovementRules) -> Self {
        Self { log: PhaseLog::new(rules), times: Times::new(1) }
    }

    /// Adds a state at a time in nanoseconds. Returns an error if memory runs out.
    pub(crate) fn add(&mut self, pose: Pose, now: u64) -> Result<(), OutOfMemory> {
        self.times.push(now)?;
        self.log.add(pose);
        Ok(())
    }

    /// Returns the figures of the phases in a maze of this size, or `None` before the first state. The
    /// vehicle of the planner times the runs.
    pub(crate) fn report(&self, planner: &mut Planner, size: MazeSize) -> Option<PhaseReport> {
        self.log.report(planner, size, |first, last| self.times.seconds(first, last))
    }
}

#[cfg(test)]
mod tests {
    use mmsim_fastrun::Vehicle;
    use mmsim_maze::{KnownMaze, Maze};
    use mmsim_solvers::{BundledStrategy, Mouse, SearchDriver};

    use super::*;

    #[test]
    fn each_phase_has_the_time_of_the_vehicle() {
        let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse().unwrap();
        let strategy = BundledStrategy::ShortestPathSearch.strategy();
        let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(&maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, 100);
        let (mut times, mut now) = (PhaseTimes::new(MovementRules::from_maze(&maze)), 0);
        let mut planner = Planner::new(Vehicle::expert());
        assert_eq!(times.report(&mut planner, maze.size()), None);
        while driver.advance_in(&maze) == Ok(true) {
            times.add(driver.mouse().pose(), now).unwrap();
            now += 1_000_000 * u64::from(driver.stats().steps());
        }
        insta::assert_snapshot!(table(times.report(&mut planner, maze.size()).unwrap().rows()), @r"
        search run  2 steps   1 turn  0.800 s
        return run  2 steps  2 turns  1.000 s
        fast run    2 steps  2 turns  0.327 s
        total       6 steps  5 turns  2.127 s
        ");
    }
}
