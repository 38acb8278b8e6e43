//! The cost of a search: the steps and turns in each phase.

use mmsim_maze::Step;

use crate::strategy::Phase;

/// The steps and turns of a search, counted separately for each [`Phase`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SearchStats {
    /// The steps and turns of the search run.
    pub search_run: PhaseStats,
    /// The steps and turns of the return run.
    pub return_run: PhaseStats,
    /// The steps and turns of the fast run.
    pub fast_run: PhaseStats,
    /// The number of steps in all phases until the mouse first entered a goal cell, or `None` if it
    /// has not entered one.
    pub steps_to_goal: Option<u32>,
}

/// The steps and turns in one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PhaseStats {
    /// The number of steps. Each step is one cell long.
    pub steps: u32,
    /// The number of quarter turns. A half turn counts as two quarter turns.
    pub turns: u32,
}

impl SearchStats {
    /// Returns the number of steps in all phases.
    pub const fn steps(&self) -> u32 {
        self.exploration().steps + self.fast_run.steps
    }

    /// Returns the number of quarter turns in all phases.
    pub const fn turns(&self) -> u32 {
        self.exploration().turns + self.fast_run.turns
    }

    /// Returns the steps and turns of the search run and the return run together.
    pub const fn exploration(&self) -> PhaseStats {
        let (search, back) = (self.search_run, self.return_run);
        PhaseStats { steps: search.steps + back.steps, turns: search.turns + back.turns }
    }

    /// Returns true if the mouse has entered a goal cell.
    pub const fn goal_reached(&self) -> bool {
        self.steps_to_goal.is_some()
    }

    /// Counts a step.
    pub(crate) const fn count(&mut self, phase: Phase, step: Step) {
        let phase = match phase {
            Phase::SearchRun => &mut self.search_run,
            Phase::ReturnRun => &mut self.return_run,
            Phase::FastRun => &mut self.fast_run,
        };
        phase.steps += 1;
        phase.turns += quarter_turns(step);
    }
}

const fn quarter_turns(step: Step) -> u32 {
    match step {
        Step::Front => 0,
        Step::Left | Step::Right => 1,
        Step::Back => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_and_turns_are_counted_by_phase() {
        let mut stats = SearchStats::default();
        for (phase, steps) in [
            (Phase::SearchRun, &[Step::Front, Step::Left][..]),
            (Phase::ReturnRun, &[Step::Right, Step::Back, Step::Back]),
            (Phase::FastRun, &[Step::Front, Step::Front, Step::Front, Step::Front, Step::Back]),
        ] {
            for &step in steps {
                stats.count(phase, step);
            }
        }
        let expected = SearchStats {
            search_run: PhaseStats { steps: 2, turns: 1 },
            return_run: PhaseStats { steps: 3, turns: 5 },
            fast_run: PhaseStats { steps: 5, turns: 2 },
            steps_to_goal: None,
        };
        assert_eq!(stats, expected);
        assert_eq!(stats.exploration(), PhaseStats { steps: 5, turns: 6 });
        assert_eq!((stats.steps(), stats.turns()), (10, 8));
    }

    #[test]
    fn the_goal_is_reached_even_without_steps() {
        let mut stats = SearchStats::default();
        assert!(!stats.goal_reached());
        stats.steps_to_goal = Some(0);
        assert!(stats.goal_reached());
    }
}
