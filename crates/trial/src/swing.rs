//! Swing: the published explorer, which plans with A* and swings over key points.

use std::fmt;
use std::str::FromStr;

use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown, Walls};
use mmsim_solvers::{KeyPointRoute, ShortestPath, centre};

use crate::race::straight;
use crate::{Action, RaceSteps, Robot, Rotation, Survey};

/// Swing, the published explorer: goes to key points one after another along the shortest way over
/// the walls seen so far, unseen ones taken as open, planned anew whenever a wall shows up; equal
/// successive steps are joined to one of up to 3 cells. Then it resets and races along the shortest
/// way that it knows to be open.
///
/// It goes back without turning round, but only where it has seen that there is no wall. A key
/// point that is cut off it [gives up](KeyPointRoute); where no goal cell can be reached it
/// [says so](Action::GiveUp).
#[derive(Clone, Debug)]
pub struct Swing {
    survey: Survey,
    route: KeyPointRoute,
    measure: Measure,
    /// Good until a wall shows up or its end is reached.
    plan: Option<Plan>,
    been_in_goal: bool,
    races: bool,
}

/// What a plan counts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Measure {
    Cells,
    TimeSteps,
}

#[derive(Clone, Debug)]
struct Plan {
    ends: CellSet,
    way: Way,
}

#[derive(Clone, Debug)]
enum Way {
    /// And how many steps of it are done.
    Cells(Box<ShortestPath>, usize),
    TimeSteps(Box<RaceSteps>),
}

/// How far a tour goes, as the report compares it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Variant {
    /// To the centre.
    JustArrive,
    /// To the centre and back to the start.
    ArriveAndBack,
    /// Over all key points.
    #[default]
    All,
}

/// How many of the three corners are key points.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct KeyPoints(u8);

/// A name of no [`Variant`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {names}, found {name:?}", names = Variant::ALL.map(Variant::name).join(", "))]
pub struct UnknownVariant {
    /// The name.
    pub name: String,
}

/// No number of [`KeyPoints`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected 0 to 3 key points, found {found:?}")]
pub struct KeyPointsError {
    /// What was there instead.
    pub found: String,
}

impl Swing {
    /// The published explorer, which counts cells.
    pub fn new(before: KnownMaze, variant: Variant, key_points: KeyPoints) -> Self {
        Self::counting(Measure::Cells, before, variant, key_points)
    }

    /// What the report wishes for: the same with plans that count time steps, where a straight of
    /// up to 3 cells is one step.
    pub fn timed(before: KnownMaze, variant: Variant, key_points: KeyPoints) -> Self {
        Self::counting(Measure::TimeSteps, before, variant, key_points)
    }

    fn counting(
        measure: Measure,
        before: KnownMaze,
        variant: Variant,
        key_points: KeyPoints,
    ) -> Self {
        let (size, start, goals) = (before.size(), before.start(), *before.goals());
        let route = match variant {
            Variant::JustArrive => KeyPointRoute::just_arrive(goals),
            Variant::ArriveAndBack => KeyPointRoute::arrive_and_back(start, goals),
            Variant::All => KeyPointRoute::swing(size, start, goals, key_points.0.into()),
        };
        let survey = Survey::new(before);
        Self { survey, route, measure, plan: None, been_in_goal: false, races: false }
    }

    /// The next step of the first run, `None` if the goal is cut off.
    fn explore(&mut self) -> Option<Action> {
        if self.plan.is_none() {
            let (walls, pose) = (self.survey.map().walls(Unknown::Open), self.survey.pose());
            let centre = centre(self.survey.goals(), walls, pose.cell);
            match self.route.target(walls, pose.cell).filter(|_| centre.is_some()) {
                Some(target) => {
                    self.plan = self.plan(walls, target, [target].into_iter().collect());
                }
                None if self.been_in_goal => return Some(Action::Reset),
                // The tour was over where it began; only a step that ends in the goal counts.
                None => return centre.map(|_| Action::STAY),
            }
        }
        self.follow()
    }

    /// The next step of the second run, `None` if the goal is cut off.
    fn race(&mut self) -> Option<Action> {
        let goals = *self.survey.goals();
        if self.survey.is_in_goal() {
            return Some(Action::STAY);
        }
        if self.plan.is_none() {
            self.plan = [Unknown::Closed, Unknown::Open].into_iter().find_map(|unknown| {
                let walls = self.survey.map().walls(unknown);
                self.plan(walls, centre(&goals, walls, self.survey.pose().cell)?, goals)
            });
        }
        self.follow()
    }

    /// A plan that leads to one cell by the shortest way, or to any of several in the fewest time
    /// steps.
    fn plan(&self, walls: &Walls, cell: Cell, ends: CellSet) -> Option<Plan> {
        let way = match self.measure {
            Measure::Cells => {
                Way::Cells(Box::new(ShortestPath::find(walls, self.survey.pose().cell, cell)?), 0)
            }
            Measure::TimeSteps => Way::TimeSteps(Box::new(RaceSteps::flood(walls, &ends))),
        };
        Some(Plan { ends, way })
    }

    /// The next step of the plan.
    fn follow(&mut self) -> Option<Action> {
        let (map, pose) = (self.survey.map(), self.survey.pose());
        let (heading, cells) = match &self.plan.as_ref()?.way {
            Way::Cells(path, done) => {
                let mut headings = path.headings().skip(*done);
                let heading = headings.next()?;
                (heading, 1 + headings.take_while(|&next| next == heading).count())
            }
            Way::TimeSteps(race) => {
                let next = |unknown| race.next_straight(map.walls(unknown), pose);
                next(Unknown::Closed).or_else(|| next(Unknown::Open))?
            }
        };
        let known = map.walls(Unknown::Closed);
        let cells = straight(known, pose.cell, heading).take(cells).count();
        if let Some(Plan { way: Way::Cells(_, done), .. }) = &mut self.plan {
            *done += cells;
        }
        // Nothing may be known of what lies behind: a turn on the spot lets it see.
        let turn = Action::Move { rotation: Rotation::Left, cells: 0 };
        let cells = i8::try_from(cells).ok().filter(|&cells| cells > 0);
        Some(cells.map_or(turn, |cells| Action::towards(pose.heading, heading, cells)))
    }
}

impl Robot for Swing {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        let walls = self.survey.map().walls(Unknown::Open).clone();
        self.survey.observe(sensors);
        let cell = self.survey.pose().cell;
        if *self.survey.map().walls(Unknown::Open) != walls {
            self.plan = None;
        }
        self.plan.take_if(|plan| plan.ends.contains(cell));
        let action = if self.races { self.race() } else { self.explore() };
        let action = action.unwrap_or(Action::GiveUp);
        if action == Action::Reset {
            self.races = true;
            self.plan = None;
        }
        self.survey.go(action);
        self.been_in_goal |= self.survey.is_in_goal();
        action
    }
}

impl Variant {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::JustArrive, Self::ArriveAndBack, Self::All];

    /// Its name, as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::JustArrive => "just-arrive",
            Self::ArriveAndBack => "arrive-and-back",
            Self::All => "all",
        }
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Variant {
    type Err = UnknownVariant;

    fn from_str(name: &str) -> Result<Self, UnknownVariant> {
        let named = Self::ALL.into_iter().find(|variant| variant.name() == name);
        named.ok_or_else(|| UnknownVariant { name: name.into() })
    }
}

impl KeyPoints {
    /// From none to all of them.
    pub const ALL: [Self; 1 + KeyPointRoute::CORNERS] = [Self(0), Self(1), Self(2), Self(3)];
}

impl Default for KeyPoints {
    /// All of them.
    fn default() -> Self {
        Self(3)
    }
}

impl fmt::Display for KeyPoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for KeyPoints {
    type Err = KeyPointsError;

    fn from_str(number: &str) -> Result<Self, KeyPointsError> {
        let named = Self::ALL.into_iter().find(|points| points.to_string() == number);
        named.ok_or_else(|| KeyPointsError { found: number.into() })
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::{Ending, Noise, Trial, try_robot, try_watched};

    #[test]
    fn names_are_read_back() {
        for variant in Variant::ALL {
            assert_eq!(variant.to_string().parse(), Ok(variant));
        }
        for points in KeyPoints::ALL {
            assert_eq!(points.to_string().parse(), Ok(points));
        }
        insta::assert_snapshot!("4".parse::<KeyPoints>().unwrap_err(), @r#"expected 0 to 3 key points, found "4""#);
        insta::assert_snapshot!("swing".parse::<Variant>().unwrap_err(), @r#"expected one of just-arrive, arrive-and-back, all, found "swing""#);
    }

    #[test]
    fn equal_steps_are_joined_and_what_lies_behind_is_looked_at_first() {
        let maze: Maze =
            "o---o\n| S |\no   o\n|   |\no   o\n|   |\no   o\n| G |\no---o\n".parse().unwrap();
        for timed in [false, true] {
            let (before, points) = (KnownMaze::unexplored(&maze), KeyPoints::default());
            let mut robot = if timed {
                Swing::timed(before, Variant::JustArrive, points)
            } else {
                Swing::new(before, Variant::JustArrive, points)
            };
            let mut steps = Vec::new();
            try_watched(&maze, &mut robot, &mut Noise::none(), |_, _, action| {
                steps.push(action.to_string());
            });
            assert_eq!(steps, ["(-90, 0)", "(-90, 3)", "(Reset, Reset)", "(0, -3)"]);
        }
    }

    #[test]
    fn a_goal_that_is_cut_off_is_given_up() {
        let text = "o---o---o---o\n|   | G |   |\no---o---o   o\n| S         |\no---o---o---o\n";
        let maze: Maze = text.parse().unwrap();
        for variant in Variant::ALL {
            let mut robot = Swing::new(KnownMaze::unexplored(&maze), variant, KeyPoints::default());
            assert_eq!(try_robot(&maze, &mut robot), Ending::GaveUp, "{variant}");
        }
    }

    #[test]
    fn sensors_that_err_do_no_harm() {
        let text = "o---o---o---o\n|         G |\no   o---o   o\n| S         |\no---o---o---o\n";
        let maze: Maze = text.parse().unwrap();
        for seed in 0..50 {
            let mut robot =
                Swing::new(KnownMaze::unexplored(&maze), Variant::All, KeyPoints::default());
            let mut noise = Noise::new(0.3, seed);
            let in_maze = |trial: &Trial<'_>, _, _| {
                assert!(maze.size().contains(trial.pose().cell));
            };
            try_watched(&maze, &mut robot, &mut noise, in_maze);
        }
    }
}
