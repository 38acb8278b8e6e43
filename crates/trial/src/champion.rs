//! The champion, a robot that explores as long as exploration pays off.

mod belief_state;
mod contest;
mod exploration_value;
mod maze_batch;
mod maze_samples;
mod unknown_stretch;
mod wall_prior;

use mmsim_maze::{Cell, Heading, KnownMaze, Pose, Unknown, WallState};

use crate::race::{RaceSteps, race_optimum};
use crate::robot::{Action, Robot, Rotation};
use crate::survey::Survey;
use crate::trial::Trial;
use belief_state::BeliefState;
use exploration_value::ExplorationValue;
pub use wall_prior::WallPrior;

/// A robot that moves to the goal, explores as long as the expected gain exceeds the cost, and then
/// races along the fastest known path.
///
/// **On the way to the goal** the champion plans optimistically: it treats unknown walls as open.
/// It follows the path that is fastest under this assumption, up to the point where the path leaves
/// the explored area.
///
/// **After reaching the goal** the champion samples random mazes that agree with the known walls; a
/// [`WallPrior`] gives the probabilities of the unknown walls. In each sample, the champion finds
/// the fastest path from the start to the goal. The part of this path from its first to its last
/// unknown wall is a stretch. For each stretch, the champion totals over all samples how many
/// race steps the path saves and how many steps it takes to explore the stretch. A [`StoppingRule`]
/// sets the minimum gain per exploration step. Among the stretches whose gain exceeds this minimum,
/// the champion heads for the one with the largest total gain. The total gain of a stretch is its
/// own gain plus twice the gains of the other stretches. The steps from the stretch to another
/// stretch count four times, so distant stretches hardly matter. The champion stops exploring if no
/// stretch has a gain above the minimum or if no faster race is possible.
///
/// The champion assumes that the maze is similar to a contest maze, in which the goal cells form a
/// room with one entrance. In mazes of other kinds, the champion may explore too little or too
/// much. However, the champion never relies on sampled walls when it moves: with noise-free
/// sensors, it crosses only sides that it has seen to be open.
///
/// With noisy sensors the champion keeps a probability for each wall and repeats uncertain
/// readings. The champion also tracks several hypotheses about its position, because an undetected
/// wall can cut a move short.
#[derive(Clone, Debug)]
pub struct Champion {
    belief: BeliefState,
    is_noisy: bool,
    rule: StoppingRule,
    prior: WallPrior,
    value: Option<ExplorationValue>,
    seed: u64,
    steps: u32,
}

/// The rule that decides when a [`Champion`] stops exploring.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub enum StoppingRule {
    /// Stop when the gain is at most this value. The gain is 30 times the expected number of race
    /// steps saved, to the power of 3/4, per exploration step. At a gain of 1, exploration costs
    /// about as much as it saves.
    MinGain(f64),
    /// Stop only when no faster race is possible, whatever the cost of exploration.
    Proven,
}

impl Default for StoppingRule {
    fn default() -> Self {
        Self::MinGain(1.)
    }
}

impl Champion {
    /// Creates a robot at the start of its first run. `noise` is the probability that a sensor
    /// reading is wrong by one cell; values outside 0 to 1 are treated as 0.
    pub fn new(
        unexplored: KnownMaze,
        rule: StoppingRule,
        prior: WallPrior,
        noise: f64,
        seed: u64,
    ) -> Self {
        let noise = if (0. ..=1.).contains(&noise) { noise } else { 0. };
        let belief = BeliefState::new(unexplored, noise);
        Self { belief, is_noisy: noise > 0., rule, prior, value: None, seed, steps: 0 }
    }

    /// Returns the known walls and the estimated pose.
    pub fn survey(&self) -> &Survey {
        &self.belief.most_likely().survey
    }

    fn explore(&mut self) -> Action {
        let hypothesis = self.belief.most_likely();
        let (has_visited_goal, pose) = (hypothesis.has_visited_goal, hypothesis.survey.pose());
        let mut map = hypothesis.survey.map().clone();
        let mut bounds = RaceBounds::new(&map, pose.cell);
        if bounds.lower.is_none() && self.is_noisy {
            map = hypothesis.without_uncertain_walls();
            bounds = RaceBounds::new(&map, pose.cell);
        }
        let Some(lower) = bounds.lower else { return Action::GiveUp };
        let target = match bounds.upper.filter(|_| has_visited_goal) {
            Some(upper) if upper <= lower || self.must_race(upper) => None,
            Some(upper) => match self.rule {
                StoppingRule::MinGain(min_gain) => {
                    let (prior, seed) = (&self.prior, self.seed);
                    let value =
                        self.value.get_or_insert_with(|| ExplorationValue::new(&map, prior, seed));
                    value.best_target(&map, prior, &bounds.from_here, upper, min_gain)
                }
                StoppingRule::Proven => bounds.nearest_improving(&map, upper),
            },
            None => bounds.nearest_to_goal(&map),
        };
        match target {
            Some(target) => move_to(&map, pose, target),
            None if has_visited_goal => Action::Reset,
            // The map is contradictory: read the sensors again.
            None => TURN,
        }
    }

    /// Returns true if the race must begin now in order to finish within the step limit.
    fn must_race(&self, upper: u16) -> bool {
        let race = u32::from(upper);
        self.steps + race + race / 4 + 4 >= Trial::MAX_STEPS
    }

    fn race(&self) -> Action {
        let survey = self.survey();
        let (map, pose) = (survey.map(), survey.pose());
        if survey.is_in_goal() {
            return Action::STAY;
        }
        // The path has unknown walls only if readings have contradicted the map since the reset.
        let plan = |unknown| {
            let walls = map.walls(unknown);
            RaceSteps::flood(walls, map.goals()).next_move(walls, pose)
        };
        plan(Unknown::Closed).or_else(|| plan(Unknown::Open)).unwrap_or(Action::STAY)
    }
}

impl Robot for Champion {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.belief.observe(sensors);
        let action = if self.belief.most_likely().is_racing { self.race() } else { self.explore() };
        self.belief.apply(action);
        self.steps += 1;
        action
    }
}

/// Bounds on the number of race steps, and the distances used to compute them.
struct RaceBounds {
    /// The distances from the current cell if all unknown walls are closed.
    from_here: RaceSteps,
    /// The distances to the goal if all unknown walls are open.
    to_goal: RaceSteps,
    /// The length of the shortest race in steps, assuming that every unknown wall is present.
    upper: Option<u16>,
    /// The length of the shortest race in steps, assuming that every unknown wall is absent.
    lower: Option<u16>,
}

impl RaceBounds {
    fn new(map: &KnownMaze, here: Cell) -> Self {
        let (known, start) = (map.walls(Unknown::Closed), map.start().cell);
        let to_goal = RaceSteps::flood(map.walls(Unknown::Open), map.goals());
        Self {
            from_here: RaceSteps::flood_from(known, here),
            upper: race_optimum(known, start, map.goals()),
            lower: to_goal.at_least_one(start),
            to_goal,
        }
    }

    /// Returns the next cell on the way to the goal: a cell at the edge of the explored area, or a
    /// goal cell. If all unknown walls are open, one of the fastest paths to the goal leads through
    /// this cell. Ties are broken by the number of steps to the cell plus the Manhattan distance
    /// from the cell to the goal, then by the number of steps to the cell.
    fn nearest_to_goal(&self, map: &KnownMaze) -> Option<Cell> {
        let manhattan = |cell: Cell, goal: Cell| cell.x.abs_diff(goal.x) + cell.y.abs_diff(goal.y);
        let to_any_goal = |cell| map.goals().iter().map(|goal| manhattan(cell, goal)).min();
        let key = |cell| {
            let (to_cell, to_goal) = (self.from_here.at_least_one(cell)?, self.to_goal.at(cell)?);
            Some((to_cell + to_goal, to_cell + u16::from(to_any_goal(cell)?), to_cell))
        };
        let is_edge = |&cell: &Cell| map.goals().contains(cell) || has_unknown_side(map, cell);
        let edge = map.size().cells().filter(is_edge);
        edge.filter(|&cell| key(cell).is_some()).min_by_key(|&cell| key(cell))
    }

    /// Returns the nearest cell at the edge of the explored area that may be part of a race of
    /// fewer than `upper` steps. If there is no such cell, returns the nearest cell that may be
    /// part of a race of exactly `upper` steps.
    fn nearest_improving(&self, map: &KnownMaze, upper: u16) -> Option<Cell> {
        let from_start = RaceSteps::flood_from(map.walls(Unknown::Open), map.start().cell);
        let key = |cell| {
            let race = from_start.at(cell)? + self.to_goal.at(cell)?;
            Some((race == upper, self.from_here.at_least_one(cell)?)).filter(|_| race <= upper)
        };
        let edge = map.size().cells().filter(|&cell| has_unknown_side(map, cell));
        edge.filter(|&cell| key(cell).is_some()).min_by_key(|&cell| key(cell))
    }
}

const TURN: Action = Action::Move { rotation: Rotation::Right, cells: 0 };

/// Returns the next move towards `target`. If the robot is in `target`, returns a turn that reveals
/// the wall behind the robot.
fn move_to(map: &KnownMaze, pose: Pose, target: Cell) -> Action {
    let walls = map.walls(Unknown::Closed);
    RaceSteps::flood_from(walls, target).next_move(walls, pose).unwrap_or(TURN)
}

fn has_unknown_side(map: &KnownMaze, cell: Cell) -> bool {
    Heading::ALL.into_iter().any(|heading| map.wall(cell, heading) == WallState::Unknown)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::race::race_optimum;
    use crate::trial::{SensorNoise, TrialOutcome, run_observed_trial, run_trial};

    /// A maze with two paths to the goal. The shorter path leads away from the goal at first.
    const MAZE: &str = "\
o---o---o---o---o---o---o
|                       |
o   o---o---o---o   o   o
|   |           |   |   |
o   o   o---o   o---o   o
|   |   | G   G |       |
o   o   o   o   o   o   o
|   |     G   G |   |   |
o   o   o---o---o   o   o
|   |           |       |
o   o---o---o   o---o   o
| S |                   |
o---o---o---o---o---o---o
";

    fn champion(maze: &Maze, rule: StoppingRule, noise: f64, seed: u64) -> Champion {
        Champion::new(KnownMaze::unexplored(maze), rule, WallPrior::CONTEST, noise, seed)
    }

    fn outcome(text: &str, rule: StoppingRule, noise: f64, seed: u64) -> TrialOutcome {
        let maze: Maze = text.parse().unwrap();
        let mut robot = champion(&maze, rule, noise, seed);
        run_observed_trial(&maze, &mut robot, &mut SensorNoise::new(noise, seed), |_, _, _| {})
    }

    #[test]
    fn a_proven_race_is_optimal() {
        let maze: Maze = MAZE.parse().unwrap();
        let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals()).unwrap();
        let score = |rule| match outcome(MAZE, rule, 0., 0) {
            TrialOutcome::Scored(score) => score,
            other => panic!("{other:?}"),
        };
        let (proven, default) = (score(StoppingRule::Proven), score(StoppingRule::default()));
        assert_eq!(proven.race_steps, u32::from(optimum));
        assert!(default.explore_steps <= proven.explore_steps, "{default:?} {proven:?}");
    }

    #[test]
    fn gives_up_if_the_goal_is_unreachable() {
        let closed =
            MAZE.replace("o---o   o---o   o\n|   |   | G", "o---o---o---o   o\n|   |   | G");
        let closed = closed.replace("|   |     G", "|   |   | G");
        for text in [closed.as_str(), "o---o---o\n| S | G |\no---o---o\n"] {
            assert_eq!(outcome(text, StoppingRule::default(), 0., 0), TrialOutcome::GaveUp);
        }
    }

    #[test]
    fn handles_unusual_mazes() {
        let steps = |text| match outcome(text, StoppingRule::default(), 0., 0) {
            TrialOutcome::Scored(score) => (score.explore_steps, score.race_steps),
            other => panic!("{other:?} in\n{text}"),
        };
        assert_eq!(steps("o---o\n| G |\no---o\n"), (2, 1), "start in the goal");
        assert_eq!(steps("o---o\n| S |\no   o\n| G |\no---o\n"), (3, 1), "goal behind the start");
        assert_eq!(steps("o---o---o---o---o\n| S           G |\no---o---o---o---o\n"), (2, 1));
    }

    #[test]
    fn scores_with_noisy_sensors() {
        let mut scored = 0;
        for seed in 0..40 {
            let noise = [0.01, 0.05, 0.1, 0.2][usize::try_from(seed % 4).unwrap()];
            let outcome = outcome(MAZE, StoppingRule::default(), noise, seed);
            scored += u32::from(matches!(outcome, TrialOutcome::Scored(_)));
        }
        assert!(scored >= 38, "{scored} of 40");
    }

    #[test]
    fn arbitrary_readings_do_not_panic() {
        let maze: Maze = MAZE.parse().unwrap();
        for noise in [0., 0.1, 1.] {
            let mut robot = champion(&maze, StoppingRule::default(), noise, 1);
            for step in 0..300_u32 {
                let readings =
                    [step * 7, step * 11, step * 13].map(|cells| (cells % 256).to_le_bytes()[0]);
                robot.next_move(readings);
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_score() {
        let maze: Maze = MAZE.parse().unwrap();
        let score = || run_trial(&maze, &mut champion(&maze, StoppingRule::default(), 0., 1));
        assert_eq!(score(), score());
    }
}
