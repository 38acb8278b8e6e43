//! The figures of a search.

use std::fmt;

use mmsim_fastrun::FastRun;
use mmsim_maze::{Cell, CellSet, Walls, counted};
use serde::Serialize;

use crate::cause::Cause;
use crate::times::SearchTimes;
use crate::verdict::{Ending, Verdict};

/// The statistics of a search, excluding the fast run unless stated otherwise. The field names
/// are JSON keys and CSV column names.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SearchFigures {
    /// True if the mouse has reached the goal.
    pub goal_reached: bool,
    /// The number of steps until the mouse first reached a goal cell, possibly on the fast run.
    pub steps_to_goal: Option<u32>,
    /// The number of steps until the shortest path was proven.
    pub steps_until_proven: Option<u32>,
    /// The number of steps until the mouse stopped or began its fast run.
    pub search_steps: u32,
    /// The number of quarter turns until the mouse stopped or began its fast run. A U-turn counts
    /// as two quarter turns.
    pub search_turns: u32,
    /// The length in steps of the shortest path known to be open at the end of the search.
    pub path_found: Option<u16>,
    /// The distance in steps from the start to the goal in the true maze, or `None` if the goal is
    /// unreachable.
    pub shortest_path: Option<u16>,
    /// The number of cells in which the mouse has been, including the fast run.
    pub visited_cells: usize,
    /// The number of states, including those of the fast run.
    pub states: u32,
    /// The processor time in microseconds, rounded to three decimal places, or `None` for a mouse in
    /// another process.
    pub processor_time_us: Option<f64>,
    /// The reason why the search or the fast run ended early.
    pub error: Option<String>,
    /// How the search ended.
    pub ending: Ending,
    /// The number of steps of the best complete fast run.
    pub fast_run_steps: Option<u32>,
    /// The number of movements that a wall blocked, or `None` for a protocol client without
    /// misreadings, which reports only poses.
    pub crashes: Option<u32>,
    /// True if the mouse correctly reported that the goal is unreachable.
    #[serde(skip)]
    pub is_rightly_given_up: bool,
    /// True if the mouse has stopped by itself or begun its fast run, so the figures of the whole
    /// search are complete.
    #[serde(skip)]
    pub is_complete: bool,
    /// The cells that the mouse entered until it stopped or began its fast run.
    #[serde(skip)]
    pub path: Vec<Cell>,
    /// The cause that the mouse has not reached the goal, if it is known. `error` states it.
    #[serde(skip)]
    pub cause: Option<Cause>,
    /// Where a repetition of the search differed, if one did.
    #[serde(skip)]
    pub random: Option<Divergence>,
    /// What the mouse can do after the search.
    #[serde(skip)]
    pub outcome: SearchOutcome,
    /// The times of a vehicle, if one was given.
    #[serde(skip)]
    pub times: Option<SearchTimes>,
}

/// Where a repetition of a search differs from the first run. The field names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Divergence {
    /// The numbers of both runs, counted from 1.
    pub runs: [u16; 2],
    /// The number of equal steps.
    pub steps: usize,
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { runs: [one, other], steps } = self;
        write!(f, "runs {one} and {other} differ from step {} on", steps + 1)
    }
}

/// What a mouse knows and where it is when it stops or begins its fast run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SearchOutcome {
    /// The walls that the mouse knows. Unknown walls count as present.
    pub known_walls: Option<Walls>,
    /// The cell in which the mouse is.
    pub last_cell: Option<Cell>,
    /// The cells of the first complete fast run, or no cells if the mouse made none.
    pub route: Vec<Cell>,
    /// This fast run, if the mouse has driven it with slalom turns.
    pub driven: Option<FastRun>,
    /// The number of quarter turns until the mouse first reached a goal cell, or 0.
    pub turns_to_goal: u32,
    /// The number of times that the mouse was put back at the start or ran into a wall.
    pub touches: u32,
    /// The number of these before the mouse first reached a goal cell.
    pub touches_to_goal: u32,
}

impl SearchFigures {
    /// Adds the verdict on the mouse.
    #[must_use]
    pub fn with_verdict(self, verdict: Verdict) -> Self {
        let Verdict { goal_reached, ending, error, cause } = verdict;
        Self { goal_reached, error, ending, cause, ..self }
    }

    /// Returns the reason why the mouse failed: it has neither reached the goal nor correctly reported
    /// that the goal is unreachable.
    pub fn failure(&self) -> Option<String> {
        let limit = || format!("goal not reached after {}", counted(self.search_steps, "step"));
        let has_failed = !self.goal_reached && !self.is_rightly_given_up;
        has_failed.then(|| self.error.clone().unwrap_or_else(limit))
    }

    /// Notes where run number `run` of the same mouse in the same maze differs from this first run: in its
    /// cells, in whether it has reached the goal, or in whether it has failed. A run that a limit has
    /// ended may be shorter.
    pub fn compare_repetition(&mut self, run: u16, other: &Self) {
        let is_cut = |figures: &Self| !matches!(figures.ending, Ending::Finished | Ending::GaveUp);
        let equal = self.path.iter().zip(&other.path).take_while(|(one, two)| one == two).count();
        let shorter = self.path.len().min(other.path.len());
        let may_be_shorter = is_cut(self) || is_cut(other);
        let result = |figures: &Self| (figures.goal_reached, figures.ending == Ending::Failed);
        let is_same = equal == shorter
            && (may_be_shorter || self.path.len() == other.path.len())
            && result(self) == result(other);
        if !is_same {
            // The first cell is the start.
            let steps = equal.saturating_sub(1);
            self.random.get_or_insert(Divergence { runs: [1, run], steps });
        }
    }

    /// Returns the number of steps before the mouse first reached a goal cell that led into cells in
    /// which it had been before, so they revealed no new walls.
    pub fn repeated_steps(&self) -> usize {
        let steps = self.steps_to_goal.unwrap_or(self.search_steps) as usize;
        let mut visited = CellSet::default();
        self.path.iter().take(steps + 1).filter(|&&cell| !visited.insert(cell)).count()
    }

    /// Returns the reason why a mouse that has reached the goal did not finish: it did not stop by
    /// itself, or it jumped.
    pub fn unfinished(&self) -> Option<&str> {
        self.error.as_deref().filter(|_| self.goal_reached)
    }
}

#[cfg(test)]
mod tests {
    use super::Ending::{GaveUp, TimeLimit};
    use super::*;

    #[test]
    fn a_repetition_differs_where_its_path_does() {
        let figures = |path: &[u8], ending| SearchFigures {
            path: path.iter().map(|&x| Cell::new(x, 0)).collect(),
            ending,
            ..SearchFigures::default()
        };
        for (ending, other, expected) in [
            (GaveUp, &[0, 1, 2][..], None),
            (GaveUp, &[0, 1, 0], Some(1)),
            (TimeLimit, &[0, 1, 0], Some(1)),
            (GaveUp, &[0, 1], Some(1)),
            (TimeLimit, &[0, 1], None),
        ] {
            let mut first = figures(&[0, 1, 2], ending);
            first.compare_repetition(2, &figures(other, GaveUp));
            assert_eq!(first.random.map(|random| random.steps), expected, "{ending:?} {other:?}");
        }
    }

    #[test]
    fn steps_into_known_cells_count_until_the_goal() {
        let path: Vec<Cell> = [0, 1, 2, 1, 0, 1, 2, 3, 2].map(|x| Cell::new(x, 0)).to_vec();
        let repeated = |steps_to_goal| {
            let path = path.clone();
            SearchFigures { steps_to_goal, path, search_steps: 8, ..Default::default() }
                .repeated_steps()
        };
        assert_eq!([Some(2), Some(7), None].map(repeated), [0, 4, 5]);
    }
}
