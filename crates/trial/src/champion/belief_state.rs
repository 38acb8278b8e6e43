//! The belief of a robot with noisy sensors.

use mmsim_maze::KnownMaze;

use super::hypothesis::{Hypothesis, MAX_HYPOTHESES};
use crate::action::Action;

/// The belief of a robot with noisy sensors: several hypotheses about the maze and the pose. The
/// pose is uncertain because a wall can cut a move short without the robot noticing.
///
/// With noise-free sensors there is only one hypothesis, which is equivalent to a
/// [`Survey`](crate::Survey).
#[derive(Clone, Debug)]
pub(super) struct BeliefState {
    /// The hypotheses, in descending order of likelihood. There is always at least one hypothesis.
    hypotheses: Vec<Hypothesis>,
    noise: f64,
}

/// The minimum weight of a hypothesis, relative to the weight of the most likely hypothesis.
/// Hypotheses with less weight are dropped.
const MIN_WEIGHT: f64 = 1e-6;

impl BeliefState {
    pub(super) fn new(unexplored: KnownMaze, noise: f64) -> Self {
        Self { hypotheses: vec![Hypothesis::new(unexplored)], noise }
    }

    /// Returns the most likely hypothesis.
    pub(super) fn most_likely(&self) -> &Hypothesis {
        &self.hypotheses[0]
    }

    /// Updates the weight and the map of each hypothesis. The weight is multiplied by the
    /// likelihood of the readings. If all weights become 0, the hypotheses are replaced by copies
    /// of the previously most likely one, placed at the poses that best explain the readings.
    pub(super) fn observe(&mut self, sensors: [u8; 3]) {
        let weight = |hypothesis: &Hypothesis| {
            let likelihood = hypothesis.likelihood(hypothesis.survey.pose(), sensors, self.noise);
            // If the robot had finished, the trial would be over.
            if hypothesis.has_finished { 0. } else { hypothesis.weight * likelihood }
        };
        let weights: Vec<f64> = self.hypotheses.iter().map(weight).collect();
        if weights.iter().sum::<f64>() > 0. {
            for (hypothesis, weight) in self.hypotheses.iter_mut().zip(weights) {
                hypothesis.weight = weight;
            }
        } else {
            self.hypotheses = self.hypotheses[0].relocalized(sensors, self.noise);
        }
        self.sort();
        self.hypotheses.truncate(MAX_HYPOTHESES);
        let max = self.hypotheses[0].weight;
        self.hypotheses.retain(|hypothesis| hypothesis.weight >= max * MIN_WEIGHT);
        for hypothesis in &mut self.hypotheses {
            hypothesis.weight /= max;
            hypothesis.observe(sensors, self.noise);
        }
    }

    /// Applies an action to each hypothesis. If an unknown wall may cut the move short, the
    /// hypothesis is replaced by one hypothesis for each possible outcome.
    pub(super) fn apply(&mut self, action: Action) {
        let is_noisy = self.noise > 0.;
        self.hypotheses = self
            .hypotheses
            .iter()
            .flat_map(|hypothesis| hypothesis.successors(action, is_noisy))
            .collect();
        self.sort();
    }

    fn sort(&mut self) {
        self.hypotheses.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, CellSet, Heading, MazeSize, WallState};

    use super::*;
    use crate::survey::Survey;

    fn belief(noise: f64) -> BeliefState {
        BeliefState::new(KnownMaze::new(MazeSize::CLASSIC, Cell::new(0, 0), CellSet::EMPTY), noise)
    }

    fn wall(belief: &BeliefState, y: u8) -> WallState {
        belief.most_likely().survey.map().wall(Cell::new(0, y), Heading::North)
    }

    #[test]
    fn noise_free_readings_are_certain() {
        let mut belief = belief(0.);
        belief.observe([0, 2, 0]);
        let mut survey = Survey::new(belief.most_likely().survey.map().clone());
        survey.observe([0, 2, 0]);
        assert_eq!(belief.most_likely().survey, survey);
        belief.apply(Action::from_numbers(0, 2));
        assert_eq!(belief.hypotheses.len(), 1);
        assert_eq!(belief.most_likely().survey.pose().cell, Cell::new(0, 2));
    }

    #[test]
    fn noisy_readings_become_certain_by_repetition() {
        let mut belief = belief(0.3);
        belief.observe([0, 3, 0]);
        assert_eq!(wall(&belief, 2), WallState::Unknown, "one reading is not enough");
        assert_eq!(wall(&belief, 0), WallState::Absent, "errors are at most one cell");
        for cells in [2, 2, 2, 3, 2, 2] {
            belief.observe([0, cells, 0]);
        }
        assert_eq!(wall(&belief, 1), WallState::Absent);
        assert_eq!(wall(&belief, 2), WallState::Present);
    }

    #[test]
    fn an_unexpected_wall_is_inferred_from_later_readings() {
        let mut belief = belief(0.1);
        belief.observe([0, 1, 5]);
        belief.apply(Action::from_numbers(0, 1));
        let cell = |belief: &BeliefState| belief.most_likely().survey.pose().cell;
        let mut elsewhere = belief.clone();
        elsewhere.observe([0, 0, 1]);
        assert_eq!(cell(&elsewhere), Cell::new(0, 1), "the right side differs from the start");
        // The readings are those of the start, except for a wall ahead: the move failed.
        for _ in 0..3 {
            belief.observe([0, 0, 5]);
        }
        assert_eq!(cell(&belief), Cell::new(0, 0));
        assert_eq!(wall(&belief, 0), WallState::Present);
        assert_eq!(wall(&elsewhere, 0), WallState::Absent);
    }

    #[test]
    fn a_reset_before_the_goal_is_refused() {
        for noise in [0., 0.1] {
            let mut belief = belief(noise);
            for _ in 0..3 {
                belief.observe([0, 5, 0]);
            }
            belief.apply(Action::from_numbers(0, 2));
            belief.observe([0, 3, 1]);
            belief.apply(Action::Reset);
            belief.observe([0, 3, 1]);
            let hypothesis = belief.most_likely();
            assert_eq!(hypothesis.survey.pose().cell, Cell::new(0, 2));
            assert!(!hypothesis.is_racing);
        }
    }
}
