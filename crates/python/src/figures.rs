//! The figures of a search, with the keys of `mmsim compare --json`.

use std::sync::atomic::{AtomicBool, Ordering};

use mmsim_maze::{KnownMaze, Maze, Pose};
use mmsim_protocol::State;
use mmsim_recording::{Block, History, Phases, RunPhase};
use mmsim_solvers::{
    BundledStrategy, DriveError, Mouse, Move, PathBounds, Phase, SearchDriver, steps_between,
    steps_until_proven,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The figures of a search, without the fast run unless stated otherwise.
pub(crate) struct Figures {
    goal_reached: bool,
    steps_to_goal: Option<u32>,
    steps_until_proven: Option<u32>,
    steps_in_all: u32,
    turns: u32,
    path_found: Option<u16>,
    shortest_path: Option<u16>,
    fast_run_steps: Option<u32>,
    visited_cells: usize,
    states: usize,
    pub(crate) ending: &'static str,
    pub(crate) error: Option<String>,
}

impl Figures {
    /// Adds the figures to a row of a table.
    pub(crate) fn put(&self, row: &Bound<'_, PyDict>) -> PyResult<()> {
        row.set_item("goal_reached", self.goal_reached)?;
        row.set_item("steps_to_goal", self.steps_to_goal)?;
        row.set_item("steps_until_proven", self.steps_until_proven)?;
        row.set_item("steps_in_all", self.steps_in_all)?;
        row.set_item("turns", self.turns)?;
        row.set_item("path_found", self.path_found)?;
        row.set_item("shortest_path", self.shortest_path)?;
        row.set_item("fast_run_steps", self.fast_run_steps)?;
        row.set_item("visited_cells", self.visited_cells)?;
        row.set_item("states", self.states)?;
        row.set_item("ending", self.ending)?;
        row.set_item("error", self.error.as_deref())
    }

    /// Searches a maze with a bundled strategy. Returns `None` if the search was cancelled.
    pub(crate) fn search(
        maze: &Maze,
        strategy: BundledStrategy,
        max_states: u32,
        is_cancelled: &AtomicBool,
    ) -> Option<Self> {
        let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, max_states);
        let (mut poses, mut states, mut advanced) = (Vec::new(), 0, Ok(true));
        // The map at the end of the search run and the return run.
        let mut path_found = None;
        while advanced == Ok(true) {
            if is_cancelled.load(Ordering::Relaxed) {
                return None;
            }
            if driver.phase() == Phase::FastRun && path_found.is_none() {
                path_found = Some(PathBounds::new(driver.mouse().map()).pessimistic);
            }
            let is_exploring = driver.phase() != Phase::FastRun;
            advanced = driver.advance_in(maze);
            if advanced == Ok(true) {
                states += 1;
                poses.extend(is_exploring.then(|| driver.mouse().pose()));
            }
        }
        let path_found =
            path_found.unwrap_or_else(|| PathBounds::new(driver.mouse().map()).pessimistic);
        let (counted, error) = (driver.stats(), advanced.err());
        let is_in_goal = maze.goals().contains(driver.mouse().pose().cell);
        let ending = match &error {
            Some(DriveError::Search(_)) => "gave_up",
            Some(_) => "failed",
            None if driver.decision() == Some(Ok(Move::Stop)) && is_in_goal => "finished",
            None if driver.decision() == Some(Ok(Move::Stop)) => "gave_up",
            None => "step_limit",
        };
        let has_fast_run = driver.phase() == Phase::FastRun && is_in_goal;
        Some(Self {
            goal_reached: counted.goal_reached(),
            steps_to_goal: counted.steps_to_goal,
            steps_until_proven: steps_until_proven(maze, &poses),
            steps_in_all: counted.exploration().steps,
            turns: counted.exploration().turns,
            path_found,
            shortest_path: steps_between(maze.walls(), maze.start().cell, maze.goals()),
            fast_run_steps: has_fast_run.then_some(counted.fast_run.steps),
            visited_cells: driver.mouse().map().visited().len(),
            states,
            ending,
            error: error.as_ref().map(ToString::to_string),
        })
    }

    /// Computes the figures from the states that a mouse has reported. A fast run begins when the
    /// mouse leaves the start cell after it has reached the goal.
    pub(crate) fn from_history(maze: &Maze, history: &History) -> Self {
        let unexplored = KnownMaze::unexplored(maze);
        let mut poses: Vec<Pose> = Vec::new();
        let (mut last, mut steps_to_goal) = (Phases::default(), None);
        let (mut exploration, mut known) = (None, unexplored.clone());
        for block in 0..history.len().div_ceil(Block::STATES) {
            let Some(states) = history.block(block).and_then(Block::unpack) else { break };
            let Some(mut scan) = states.scan() else { break };
            while let Some(scanned) = scan.advance() {
                let Ok(state) = State::decode(scanned.message, maze.size()) else { continue };
                let phases = *scanned.phases;
                if phases.fast_runs == 1 && exploration.is_none() {
                    // The turns in the start cell belong to the fast run.
                    let turns = phases.total.turns - u64::from(phases.fast_run.turns);
                    exploration = Some((last.total.steps, turns, poses.len(), known.clone()));
                }
                if phases.phase != RunPhase::Search && phases.jumps == 0 {
                    steps_to_goal.get_or_insert(phases.total.steps);
                }
                known = scanned.context.known_maze(&state, &unexplored, Some(maze));
                poses.push(state.pose());
                last = phases;
            }
        }
        let states = poses.len();
        let visited_cells = known.visited().len();
        let (steps, turns, explored, known) =
            exploration.unwrap_or((last.total.steps, last.total.turns, states, known));
        poses.truncate(explored);
        let saturate = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
        let goal_reached = steps_to_goal.is_some();
        Self {
            goal_reached,
            steps_to_goal: steps_to_goal.map(saturate),
            steps_until_proven: proven(maze, &poses),
            steps_in_all: saturate(steps),
            turns: saturate(turns),
            path_found: PathBounds::new(&known).pessimistic,
            shortest_path: steps_between(maze.walls(), maze.start().cell, maze.goals()),
            fast_run_steps: last.best_run.map(|run| run.steps),
            visited_cells,
            states,
            ending: if goal_reached { "finished" } else { "gave_up" },
            error: None,
        }
    }
}

/// Returns the number of steps after which the shortest path was proven. A turn on the spot is a
/// state of its own, but no step.
fn proven(maze: &Maze, poses: &[Pose]) -> Option<u32> {
    let number = steps_until_proven(maze, poses)? as usize;
    let moved = poses.windows(2).take(number).filter(|pair| pair[0].cell != pair[1].cell).count();
    u32::try_from(moved).ok()
}
