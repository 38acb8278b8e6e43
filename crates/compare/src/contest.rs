//! Mice that compete under the rules of a contest.

mod attempt;
mod rules;
mod standings;

use mmsim_fastrun::Planner;
use mmsim_run::{SearchFigures, SearchSpeed, Timing};
use serde::Serialize;

pub use self::attempt::{Attempt, ContestRun, RunKind};
pub use self::rules::{RuleSet, Rules};
pub use self::standings::{ContestEntry, MazeResult, Standing};
use crate::named_maze::{NamedMaze, unique_names};
use crate::parallel::map_each;

/// The results of a contest. The field names are JSON keys.
#[derive(Debug, Serialize)]
pub struct Contest {
    /// The rules.
    #[serde(flatten)]
    pub rules: Rules,
    /// The name of the vehicle of all fast runs.
    pub vehicle: String,
    /// The speed of the mice while they search or return.
    pub search_speed: SearchSpeed,
    /// The totals of the mice, best mice first.
    pub standings: Vec<Standing>,
    /// The results of the mazes.
    pub mazes: Vec<MazeResult>,
    /// The names of the mazes whose goal is unreachable.
    pub skipped: Vec<String>,
}

impl Contest {
    /// Holds a contest of mice with these names. Each mouse has figures in each maze.
    pub fn new(
        names: &[impl AsRef<str> + Sync],
        mazes: &[NamedMaze],
        figures: &[Vec<SearchFigures>],
        Timing { vehicle, search_speed }: &Timing,
        rules: Rules,
    ) -> Self {
        let planner = Planner::new(vehicle.clone());
        let maze_names = unique_names(mazes);
        let indices: Vec<usize> = (0..mazes.len()).collect();
        let results = map_each(&indices, |&index| {
            let NamedMaze { maze, .. } = &mazes[index];
            let mut planner = planner.clone();
            // A maze is skipped if its goal is unreachable.
            planner.plan(maze.walls(), maze.start().cell, maze.goals()).ok()?;
            let attempts = names.iter().zip(figures).map(|(name, figures)| {
                let figures = &figures[index];
                let attempt = Attempt::new(&mut planner, maze, figures, *search_speed, &rules);
                (name.as_ref().to_string(), attempt)
            });
            Some(MazeResult::new(&mazes[index], &maze_names[index], attempts.collect()))
        });
        let is_skipped = |(_, result): &(&String, &Option<MazeResult>)| result.is_none();
        let skipped = maze_names.iter().zip(&results).filter(is_skipped);
        let skipped = skipped.map(|(name, _)| name.clone()).collect();
        let mazes: Vec<MazeResult> = results.into_iter().flatten().collect();
        Self {
            rules,
            vehicle: vehicle.name().into(),
            search_speed: *search_speed,
            standings: Standing::all(names.iter().map(AsRef::as_ref), &mazes),
            mazes,
            skipped,
        }
    }
}
