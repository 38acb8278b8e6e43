//! The class `FastRun`: the fastest run of a vehicle through a maze.

use mmsim_drawing::{DrivenPath, Scene};
use mmsim_fastrun::{FastRun, LoadVehicleError, Planner, Trajectory, Vehicle};
use mmsim_maze::{Cell, Maze};
use pyo3::prelude::*;

use crate::error::{SearchError, io_error, value_error};

/// The fastest run of a vehicle through a maze, from rest to rest.
#[pyclass(frozen, name = "FastRun", module = "micromouse_sim")]
pub(crate) struct PyFastRun {
    maze: Maze,
    /// The name of the vehicle.
    #[pyo3(get)]
    vehicle: String,
    run: FastRun,
    trajectory: Trajectory,
}

/// Returns the preset with this name, or reads a TOML file.
pub(crate) fn vehicle(py: Python<'_>, text: &str) -> PyResult<Vehicle> {
    py.detach(|| Vehicle::load(text)).map_err(|error| match &error {
        LoadVehicleError::Read { source, .. } => io_error(source.kind(), error),
        _ => value_error(error),
    })
}

impl PyFastRun {
    /// Plans the fastest run of a vehicle.
    pub(crate) fn plan(py: Python<'_>, maze: &Maze, vehicle: Option<&str>) -> PyResult<Self> {
        let vehicle = vehicle.map(|text| self::vehicle(py, text)).transpose()?;
        let vehicle = vehicle.unwrap_or_else(|| Vehicle::default_for(maze.size()));
        py.detach(|| {
            let mut planner = Planner::new(vehicle);
            let run = planner
                .plan(maze.walls(), maze.start().cell, maze.goals())
                .map_err(|error| SearchError::new_err(error.to_string()))?
                .clone();
            let trajectory = run
                .drive(planner.vehicle())
                .map_err(|error| SearchError::new_err(error.to_string()))?;
            let vehicle = planner.vehicle().name().into();
            Ok(Self { maze: maze.clone(), vehicle, run, trajectory })
        })
    }
}

#[pymethods]
impl PyFastRun {
    /// The time in seconds.
    #[getter]
    fn time_s(&self) -> f64 {
        self.trajectory.duration()
    }

    /// The time in seconds from leaving the start cell to entering the goal.
    #[getter]
    fn gate_to_gate_s(&self) -> f64 {
        self.trajectory.gate_to_gate(self.maze.goals())
    }

    /// The length in millimetres.
    #[getter]
    fn length_mm(&self) -> f64 {
        self.trajectory.length()
    }

    /// The top speed in millimetres per second.
    #[getter]
    fn top_speed_mm_s(&self) -> f64 {
        self.trajectory.top_speed()
    }

    /// The number of slalom turns.
    #[getter]
    fn slalom_turns(&self) -> usize {
        self.run.turns().len()
    }

    /// The cells of the run.
    #[getter]
    fn cells(&self) -> Vec<(u8, u8)> {
        self.run.cells().into_iter().map(|Cell { x, y }| (x, y)).collect()
    }

    /// The straights and turns, as `mmsim fast-run --json` prints them.
    #[getter]
    fn moves(&self) -> String {
        self.run.to_string()
    }

    fn __repr__(&self) -> String {
        format!(
            "<FastRun of {:?}, {:.3} s, {} turns>",
            self.vehicle,
            self.time_s(),
            self.slalom_turns()
        )
    }

    fn _repr_svg_(&self) -> String {
        Scene::from_maze(&self.maze)
            .with_paths(&[DrivenPath::from_trajectory(&self.vehicle, &self.trajectory)])
            .svg()
    }
}
