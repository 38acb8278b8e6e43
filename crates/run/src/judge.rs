//! Judges what a mouse did in a maze from its poses and the walls that it has read.

use mmsim_fastrun::{FastRun, Planner};
#[cfg(feature = "recording")]
use mmsim_maze::Wall;
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Maze, Pose, Unknown, WallState};
#[cfg(feature = "recording")]
use mmsim_protocol::State;
use mmsim_solvers::{PathBounds, steps_between};

use crate::cause::{Cause, EndFacts, Evidence};
use crate::fastest_run::FastestRun;
use crate::figures::{SearchFigures, SearchOutcome};
use crate::movement::{MovementRules, Transition};
use crate::phases::{Phases, RunPhase};
use crate::times::saturate;

/// The maximum number of readings that wait for the next pose. Mice need up to two.
const MAX_READ_AHEAD: usize = 16;

/// Judges what a mouse does in a maze. The figures do not depend on what the mouse reports about
/// walls, only on the walls that it has read or run into.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Maze, Pose};
/// use mmsim_run::Judge;
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let mut judge = Judge::new(&maze);
/// judge.read_walls(maze.start());
/// judge.add(maze.start(), false);
/// judge.add(Pose::new(Cell::new(1, 0), Heading::East), false);
/// assert_eq!(judge.figures().steps_to_goal, Some(1));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Judge {
    maze: Maze,
    rules: MovementRules,
    /// The walls that the mouse has read or run into.
    known: KnownMaze,
    /// The walls that the mouse knows, each with the number of steps before it, in order.
    readings: Vec<(u32, Cell, Heading)>,
    /// True if walls have become known since the shortest path was last examined.
    has_new_walls: bool,
    path: Vec<Cell>,
    visited: CellSet,
    /// The number of movements that a wall blocked.
    crashes: u32,
    /// The poses of readings that belong to the next pose.
    read_ahead: Vec<Pose>,
    phases: Phases,
    evidence: Evidence,
    steps_until_proven: Option<u32>,
    touches_to_goal: u32,
    /// The figures of the search run and the return run, at the beginning of the first fast run.
    exploration: Option<SearchFigures>,
    /// The cells of the current or latest fast run, until one is complete.
    route: Vec<Cell>,
    /// The number of the fast run along the route, once it is complete.
    route_run: Option<u32>,
    /// This fast run, if the mouse has driven it with slalom turns.
    driven: Option<FastRun>,
}

impl Judge {
    /// Creates the judge of a mouse that has not begun.
    pub fn new(maze: &Maze) -> Self {
        Self {
            rules: MovementRules::from_maze(maze),
            known: KnownMaze::unexplored(maze),
            maze: maze.clone(),
            readings: Vec::new(),
            has_new_walls: true,
            path: Vec::new(),
            visited: CellSet::EMPTY,
            crashes: 0,
            read_ahead: Vec::new(),
            phases: Phases::default(),
            evidence: Evidence::new(maze),
            steps_until_proven: None,
            touches_to_goal: 0,
            exploration: None,
            route: Vec::new(),
            route_run: None,
            driven: None,
        }
    }

    /// Returns the maze.
    pub const fn maze(&self) -> &Maze {
        &self.maze
    }

    /// Returns the walls that the mouse has read or run into.
    pub const fn known(&self) -> &KnownMaze {
        &self.known
    }

    /// Returns the phases of the mouse, which decide whether it has reached the goal.
    pub const fn phases(&self) -> &Phases {
        &self.phases
    }

    /// Returns true if there is a wall on this side of the cell. The mouse now knows this wall.
    pub fn read_wall(&mut self, cell: Cell, heading: Heading) -> bool {
        let is_present = self.maze.walls().has(cell, heading);
        if self.known.wall(cell, heading) == WallState::Unknown {
            let state = if is_present { WallState::Present } else { WallState::Absent };
            self.known.set_wall(cell, heading, state);
            self.readings.push((saturate(self.phases.total.steps), cell, heading));
            self.has_new_walls = true;
        }
        is_present
    }

    /// Notes that the mouse has read the walls to its left, ahead and to its right. A mouse that reads
    /// the walls around another cell than its own has moved, but not reported its pose yet.
    pub fn read_walls(&mut self, pose: Pose) {
        let is_ahead = self.phases.pose.is_none_or(|current| current.cell != pose.cell);
        if is_ahead && self.read_ahead.len() < MAX_READ_AHEAD {
            self.read_ahead.push(pose);
        } else {
            self.note_walls(pose);
        }
    }

    /// Notes a run from the start to the goal that the mouse has just completed, with its turns. It
    /// may lead further into the goal than the route. Later runs than that along the route do not count.
    pub fn drive(&mut self, run: &FastRun) {
        let is_first = self.driven.is_none() && self.route_run == Some(self.phases.fast_runs);
        if is_first && !run.turns().is_empty() && run.cells().starts_with(&self.route) {
            self.driven = Some(run.clone());
        }
    }

    /// Notes that a wall has blocked the mouse.
    pub const fn crash(&mut self) {
        self.evidence.block();
        self.crashes = self.crashes.saturating_add(1);
    }

    /// Notes that the simulator was reset, which numbers the states from 0 again.
    pub fn reset(&mut self) {
        self.evidence.clear();
    }

    /// Notes in which walls the mouse believes: in the newest state or, if `is_shown` is false, after it.
    pub fn believe(&mut self, is_shown: bool, has_wall: impl Fn(Cell, Heading) -> bool) {
        self.evidence.believe(is_shown, has_wall);
    }

    /// Returns the cause of the failure of a mouse whose run has ended, or `None` if it has reached the
    /// goal, has jumped, or failed for another reason.
    pub fn cause(&self, facts: &EndFacts) -> Option<Cause> {
        let Phases { goal, first_jump, states, .. } = self.phases;
        // A reset has cleared the evidence of what the mouse did before it.
        let is_reset = states > 0 && self.evidence.is_empty();
        if goal.is_some() || first_jump.is_some() || is_reset {
            return None;
        }
        self.evidence.cause(&self.maze, facts)
    }

    fn note_walls(&mut self, pose: Pose) {
        for heading in [pose.heading.left(), pose.heading, pose.heading.right()] {
            self.read_wall(pose.cell, heading);
        }
    }

    /// Adds the pose of a mouse that has moved or turned, or that was put back at the start.
    pub fn add(&mut self, pose: Pose, is_restart: bool) {
        self.examine_path();
        let before = self.phases;
        self.phases.add(&self.rules, pose, is_restart);
        self.evidence.add(pose);
        self.visited.insert(pose.cell);
        match before.pose {
            Some(from) => self.note_movement(&before, from.cell, pose.cell),
            None => self.path.push(pose.cell),
        }
        if self.phases.is_goal_reached() && !before.is_goal_reached() {
            self.touches_to_goal = self.touches();
        }
        for pose in std::mem::take(&mut self.read_ahead) {
            self.note_walls(pose);
        }
    }

    /// Notes how the mouse got from one cell to another, or that it has turned.
    fn note_movement(&mut self, before: &Phases, from: Cell, to: Cell) {
        if let Some(Transition::Move { steps: 1, .. }) = self.phases.transition {
            // The mouse has moved between neighbouring cells, so there is no wall between them.
            let side = Heading::ALL.into_iter().find(|&side| from.neighbour(side) == Some(to));
            side.map(|side| self.read_wall(from, side));
        }
        if before.fast_runs == 0 && self.phases.fast_runs == 1 {
            // The turns in the start cell belong to the fast run.
            let turns = self.phases.total.turns - u64::from(self.phases.fast_run.turns);
            self.exploration = Some(self.exploration_at(before.total.steps, turns, from));
        }
        self.note_route(from, to, before.fast_runs);
        if from != to {
            self.path.push(to);
        }
    }

    /// Notes the cells of the fast run. `fast_runs` is the number of fast runs before this movement.
    fn note_route(&mut self, from: Cell, to: Cell, fast_runs: u32) {
        if self.route_run.is_some() {
            return;
        }
        // A run with a jump has no route.
        if self.phases.first_jump.is_some() {
            return self.route.clear();
        }
        let Phases { phase, fast_runs: now, .. } = self.phases;
        let has_begun = now > fast_runs;
        if has_begun {
            self.route = vec![from];
        }
        let is_complete = phase == RunPhase::AtGoal && !self.route.is_empty();
        if has_begun || phase == RunPhase::Fast || is_complete {
            self.route.extend(self.rules.cells_between(from, to));
            self.route_run = is_complete.then_some(now);
        } else {
            // The mouse was put back at the start.
            self.route.clear();
        }
    }

    const fn touches(&self) -> u32 {
        self.phases.restarts.saturating_add(self.crashes)
    }

    /// Notes whether the known walls prove that the shortest known path is shortest.
    fn examine_path(&mut self) {
        if self.has_new_walls && self.steps_until_proven.is_none() {
            self.has_new_walls = false;
            let is_proven = PathBounds::new(&self.known).is_proven();
            self.steps_until_proven = is_proven.then(|| saturate(self.phases.total.steps));
        }
    }

    /// Returns the number of steps after which the known walls proved that the fastest known run of the
    /// planner's vehicle is the fastest of the maze, or `None` if they do not prove it.
    pub fn steps_until_fastest_run_proven(&self, planner: &mut Planner) -> Option<u32> {
        let mut is_proven = |count: usize| {
            let mut map = KnownMaze::unexplored(&self.maze);
            for &(_, cell, heading) in &self.readings[..count] {
                map.set_wall(cell, heading, self.known.wall(cell, heading));
            }
            FastestRun::new(&map, planner).fastest_run_proven
        };
        // Walls that prove it still do when more are known.
        let (mut low, mut high) = (0, self.readings.len());
        if !is_proven(high) {
            return None;
        }
        while low < high {
            let middle = usize::midpoint(low, high);
            if is_proven(middle) { high = middle } else { low = middle + 1 }
        }
        Some(low.checked_sub(1).map_or(0, |last| self.readings[last].0))
    }

    fn exploration_at(&self, steps: u64, turns: u64, last_cell: Cell) -> SearchFigures {
        SearchFigures {
            search_steps: saturate(steps),
            search_turns: saturate(turns),
            path_found: PathBounds::new(&self.known).pessimistic,
            path: self.path.clone(),
            outcome: SearchOutcome {
                known_walls: Some(self.known.walls(Unknown::Closed).clone()),
                last_cell: Some(last_cell),
                touches: self.touches(),
                ..SearchOutcome::default()
            },
            ..SearchFigures::default()
        }
    }

    /// Returns the figures of the search so far. The fields that describe the end of the search have
    /// default values.
    pub fn figures(&mut self) -> SearchFigures {
        for pose in std::mem::take(&mut self.read_ahead) {
            self.note_walls(pose);
        }
        self.examine_path();
        let Phases { total, goal, pose, .. } = self.phases;
        let (start, goals) = (self.maze.start().cell, self.maze.goals());
        let last_cell = pose.map_or(start, |pose| pose.cell);
        let whole = || self.exploration_at(total.steps, total.turns, last_cell);
        let exploration = self.exploration.clone().unwrap_or_else(whole);
        let route = self.route_run.map(|_| self.route.clone()).unwrap_or_default();
        SearchFigures {
            goal_reached: goal.is_some(),
            steps_to_goal: goal.map(|goal| saturate(goal.steps)),
            steps_until_proven: self.steps_until_proven,
            shortest_path: steps_between(self.maze.walls(), start, goals),
            fast_run_steps: self.phases.best_run.map(|run| run.steps),
            visited_cells: self.visited.len(),
            states: self.phases.states,
            crashes: Some(self.crashes),
            is_complete: self.exploration.is_some() && self.phases.first_jump.is_none(),
            outcome: SearchOutcome {
                route,
                driven: self.driven.clone(),
                turns_to_goal: goal.map_or(0, |goal| saturate(goal.turns)),
                touches_to_goal: self.touches_to_goal,
                ..exploration.outcome
            },
            ..exploration
        }
    }
}

#[cfg(feature = "recording")]
impl Judge {
    /// Judges the states of a history, or only those until the goal. A client that has not read any
    /// walls through the simulator knows the walls that it claims correctly. `crashes` holds, for each
    /// movement that a wall blocked, the number of states before it.
    pub fn from_history(
        maze: &Maze,
        history: &mmsim_recording::History,
        crashes: &[usize],
        stops_at_goal: bool,
    ) -> Self {
        let blocks = 0..history.len().div_ceil(mmsim_recording::Block::STATES);
        let blocks = blocks.map_while(|block| history.block(block)?.unpack());
        Self::from_blocks(maze, blocks, crashes, stops_at_goal)
    }

    /// Judges the blocks of a history in order. See [`from_history`](Self::from_history).
    pub fn from_blocks(
        maze: &Maze,
        blocks: impl IntoIterator<Item = mmsim_recording::States>,
        crashes: &[usize],
        stops_at_goal: bool,
    ) -> Self {
        let (mut judge, unexplored) = (Self::new(maze), KnownMaze::unexplored(maze));
        let mut crashes = crashes.iter().peekable();
        let (mut count, mut read_before) = (0, None);
        for states in blocks {
            let Some(mut scan) = states.scan() else { break };
            while let Some(scanned) = scan.advance() {
                while crashes.next_if(|&&before| before <= count).is_some() {
                    judge.crash();
                }
                count += 1;
                judge.add(scanned.pose, scanned.has_restart);
                let state = scanned.state(maze.size());
                if let Some(state) = &state {
                    judge.believe(true, |cell, heading| state.has_wall(cell, heading));
                }
                // Most states show the walls of the state before them.
                let before = scanned.index.checked_sub(1).and_then(|index| states.get(index));
                let is_repeated = |state: &State<'_>| {
                    let before = before.and_then(|it| State::decode(it, maze.size()).ok());
                    before.is_some_and(|it| it.walls() == state.walls())
                };
                match (scanned.context.walls_read(), state) {
                    (Some(read), _) if read_before.as_ref() != Some(read) => {
                        judge.note_known(|wall| read.has(wall.cell, wall.heading));
                        read_before = Some(read.clone());
                    }
                    (None, Some(state)) if scanned.is_context_new || !is_repeated(&state) => {
                        let known = scanned.context.known_maze(&state, &unexplored, Some(maze));
                        judge.note_known(|wall| {
                            known.wall(wall.cell, wall.heading) != WallState::Unknown
                        });
                    }
                    _ => {}
                }
                if stops_at_goal && judge.phases.is_goal_reached() {
                    return judge;
                }
            }
        }
        crashes.for_each(|_| judge.crash());
        judge
    }

    fn note_known(&mut self, is_known: impl Fn(&Wall) -> bool) {
        for Wall { cell, heading, .. } in self.maze.size().inner_walls().filter(is_known) {
            self.read_wall(cell, heading);
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_fastrun::Vehicle;
    use mmsim_solvers::{FastestPathSearch, Mouse, SearchDriver};

    use super::*;
    use crate::times::tests::DETOUR;

    fn pose(x: u8, y: u8, heading: Heading) -> Pose {
        Pose::new(Cell::new(x, y), heading)
    }

    const CORRIDOR: &str = "o---o---o---o\n| S       G |\no---o---o---o\n";

    #[test]
    fn readings_in_a_cell_belong_to_the_pose_there() {
        let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse().unwrap();
        let (start, next) = (pose(0, 0, Heading::East), pose(1, 0, Heading::East));
        for reads_first in [false, true] {
            let mut judge = Judge::new(&maze);
            for pose in [start, next] {
                if reads_first {
                    judge.read_walls(pose);
                }
                judge.add(pose, false);
                judge.read_walls(pose);
            }
            assert_eq!(judge.figures().steps_until_proven, Some(1), "{reads_first}");
        }
    }

    /// Slalom turns count only on the first complete fast run, not on the search run or a later run.
    #[test]
    fn only_the_first_complete_fast_run_counts_as_driven() {
        let maze = "o---o---o---o\n|     G   G |\no   o---o---o\n| S |       |\no---o---o---o\n";
        let maze: Maze = maze.parse().unwrap();
        let there =
            [pose(0, 0, Heading::North), pose(0, 1, Heading::East), pose(1, 1, Heading::East)];
        let back =
            [pose(1, 1, Heading::West), pose(0, 1, Heading::South), pose(0, 0, Heading::South)];
        let deep = FastRun::parse(Cell::new(0, 0), "N 1 s90R 3").unwrap();
        for is_first in [true, false] {
            let mut judge = Judge::new(&maze);
            let add = |judge: &mut Judge, poses: &[Pose]| {
                for &pose in poses {
                    judge.add(pose, false);
                }
            };
            add(&mut judge, &there);
            judge.drive(&deep);
            add(&mut judge, &[&back[..], &there].concat());
            assert_eq!(judge.figures().outcome.driven, None, "not yet driven");
            if !is_first {
                add(&mut judge, &[&back[..], &there].concat());
            }
            judge.drive(&deep);
            assert_eq!(judge.figures().outcome.driven.is_some(), is_first);
        }
    }

    #[test]
    fn a_goal_after_a_jump_does_not_count() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        let mut moved = Judge::new(&maze);
        let poses =
            [pose(0, 0, Heading::North), pose(1, 0, Heading::East), pose(2, 0, Heading::East)];
        for pose in poses {
            moved.add(pose, false);
        }
        assert_eq!((moved.phases().first_jump, moved.figures().steps_to_goal), (None, Some(2)));
        let maze: Maze = "o---o---o---o\n| S |     G |\no---o---o---o\n".parse().unwrap();
        let mut jumped = Judge::new(&maze);
        for pose in poses {
            jumped.add(pose, false);
        }
        assert_eq!(jumped.phases().first_jump, Some([Cell::new(0, 0), Cell::new(1, 0)]));
        assert!(!jumped.figures().goal_reached);
        let mut elsewhere = Judge::new(&maze);
        elsewhere.add(poses[2], false);
        assert_eq!(
            (elsewhere.phases().first_jump.is_some(), elsewhere.figures().goal_reached),
            (true, false)
        );
    }

    #[test]
    fn a_restart_is_not_a_step() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        let mut judge = Judge::new(&maze);
        for (x, heading, is_restart) in [
            (0, Heading::North, false),
            (1, Heading::East, false),
            (0, Heading::North, true),
            (1, Heading::East, false),
            (2, Heading::East, false),
        ] {
            judge.add(pose(x, 0, heading), is_restart);
        }
        let figures = judge.figures();
        assert_eq!((figures.steps_to_goal, figures.search_turns, figures.states), (Some(3), 2, 5));
        let SearchOutcome { touches, touches_to_goal, last_cell, .. } = figures.outcome;
        assert_eq!((touches, touches_to_goal, last_cell), (1, 1, Some(Cell::new(2, 0))));
        assert_eq!(figures.path_found, Some(2), "the mouse has passed both sides");
    }

    #[test]
    fn the_route_is_that_of_the_first_complete_fast_run() {
        let maze = "o---o---o---o\n|           |\no   o---o   o\n| S       G |\no---o---o---o\n";
        let maze: Maze = maze.parse().unwrap();
        let (north, east, west) = (Heading::North, Heading::East, Heading::West);
        let around = [(0, 0, north), (0, 1, north), (2, 1, east), (2, 0, Heading::South)];
        let back = [(1, 0, west), (0, 0, west)];
        let mut judge = Judge::new(&maze);
        let mut drive = |poses: &[(u8, u8, Heading)], is_restart: bool| {
            for &(x, y, heading) in poses {
                judge.add(pose(x, y, heading), is_restart);
            }
            let cells = judge.figures().outcome.route;
            cells.iter().map(|cell| (cell.x, cell.y)).collect::<Vec<_>>()
        };
        assert_eq!(drive(&around, false), []);
        assert_eq!(drive(&back, false), []);
        // The first fast run ends early.
        assert_eq!(drive(&[(1, 0, east)], false), []);
        assert_eq!(drive(&[(0, 0, north)], true), []);
        // The mouse reports only some of the cells of a straight.
        let expected = [(0, 0), (0, 1), (1, 1), (2, 1), (2, 0)];
        assert_eq!(drive(&around[1..], false), expected);
        drive(&back, false);
        assert_eq!(drive(&[(1, 0, east), (2, 0, east)], false), expected, "the first one");
        let outcome = judge.figures().outcome;
        assert_eq!((outcome.last_cell, outcome.touches), (Some(Cell::new(0, 0)), 0));
    }

    /// The judge looks for the proof by bisection. A check in each state finds the same step.
    #[test]
    fn the_proof_is_found_in_the_first_state_that_has_it() {
        let maze: Maze = DETOUR.parse().unwrap();
        let (mut planner, mut judge) = (Planner::new(Vehicle::expert()), Judge::new(&maze));
        let map = KnownMaze::unexplored(&maze);
        let mut mouse = Mouse::new(FastestPathSearch::default(), map, maze.start());
        let mut driver = SearchDriver::new(&mut mouse, 1000);
        let (mut first, mut states) = (None, 0);
        while driver.advance_in(&maze) == Ok(true) {
            states += 1;
            let pose = driver.mouse().pose();
            judge.add(pose, false);
            judge.read_walls(pose);
            if FastestRun::new(judge.known(), &mut planner).fastest_run_proven {
                first.get_or_insert(driver.stats().steps());
            }
            assert_eq!(judge.steps_until_fastest_run_proven(&mut planner), first, "state {states}");
        }
        assert!(
            first.is_some_and(|steps| 0 < steps && steps < states - 1),
            "{first:?} of {states}"
        );
    }
}
