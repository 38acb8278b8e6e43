//! One search of one maze by one strategy, in memory, and its figures.

use mmsim_maze::{KnownMaze, Maze, Pose, Step, Unknown, WallState, Walls};
use mmsim_solvers::{Crash, Distances, Mouse, Move, SearchError, Strategy};

/// A search from its beginning to its end.
#[derive(Debug)]
pub(crate) struct Search {
    /// Where the mouse stood each time it decided what to do: a step is from one to the next.
    poses: Vec<Pose>,
    /// How many of them belong to the search run: all, or those up to where the fast run begins.
    run_states: usize,
    /// With which step it does.
    first_fast_step: Option<Step>,
    /// Why the search could not go on.
    fault: Option<Fault>,
}

/// Why a search cannot go on.
#[derive(Debug, thiserror::Error)]
enum Fault {
    /// The strategy says so.
    #[error(transparent)]
    Search(#[from] SearchError),
    /// The strategy drives the mouse into a wall.
    #[error(transparent)]
    Crash(#[from] Crash),
}

impl Search {
    /// Lets the strategy search the maze until it stops, but in at most `max_states` states, of
    /// which there is one in each cell that the mouse comes to.
    #[cfg(test)]
    fn run(maze: &Maze, strategy: impl Strategy, max_states: u32) -> Self {
        let (search, mouse) = Self::begin(maze, strategy, max_states);
        search.finish(maze, mouse, max_states)
    }

    /// The search run of this: until the strategy stops or begins a fast run.
    pub(crate) fn begin<S: Strategy>(
        maze: &Maze,
        strategy: S,
        max_states: u32,
    ) -> (Self, Mouse<S>) {
        let mut mouse = Mouse::new(strategy, known_at_first(maze), maze.start());
        let mut search =
            Self { poses: Vec::new(), run_states: 0, first_fast_step: None, fault: None };
        search.fault = search.go_on(maze, &mut mouse, max_states).err();
        search.run_states = search.poses.len();
        (search, mouse)
    }

    /// The same with the fast run, if there is one.
    pub(crate) fn finish<S: Strategy>(
        mut self,
        maze: &Maze,
        mut mouse: Mouse<S>,
        max_states: u32,
    ) -> Self {
        if let Some(step) = self.first_fast_step {
            let gone = mouse.go(step).map_err(Fault::from);
            self.fault = gone.and_then(|()| self.go_on(maze, &mut mouse, max_states)).err();
        }
        self
    }

    /// Goes on to the end, or to where the fast run begins.
    fn go_on<S: Strategy>(
        &mut self,
        maze: &Maze,
        mouse: &mut Mouse<S>,
        max_states: u32,
    ) -> Result<(), Fault> {
        while self.poses.len() < max_states as usize {
            let pose = mouse.pose();
            // The true walls do not contradict each other.
            let _ = mouse.see(maze.walls().around(pose));
            self.poses.push(pose);
            match mouse.decide()? {
                Move::Step(step) if mouse.runs_fast() && self.first_fast_step.is_none() => {
                    self.first_fast_step = Some(step);
                    break;
                }
                Move::Step(step) => mouse.go(step)?,
                Move::Stop => break,
            }
        }
        Ok(())
    }

    fn search_run(&self) -> &[Pose] {
        &self.poses[..self.run_states]
    }
}

/// What came of a search. All is of the search run, but that the goal may be reached on the fast
/// run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Figures {
    /// Steps until the mouse stood in a goal cell for the first time.
    pub(crate) steps_to_goal: Option<u32>,
    /// Steps until the shortest path was proven: with all unknown walls taken as open there was no
    /// shorter one than over what was known.
    pub(crate) steps_until_proven: Option<u32>,
    /// Steps until the strategy stopped or began its fast run.
    pub(crate) steps_in_all: u32,
    /// Quarter turns on these steps; turning round is two.
    pub(crate) turns: u32,
    /// Steps from the start to the goal over what was known at the end.
    pub(crate) path_found: Option<u16>,
    /// Steps from the start to the goal over the true walls, `None` where there is no way.
    pub(crate) shortest_path: Option<u16>,
    /// Whether the strategy said rightly that the goal cannot be reached.
    pub(crate) is_rightly_given_up: bool,
    /// Why the search could not go on.
    pub(crate) error: Option<String>,
}

impl Figures {
    /// The figures of a search of this maze.
    pub(crate) fn of(maze: &Maze, search: &Search) -> Self {
        let run = search.search_run();
        let shortest_path = distance(maze, maze.walls());
        let in_goal = |pose: &Pose| maze.goals().contains(pose.cell);
        let says_unreachable = matches!(
            search.fault,
            Some(Fault::Search(SearchError::GoalUnreachable { .. } | SearchError::BoxedIn { .. }))
        );
        Self {
            steps_to_goal: search.poses.iter().position(in_goal).map(number),
            steps_until_proven: steps_until_proven(maze, run).map(number),
            steps_in_all: number(run.len().saturating_sub(1)),
            turns: run.windows(2).map(|step| quarter_turns(step[0], step[1])).sum(),
            path_found: distance(maze, known_after(maze, run).walls(Unknown::Closed)),
            shortest_path,
            is_rightly_given_up: shortest_path.is_none() && says_unreachable,
            error: search.fault.as_ref().map(ToString::to_string),
        }
    }
}

/// After how many steps of this search run the shortest path is proven. Knowledge only grows, so
/// from then on it stays proven, and the first such state is found by halving.
fn steps_until_proven(maze: &Maze, run: &[Pose]) -> Option<usize> {
    let states: Vec<usize> = (0..run.len()).collect();
    let first = states.partition_point(|&last| !is_proven(maze, &known_after(maze, &run[..=last])));
    (first < run.len()).then_some(first)
}

/// Whether no unknown wall can make the path from the start to the goal any shorter.
fn is_proven(maze: &Maze, map: &KnownMaze) -> bool {
    let over = |unknown| distance(maze, map.walls(unknown));
    // The cheaper flood first: it ends where the known walls do.
    over(Unknown::Closed).is_some_and(|found| over(Unknown::Open) == Some(found))
}

/// Steps from the start to the goal.
fn distance(maze: &Maze, walls: &Walls) -> Option<u16> {
    Distances::flood(walls, maze.goals()).at(maze.start().cell)
}

/// What a mouse knows that has been here.
fn known_after(maze: &Maze, run: &[Pose]) -> KnownMaze {
    let mut map = known_at_first(maze);
    for &pose in run {
        look(&mut map, maze, pose);
    }
    map
}

/// What a mouse knows before its first decision. Where nothing is known of the side behind it, it
/// looks there with the nose turned round, as a client of the simulator does.
fn known_at_first(maze: &Maze) -> KnownMaze {
    let mut map = KnownMaze::unexplored(maze);
    let Pose { cell, heading } = maze.start();
    if map.wall(cell, heading.back()) == WallState::Unknown {
        look(&mut map, maze, Pose::new(cell, heading.back()));
    }
    map
}

fn look(map: &mut KnownMaze, maze: &Maze, pose: Pose) {
    // The true walls do not contradict each other.
    let _ = map.observe(pose, maze.walls().around(pose));
}

fn quarter_turns(from: Pose, to: Pose) -> u32 {
    if from.heading == to.heading {
        0
    } else if from.heading == to.heading.back() {
        2
    } else {
        1
    }
}

/// A number of states or steps: no search has more than the `u32` that limits it.
fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Step};
    use mmsim_solvers::{BundledStrategy, FloodFill, LeftWall, Swing};

    use super::*;
    use crate::embedded;

    fn figures(strategy: impl Strategy, drawing: &str, max_states: u32) -> Figures {
        let maze = drawing.parse().unwrap();
        Figures::of(&maze, &Search::run(&maze, strategy, max_states))
    }

    const CLOSED: &str = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";

    #[test]
    fn steps_and_turns_are_counted() {
        let maze = "\
o---o---o---o
|       | G |
o   o   o   o
|   |   |   |
o   o---o   o
| S |       |
o   o   o   o
|           |
o---o---o---o
";
        // Four steps into the dead end, turning right twice, four back, turning round and right and
        // left, then six, turning left twice. In the cell before the goal its open side is seen.
        let expected = Figures {
            steps_to_goal: Some(14),
            steps_until_proven: Some(13),
            steps_in_all: 14,
            turns: 2 + 4 + 2,
            path_found: Some(6),
            shortest_path: Some(6),
            is_rightly_given_up: false,
            error: None,
        };
        assert_eq!(figures(FloodFill::new(), maze, 1000), expected);
        assert_eq!(figures(FloodFill::new(), maze, 15), expected, "one state more than steps");
        let expected = Figures { steps_to_goal: None, steps_in_all: 13, ..expected };
        assert_eq!(figures(FloodFill::new(), maze, 14), expected, "the path is known all the same");
    }

    #[test]
    fn a_fast_run_does_not_count() {
        let maze = "\
o---o---o---o
|           |
o   o---o   o
|   | G     |
o   o---o   o
| S |       |
o---o---o---o
";
        // To the goal, the south-east corner, the goal again and the start, then fast to the goal.
        let expected = Figures {
            steps_to_goal: Some(6),
            steps_until_proven: Some(5),
            steps_in_all: 6 + 2 + 2 + 6,
            turns: 3 + 3 + 3 + 5,
            path_found: Some(6),
            shortest_path: Some(6),
            is_rightly_given_up: false,
            error: None,
        };
        assert_eq!(figures(Swing::new(), maze, 1000), expected);
    }

    #[test]
    fn a_path_that_may_be_too_long_is_not_proven() {
        let maze = "\
o---o---o
|       |
o   o   o
| S | G |
o---o---o
";
        let expected = Figures {
            steps_to_goal: Some(3),
            steps_until_proven: Some(2),
            steps_in_all: 3,
            turns: 2,
            path_found: Some(3),
            shortest_path: Some(3),
            is_rightly_given_up: false,
            error: None,
        };
        assert_eq!(figures(FloodFill::new(), maze, 1000), expected);
        // Keeping left it sees nothing of the way through the middle.
        let maze = "\
o---o---o---o
|           |
o   o---o   o
|   |   | G |
o   o   o   o
|           |
o   o---o   o
| S |       |
o---o---o---o
";
        let expected = Figures {
            steps_to_goal: Some(6),
            steps_until_proven: None,
            steps_in_all: 6,
            turns: 2,
            path_found: Some(6),
            shortest_path: Some(4),
            is_rightly_given_up: false,
            error: None,
        };
        assert_eq!(figures(LeftWall::new(), maze, 1000), expected);
    }

    #[test]
    fn only_who_says_that_there_is_no_way_gives_up_rightly() {
        let expected = Figures {
            steps_to_goal: None,
            steps_until_proven: None,
            steps_in_all: 3,
            turns: 3,
            path_found: None,
            shortest_path: None,
            is_rightly_given_up: true,
            error: Some(
                "expected a way from (1, 0) to the goal, found all of them closed by walls".into(),
            ),
        };
        assert_eq!(figures(FloodFill::new(), CLOSED, 1000), expected);
        let circling = figures(LeftWall::new(), CLOSED, 100);
        assert_eq!((circling.steps_in_all, circling.error), (99, None));
        assert!(!circling.is_rightly_given_up);
    }

    /// Goes straight on, and fast from the second state on.
    #[derive(Default)]
    struct Straight {
        states: u32,
    }

    impl Strategy for Straight {
        fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
            self.states += 1;
            let is_done = map.goals().contains(pose.cell);
            Ok(if is_done { Move::Stop } else { Move::Step(Step::Front) })
        }

        fn weight(&self, _: Cell) -> u16 {
            0
        }

        fn runs_fast(&self) -> bool {
            self.states >= 2
        }
    }

    #[test]
    fn the_goal_may_be_reached_on_the_fast_run() {
        let maze = "o---o\n| G |\no   o\n|   |\no   o\n|   |\no   o\n| S |\no---o\n";
        let Figures { steps_to_goal, steps_in_all, path_found, .. } =
            figures(Straight::default(), maze, 1000);
        assert_eq!((steps_to_goal, steps_in_all, path_found), (Some(3), 1, None));
    }

    #[test]
    fn a_crash_ends_the_search() {
        let Figures { steps_in_all, error, .. } = figures(Straight::default(), CLOSED, 1000);
        assert_eq!(steps_in_all, 1);
        insta::assert_snapshot!(error.unwrap(), @"expected a step through an open side, found the north side of (0, 1) closed by a wall");
    }

    #[test]
    fn halving_finds_the_first_state_that_is_proven() {
        for entry in embedded::catalogue().entries() {
            let maze = entry.maze().unwrap();
            for strategy in BundledStrategy::ALL {
                let search = Search::run(&maze, strategy.strategy(), strategy.max_states());
                let (run, mut map) = (search.search_run(), known_at_first(&maze));
                let first = run.iter().position(|&pose| {
                    look(&mut map, &maze, pose);
                    is_proven(&maze, &map)
                });
                assert_eq!(steps_until_proven(&maze, run), first, "{strategy} {}", entry.name());
            }
        }
    }
}
