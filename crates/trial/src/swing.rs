//! Swing, the published robot that plans with A* and visits key points.

use std::fmt;
use std::str::FromStr;

use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown, Walls};
use mmsim_solvers::{KeyPointRoute, ShortestPath, centre};

use crate::race::{RaceSteps, straight};
use crate::robot::{Action, Robot, Rotation};
use crate::survey::Survey;

/// The published robot that visits key points, such as the corners of the maze, along optimistic
/// shortest paths. The robot replans whenever it sees a new wall. On straights, the robot moves up
/// to 3 cells per step. At the end of its exploration, the robot resets and races along the
/// shortest path known to be open.
///
/// The robot moves backwards only through sides known to be open. The robot skips unreachable [key
/// points](KeyPointRoute), and it [gives up](Action::GiveUp) if no goal cell is reachable.
#[derive(Clone, Debug)]
pub struct SwingRobot {
    survey: Survey,
    route: KeyPointRoute,
    cost: PathCost,
    /// The current plan, which is valid until the robot sees a new wall or completes the plan.
    plan: Option<SwingPlan>,
    has_visited_goal: bool,
    is_racing: bool,
}

/// The unit of path costs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum PathCost {
    Cells,
    TimeSteps,
}

#[derive(Clone, Debug)]
struct SwingPlan {
    targets: CellSet,
    path: PlannedPath,
}

#[derive(Clone, Debug)]
enum PlannedPath {
    /// A path and the number of cells travelled along it.
    Cells(Box<ShortestPath>, usize),
    TimeSteps(Box<RaceSteps>),
}

/// The cells that a [`SwingRobot`] visits before its race. All three variants are from the
/// published report.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub enum Variant {
    /// Visit the centre.
    JustArrive,
    /// Visit the centre and return to the start.
    ArriveAndBack,
    /// Visit the centre, corners and start in the order defined by [`KeyPointRoute::swing`].
    #[default]
    All,
}

/// The number of corners to visit, from 0 to 3.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct KeyPoints(u8);

/// The error for a name that is not a [`Variant`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {names}, found {name:?}", names = Variant::names().join(", "))]
#[non_exhaustive]
pub struct UnknownVariant {
    /// The unknown name.
    pub name: String,
}

/// The error for a string that is not a valid number of key points.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected 0 to 3 corners, found {found:?}")]
#[non_exhaustive]
pub struct KeyPointsError {
    /// The invalid string.
    pub found: String,
}

impl SwingRobot {
    /// Creates the published robot, which minimizes the number of cells in a path.
    pub fn new(unexplored: KnownMaze, variant: Variant, key_points: KeyPoints) -> Self {
        Self::with_cost(PathCost::Cells, unexplored, variant, key_points)
    }

    /// Creates the improved robot that the published report suggests. The improved robot plans
    /// paths with the fewest time steps. A straight move of up to 3 cells takes one time step.
    pub fn timed(unexplored: KnownMaze, variant: Variant, key_points: KeyPoints) -> Self {
        Self::with_cost(PathCost::TimeSteps, unexplored, variant, key_points)
    }

    fn with_cost(
        cost: PathCost,
        unexplored: KnownMaze,
        variant: Variant,
        key_points: KeyPoints,
    ) -> Self {
        let route = Self::route(&unexplored, variant, key_points);
        let survey = Survey::new(unexplored);
        Self { survey, route, cost, plan: None, has_visited_goal: false, is_racing: false }
    }

    /// Returns the key points of a tour in an empty maze, in the order in which the robot visits them.
    pub fn tour(unexplored: &KnownMaze, variant: Variant, key_points: KeyPoints) -> Vec<Cell> {
        let walls = Walls::open(unexplored.size());
        let mut route = Self::route(unexplored, variant, key_points);
        let mut tour: Vec<Cell> = Vec::new();
        let mut here = unexplored.start().cell;
        while let Some(next) = route.target(&walls, here) {
            tour.push(next);
            here = next;
        }
        tour
    }

    fn route(unexplored: &KnownMaze, variant: Variant, key_points: KeyPoints) -> KeyPointRoute {
        let (size, start, goals) =
            (unexplored.size(), unexplored.start().cell, *unexplored.goals());
        match variant {
            Variant::JustArrive => KeyPointRoute::just_arrive(goals),
            Variant::ArriveAndBack => KeyPointRoute::arrive_and_back(start, goals),
            Variant::All => KeyPointRoute::swing(size, start, goals, key_points.0.into()),
        }
    }

    /// Returns the next step of the first run, or `None` if the goal is unreachable.
    fn explore(&mut self) -> Option<Action> {
        if self.plan.is_none() {
            let (walls, pose) = (self.survey.map().walls(Unknown::Open), self.survey.pose());
            let centre = centre(self.survey.goals(), walls, pose.cell);
            match self.route.target(walls, pose.cell).filter(|_| centre.is_some()) {
                Some(target) => {
                    self.plan = self.plan(walls, target, [target].into_iter().collect());
                }
                None if self.has_visited_goal => return Some(Action::Reset),
                // The route is complete, but the goal counts as visited only after a step that ends
                // in it.
                None => return centre.map(|_| Action::STAY),
            }
        }
        self.follow()
    }

    /// Returns the next step of the second run, or `None` if the goal is unreachable.
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

    /// Returns a plan. If path costs are in cells, the plan is a shortest path to `cell`. If path
    /// costs are in time steps, the plan is a fastest path to any cell of `targets`.
    fn plan(&self, walls: &Walls, cell: Cell, targets: CellSet) -> Option<SwingPlan> {
        let path = match self.cost {
            PathCost::Cells => PlannedPath::Cells(
                Box::new(ShortestPath::find(walls, self.survey.pose().cell, cell)?),
                0,
            ),
            PathCost::TimeSteps => {
                PlannedPath::TimeSteps(Box::new(RaceSteps::flood(walls, &targets)))
            }
        };
        Some(SwingPlan { targets, path })
    }

    /// Returns the next step of the plan.
    fn follow(&mut self) -> Option<Action> {
        let (map, pose) = (self.survey.map(), self.survey.pose());
        let (heading, cells) = match &self.plan.as_ref()?.path {
            PlannedPath::Cells(path, done) => {
                let mut headings = path.headings().skip(*done);
                let heading = headings.next()?;
                (heading, 1 + headings.take_while(|&next| next == heading).count())
            }
            PlannedPath::TimeSteps(race) => {
                let next = |unknown| race.next_straight(map.walls(unknown), pose);
                next(Unknown::Closed).or_else(|| next(Unknown::Open))?
            }
        };
        let known = map.walls(Unknown::Closed);
        let cells = straight(known, pose.cell, heading).take(cells).count();
        if let Some(SwingPlan { path: PlannedPath::Cells(_, done), .. }) = &mut self.plan {
            *done += cells;
        }
        // If the walls behind the robot are unknown, a turn on the spot reveals them.
        let turn = Action::Move { rotation: Rotation::Left, cells: 0 };
        Some(Action::towards(pose.heading, heading, cells).unwrap_or(turn))
    }
}

impl Robot for SwingRobot {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        let walls = self.survey.map().walls(Unknown::Open).clone();
        self.survey.observe(sensors);
        let cell = self.survey.pose().cell;
        if *self.survey.map().walls(Unknown::Open) != walls {
            self.plan = None;
        }
        self.plan.take_if(|plan| plan.targets.contains(cell));
        let action = if self.is_racing { self.race() } else { self.explore() };
        let action = action.unwrap_or(Action::GiveUp);
        if action == Action::Reset {
            self.is_racing = true;
            self.plan = None;
        }
        self.survey.apply(action);
        self.has_visited_goal |= self.survey.is_in_goal();
        action
    }
}

impl Variant {
    /// All variants.
    pub const ALL: &'static [Self] = &[Self::JustArrive, Self::ArriveAndBack, Self::All];

    /// Returns the name used on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::JustArrive => "just-arrive",
            Self::ArriveAndBack => "arrive-and-back",
            Self::All => "all",
        }
    }

    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|variant| variant.name()).collect()
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
        let named = Self::ALL.iter().copied().find(|variant| variant.name() == name);
        named.ok_or_else(|| UnknownVariant { name: name.into() })
    }
}

impl KeyPoints {
    /// All valid numbers of corners, from 0 to 3.
    pub const ALL: &'static [Self] = &[Self(0), Self(1), Self(2), Self(3)];

    /// Returns the number of corners.
    pub const fn number(self) -> u8 {
        self.0
    }
}

impl Default for KeyPoints {
    /// Returns the maximum: three corners.
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
        let named = Self::ALL.iter().copied().find(|points| points.to_string() == number);
        named.ok_or_else(|| KeyPointsError { found: number.into() })
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::tests::{actions, check_noisy_trials};
    use crate::trial::{TrialOutcome, run_trial};

    #[test]
    fn names_round_trip() {
        for &variant in Variant::ALL {
            assert_eq!(variant.to_string().parse(), Ok(variant));
        }
        for &points in KeyPoints::ALL {
            assert_eq!(points.to_string().parse(), Ok(points));
        }
        insta::assert_snapshot!("4".parse::<KeyPoints>().unwrap_err(), @r#"expected 0 to 3 corners, found "4""#);
        insta::assert_snapshot!("swing".parse::<Variant>().unwrap_err(), @r#"expected one of just-arrive, arrive-and-back, all, found "swing""#);
    }

    #[test]
    fn joins_cells_and_turns_before_moving_back_into_the_unknown() {
        let maze: Maze =
            "o---o\n| S |\no   o\n|   |\no   o\n|   |\no   o\n| G |\no---o\n".parse().unwrap();
        for new in [SwingRobot::new, SwingRobot::timed] {
            let unexplored = KnownMaze::unexplored(&maze);
            let mut robot = new(unexplored, Variant::JustArrive, KeyPoints::default());
            let expected = ["(-90, 0)", "(-90, 3)", "(Reset, Reset)", "(0, -3)"];
            assert_eq!(actions(&maze, &mut robot), expected);
        }
    }

    #[test]
    fn gives_up_if_the_goal_is_unreachable() {
        let text = "o---o---o---o\n|   | G |   |\no---o---o   o\n| S         |\no---o---o---o\n";
        let maze: Maze = text.parse().unwrap();
        for &variant in Variant::ALL {
            let mut robot =
                SwingRobot::new(KnownMaze::unexplored(&maze), variant, KeyPoints::default());
            assert_eq!(run_trial(&maze, &mut robot), TrialOutcome::GaveUp, "{variant}");
        }
    }

    #[test]
    fn noisy_sensors_are_harmless() {
        check_noisy_trials(|maze| {
            SwingRobot::new(KnownMaze::unexplored(maze), Variant::All, KeyPoints::default())
        });
    }
}
