//! A run through a maze, driven by a vehicle.

use std::error::Error;

use mmsim_compare::NamedMaze;
use mmsim_fastrun::{FastRun, Planner, Route, Trajectory, TurnKind, Vehicle};
use mmsim_run::loss;

/// A value of `--route`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RouteChoice {
    Fastest,
    Along(Route),
}

impl RouteChoice {
    pub(crate) const ALL: [Self; 3] =
        [Self::Fastest, Self::Along(Route::FewestCells), Self::Along(Route::FewestTurns)];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Fastest => "fastest",
            Self::Along(route) => route.name(),
        }
    }

    /// Describes the route.
    pub(crate) fn about(self) -> String {
        match self {
            Self::Fastest => "the fastest run of all routes".into(),
            Self::Along(_) => format!("the fastest run{}", self.restriction()),
        }
    }

    /// Returns the words after "fastest run of VEHICLE", with a space before them.
    pub(crate) const fn restriction(self) -> &'static str {
        match self {
            Self::Fastest => "",
            Self::Along(Route::FewestCells) => " along a route with the fewest cells",
            Self::Along(Route::FewestTurns) => " along a route with the fewest turns",
        }
    }
}

/// A maze, a vehicle and a route, and the run or the reason why there is none.
pub(crate) struct RunResult<'a> {
    pub(crate) maze: &'a NamedMaze,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) route: RouteChoice,
    pub(crate) driven: Result<DrivenRun<'a>, String>,
}

/// A run with its times.
pub(crate) struct DrivenRun<'a> {
    pub(crate) maze: &'a NamedMaze,
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
        maze: &'a NamedMaze,
        planner: &'a Planner,
        routes: &[RouteChoice],
    ) -> Vec<Self> {
        let (vehicle, mut planner) = (planner.vehicle(), planner.clone());
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
                DrivenRun { maze, vehicle, route, run, trajectory, gate_to_gate, loss }
            });
            Self { maze, vehicle, route, driven: driven.map_err(|error| error.to_string()) }
        };
        routes.iter().map(result).collect()
    }
}

impl DrivenRun<'_> {
    /// Returns the number of turns of each kind that occurs.
    pub(crate) fn turns_by_kind(&self) -> impl Iterator<Item = (TurnKind, usize)> {
        TurnKind::ALL.into_iter().filter_map(|kind| {
            let count = self.run.turns().iter().filter(|turn| turn.kind == kind).count();
            (count > 0).then_some((kind, count))
        })
    }
}
