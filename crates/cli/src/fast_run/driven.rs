//! A run through a maze, driven by a vehicle.

use std::error::Error;

use mmsim_fastrun::{FastRun, Planner, Trajectory, TurnKind, Vehicle};

use super::args::RouteChoice;
use crate::selection::Selected;

/// A maze, a vehicle and a route, and the run or the reason why there is none.
pub(crate) struct RunResult<'a> {
    pub(crate) maze: &'a Selected,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) route: RouteChoice,
    pub(crate) driven: Result<Driven<'a>, String>,
}

/// A run with its times.
pub(crate) struct Driven<'a> {
    pub(crate) maze: &'a Selected,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) route: RouteChoice,
    pub(crate) run: FastRun,
    pub(crate) trajectory: Trajectory,
    /// The time in s from leaving the start cell to entering the goal.
    pub(crate) gate_to_gate: f64,
    /// The slowdown against the fastest run, in percent.
    pub(crate) loss: f64,
}

impl<'a> RunResult<'a> {
    /// Plans and drives the run along each route.
    pub(crate) fn each_route(
        maze: &'a Selected,
        vehicle: &'a Vehicle,
        planner: &mut Planner,
        routes: &[RouteChoice],
    ) -> Vec<Self> {
        let (walls, start, goals) = (maze.maze.walls(), maze.maze.start().cell, maze.maze.goals());
        let mut drive = |route| -> Result<_, Box<dyn Error>> {
            let run = match route {
                RouteChoice::Fastest => planner.plan(walls, start, goals)?,
                RouteChoice::Along(route) => planner.plan_route(route, walls, start, goals)?,
            };
            Ok((run.clone(), run.drive(vehicle)?))
        };
        let fastest = drive(RouteChoice::Fastest).map(|(_, trajectory)| trajectory.duration());
        let result = |&route| {
            let driven = drive(route).map(|(run, trajectory)| {
                let gate_to_gate = trajectory.gate_to_gate(goals);
                let time = trajectory.duration();
                let loss = fastest.as_ref().map_or(0.0, |&fastest| loss(time, fastest));
                Driven { maze, vehicle, route, run, trajectory, gate_to_gate, loss }
            });
            Self { maze, vehicle, route, driven: driven.map_err(|error| error.to_string()) }
        };
        routes.iter().map(result).collect()
    }
}

/// Returns by how many percent a time is longer than that of the fastest run.
pub(crate) fn loss(time: f64, fastest: f64) -> f64 {
    // The planner may find either of two runs whose times differ by a few microseconds.
    let is_longer = time > fastest + 1e-5;
    if is_longer { (time / fastest - 1.0) * 100.0 } else { 0.0 }
}

impl Driven<'_> {
    /// Returns the number of turns of each kind that occurs.
    pub(crate) fn turns_by_kind(&self) -> impl Iterator<Item = (TurnKind, usize)> {
        TurnKind::ALL.into_iter().filter_map(|kind| {
            let count = self.run.turns().iter().filter(|turn| turn.kind == kind).count();
            (count > 0).then_some((kind, count))
        })
    }
}
