//! The class `Search`: the search of a bundled strategy.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use mmsim_client::{
    BUNDLED_MOUSE_NAME, BrokenRun, InMemory, Named, RunError, SearchRun, search_run,
};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_protocol::State;
use mmsim_run::Goal;
use mmsim_solvers::{BundledStrategy, Mouse, PathBounds};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::animation::{self, Frame};
use crate::connection::{Link, lock};
use crate::error::{Error, Refused, SimulatorError, type_error, value_error};
use crate::geometry::limit;
use crate::history::{History, Place, draw};
use crate::known::PyKnownMaze;
use crate::maze::PyMaze;
use crate::signals;
use crate::simulator::Simulator;

/// The search of a bundled strategy. A notebook shows it as an animation.
#[pyclass(frozen, module = "micromouse_sim")]
pub(crate) struct Search {
    maze: Py<PyMaze>,
    strategy: BundledStrategy,
    run: SearchRun,
    known: KnownMaze,
    error: Option<String>,
    history: Arc<mmsim_recording::History>,
    place: Arc<Place>,
}

/// Runs a bundled strategy, by default until it stops or has reported its usual limit of states.
#[pyfunction]
#[pyo3(signature = (maze, strategy = "flood-fill", max_states = None))]
pub(crate) fn search(
    py: Python<'_>,
    maze: &Bound<'_, PyAny>,
    strategy: &str,
    max_states: Option<&Bound<'_, PyAny>>,
) -> PyResult<Search> {
    let strategy: BundledStrategy = strategy.parse().map_err(value_error)?;
    let simulator = if let Ok(simulator) = maze.cast::<Simulator>() {
        simulator.clone()
    } else if let Ok(maze) = maze.cast::<PyMaze>() {
        Bound::new(py, Simulator::initializer(maze.clone().unbind(), None))?
    } else {
        return Err(type_error("a Maze or a Simulator", maze));
    };
    let max_states = limit(max_states)?.unwrap_or_else(|| strategy.max_states());
    simulate(&simulator, strategy, max_states)
}

/// Runs a strategy in a simulator, and copies the states. Checks for signals in the meantime.
fn simulate(
    simulator: &Bound<'_, Simulator>,
    strategy: BundledStrategy,
    max_states: u32,
) -> PyResult<Search> {
    let Link::Process(simulated) = &simulator.as_super().get().link else {
        return Err(value_error("a client cannot run a bundled strategy (use `mmsim solve`)"));
    };
    let (py, place) = (simulator.py(), Arc::clone(simulator.get().place()));
    let unexplored = &place.unexplored;
    // A simulation that is locked here must be free of earlier failures.
    drop(lock(simulated, py)?);
    let (run, error, known, history) = py.detach(|| {
        let mut history = mmsim_recording::History::new(unexplored.size());
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
        let mut mouse = Mouse::new(strategy.strategy(), unexplored.clone(), start);
        let (mut checked, mut interrupted) = (Instant::now(), Ok(()));
        let result = search_run(&mut named, &mut mouse, max_states, |_, _| {
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
            Err(BrokenRun { error: error @ RunError::Refused { .. }, .. }) => {
                return Err(Refused::new_err(error.to_string()));
            }
            Err(BrokenRun { error, .. }) => return Err(SimulatorError::new_err(error.to_string())),
        };
        Ok((run, error, mouse.map().clone(), Arc::new(history)))
    })?;
    let maze = simulator.get().true_maze().clone_ref(py);
    Ok(Search { maze, strategy, run, known, error, history, place })
}

impl Search {
    fn truth(&self) -> &Maze {
        &self.maze.get().maze
    }

    fn bounds(&self) -> PathBounds {
        PathBounds::new(&self.known)
    }
}

#[pymethods]
impl Search {
    /// The true maze.
    #[getter]
    fn maze(&self, py: Python<'_>) -> Py<PyMaze> {
        self.maze.clone_ref(py)
    }

    /// The name of the strategy.
    #[getter]
    fn strategy(&self) -> &'static str {
        self.strategy.name()
    }

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
    fn visited(&self) -> usize {
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

    /// The steps and turns of the search run, the return run and the fast run.
    #[getter]
    fn phases<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let phases = PyDict::new(py);
        for (name, figures) in self.run.stats.phases() {
            let phase = PyDict::new(py);
            phase.set_item("steps", figures.steps)?;
            phase.set_item("turns", figures.turns)?;
            phases.set_item(name.replace(' ', "_"), phase)?;
        }
        Ok(phases)
    }

    /// The reason why the strategy could not continue.
    #[getter]
    fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }

    /// The map of the mouse at the end.
    #[getter]
    fn known(&self) -> PyKnownMaze {
        self.known.clone().into()
    }

    /// The states that the mouse has reported.
    #[getter]
    fn states(&self) -> History {
        History::ended(Arc::clone(&self.history), Arc::clone(&self.place))
    }

    fn __repr__(&self) -> String {
        let (name, strategy) = (&self.maze.get().name, self.strategy.name());
        let goal = || Goal { is_reached: self.goal_reached(), error: None }.to_string();
        let ending = self.error.clone().unwrap_or_else(goal);
        format!("<Search of {name:?} with {strategy}: {}, {ending}>", self.run.stats)
    }

    fn _repr_svg_(&self) -> PyResult<String> {
        let bytes = self.history.len().checked_sub(1).and_then(|last| self.history.get(last));
        let bytes = bytes.ok_or_else(|| Error::new_err("the search has no states"))?;
        let state = State::decode(&bytes, self.truth().size()).map_err(value_error)?;
        let unexplored = &self.place.unexplored;
        let map = state.map(unexplored.start().cell, *unexplored.goals());
        Ok(draw(&state, &map, Some(self.truth())))
    }

    fn _repr_html_(&self) -> PyResult<String> {
        let size = self.truth().size();
        let mut reader = self.history.reader();
        if self.history.is_empty() {
            return Err(Error::new_err("the search has no states"));
        }
        let mut frames = Vec::with_capacity(self.history.len());
        for index in 0..self.history.len() {
            let bytes = reader.get(index).ok_or_else(|| Error::new_err("cannot read a state"))?;
            frames.push(Frame::new(&State::decode(bytes, size).map_err(value_error)?));
        }
        Ok(animation::html(self.truth(), &frames))
    }
}
