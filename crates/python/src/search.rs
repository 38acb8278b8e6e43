//! The class `Search`: the search of a bundled strategy.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use mmsim_client::{
    BUNDLED_MOUSE_NAME, BrokenRun, InMemory, Named, RunError, SearchRun, search_run,
};
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{KnownMaze, Misreadings};
use mmsim_protocol::State;
use mmsim_recording::History;
use mmsim_run::{FastestRun, Goal, MovementRules, PhaseLog, PhaseReport, RunReport};
use mmsim_solvers::{BundledStrategy, Mouse, PathBounds, Tolerance};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::animation::{self, AnimatedState};
use crate::connection::lock;
use crate::convert::limit;
use crate::error::{Error, run_error, type_error, value_error};
use crate::fast_run::vehicle;
use crate::history::{HistoryStates, PyHistory, PyState, SearchedMaze};
use crate::known::PyKnownMaze;
use crate::maze::PyMaze;
use crate::signals;
use crate::simulator::PySimulator;

/// The search of a bundled strategy. A notebook shows it as an animation.
#[pyclass(frozen, name = "Search", module = "micromouse_sim")]
pub(crate) struct PySearch {
    /// The true maze.
    #[pyo3(get)]
    maze: Py<PyMaze>,
    /// The name of the strategy.
    #[pyo3(get)]
    mouse: &'static str,
    run: SearchRun,
    known: KnownMaze,
    phases: PhaseReport,
    fastest_run: FastestRun,
    /// The reason why the strategy could not continue.
    #[pyo3(get)]
    error: Option<String>,
    history: Arc<History>,
    searched: Arc<SearchedMaze>,
}

/// Runs a bundled strategy, by default until it stops or has reported its usual limit of states.
///
/// `vehicle` times the runs, as in `Maze.fastest_run`, and `fastest-path-search` explores for it.
#[pyfunction]
#[pyo3(signature = (maze, strategy = "flood-fill", max_states = None, vehicle = None))]
pub(crate) fn search(
    py: Python<'_>,
    maze: &Bound<'_, PyAny>,
    strategy: &str,
    max_states: Option<&Bound<'_, PyAny>>,
    vehicle: Option<&str>,
) -> PyResult<PySearch> {
    let strategy: BundledStrategy = strategy.parse().map_err(value_error)?;
    let simulator = if let Ok(simulator) = maze.cast::<PySimulator>() {
        simulator.clone()
    } else if let Ok(maze) = maze.cast::<PyMaze>() {
        Bound::new(
            py,
            PySimulator::initializer(maze.clone().unbind(), None, Misreadings::default()),
        )?
    } else {
        return Err(type_error("a Maze or a Simulator", maze));
    };
    let max_states = limit(max_states)?.unwrap_or_else(|| strategy.max_states());
    let vehicle = vehicle.map(|text| self::vehicle(py, text)).transpose()?;
    simulate(&simulator, strategy, max_states, vehicle)
}

/// Runs a strategy in a simulator, and copies the states. Checks for signals in the meantime.
fn simulate(
    simulator: &Bound<'_, PySimulator>,
    strategy: BundledStrategy,
    max_states: u32,
    vehicle: Option<Vehicle>,
) -> PyResult<PySearch> {
    let py = simulator.py();
    let PySimulator { maze, searched, simulated } = simulator.get();
    let unexplored = &searched.unexplored;
    // A simulation that is locked here must be free of earlier failures.
    drop(lock(simulated, py)?);
    let (run, error, known, history, phases, fastest_run) = py.detach(|| {
        let mut history = History::new(unexplored.size());
        let mut transport = InMemory::new(|request: &[u8], reply: &mut Vec<u8>| {
            // The lock is free again before Python code runs.
            let Ok(mut simulated) = simulated.lock() else {
                return reply.extend_from_slice(b"error: the simulator has failed");
            };
            reply.extend_from_slice(simulated.handle(request));
            if request.first() == Some(&b'S') && reply == b"ok" {
                // The history has no limit.
                let _ = history.push(request);
            }
        });
        let mut named =
            Named::new(&mut transport, BUNDLED_MOUSE_NAME, strategy.name()).map_err(value_error)?;
        let start = unexplored.start();
        let size = unexplored.size();
        let mut planner = Planner::new(vehicle.unwrap_or_else(|| Vehicle::default_for(size)));
        let searching = strategy.strategy_for(&planner, Tolerance::ZERO);
        let mut mouse = Mouse::new(searching, unexplored.clone(), start);
        let mut log = PhaseLog::new(MovementRules::from_map(unexplored, None));
        let (mut checked, mut interrupted) = (Instant::now(), Ok(()));
        let result = search_run(&mut named, &mut mouse, max_states, |mouse, _| {
            log.add(mouse.pose());
            if checked.elapsed() >= signals::INTERVAL {
                checked = Instant::now();
                interrupted = signals::check();
            }
            if interrupted.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        interrupted?;
        let (run, error) = match result {
            Ok(run) => (run, None),
            Err(BrokenRun { run, error: error @ (RunError::Search(_) | RunError::Crash(_)) }) => {
                (run, Some(error.to_string()))
            }
            Err(BrokenRun { error, .. }) => return Err(run_error(error)),
        };
        let phases = log.report(&mut planner, size, |_, _| 0.0).unwrap_or_default();
        let fastest_run = FastestRun::new(mouse.map(), &mut planner);
        Ok((run, error, mouse.map().clone(), Arc::new(history), phases, fastest_run))
    })?;
    let (maze, searched) = (maze.clone_ref(py), Arc::clone(searched));
    let mouse = strategy.name();
    Ok(PySearch { maze, mouse, run, known, phases, fastest_run, error, history, searched })
}

impl PySearch {
    fn bounds(&self) -> PathBounds {
        PathBounds::new(&self.known)
    }
}

#[pymethods]
impl PySearch {
    /// True if the mouse has entered a goal cell.
    #[getter]
    fn goal_reached(&self) -> bool {
        self.run.stats.goal_reached()
    }

    /// The number of steps in all phases.
    #[getter]
    fn steps(&self) -> u32 {
        self.run.stats.steps()
    }

    /// The number of quarter turns in all phases.
    #[getter]
    fn turns(&self) -> u32 {
        self.run.stats.turns()
    }

    /// The number of steps until the mouse first entered a goal cell.
    #[getter]
    fn steps_to_goal(&self) -> Option<u32> {
        self.run.stats.steps_to_goal
    }

    /// The number of requests to the simulator, except those for the name of the mouse.
    #[getter]
    fn requests(&self) -> u32 {
        self.run.requests
    }

    /// The number of visited cells.
    #[getter]
    fn visited_cells(&self) -> usize {
        self.known.visited().len()
    }

    /// True if the mouse has proven that its path is shortest.
    #[getter]
    fn proven(&self) -> bool {
        self.bounds().is_proven()
    }

    /// The length in steps of the shortest path that the mouse knows.
    #[getter]
    fn path_found(&self) -> Option<u16> {
        self.bounds().pessimistic
    }

    /// The `steps`, `turns` and `time_s` of `search_run`, `return_run`, `fast_run` and `total`.
    ///
    /// The times are those of the vehicle in seconds, or None for a run that did not take place.
    #[getter]
    fn phases<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let phases = PyDict::new(py);
        let PhaseReport { search_run, return_run, fast_run, total, .. } = self.phases;
        let runs = [
            ("search_run", Some(search_run)),
            ("return_run", return_run),
            ("fast_run", fast_run),
            ("total", Some(total)),
        ];
        for (name, run) in runs {
            let RunReport { steps, turns, time_s, .. } = run.unwrap_or_default();
            let phase = PyDict::new(py);
            phase.set_item("steps", steps)?;
            phase.set_item("turns", turns)?;
            phase.set_item("time_s", time_s)?;
            phases.set_item(name, phase)?;
        }
        Ok(phases)
    }

    /// The name of the vehicle that times the runs.
    #[getter]
    fn vehicle(&self) -> &str {
        &self.fastest_run.vehicle
    }

    /// The time in seconds of the fastest run through the walls that the mouse knows.
    #[getter]
    fn known_run_time_s(&self) -> Option<f64> {
        self.fastest_run.known_run_time_s
    }

    /// True if the known walls prove that no run of the vehicle is faster.
    #[getter]
    fn fastest_run_proven(&self) -> bool {
        self.fastest_run.fastest_run_proven
    }

    /// The map of the mouse at the end.
    #[getter]
    fn known(&self) -> PyKnownMaze {
        self.known.clone().into()
    }

    /// The states that the mouse has reported.
    #[getter]
    fn states(&self) -> PyHistory {
        let states = HistoryStates::Search(Arc::clone(&self.history));
        PyHistory { states, searched: Arc::clone(&self.searched) }
    }

    fn __repr__(&self) -> String {
        let (name, strategy) = (&self.maze.get().name, self.mouse);
        let goal = || Goal { is_reached: self.goal_reached(), error: None }.to_string();
        let ending = self.error.clone().unwrap_or_else(goal);
        format!("<Search of {name:?} with {strategy}: {}, {ending}>", self.run.stats)
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        let index = self.history.len().saturating_sub(1);
        let bytes = self.history.get(index);
        let bytes = bytes.ok_or_else(|| Error::new_err("the search has no states"))?;
        PyState { index, bytes, searched: Arc::clone(&self.searched) }.svg()
    }

    fn _repr_html_(&self) -> PyResult<String> {
        let truth = &self.maze.get().maze;
        let mut reader = self.history.reader();
        if self.history.is_empty() {
            return Err(Error::new_err("the search has no states"));
        }
        let states = (0..self.history.len()).map(|index| {
            let bytes = reader.get(index).ok_or_else(|| Error::new_err("cannot read a state"))?;
            let state = State::decode(bytes, truth.size()).map_err(value_error)?;
            Ok(AnimatedState::new(&state))
        });
        Ok(animation::html(truth, &states.collect::<PyResult<Vec<_>>>()?))
    }
}
