//! The champion: explores as long as that pays.

mod belief;
mod contest;
mod guesses;
mod habits;
mod prospects;
mod unseen;

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Pose, Unknown, WallState};

use crate::{Action, RaceSteps, Robot, Rotation, Survey, Trial};
use belief::Belief;
pub use habits::Habits;
use prospects::Prospects;

/// The champion: goes to the goal, explores where a faster race may still hide as long as that is
/// worth its steps, and races in the fewest steps over what it knows.
///
/// **To the goal** it takes unknown walls as open and goes to the cell at the edge of what it knows
/// over which the goal is fewest time steps away.
///
/// **From then on** it guesses mazes ([`Habits`] tell how) that agree with what it has seen. In each
/// it looks up the fastest race and the stretch of it that it has not seen: so many steps it would
/// save, so many it would take to see. Over all guesses these add up. Among the stretches where a
/// step of exploring saves enough (a [`Rule`] tells how much), it goes to the one from which most
/// others are near too, and stops when there is none. It stops for certain once
/// no faster race is possible.
///
/// It assumes, as contests have it, that the goal cells are a room with one entrance, and
/// that other walls are like those of contest mazes. Where that is not so it explores too little or
/// too much, but what it does never rests on a guess: while its sensors are right, it moves only where
/// it knows the way is open.
///
/// With sensors that err it keeps a belief for each wall, looks again at what it is not sure of, and
/// where it ran into a wall it follows from what its sensors tell where it may be.
#[derive(Clone, Debug)]
pub struct Champion {
    belief: Belief,
    errs: bool,
    rule: Rule,
    habits: Habits,
    prospects: Option<Prospects>,
    seed: u64,
    steps: u32,
}

/// When a [`Champion`] stops exploring.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Rule {
    /// When a step of exploring saves less than this many thirtieths of a step of the race.
    Worth(f64),
    /// When no faster race is possible: proven, whatever that costs.
    Proven,
}

impl Default for Rule {
    fn default() -> Self {
        Self::Worth(1.2)
    }
}

impl Champion {
    /// A robot that has not begun yet. `noise` is the chance that a reading of its sensors is wrong
    /// by one cell; what is no chance, 0 to 1, is taken as 0.
    pub fn new(before: KnownMaze, rule: Rule, habits: Habits, noise: f64, seed: u64) -> Self {
        let noise = if (0. ..=1.).contains(&noise) { noise } else { 0. };
        let belief = Belief::new(before, noise);
        Self { belief, errs: noise > 0., rule, habits, prospects: None, seed, steps: 0 }
    }

    /// What it knows, and where it reckons to be.
    pub fn survey(&self) -> &Survey {
        &self.belief.likeliest().survey
    }

    fn explore(&mut self) -> Action {
        let account = self.belief.likeliest();
        let (been_in_goal, pose) = (account.been_in_goal, account.survey.pose());
        let mut map = account.survey.map().clone();
        let mut plan = Plan::new(&map, pose.cell);
        if plan.optimum.is_none() && self.errs {
            map = account.doubting();
            plan = Plan::new(&map, pose.cell);
        }
        let Some(optimum) = plan.optimum else { return Action::GiveUp };
        let target = match plan.best.filter(|_| been_in_goal) {
            Some(best) if best <= optimum || self.is_late(best) => None,
            Some(best) => match self.rule {
                Rule::Worth(worth) => {
                    let (habits, seed) = (&self.habits, self.seed);
                    let prospects =
                        self.prospects.get_or_insert_with(|| Prospects::new(&map, habits, seed));
                    prospects.most_worth(&map, habits, &plan.from_here, best, worth)
                }
                Rule::Proven => plan.nearest_that_matters(&map, best),
            },
            None => plan.nearest_to_goal(&map),
        };
        match target {
            Some(target) => move_to(&map, pose, target),
            None if been_in_goal => Action::Reset,
            // All sides that it believes to be shut cannot be: it looks again.
            None => TURN,
        }
    }

    /// Whether the race has to begin for both runs to end in time.
    fn is_late(&self, best: u16) -> bool {
        let race = u32::from(best);
        self.steps + race + race / 4 + 4 >= Trial::MAX_STEPS
    }

    fn race(&self) -> Action {
        let survey = self.survey();
        let (map, pose) = (survey.map(), survey.pose());
        if survey.is_in_goal() {
            return Action::STAY;
        }
        // Unknown walls are there only if its sensors have told it otherwise since.
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
        let action = if self.belief.likeliest().races { self.race() } else { self.explore() };
        self.belief.go(action);
        self.steps += 1;
        action
    }
}

/// What there is to plan with: time steps over what is known.
struct Plan {
    from_here: RaceSteps,
    /// To the goal, unknown walls taken as open.
    hoped: RaceSteps,
    /// The fewest steps of a race over ways known to be open.
    best: Option<u16>,
    /// The same if all unknown walls are open.
    optimum: Option<u16>,
}

impl Plan {
    fn new(map: &KnownMaze, here: Cell) -> Self {
        let from = |cell| RaceSteps::flood(map.walls(Unknown::Closed), &CellSet::from_iter([cell]));
        let (from_here, from_start) = (from(here), from(map.start()));
        let hoped = RaceSteps::flood(map.walls(Unknown::Open), map.goals());
        // A robot that starts in the goal needs a step that ends there all the same.
        let best = map.goals().iter().filter_map(|goal| from_start.at(goal)).min();
        let (best, optimum) =
            (best.map(|steps| steps.max(1)), hoped.at(map.start()).map(|steps| steps.max(1)));
        Self { from_here, hoped, best, optimum }
    }

    /// Steps to a cell over ways known to be open; to the one it stands in one step too, a turn.
    fn steps_to(&self, cell: Cell) -> Option<u16> {
        self.from_here.at(cell).map(|steps| steps.max(1))
    }

    /// The cell at the edge of what is known over which the goal is nearest, or the goal itself; of
    /// several the one with the least sum of steps to it and cells on to the goal, walls or not.
    fn nearest_to_goal(&self, map: &KnownMaze) -> Option<Cell> {
        let off = |cell: Cell, goal: Cell| cell.x.abs_diff(goal.x) + cell.y.abs_diff(goal.y);
        let crow = |cell| map.goals().iter().map(|goal| off(cell, goal)).min();
        let key = |cell| {
            let (to, on) = (self.steps_to(cell)?, self.hoped.at(cell)?);
            Some((to + on, to + u16::from(crow(cell)?), to))
        };
        let is_edge = |&cell: &Cell| map.goals().contains(cell) || has_unknown_side(map, cell);
        let edge = map.size().cells().filter(is_edge);
        let nearest = edge.filter_map(|cell| Some((key(cell)?, cell))).min_by_key(|&(key, _)| key);
        nearest.map(|(_, cell)| cell)
    }

    /// The nearest cell at the edge of what is known over which a faster race may lead.
    fn nearest_that_matters(&self, map: &KnownMaze, best: u16) -> Option<Cell> {
        let start = CellSet::from_iter([map.start()]);
        let from_start = RaceSteps::flood(map.walls(Unknown::Open), &start);
        let over = |cell| Some(from_start.at(cell)? + self.hoped.at(cell)?);
        let nearest = |most: u16| {
            let matters = |&cell: &Cell| {
                over(cell).is_some_and(|steps| steps <= most) && has_unknown_side(map, cell)
            };
            let cells = map.size().cells().filter(matters);
            cells
                .filter_map(|cell| Some((self.steps_to(cell)?, cell)))
                .min_by_key(|&(steps, _)| steps)
        };
        nearest(best - 1).or_else(|| nearest(best)).map(|(_, cell)| cell)
    }
}

const TURN: Action = Action::Move { rotation: Rotation::Right, cells: 0 };

/// The next move on the way to a cell; in it, a turn to see what lies behind.
fn move_to(map: &KnownMaze, pose: Pose, target: Cell) -> Action {
    let walls = map.walls(Unknown::Closed);
    let to_target = RaceSteps::flood(walls, &CellSet::from_iter([target]));
    to_target.next_move(walls, pose).unwrap_or(TURN)
}

fn has_unknown_side(map: &KnownMaze, cell: Cell) -> bool {
    Heading::ALL.into_iter().any(|heading| map.wall(cell, heading) == WallState::Unknown)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::{Ending, Noise, try_robot, try_watched};

    /// With two ways to the goal, the shorter one away from it at first.
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

    fn ending(text: &str, rule: Rule, noise: f64, seed: u64) -> Ending {
        let maze: Maze = text.parse().unwrap();
        let before = KnownMaze::unexplored(&maze);
        let mut robot = Champion::new(before, rule, Habits::CONTEST, noise, seed);
        try_watched(&maze, &mut robot, &mut Noise::new(noise, seed), |_, _, _| {})
    }

    #[test]
    fn what_is_proven_is_the_optimum() {
        let maze: Maze = MAZE.parse().unwrap();
        let optimum = crate::race_optimum(maze.walls(), maze.start().cell, maze.goals()).unwrap();
        let Ending::Scored(proven) = ending(MAZE, Rule::Proven, 0., 0) else { panic!("no score") };
        assert_eq!(proven.race_steps, u32::from(optimum));
        let Ending::Scored(worth) = ending(MAZE, Rule::default(), 0., 0) else {
            panic!("no score")
        };
        assert!(worth.explore_steps <= proven.explore_steps, "{worth:?} {proven:?}");
    }

    #[test]
    fn a_goal_that_is_cut_off_is_given_up() {
        let cut = MAZE.replace("o---o   o---o   o\n|   |   | G", "o---o---o---o   o\n|   |   | G");
        let cut = cut.replace("|   |     G", "|   |   | G");
        assert_eq!(ending(&cut, Rule::default(), 0., 0), Ending::GaveUp);
        assert_eq!(
            ending("o---o---o\n| S | G |\no---o---o\n", Rule::default(), 0., 0),
            Ending::GaveUp
        );
    }

    #[test]
    fn odd_mazes_are_run_too() {
        let steps = |text| match ending(text, Rule::default(), 0., 0) {
            Ending::Scored(score) => (score.explore_steps, score.race_steps),
            other => panic!("{other:?} in\n{text}"),
        };
        assert_eq!(steps("o---o\n| G |\no---o\n"), (2, 1), "it starts in the goal");
        assert_eq!(steps("o---o\n| S |\no   o\n| G |\no---o\n"), (3, 1), "the way lies behind");
        assert_eq!(steps("o---o---o---o---o\n| S           G |\no---o---o---o---o\n"), (2, 1));
    }

    #[test]
    fn it_finishes_though_its_sensors_err() {
        let mut scored = 0;
        for seed in 0..40 {
            let noise = [0.01, 0.05, 0.1, 0.2][usize::try_from(seed % 4).unwrap()];
            scored +=
                u32::from(matches!(ending(MAZE, Rule::default(), noise, seed), Ending::Scored(_)));
        }
        assert!(scored >= 38, "{scored} of 40");
    }

    #[test]
    fn it_answers_whatever_its_sensors_tell() {
        let maze: Maze = MAZE.parse().unwrap();
        for noise in [0., 0.1, 1.] {
            let mut robot = Champion::new(
                KnownMaze::unexplored(&maze),
                Rule::default(),
                Habits::CONTEST,
                noise,
                1,
            );
            for step in 0..300_u32 {
                let told =
                    [step * 7, step * 11, step * 13].map(|told| (told % 256).to_le_bytes()[0]);
                robot.next_move(told);
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_score() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut robots = [1, 1].map(|seed| {
            Champion::new(KnownMaze::unexplored(&maze), Rule::default(), Habits::CONTEST, 0., seed)
        });
        let [first, second] = robots.each_mut().map(|robot| try_robot(&maze, robot));
        assert_eq!(first, second);
    }
}
