//! The course of a search by a mouse in another process: its poses and the walls that it knows.

use mmsim_maze::{Cell, Heading, KnownMaze, Maze, Pose, Unknown, WallState, Walls};
use mmsim_recording::{Course, Phases, RunPhase, Transition};
use mmsim_solvers::{PathBounds, steps_between};

use super::figures::{Figures, SearchOutcome};

/// The maximum number of readings that wait for the next pose. Mice need up to two.
const MAX_READ_AHEAD: usize = 16;

/// What a mouse has done and seen in a maze. The figures do not depend on what the mouse reports
/// about walls, only on the walls that it has read or run into.
pub(crate) struct Track {
    maze: Maze,
    course: Course,
    /// The walls that the mouse has read or run into.
    known: KnownMaze,
    /// True if walls have become known since the shortest path was last examined.
    has_new_walls: bool,
    path: Vec<Cell>,
    pose: Option<Pose>,
    /// The number of movements that a wall blocked.
    pub(crate) crashes: u32,
    /// The poses of readings that belong to the next pose.
    read_ahead: Vec<Pose>,
    states: u32,
    phases: Phases,
    steps_to_goal: Option<u32>,
    steps_until_proven: Option<u32>,
    turns_to_goal: u32,
    touches_to_goal: u32,
    /// The figures at the beginning of the first fast run.
    exploration: Option<Exploration>,
    /// The cells of the current or latest fast run, until one is complete.
    route: Vec<Cell>,
    is_route_complete: bool,
    /// The cells of the first jump.
    jump: Option<[Cell; 2]>,
}

/// The figures of the search run and the return run.
#[derive(Clone)]
struct Exploration {
    steps: u32,
    turns: u32,
    path_found: Option<u16>,
    /// The number of entered cells.
    cells: usize,
    known_walls: Walls,
    last_cell: Cell,
    touches: u32,
}

impl Track {
    pub(crate) fn new(maze: &Maze) -> Self {
        Self {
            course: Course::from_maze(maze),
            known: KnownMaze::unexplored(maze),
            maze: maze.clone(),
            has_new_walls: true,
            path: Vec::new(),
            pose: None,
            crashes: 0,
            read_ahead: Vec::new(),
            states: 0,
            phases: Phases::default(),
            steps_to_goal: None,
            steps_until_proven: None,
            turns_to_goal: 0,
            touches_to_goal: 0,
            exploration: None,
            route: Vec::new(),
            is_route_complete: false,
            jump: None,
        }
    }

    /// Returns the number of reported poses.
    pub(crate) const fn states(&self) -> u32 {
        self.states
    }

    pub(crate) const fn is_goal_reached(&self) -> bool {
        self.steps_to_goal.is_some()
    }

    /// Returns the cells before and after the first jump: a change of the pose that no movement
    /// explains, for example through a wall. A goal that is reached after a jump does not count.
    pub(crate) const fn jump(&self) -> Option<[Cell; 2]> {
        self.jump
    }

    /// Returns true if there is a wall on this side of the cell. The mouse now knows this wall.
    pub(crate) fn read_wall(&mut self, cell: Cell, heading: Heading) -> bool {
        let is_present = self.maze.walls().has(cell, heading);
        if self.known.wall(cell, heading) == WallState::Unknown {
            let state = if is_present { WallState::Present } else { WallState::Absent };
            self.known.set_wall(cell, heading, state);
            self.has_new_walls = true;
        }
        is_present
    }

    /// Notes that the mouse has read the walls to its left, ahead and to its right. A mouse that reads
    /// the walls around another cell than its own has moved, but not reported its pose yet.
    pub(crate) fn read_walls(&mut self, pose: Pose) {
        let is_ahead = self.pose.is_none_or(|current| current.cell != pose.cell);
        if is_ahead && self.read_ahead.len() < MAX_READ_AHEAD {
            self.read_ahead.push(pose);
        } else {
            self.note_walls(pose);
        }
    }

    fn note_walls(&mut self, pose: Pose) {
        for heading in [pose.heading.left(), pose.heading, pose.heading.right()] {
            self.read_wall(pose.cell, heading);
        }
    }

    /// Adds the pose of a mouse that has moved or turned, or that was put back at the start.
    pub(crate) fn add(&mut self, pose: Pose, is_restart: bool) {
        self.move_to(pose, is_restart);
        for pose in std::mem::take(&mut self.read_ahead) {
            self.note_walls(pose);
        }
    }

    fn move_to(&mut self, pose: Pose, is_restart: bool) {
        self.examine_path();
        let start = self.maze.start().cell;
        let Some(before) = self.pose.replace(pose) else {
            if pose.cell != start {
                self.jump = Some([start, pose.cell]);
            }
            self.states = 1;
            self.path.push(pose.cell);
            self.phases.arrive(&self.course, pose);
            return self.note_goal();
        };
        let transition = match self.course.transition(before, pose) {
            _ if is_restart && pose.cell == start => Transition::Restart,
            _ if is_restart => Transition::Jump,
            transition => transition,
        };
        let state = self.states;
        self.states = state.saturating_add(1);
        let (fast_runs, total) = (self.phases.fast_runs, self.phases.total);
        self.phases.add(&self.course, state as usize, transition, pose);
        match transition {
            Transition::Move { steps: 1, .. } => self.pass(before.cell, pose.cell),
            Transition::Jump => _ = self.jump.get_or_insert([before.cell, pose.cell]),
            Transition::Move { .. } | Transition::Restart => {}
        }
        if fast_runs == 0 && self.phases.fast_runs == 1 {
            // The turns in the start cell belong to the fast run.
            let before_leaving = self.phases.total.turns - u64::from(self.phases.fast_run.turns);
            self.exploration = Some(self.exploration_at(total.steps, before_leaving, before.cell));
        }
        self.note_route(before.cell, pose.cell, fast_runs);
        if before.cell != pose.cell {
            self.path.push(pose.cell);
        }
        self.note_goal();
    }

    /// Notes that the mouse has moved between neighbouring cells, so there is no wall between them.
    fn pass(&mut self, from: Cell, to: Cell) {
        if let Some(heading) =
            Heading::ALL.into_iter().find(|&side| from.neighbour(side) == Some(to))
        {
            self.read_wall(from, heading);
        }
    }

    fn note_goal(&mut self) {
        let is_reached = self.phases.phase != RunPhase::Search && self.jump.is_none();
        if is_reached && self.steps_to_goal.is_none() {
            self.steps_to_goal = Some(saturate(self.phases.total.steps));
            self.turns_to_goal = saturate(self.phases.total.turns);
            self.touches_to_goal = self.touches();
        }
    }

    /// Notes the cells of the fast run. `fast_runs` is the number of fast runs before this movement.
    fn note_route(&mut self, from: Cell, to: Cell, fast_runs: u32) {
        if self.is_route_complete {
            return;
        }
        let Phases { phase, fast_runs: now, .. } = self.phases;
        let has_begun = now > fast_runs;
        if has_begun {
            self.route = vec![from];
        }
        let is_complete = phase == RunPhase::AtGoal && !self.route.is_empty();
        if has_begun || phase == RunPhase::Fast || is_complete {
            self.route.extend(cells_between(self.maze.walls(), from, to));
            self.is_route_complete = is_complete;
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

    fn exploration_at(&self, steps: u64, turns: u64, last_cell: Cell) -> Exploration {
        Exploration {
            steps: saturate(steps),
            turns: saturate(turns),
            path_found: PathBounds::new(&self.known).pessimistic,
            cells: self.path.len(),
            known_walls: self.known.walls(Unknown::Closed).clone(),
            last_cell,
            touches: self.touches(),
        }
    }

    /// Returns the figures of the search so far. The fields that describe the end of the search have
    /// default values.
    pub(crate) fn figures(&mut self) -> Figures {
        for pose in std::mem::take(&mut self.read_ahead) {
            self.note_walls(pose);
        }
        self.examine_path();
        let total = self.phases.total;
        let (start, goals) = (self.maze.start().cell, self.maze.goals());
        let last_cell = self.pose.map_or(start, |pose| pose.cell);
        let whole = || self.exploration_at(total.steps, total.turns, last_cell);
        let Exploration { steps, turns, path_found, cells, known_walls, last_cell, touches } =
            self.exploration.clone().unwrap_or_else(whole);
        let route = if self.is_route_complete { self.route.clone() } else { Vec::new() };
        Figures {
            goal_reached: self.is_goal_reached(),
            steps_to_goal: self.steps_to_goal,
            steps_until_proven: self.steps_until_proven,
            steps_in_all: steps,
            turns,
            path_found,
            shortest_path: steps_between(self.maze.walls(), start, goals),
            fast_run_steps: self.phases.best_run.map(|run| run.steps),
            is_complete: self.exploration.is_some(),
            path: self.path[..cells.min(self.path.len())].to_vec(),
            outcome: SearchOutcome {
                known_walls: Some(known_walls),
                last_cell: Some(last_cell),
                route,
                turns_to_goal: self.turns_to_goal,
                touches,
                touches_to_goal: self.touches_to_goal,
            },
            ..Figures::default()
        }
    }
}

/// Returns the cells that a mouse enters when it drives from one cell to another, in a straight line
/// or to a diagonal neighbour.
fn cells_between(walls: &Walls, from: Cell, to: Cell) -> Vec<Cell> {
    let distance = |cell: Cell| u16::from(cell.x.abs_diff(to.x)) + u16::from(cell.y.abs_diff(to.y));
    let nearer =
        |at: Cell| walls.open_neighbours(at).filter(move |&next| distance(next) < distance(at));
    let (mut cells, mut at) = (Vec::new(), from);
    while at != to {
        // Beside a wall, a mouse can get to a diagonal neighbour only past the other cell.
        let mut open = nearer(at).filter(|&next| next == to || nearer(next).next().is_some());
        let Some(next) = open.next() else { break };
        cells.push(next);
        at = next;
    }
    cells
}

fn saturate(count: u64) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use mmsim_solvers::{BundledStrategy, Mouse, SearchDriver};

    use super::*;
    use crate::compare::search::search;

    fn pose(x: u8, y: u8, heading: Heading) -> Pose {
        Pose::new(Cell::new(x, y), heading)
    }

    const CORRIDOR: &str = "o---o---o---o\n| S       G |\no---o---o---o\n";

    /// Runs a strategy and adds its readings and poses to a track.
    fn track(maze: &Maze, strategy: BundledStrategy) -> Track {
        let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, strategy.max_states());
        let mut track = Track::new(maze);
        loop {
            let mut read = Vec::new();
            let advanced = driver.advance(|pose| {
                read.push(pose);
                Ok::<_, ()>(maze.walls().around(pose))
            });
            if advanced != Ok(true) {
                return track;
            }
            track.add(driver.mouse().pose(), false);
            for pose in read {
                track.read_walls(pose);
            }
        }
    }

    #[test]
    fn the_figures_of_a_track_equal_those_of_the_search_loop() {
        for entry in mmsim_formats::Catalogue::bundled().entries() {
            let maze = entry.maze().unwrap();
            for &strategy in BundledStrategy::ALL {
                let figures = track(&maze, strategy).figures();
                let expected = search(&maze, || strategy.strategy(), strategy.max_states());
                let name = format!("{strategy} in {}", entry.name());
                assert_eq!(figures.goal_reached, expected.goal_reached, "{name}");
                assert_eq!(figures.steps_to_goal, expected.steps_to_goal, "{name}");
                assert_eq!(figures.shortest_path, expected.shortest_path, "{name}");
                assert_eq!(figures.steps_until_proven, expected.steps_until_proven, "{name}");
                assert_eq!(figures.steps_in_all, expected.steps_in_all, "{name}");
                assert_eq!(figures.turns, expected.turns, "{name}");
                assert_eq!(figures.path_found, expected.path_found, "{name}");
                assert_eq!(figures.fast_run_steps, expected.fast_run_steps, "{name}");
                assert_eq!(figures.path, expected.path, "{name}");
                assert_eq!(figures.outcome, expected.outcome, "{name}");
            }
        }
    }

    #[test]
    fn readings_in_a_cell_belong_to_the_pose_there() {
        let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse().unwrap();
        let (start, next) = (pose(0, 0, Heading::East), pose(1, 0, Heading::East));
        for reads_first in [false, true] {
            let mut track = Track::new(&maze);
            for pose in [start, next] {
                if reads_first {
                    track.read_walls(pose);
                }
                track.add(pose, false);
                track.read_walls(pose);
            }
            assert_eq!(track.figures().steps_until_proven, Some(1), "{reads_first}");
        }
    }

    #[test]
    fn a_goal_after_a_jump_does_not_count() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        let mut moved = Track::new(&maze);
        let poses =
            [pose(0, 0, Heading::North), pose(1, 0, Heading::East), pose(2, 0, Heading::East)];
        for pose in poses {
            moved.add(pose, false);
        }
        assert_eq!((moved.jump(), moved.figures().steps_to_goal), (None, Some(2)));
        let maze: Maze = "o---o---o---o\n| S |     G |\no---o---o---o\n".parse().unwrap();
        let mut jumped = Track::new(&maze);
        for pose in poses {
            jumped.add(pose, false);
        }
        assert_eq!(jumped.jump(), Some([Cell::new(0, 0), Cell::new(1, 0)]));
        assert!(!jumped.figures().goal_reached);
        let mut elsewhere = Track::new(&maze);
        elsewhere.add(poses[2], false);
        assert_eq!((elsewhere.jump().is_some(), elsewhere.figures().goal_reached), (true, false));
    }

    #[test]
    fn a_restart_is_not_a_step() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        let mut track = Track::new(&maze);
        for (x, heading, is_restart) in [
            (0, Heading::North, false),
            (1, Heading::East, false),
            (0, Heading::North, true),
            (1, Heading::East, false),
            (2, Heading::East, false),
        ] {
            track.add(pose(x, 0, heading), is_restart);
        }
        let figures = track.figures();
        assert_eq!((figures.steps_to_goal, figures.turns, track.states()), (Some(3), 2, 5));
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
        let mut track = Track::new(&maze);
        let mut drive = |poses: &[(u8, u8, Heading)], is_restart: bool| {
            for &(x, y, heading) in poses {
                track.add(pose(x, y, heading), is_restart);
            }
            let cells = track.figures().outcome.route;
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
        let outcome = track.figures().outcome;
        assert_eq!((outcome.last_cell, outcome.touches), (Some(Cell::new(0, 0)), 0));
    }

    #[test]
    fn the_cells_between_two_poses_are_connected() {
        let maze = "o---o---o\n|       |\no   o---o\n| S | G |\no---o---o\n";
        let maze: Maze = maze.parse().unwrap();
        let cell = |(x, y)| Cell::new(x, y);
        let between = |from, to| cells_between(maze.walls(), cell(from), cell(to));
        assert_eq!(between((0, 0), (1, 1)), [cell((0, 1)), cell((1, 1))]);
        assert_eq!(between((1, 1), (0, 0)), [cell((0, 1)), cell((0, 0))]);
        assert_eq!(between((0, 0), (0, 0)), []);
        assert_eq!(between((0, 0), (1, 0)), [], "there is a wall");
    }
}
