//! The progress of a mouse through the runs of its search, for comparing two searches.

use crate::phases::{Phases, RunFigures, RunPhase};

/// How far a mouse has come: the number of its current leg, and the steps since the leg began.
///
/// Legs are the runs of a search in order: leg 0 is the search run, leg 2k is the k-th fast run, and
/// leg 2k + 1 is the return run that follows leg 2k. A mouse that waits in the goal or in the start
/// cell is at the end of a leg. A leg has no steps if the mouse is put back at the start instead of
/// returning. From state to state, the progress never decreases.
///
/// ```
/// use mmsim_recording::{LegProgress, Phases};
/// assert_eq!(Phases::default().leg(), LegProgress { leg: 0, steps: 0 });
/// assert!(LegProgress { leg: 1, steps: 3 } < LegProgress { leg: 2, steps: 0 });
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct LegProgress {
    /// The number of the leg.
    pub leg: u32,
    /// The number of steps since the leg began, in cells.
    pub steps: u32,
}

impl Phases {
    /// Returns the current leg and the steps since it began.
    pub fn leg(&self) -> LegProgress {
        let outward = 2 * u64::from(self.fast_runs);
        let returned = self.return_run;
        // Before the return run of this leg, `return_run` is an earlier one.
        let is_current = !returned.is_empty() && returned.first >= self.fast_run.first;
        let (leg, run) = match self.phase {
            RunPhase::Search => (outward, self.search_run),
            RunPhase::AtGoal if self.fast_runs == 0 => (outward, self.search_run),
            RunPhase::AtGoal | RunPhase::Fast => (outward, self.fast_run),
            RunPhase::Return => (outward + 1, returned),
            RunPhase::AtStart if is_current => (outward + 1, returned),
            RunPhase::AtStart => (outward + 1, RunFigures::default()),
        };
        LegProgress { leg: u32::try_from(leg).unwrap_or(u32::MAX), steps: run.steps }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, Maze, Pose};
    use proptest::prelude::*;

    use super::*;
    use crate::transition::Course;

    /// Returns the progress in each state of a mouse in a corridor of five cells, with the start in
    /// cell 0 and the goal in cell 4. The mouse is put back at the start if it moves from another cell
    /// to cell 0 with the heading north.
    fn progress(states: &[(u8, Heading)]) -> Vec<(u32, u32)> {
        let maze: Maze = "o---o---o---o---o---o\n| S               G |\no---o---o---o---o---o\n"
            .parse()
            .unwrap();
        let course = Course::from_maze(&maze);
        let pose = |state: usize| Pose::new(Cell::new(states[state].0, 0), states[state].1);
        let mut phases = Phases::default();
        phases.arrive(&course, pose(0));
        let mut all = vec![phases.leg()];
        for state in 1..states.len() {
            let transition = course.transition(pose(state - 1), pose(state));
            phases.add(&course, state, transition, pose(state));
            all.push(phases.leg());
        }
        all.into_iter().map(|LegProgress { leg, steps }| (leg, steps)).collect()
    }

    #[test]
    fn legs_are_the_runs_in_order() {
        use Heading::{East, North, West};
        let states = [
            (0, North),
            (3, East),
            (4, East),
            // A return run and the first fast run.
            (4, West),
            (1, West),
            (0, West),
            (0, East),
            (2, East),
            (4, East),
            // The mouse is put back instead of returning. The second fast run ends early.
            (0, North),
            (2, East),
            (0, North),
            // The third fast run.
            (1, East),
            (4, East),
            (4, West),
            (3, West),
        ];
        let expected = [
            (0, 0),
            (0, 3),
            (0, 4),
            (1, 0),
            (1, 3),
            (1, 4),
            (1, 4),
            (2, 2),
            (2, 4),
            (3, 0),
            (4, 2),
            (5, 0),
            (6, 1),
            (6, 4),
            (7, 0),
            (7, 1),
        ];
        assert_eq!(progress(&states), expected);
    }

    proptest! {
        #[test]
        fn progress_never_decreases(
            states in prop::collection::vec((0u8..5, 0usize..4), 1..200),
        ) {
            let heading = |index: usize| Heading::ALL[index];
            let states: Vec<_> = states.into_iter().map(|(x, at)| (x, heading(at))).collect();
            let progress = progress(&states);
            prop_assert!(progress.is_sorted(), "{:?}", progress);
        }
    }
}
