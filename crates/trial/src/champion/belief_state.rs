//! The belief of a robot with noisy sensors: hypotheses about the maze and its pose.

use mmsim_maze::{Cell, Heading, KnownMaze, Pose, Wall, WallState};

use crate::robot::Action;
use crate::survey::Survey;
use crate::trial::sensor_headings;

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
        let before = self.hypotheses.iter();
        self.hypotheses = before.flat_map(|one| one.successors(action, is_noisy)).collect();
        self.sort();
    }

    fn sort(&mut self) {
        self.hypotheses.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    }
}

/// The maximum number of hypotheses.
const MAX_HYPOTHESES: usize = 8;

/// A possible pose of the robot and, for each side of each cell, the probability that the side is
/// open.
///
/// A reading is the number of open cells up to the next wall. The probability of a reading follows
/// from the probabilities of the walls in front of the sensor and from the sensor noise. Each
/// reading updates these wall probabilities by Bayes' rule.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    /// The pose, and the walls as a map in which each wall is present, absent or unknown.
    pub(super) survey: Survey,
    /// True if a step of the first run has ended in the goal.
    pub(super) has_visited_goal: bool,
    /// True if the robot is in the second run.
    pub(super) is_racing: bool,
    /// True if a step of the second run has ended in the goal. The hypothesis is wrong if the trial
    /// continues after such a step.
    has_finished: bool,
    weight: f64,
    /// The probability that there is no wall, indexed by
    /// [`MazeSize::wall_index`](mmsim_maze::MazeSize::wall_index).
    open: Vec<f32>,
}

/// A side counts as open if the probability that it is open is at least this value. A side counts
/// as closed if the probability that it is closed is at least this value.
const CERTAIN: f32 = 0.9;
/// With noisy sensors, neither the probability that a side is open nor the probability that it is
/// closed exceeds this value. The value is below 1 so that later readings can still change the
/// probability.
const MAX_PROBABILITY: f32 = 0.999;
/// The minimum likelihood of a sensor reading if at least one wall up to the measured distance is
/// unknown. Without this limit, long corridors would be considered too unlikely, because the walls
/// are treated as independent.
const MIN_UNKNOWN_LIKELIHOOD: f64 = 0.05;

impl Hypothesis {
    /// Creates the initial hypothesis, with the robot at the start.
    fn new(unexplored: KnownMaze) -> Self {
        Self {
            open: vec![0.5; 2 * unexplored.size().area()],
            survey: Survey::new(unexplored),
            has_visited_goal: false,
            is_racing: false,
            has_finished: false,
            weight: 1.,
        }
    }

    /// Returns a copy of the map with all uncertain walls set to unknown. A wall is uncertain if it
    /// may be due to a wrong reading.
    pub(super) fn without_uncertain_walls(&self) -> KnownMaze {
        let mut map = self.survey.map().clone();
        for Wall { cell, heading, .. } in map.size().inner_walls() {
            let may_be_open = self.open(cell, heading) > 2. * (1. - MAX_PROBABILITY);
            if may_be_open && map.wall(cell, heading) == WallState::Present {
                map.set_wall(cell, heading, WallState::Unknown);
            }
        }
        map
    }

    /// Returns the probability that a side is open.
    fn open(&self, cell: Cell, heading: Heading) -> f32 {
        self.index(cell, heading).map_or(0., |index| self.open[index])
    }

    fn set_open(&mut self, cell: Cell, heading: Heading, open: f32, noise: f64) {
        if let Some(index) = self.index(cell, heading) {
            let max = if noise > 0. { MAX_PROBABILITY } else { 1. };
            let open = open.clamp(1. - max, max);
            self.open[index] = open;
            let wall = if open >= CERTAIN {
                WallState::Absent
            } else if open <= 1. - CERTAIN {
                WallState::Present
            } else {
                WallState::Unknown
            };
            self.survey.set_wall(cell, heading, wall);
        }
    }

    fn index(&self, cell: Cell, heading: Heading) -> Option<usize> {
        self.survey.map().size().wall_index(Wall::new(cell, heading))
    }

    /// Returns the likelihood of the sensor readings at a given pose.
    fn likelihood(&self, pose: Pose, sensors: [u8; 3], noise: f64) -> f64 {
        let likelihood = |(heading, reading): (Heading, u8)| {
            let likelihood = self.likelihoods(pose.cell, heading, reading, noise).sum::<f64>();
            let mut cells = self.cells_ahead(pose.cell, heading).take(usize::from(reading) + 1);
            let is_unknown =
                cells.any(|cell| (1. - CERTAIN..CERTAIN).contains(&self.open(cell, heading)));
            if is_unknown { likelihood.max(MIN_UNKNOWN_LIKELIHOOD) } else { likelihood }
        };
        sensor_headings(pose.heading).into_iter().zip(sensors).map(likelihood).product()
    }

    /// For each number of open cells (0, 1, 2, …), returns the joint probability that this is the
    /// true number and that the sensor reports `reading`.
    fn likelihoods(
        &self,
        cell: Cell,
        heading: Heading,
        reading: u8,
        noise: f64,
    ) -> impl Iterator<Item = f64> + '_ {
        let mut reached = 1.;
        (0..).zip(self.cells_ahead(cell, heading)).map(move |(cells, here)| {
            let open = f64::from(self.open(here, heading));
            let probability = reached * (1. - open) * reading_probability(reading, cells, noise);
            reached *= open;
            probability
        })
    }

    /// Returns the cells on the straight line from `cell` to the edge of the maze.
    fn cells_ahead(&self, cell: Cell, heading: Heading) -> impl Iterator<Item = Cell> + use<> {
        let size = self.survey.map().size();
        std::iter::successors(Some(cell), move |&cell| size.neighbour(cell, heading))
    }

    /// Updates the wall probabilities from the readings.
    fn observe(&mut self, sensors: [u8; 3], noise: f64) {
        let pose = self.survey.pose();
        self.survey.visit();
        for (heading, reading) in sensor_headings(pose.heading).into_iter().zip(sensors) {
            let likelihoods: Vec<f64> =
                self.likelihoods(pose.cell, heading, reading, noise).collect();
            let total: f64 = likelihoods.iter().sum();
            if total <= 0. {
                continue;
            }
            for (index, here) in self.cells_ahead(pose.cell, heading).enumerate() {
                let nearer: f64 = likelihoods[..index].iter().sum();
                let farther: f64 = likelihoods[index + 1..].iter().sum();
                let open = (nearer * f64::from(self.open(here, heading)) + farther) / total;
                // The precision of f32 is sufficient.
                #[allow(clippy::cast_possible_truncation)]
                self.set_open(here, heading, open as f32, noise);
            }
        }
    }

    /// Returns hypotheses for a robot that has lost its position: copies of this hypothesis with
    /// the poses that best explain the readings.
    fn relocalized(&self, sensors: [u8; 3], noise: f64) -> Vec<Self> {
        let cells = self.survey.map().size().cells();
        let poses = cells.flat_map(|cell| Heading::ALL.map(|heading| Pose::new(cell, heading)));
        let mut weights: Vec<(f64, Pose)> =
            poses.map(|pose| (self.likelihood(pose, sensors, noise), pose)).collect();
        weights.sort_by(|a, b| b.0.total_cmp(&a.0));
        weights.truncate(MAX_HYPOTHESES);
        let at = |(weight, pose): (f64, Pose)| {
            let mut hypothesis = Self { weight, has_finished: false, ..self.clone() };
            hypothesis.survey.set_pose(pose);
            hypothesis
        };
        let mut hypotheses: Vec<Self> = weights.into_iter().map(at).collect();
        hypotheses[0].weight = hypotheses[0].weight.max(f64::MIN_POSITIVE);
        hypotheses
    }

    /// Returns the hypotheses that may be true after an action.
    fn successors(&self, action: Action, is_noisy: bool) -> Vec<Self> {
        let mut successors = match action {
            Action::Move { rotation, cells } => {
                self.after_move(rotation.turn(self.survey.pose().heading), cells)
            }
            Action::Reset => {
                let mut accepted = Self { is_racing: true, ..self.clone() };
                accepted.survey.apply(action);
                let mut refused =
                    Self { has_visited_goal: false, is_racing: false, ..self.clone() };
                // The robot may be wrong about its visit to the goal.
                let unlikely = if self.has_visited_goal { &mut refused } else { &mut accepted };
                unlikely.weight *= 0.01;
                match (is_noisy, self.has_visited_goal) {
                    (true, _) => vec![accepted, refused],
                    (false, true) => vec![accepted],
                    (false, false) => vec![refused],
                }
            }
            Action::GiveUp | Action::Fail => vec![self.clone()],
        };
        for hypothesis in &mut successors {
            let is_in_goal = hypothesis.survey.is_in_goal();
            hypothesis.has_visited_goal |= is_in_goal;
            hypothesis.has_finished = is_in_goal && self.is_racing;
        }
        successors
    }

    fn after_move(&self, heading: Heading, cells: i8) -> Vec<Self> {
        let towards = if cells < 0 { heading.back() } else { heading };
        let mut here = self.clone();
        here.survey.set_pose(Pose::new(self.survey.pose().cell, heading));
        let mut successors = Vec::new();
        for _ in 0..cells.unsigned_abs() {
            let cell = here.survey.pose().cell;
            let open = here.open(cell, towards);
            if open < 1. {
                let mut stopped = here.clone();
                stopped.weight *= f64::from(1. - open);
                stopped.set_open(cell, towards, 0., 1.);
                successors.push(stopped);
            }
            let Some(next) = cell.neighbour(towards).filter(|_| open > 0.) else {
                return successors;
            };
            here.weight *= f64::from(open);
            here.set_open(cell, towards, 1., if open < 1. { 1. } else { 0. });
            here.survey.set_pose(Pose::new(next, heading));
        }
        successors.push(here);
        successors
    }
}

/// Returns the probability of a reading, given that the true number of open cells is `cells`.
fn reading_probability(reading: u8, cells: u8, noise: f64) -> f64 {
    match (reading.abs_diff(cells), cells) {
        (0, _) => 1. - noise,
        (1, 0) => noise,
        (1, _) => noise / 2.,
        _ => 0.,
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, CellSet, Heading, MazeSize, WallState};

    use super::*;

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
