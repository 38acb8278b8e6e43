//! Mice that compete under the rules of a contest, and their ranks, in each maze and in total.

mod attempt;
mod rules;

use mmsim_fastrun::Planner;
use mmsim_run::{SearchFigures, SearchSpeed, Timing, tenth_of_ms};
use serde::Serialize;

pub use self::attempt::{Attempt, ContestRun, RunKind};
pub use self::rules::{RuleSet, Rules};
use crate::comparison::MazeColumns;
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

/// The result of one maze, best mice first. The field names are JSON keys.
#[derive(Debug, Serialize)]
pub struct MazeResult {
    /// The maze. Its name is unique among the mazes.
    #[serde(flatten)]
    pub maze: MazeColumns,
    /// The attempts, best mice first.
    pub entries: Vec<ContestEntry>,
}

/// The attempt of a mouse and its rank. The field names are JSON keys.
#[derive(Debug, Serialize)]
pub struct ContestEntry {
    /// The number of mice with a better score, plus one. `None` without a score.
    pub rank: Option<usize>,
    /// The name of the mouse.
    pub mouse: String,
    /// The attempt.
    #[serde(flatten)]
    pub attempt: Attempt,
}

/// The total of a mouse over all mazes. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// The number of better mice, plus one.
    pub rank: usize,
    /// The name of the mouse.
    pub mouse: String,
    /// The number of mazes in which the mouse has a score.
    pub scored: usize,
    /// The number of mazes in which no mouse has a better score.
    pub wins: usize,
    /// The sum of the scores in s.
    pub total_score_s: f64,
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

impl MazeResult {
    /// Ranks the attempts of all mice in a maze.
    fn new(maze: &NamedMaze, name: &str, attempts: Vec<(String, Attempt)>) -> Self {
        let scores: Vec<f64> = attempts.iter().filter_map(|(_, attempt)| attempt.score_s).collect();
        let rank = |score: f64| 1 + scores.iter().filter(|&&other| other < score).count();
        let entry = |(mouse, attempt): (String, Attempt)| ContestEntry {
            rank: attempt.score_s.map(rank),
            mouse,
            attempt,
        };
        let mut entries: Vec<ContestEntry> = attempts.into_iter().map(entry).collect();
        // Mice without a score come last, in the given order.
        entries.sort_by_key(|entry| entry.rank.unwrap_or(usize::MAX));
        Self { maze: MazeColumns::new(maze, name), entries }
    }

    /// Returns the attempt of a mouse.
    pub fn entry(&self, mouse: &str) -> Option<&ContestEntry> {
        self.entries.iter().find(|entry| entry.mouse == mouse)
    }
}

impl Standing {
    /// Returns the totals, best mice first. A mouse with a score in more mazes is better; ties go to the
    /// lower total.
    fn all<'m>(mice: impl Iterator<Item = &'m str>, results: &[MazeResult]) -> Vec<Self> {
        let total = |mouse: &str| {
            let entries = || results.iter().filter_map(|result| result.entry(mouse));
            let scores = entries().filter_map(|entry| entry.attempt.score_s);
            Self {
                rank: 0,
                mouse: mouse.into(),
                scored: scores.clone().count(),
                wins: entries().filter(|entry| entry.rank == Some(1)).count(),
                // The sum of no scores is -0.
                total_score_s: tenth_of_ms(scores.sum::<f64>() + 0.0),
            }
        };
        let mut standings: Vec<Self> = mice.map(total).collect();
        let is_better = |a: &Self, b: &Self| {
            b.scored.cmp(&a.scored).then(a.total_score_s.total_cmp(&b.total_score_s))
        };
        standings.sort_by(is_better);
        let sorted = standings.clone();
        for standing in &mut standings {
            let better = sorted.iter().filter(|other| is_better(other, standing).is_lt());
            standing.rank = 1 + better.count();
        }
        standings
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use mmsim_run::Ending;

    use super::*;

    fn result(scores: &[(&str, Option<f64>)]) -> MazeResult {
        let maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let maze = NamedMaze { path: PathBuf::from("a.txt"), name: "a".into(), maze };
        let attempt = |&(mouse, score_s): &(&str, Option<f64>)| {
            let (error, runs) = (None, Vec::new());
            let attempt = Attempt {
                score_s,
                search_time_s: Some(1.0),
                touched: false,
                goal_reached: true,
                ending: Ending::Finished,
                error,
                runs,
            };
            (mouse.to_string(), attempt)
        };
        MazeResult::new(&maze, "a", scores.iter().map(attempt).collect())
    }

    #[test]
    fn equal_scores_share_a_rank() {
        let result = result(&[
            ("a", None),
            ("b", Some(9.0)),
            ("c", Some(8.0)),
            ("d", Some(9.0)),
            ("e", Some(10.0)),
        ]);
        let ranks: Vec<_> =
            result.entries.iter().map(|entry| (&*entry.mouse, entry.rank)).collect();
        let expected =
            [("c", Some(1)), ("b", Some(2)), ("d", Some(2)), ("e", Some(4)), ("a", None)];
        assert_eq!(ranks, expected);
    }

    #[test]
    fn more_scores_rank_before_a_lower_total() {
        let results = [
            result(&[("a", Some(3.0)), ("b", Some(9.0)), ("c", Some(4.0)), ("d", None)]),
            result(&[("a", None), ("b", Some(9.0)), ("c", Some(14.0)), ("d", None)]),
        ];
        let standings = Standing::all(["a", "b", "c", "d"].into_iter(), &results);
        let found: Vec<_> = standings
            .iter()
            .map(|one| (one.rank, &*one.mouse, one.scored, one.wins, one.total_score_s))
            .collect();
        let expected =
            [(1, "b", 2, 1, 18.0), (1, "c", 2, 0, 18.0), (3, "a", 1, 1, 3.0), (4, "d", 0, 0, 0.0)];
        assert_eq!(found, expected);
    }
}
