//! A run through a maze, driven by a vehicle.

use std::error::Error;

use mmsim_fastrun::{FastRun, Planner, Route, Segment, Trajectory, TurnKind, Vehicle};

use super::args::RouteChoice;
use crate::selection::Selected;

/// A maze, a vehicle and a route, and the run or the reason why there is none.
pub(crate) struct Attempt<'a> {
    pub(crate) maze: &'a Selected,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) route: RouteChoice,
    pub(crate) result: Result<Driven<'a>, String>,
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

impl<'a> Attempt<'a> {
    /// Plans and drives the run along each route.
    pub(crate) fn each_route(
        maze: &'a Selected,
        vehicle: &'a Vehicle,
        planner: &mut Planner,
        routes: &[RouteChoice],
    ) -> Vec<Self> {
        let fastest = plan(maze, planner).and_then(|run| Ok((run.time(vehicle)?, run)));
        let mut drive = |route| {
            let (least, fastest) = fastest.as_ref().map_err(ToString::to_string)?;
            let driven = match route {
                RouteChoice::Fastest => Ok(fastest.clone()),
                RouteChoice::Along(route) => plan_along(maze, planner, route),
            };
            let driven = driven.and_then(|run| Ok((run.drive(vehicle)?, run)));
            let (trajectory, run) = driven.map_err(|error| error.to_string())?;
            let gate_to_gate = trajectory.gate_to_gate(maze.maze.goals());
            let loss = loss(trajectory.duration(), *least);
            Ok(Driven { maze, vehicle, route, run, trajectory, gate_to_gate, loss })
        };
        let mut attempt = |&route| Self { maze, vehicle, route, result: drive(route) };
        routes.iter().map(&mut attempt).collect()
    }
}

fn plan(
    Selected { maze, .. }: &Selected,
    planner: &mut Planner,
) -> Result<FastRun, Box<dyn Error>> {
    Ok(planner.plan(maze.walls(), maze.start().cell, maze.goals())?.clone())
}

fn plan_along(
    Selected { maze, .. }: &Selected,
    planner: &mut Planner,
    route: Route,
) -> Result<FastRun, Box<dyn Error>> {
    let cells = route.cells(maze.walls(), maze.start().cell, maze.goals())?;
    Ok(planner.plan_along(maze.size(), &cells)?.clone())
}

/// Returns the slowdown against the fastest run, in percent.
fn loss(time: f64, fastest: f64) -> f64 {
    // Runs with the same segments in another order differ by rounding errors.
    let is_longer = time > fastest * (1.0 + 1e-9);
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

    /// Returns the greatest speed, in mm/s.
    pub(crate) fn top_speed(&self) -> f64 {
        self.trajectory.segments().iter().map(Segment::top_speed).fold(0.0, f64::max)
    }
}
