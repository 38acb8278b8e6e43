//! The cost of a search: the steps and turns in each phase.

use core::fmt;

use mmsim_maze::{Step, counted};

use crate::strategy::Phase;

/// The steps and turns of a search, split into the search run, the return run and the fast run.
///
/// The search run ends when the mouse first enters a goal cell, even if the strategy then continues
/// to explore. The return run lasts until the fast run begins. `Phases` in `mmsim-run` only
/// knows the poses of a mouse, so there a return run ends when the mouse passes the start cell.
///
/// [`Display`](fmt::Display) prints the steps of each phase, such as `24 steps` or `14 steps (search
/// run 4, return run 6, fast run 4)`.
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
    /// The number of steps that a wall blocked.
    pub crashes: u32,
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

    /// Returns the search run, the return run and the fast run with their names.
    pub const fn phases(&self) -> [(&'static str, PhaseStats); 3] {
        let Self { search_run, return_run, fast_run, .. } = *self;
        [("search run", search_run), ("return run", return_run), ("fast run", fast_run)]
    }

    /// Counts a step.
    pub(crate) const fn count(&mut self, phase: Phase, step: Step) {
        let phase = self.phase_mut(phase);
        phase.steps += 1;
        phase.turns += quarter_turns(step);
    }

    /// Counts the last step as a turn and a crash.
    pub(crate) const fn count_crash(&mut self, phase: Phase) {
        self.phase_mut(phase).steps -= 1;
        self.crashes += 1;
    }

    const fn phase_mut(&mut self, phase: Phase) -> &mut PhaseStats {
        match (phase, self.goal_reached()) {
            (Phase::FastRun, _) => &mut self.fast_run,
            (_, false) => &mut self.search_run,
            (_, true) => &mut self.return_run,
        }
    }
}

impl fmt::Display for SearchStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let steps = self.steps();
        write!(f, "{}", counted(steps, "step"))?;
        if steps == self.search_run.steps {
            return Ok(());
        }
        let mut separator = " (";
        for (name, PhaseStats { steps, .. }) in self.phases() {
            write!(f, "{separator}{name} {steps}")?;
            separator = ", ";
        }
        f.write_str(")")
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
        for (phase, steps, reaches_goal) in [
            (Phase::SearchRun, &[Step::Front, Step::Left][..], true),
            // Further exploration is a part of the return run.
            (Phase::SearchRun, &[Step::Right], false),
            (Phase::ReturnRun, &[Step::Back, Step::Back], false),
            (Phase::FastRun, &[Step::Front, Step::Front, Step::Front, Step::Back], false),
            (Phase::FastRun, &[Step::Front], false),
        ] {
            for &step in steps {
                stats.count(phase, step);
            }
            if reaches_goal {
                assert_eq!(stats.to_string(), "2 steps");
                stats.steps_to_goal = Some(stats.steps());
            }
        }
        let expected = SearchStats {
            search_run: PhaseStats { steps: 2, turns: 1 },
            return_run: PhaseStats { steps: 3, turns: 5 },
            fast_run: PhaseStats { steps: 5, turns: 2 },
            steps_to_goal: Some(2),
            crashes: 0,
        };
        assert_eq!(stats, expected);
        assert_eq!(stats.to_string(), "10 steps (search run 2, return run 3, fast run 5)");
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
