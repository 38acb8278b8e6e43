//! The class `FastRun`: the fastest run of a vehicle through a maze.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use mmsim_drawing::{DrivenPath, PathPoint, Scene};
use mmsim_fastrun::{MotionState, Planner, Trajectory, Vehicle};
use mmsim_maze::{Cell, Maze};
use pyo3::prelude::*;

use crate::error::{SearchError, io_error, value_error};

/// The maximum size of a vehicle file, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The number of points of the drawn curve for each cell that is passed.
const POINTS_PER_CELL: f64 = 16.0;

/// The fastest run of a vehicle through a maze, from rest to rest.
#[pyclass(frozen, module = "micromouse_sim")]
pub(crate) struct FastRun {
    maze: Maze,
    vehicle: String,
    run: mmsim_fastrun::FastRun,
    trajectory: Trajectory,
}

/// Returns the preset with this name, or reads a TOML file.
pub(crate) fn vehicle(text: &str) -> PyResult<Vehicle> {
    if let Some(vehicle) = Vehicle::preset(text) {
        return Ok(vehicle);
    }
    let path = Path::new(text);
    if path.components().count() == 1 && path.extension().is_none() && !path.exists() {
        let names = Vehicle::PRESETS.join(", ");
        return Err(value_error(format_args!("expected {names} or a TOML file, found {text:?}")));
    }
    let mut toml = String::new();
    let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_string(&mut toml));
    let read = read.and_then(|length| {
        let is_small = length as u64 <= MAX_BYTES;
        if is_small { Ok(()) } else { Err(io::Error::other("larger than 1 MiB")) }
    });
    read.map_err(|error| {
        io_error(error.kind(), format_args!("cannot read {}: {error}", path.display()))
    })?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Vehicle::from_toml(&toml, &name)
        .map_err(|error| value_error(format_args!("{}: {error}", path.display())))
}

impl FastRun {
    /// Plans the fastest run of a vehicle.
    pub(crate) fn plan(py: Python<'_>, maze: &Maze, vehicle: &str) -> PyResult<Self> {
        let vehicle = self::vehicle(vehicle)?;
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

    fn path(&self) -> DrivenPath {
        let pitch = 2.0 * self.trajectory.half_cell();
        let point = |MotionState { time, x, y, heading, speed, .. }: MotionState| PathPoint {
            time,
            x: x / pitch,
            y: y / pitch,
            heading,
            speed,
        };
        let states = self.trajectory.samples_along(pitch / POINTS_PER_CELL);
        DrivenPath::new(&self.vehicle, states.map(point).collect())
    }
}

#[pymethods]
impl FastRun {
    /// The name of the vehicle.
    #[getter]
    fn vehicle(&self) -> &str {
        &self.vehicle
    }

    /// The time in seconds.
    #[getter]
    fn time(&self) -> f64 {
        self.trajectory.duration()
    }

    /// The time in seconds from leaving the start cell to entering the goal.
    #[getter]
    fn gate_to_gate(&self) -> f64 {
        self.trajectory.gate_to_gate(self.maze.goals())
    }

    /// The length in millimetres.
    #[getter]
    fn length(&self) -> f64 {
        self.trajectory.length()
    }

    /// The top speed in millimetres per second.
    #[getter]
    fn top_speed(&self) -> f64 {
        self.trajectory.top_speed()
    }

    /// The number of turns.
    #[getter]
    fn turns(&self) -> usize {
        self.run.turns().len()
    }

    /// The cells of the run.
    #[getter]
    fn cells(&self) -> Vec<(u8, u8)> {
        self.run.cells().into_iter().map(|Cell { x, y }| (x, y)).collect()
    }

    /// The straights and turns, as `mmsim fast-run --json` prints them.
    #[getter]
    fn run(&self) -> String {
        self.run.to_string()
    }

    fn __repr__(&self) -> String {
        format!("<FastRun of {:?}, {:.3} s, {} turns>", self.vehicle, self.time(), self.turns())
    }

    fn _repr_svg_(&self) -> String {
        Scene::from_maze(&self.maze).with_paths(&[self.path()]).svg()
    }
}
