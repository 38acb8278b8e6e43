//! The search of one mouse as a reinforcement-learning environment, and batches of these environments,
//! which the Gymnasium environments of the package wrap.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};

use mmsim_generator::{Style, generate};
use mmsim_maze::{Cell, Heading, KnownMaze, Maze, MazeSize, Pose, Sides, Unknown, WyRand};
use mmsim_protocol::{CellWalls, Order};
use mmsim_solvers::PathBounds;
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use crate::convert::{self, named};
use crate::error::{Error, value_error};
use crate::grid::{columns, from_columns};
use crate::known::PyKnownMaze;
use crate::maze::PyMaze;
use crate::signals;

/// The maximum number of environments in a batch. Each one takes a few kilobytes.
const MAX_ENVS: usize = 65_536;

/// The walls, openings and goals of one environment, of the shape (width, height), and its pose.
type Observation<'py> = (
    Bound<'py, PyArray2<u8>>,
    Bound<'py, PyArray2<u8>>,
    Bound<'py, PyArray2<u8>>,
    Bound<'py, PyArray1<i64>>,
);

/// The same arrays for all environments, with one more axis in front.
type Observations<'py> = (
    Bound<'py, PyArray3<u8>>,
    Bound<'py, PyArray3<u8>>,
    Bound<'py, PyArray3<u8>>,
    Bound<'py, PyArray2<i64>>,
);

/// The rewards, and whether each episode was terminated or truncated.
type Results<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<bool>>, Bound<'py, PyArray1<bool>>);

/// Several search environments that take their steps together; see `micromouse_sim.gym`.
#[pyclass(frozen, module = "micromouse_sim")]
pub(crate) struct SearchBatch {
    pool: MazePool,
    size: MazeSize,
    rules: EpisodeRules,
    envs: Mutex<Vec<SearchEnv>>,
}

#[pymethods]
impl SearchBatch {
    // Without `mazes`, each episode generates a maze. Without `max_steps`, an episode is truncated
    // after four actions for each cell.
    #[new]
    fn new(
        py: Python<'_>,
        mazes: Option<Vec<PyRef<'_, PyMaze>>>,
        size: &Bound<'_, PyAny>,
        style: &str,
        until_proven: bool,
        max_steps: Option<&Bound<'_, PyAny>>,
        count: usize,
    ) -> PyResult<Self> {
        // The crate `numpy` panics if NumPy is missing.
        py.import("numpy")?;
        let (pool, size) = if let Some(mazes) = mazes {
            listed(mazes.iter().map(|maze| maze.maze.clone()).collect())?
        } else {
            let size = convert::size(size)?;
            (MazePool::Generated(size, named(Style::ALL, Style::name, style)?), size)
        };
        let default = || 4 * u32::from(size.width()) * u32::from(size.height());
        let max_steps = convert::limit(max_steps)?.unwrap_or_else(default);
        if max_steps == 0 {
            return Err(value_error("expected at least one step in max_steps, found 0"));
        }
        let rules = EpisodeRules { until_proven, max_steps };
        if count > MAX_ENVS {
            let reason = "environments in one batch";
            return Err(value_error(format_args!(
                "expected at most {MAX_ENVS} {reason}, found {count}"
            )));
        }
        let mut envs = Vec::new();
        for seed in 0..count as u64 {
            signals::check()?;
            envs.push(SearchEnv::new(&pool, seed));
        }
        Ok(Self { pool, size, rules, envs: Mutex::new(envs) })
    }

    /// Width and height in cells.
    #[getter]
    fn size(&self) -> (u8, u8) {
        (self.size.width(), self.size.height())
    }

    /// Begins a new episode. A seed also determines the mazes of later episodes.
    fn reset(&self, py: Python<'_>, index: usize, seed: Option<u64>) -> PyResult<()> {
        self.with(py, index, |env| match seed {
            Some(seed) => *env = SearchEnv::new(&self.pool, seed),
            None => env.reset(&self.pool),
        })
    }

    /// Takes one action in the first environment.
    fn step_one(&self, py: Python<'_>, action: i64) -> PyResult<(f64, bool, bool)> {
        let quarters = quarters(action)?;
        let Outcome { reward, is_terminated, is_truncated } =
            self.with(py, 0, |env| env.act(quarters, self.rules))?;
        Ok((reward, is_terminated, is_truncated))
    }

    /// Takes one action in each environment, or begins a new episode where one is over.
    #[expect(clippy::needless_pass_by_value, reason = "PyO3 extracts a value")]
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: PyReadonlyArray1<'py, i64>,
    ) -> PyResult<Results<'py>> {
        let actions = actions.as_array();
        let mut envs = self.lock(py)?;
        if actions.len() != envs.len() {
            let found = actions.len();
            return Err(value_error(format_args!(
                "expected {} actions, found {found}",
                envs.len()
            )));
        }
        let quarters: Vec<u8> =
            actions.iter().map(|&action| quarters(action)).collect::<PyResult<_>>()?;
        let all = &mut *envs;
        let outcomes: Vec<Outcome> = py.detach(|| {
            let step = |(env, quarters): (&mut SearchEnv, u8)| {
                if env.is_over {
                    env.reset(&self.pool);
                    Outcome::default()
                } else {
                    env.act(quarters, self.rules)
                }
            };
            all.iter_mut().zip(quarters).map(step).collect()
        });
        drop(envs);
        let array = |flag: fn(&Outcome) -> bool| {
            outcomes.iter().map(flag).collect::<Array1<_>>().into_pyarray(py)
        };
        let rewards: Array1<f64> = outcomes.iter().map(|outcome| outcome.reward).collect();
        Ok((
            rewards.into_pyarray(py),
            array(|outcome| outcome.is_terminated),
            array(|outcome| outcome.is_truncated),
        ))
    }

    /// Returns walls, openings, goals and the pose of one environment.
    fn observation<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Observation<'py>> {
        let ([walls, openings, goals], pose) =
            self.with(py, index, |env| (env.flags().map(<[u8]>::to_vec), env.pose()))?;
        let array = |flags| from_columns(py, self.size, flags);
        let pose = PyArray1::from_slice(py, &pose);
        Ok((array(walls)?, array(openings)?, array(goals)?, pose))
    }

    /// Returns walls, openings, goals and poses of all environments.
    fn observations<'py>(&self, py: Python<'py>) -> PyResult<Observations<'py>> {
        let envs = self.lock(py)?;
        let count = envs.len();
        let mut all = [const { Vec::new() }; 3];
        for (index, all) in all.iter_mut().enumerate() {
            all.reserve_exact(count * self.size.area());
            for env in &*envs {
                all.extend_from_slice(env.flags()[index]);
            }
        }
        let poses = envs.iter().flat_map(SearchEnv::pose).collect();
        drop(envs);
        let shape = (count, self.size.width().into(), self.size.height().into());
        let array = |all| {
            let array = Array3::from_shape_vec(shape, all).map_err(value_error)?;
            PyResult::Ok(array.into_pyarray(py))
        };
        let poses = Array2::from_shape_vec((count, 3), poses).map_err(value_error)?;
        let [walls, openings, goals] = all;
        Ok((array(walls)?, array(openings)?, array(goals)?, poses.into_pyarray(py)))
    }

    /// Returns the action mask of one environment, and whether its mouse was in the goal.
    fn info<'py>(
        &self,
        py: Python<'py>,
        index: usize,
    ) -> PyResult<(Bound<'py, PyArray1<i8>>, bool)> {
        let (mask, goal) = self.with(py, index, |env| (env.action_mask(), env.is_goal_reached))?;
        Ok((PyArray1::from_slice(py, &mask), goal))
    }

    /// Returns the action masks of all environments, and whether each mouse was in the goal.
    #[expect(clippy::type_complexity, reason = "two arrays")]
    fn infos<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyArray2<i8>>, Bound<'py, PyArray1<bool>>)> {
        let envs = self.lock(py)?;
        let masks: Vec<i8> = envs.iter().flat_map(SearchEnv::action_mask).collect();
        let goals: Array1<bool> = envs.iter().map(|env| env.is_goal_reached).collect();
        drop(envs);
        let masks = Array2::from_shape_vec((goals.len(), 4), masks).map_err(value_error)?;
        Ok((masks.into_pyarray(py), goals.into_pyarray(py)))
    }

    /// Returns the true maze of an environment.
    fn maze(&self, py: Python<'_>, index: usize) -> PyResult<PyMaze> {
        let maze = self.with(py, index, |env| env.maze.clone())?;
        Ok(PyMaze { path: PathBuf::new(), name: "episode".into(), maze })
    }

    /// Returns a copy of the map that the mouse of an environment has made.
    fn known(&self, py: Python<'_>, index: usize) -> PyResult<PyKnownMaze> {
        Ok(self.with(py, index, |env| env.known.clone())?.into())
    }
}

impl SearchBatch {
    fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Vec<SearchEnv>>> {
        self.envs.lock_py_attached(py).map_err(|_| {
            Error::new_err("an earlier operation on the batch has failed unexpectedly")
        })
    }

    /// Calls a function, which must not run Python code, with an environment.
    fn with<R>(
        &self,
        py: Python<'_>,
        index: usize,
        call: impl FnOnce(&mut SearchEnv) -> R,
    ) -> PyResult<R> {
        let mut envs = self.lock(py)?;
        let count = envs.len();
        envs.get_mut(index).map(call).ok_or_else(|| no_env(index, count))
    }
}

/// Creates the pool of these mazes, which must have the same size.
fn listed(mazes: Vec<Maze>) -> PyResult<(MazePool, MazeSize)> {
    let size = mazes.first().ok_or_else(|| value_error("expected at least one maze"))?.size();
    match mazes.iter().map(Maze::size).find(|&other| other != size) {
        Some(other) => Err(value_error(format_args!(
            "expected mazes of the same size, found {size} and {other} cells"
        ))),
        None => Ok((MazePool::Listed(mazes), size)),
    }
}

/// Converts an action to quarter turns to the right.
fn quarters(action: i64) -> PyResult<u8> {
    u8::try_from(action)
        .ok()
        .filter(|&quarters| quarters < 4)
        .ok_or_else(|| value_error(format_args!("expected an action from 0 to 3, found {action}")))
}

fn no_env(index: usize, count: usize) -> PyErr {
    PyIndexError::new_err(format!("environment {index} out of range (0 to {})", count.max(1) - 1))
}

/// The mazes that episodes are drawn from.
enum MazePool {
    /// Each episode takes a random maze of this list, which is not empty.
    Listed(Vec<Maze>),
    /// Each episode generates a new maze.
    Generated(MazeSize, Style),
}

impl MazePool {
    fn draw(&self, rng: &mut WyRand) -> Maze {
        match self {
            Self::Listed(mazes) => mazes[rng.index(mazes.len())].clone(),
            Self::Generated(size, style) => generate(*size, rng.next_u64(), *style),
        }
    }
}

/// When an episode ends.
#[derive(Clone, Copy)]
struct EpisodeRules {
    /// True if an episode ends when the shortest path is proven, false if it ends at the goal.
    until_proven: bool,
    /// The number of actions after which an episode is truncated.
    max_steps: u32,
}

/// The result of one action.
#[derive(Clone, Copy, Default)]
struct Outcome {
    reward: f64,
    is_terminated: bool,
    is_truncated: bool,
}

/// One episode after another, each in a maze of the pool.
struct SearchEnv {
    rng: WyRand,
    maze: Maze,
    known: KnownMaze,
    pose: Pose,
    /// The number of actions in this episode, including those against a wall.
    steps: u32,
    is_goal_reached: bool,
    is_proven: bool,
    /// True after the last action of the episode.
    is_over: bool,
    /// The flags of each cell as in a state, in the order of [`columns`].
    walls: Vec<u8>,
    /// The sides of each cell that are known to be open, with the same flags.
    openings: Vec<u8>,
    /// 1 for each goal cell, else 0.
    goals: Vec<u8>,
}

impl SearchEnv {
    /// Begins the first episode.
    fn new(pool: &MazePool, seed: u64) -> Self {
        let mut rng = WyRand::new(seed);
        let maze = pool.draw(&mut rng);
        let mut env = Self {
            rng,
            known: KnownMaze::unexplored(&maze),
            pose: maze.start(),
            maze,
            steps: 0,
            is_goal_reached: false,
            is_proven: false,
            is_over: false,
            walls: Vec::new(),
            openings: Vec::new(),
            goals: Vec::new(),
        };
        env.begin();
        env
    }

    /// Begins a new episode, in the next maze of the random sequence.
    fn reset(&mut self, pool: &MazePool) {
        self.maze = pool.draw(&mut self.rng);
        self.begin();
    }

    fn begin(&mut self) {
        self.known = KnownMaze::unexplored(&self.maze);
        self.pose = self.maze.start();
        (self.steps, self.is_proven, self.is_over) = (0, false, false);
        let size = self.maze.size();
        self.walls.resize(size.area(), 0);
        self.openings.resize(size.area(), 0);
        size.cells().for_each(|cell| self.update(cell));
        self.goals.clear();
        self.goals.extend(columns(size).map(|cell| u8::from(self.maze.goals().contains(cell))));
        // Like the bundled strategies, the mouse also sees the wall behind it at the start.
        let behind = Pose::new(self.pose.cell, self.pose.heading.back());
        self.observe(behind);
        self.observe(self.pose);
        self.is_goal_reached = self.maze.goals().contains(self.pose.cell);
    }

    /// Turns by `quarters` to the right and takes a step, unless there is a wall.
    fn act(&mut self, quarters: u8, rules: EpisodeRules) -> Outcome {
        let heading = Heading::ALL[usize::from((self.pose.heading as u8 + quarters) % 4)];
        self.steps += 1;
        self.pose.heading = heading;
        let mut reward = -1.;
        let next = self.maze.size().neighbour(self.pose.cell, heading);
        if let Some(cell) = next.filter(|_| !self.maze.walls().has(self.pose.cell, heading)) {
            self.pose.cell = cell;
            let is_new = self.observe(self.pose);
            let bonus = self.bonus();
            if !self.is_goal_reached && self.maze.goals().contains(cell) {
                self.is_goal_reached = true;
                reward += bonus;
                self.is_proven = rules.until_proven && PathBounds::new(&self.known).is_proven();
            } else if is_new && self.is_goal_reached && rules.until_proven {
                self.is_proven = PathBounds::new(&self.known).is_proven();
            }
            if self.is_proven {
                reward += bonus;
            }
        }
        let is_terminated = if rules.until_proven { self.is_proven } else { self.is_goal_reached };
        let is_truncated = !is_terminated && self.steps >= rules.max_steps;
        self.is_over = is_terminated || is_truncated;
        Outcome { reward, is_terminated, is_truncated }
    }

    /// Returns the reward for reaching the goal, and that for a proof: the number of cells.
    fn bonus(&self) -> f64 {
        f64::from(u16::try_from(self.maze.size().area()).unwrap_or(u16::MAX))
    }

    /// Reads the walls around the mouse. Returns true if the mouse was never in this cell before.
    fn observe(&mut self, pose: Pose) -> bool {
        let is_new = !self.known.visited().contains(pose.cell);
        // The walls of a maze never contradict each other.
        let _ = self.known.observe(pose, self.maze.walls().around(pose));
        let size = self.maze.size();
        self.update(pose.cell);
        for heading in Heading::ALL {
            if let Some(cell) = size.neighbour(pose.cell, heading) {
                self.update(cell);
            }
        }
        is_new
    }

    fn update(&mut self, cell: Cell) {
        let Some(index) = Order::F.index(cell, self.maze.size()) else { return };
        let possible = self.known.walls(Unknown::Closed).sides(cell);
        self.walls[index] = CellWalls::known(&self.known, cell).0;
        self.openings[index] = CellWalls::from_sides(Sides::from_bits(!possible.bits())).0;
    }

    /// Returns walls, openings and goals.
    fn flags(&self) -> [&[u8]; 3] {
        [&self.walls, &self.openings, &self.goals]
    }

    /// Returns x, y and the heading (0 to 3 from north clockwise).
    fn pose(&self) -> [i64; 3] {
        [self.pose.cell.x.into(), self.pose.cell.y.into(), self.pose.heading as i64]
    }

    /// Returns, for each action, 1 if there is no wall in that direction, else 0.
    fn action_mask(&self) -> [i8; 4] {
        let Pose { cell, heading } = self.pose;
        let walls = self.maze.walls();
        [heading, heading.right(), heading.back(), heading.left()]
            .map(|heading| i8::from(!walls.has(cell, heading)))
    }
}
