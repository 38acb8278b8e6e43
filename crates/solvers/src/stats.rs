//! What a search has cost: steps and turns, by phase.

use mmsim_maze::Step;

use crate::strategy::Phase;

/// Steps and turns of a search, by [`Phase`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SearchStats {
    /// The search run, up to the return run or the fast run.
    pub search_run: PhaseStats,
    /// The return run, back to the start.
    pub return_run: PhaseStats,
    /// The fast run.
    pub fast_run: PhaseStats,
    /// Steps until the mouse first stood in a goal cell, in whichever phase that was.
    pub steps_to_goal: Option<u32>,
}

/// Steps and turns of one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PhaseStats {
    /// Steps, one cell each.
    pub steps: u32,
    /// Quarter turns; turning round is two.
    pub turns: u32,
}

impl SearchStats {
    /// Returns the steps of all phases.
    pub const fn steps(&self) -> u32 {
        self.exploration().steps + self.fast_run.steps
    }

    /// Returns the quarter turns of all phases.
    pub const fn turns(&self) -> u32 {
        self.exploration().turns + self.fast_run.turns
    }

    /// Returns the sum of search run and return run.
    pub const fn exploration(&self) -> PhaseStats {
        let (search, back) = (self.search_run, self.return_run);
        PhaseStats { steps: search.steps + back.steps, turns: search.turns + back.turns }
    }

    /// Whether the mouse stood in a goal cell.
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
