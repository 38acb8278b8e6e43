//! Mice that compete under the rules of a contest, and their ranks, in each maze and overall.

mod attempt;
mod rules;

use mmsim_fastrun::{Planners, Vehicle, VehicleParameters};
use mmsim_run::{SearchFigures, tenth_of_ms};
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
    /// The vehicles of the mice.
    pub vehicles: Vec<ContestVehicle>,
    /// The ranking over all mazes, best mice first.
    pub standings: Vec<Standing>,
    /// The results of the mazes.
    pub mazes: Vec<MazeResult>,
    /// The names of the mazes whose goal is unreachable.
    pub skipped: Vec<String>,
}

/// A vehicle of all mice in some mazes. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContestVehicle {
    /// The name.
    pub vehicle: String,
    /// The speed while a mouse searches or returns, in mm/s.
    pub search_speed_mm_s: f64,
    /// The time of a quarter turn while a mouse searches or returns, in s.
    pub search_turn_time_s: f64,
}

/// The result of one maze, best mice first. The field names are JSON keys.
#[derive(Debug, Serialize)]
pub struct MazeResult {
    /// The maze. Its name is unique among the mazes.
    #[serde(flatten)]
    pub maze: MazeColumns,
    /// The name of the vehicle of all mice.
    pub vehicle: String,
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
    /// One point for each rival with a worse score or none, and half a point for each rival with the
    /// same score. 0 without a score.
    pub points: f64,
    /// The attempt.
    #[serde(flatten)]
    pub attempt: Attempt,
}

/// The rank of a mouse over all mazes. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// The number of better mice, plus one.
    pub rank: usize,
    /// The name of the mouse.
    pub mouse: String,
    /// The sum of the points in all mazes.
    pub points: f64,
    /// The number of mazes in which the mouse has a score.
    pub scored: usize,
    /// The number of mazes in which no mouse has a better score.
    pub wins: usize,
    /// The mean score in s over the mazes in which each mouse has a score. `None` if there are none.
    pub mean_score_s: Option<f64>,
}

impl Contest {
    /// Holds a contest of mice with these names, all with one vehicle or with the
    /// [default vehicle](Vehicle::default_for) of each maze. Each mouse has figures in each maze.
    pub fn new(
        names: &[impl AsRef<str> + Sync],
        mazes: &[NamedMaze],
        figures: &[Vec<SearchFigures>],
        vehicle: Option<Vehicle>,
        rules: Rules,
    ) -> Self {
        let planners = Planners::new(vehicle);
        let maze_names = unique_names(mazes);
        let indices: Vec<usize> = (0..mazes.len()).collect();
        let results = map_each(&indices, |&index| {
            let NamedMaze { maze, .. } = &mazes[index];
            let mut planner = planners.for_size(maze.size()).clone();
            // A maze is skipped if its goal is unreachable.
            planner.plan(maze.walls(), maze.start().cell, maze.goals()).ok()?;
            let attempts = names.iter().zip(figures).map(|(name, figures)| {
                let figures = &figures[index];
                let attempt = Attempt::new(&mut planner, maze, figures, &rules);
                (name.as_ref().to_string(), attempt)
            });
            let attempts = attempts.collect();
            let vehicle = planner.vehicle().name();
            Some(MazeResult::new(&mazes[index], &maze_names[index], vehicle, attempts))
        });
        let is_skipped = |(_, result): &(&String, &Option<MazeResult>)| result.is_none();
        let skipped = maze_names.iter().zip(&results).filter(is_skipped);
        let skipped = skipped.map(|(name, _)| name.clone()).collect();
        let mazes: Vec<MazeResult> = results.into_iter().flatten().collect();
        let is_driven = |vehicle: &&Vehicle| mazes.iter().any(|it| it.vehicle == vehicle.name());
        let vehicles = planners.vehicles().filter(is_driven).map(ContestVehicle::new).collect();
        Self {
            rules,
            vehicles,
            standings: Standing::all(names.iter().map(AsRef::as_ref), &mazes),
            mazes,
            skipped,
        }
    }
}

impl ContestVehicle {
    fn new(vehicle: &Vehicle) -> Self {
        let VehicleParameters { search_speed, search_turn_time, .. } = *vehicle.parameters();
        Self {
            vehicle: vehicle.name().into(),
            search_speed_mm_s: search_speed,
            search_turn_time_s: search_turn_time,
        }
    }
}

impl MazeResult {
    /// Returns true if each mouse has a score.
    pub fn is_scored_by_all(&self) -> bool {
        self.entries.iter().all(|entry| entry.rank.is_some())
    }

    /// Ranks the attempts of all mice in a maze.
    fn new(maze: &NamedMaze, name: &str, vehicle: &str, attempts: Vec<(String, Attempt)>) -> Self {
        let scores: Vec<Option<f64>> =
            attempts.iter().map(|(_, attempt)| attempt.score_s).collect();
        let entry = |(mouse, attempt): (String, Attempt)| {
            let Some(score) = attempt.score_s else {
                return ContestEntry { rank: None, mouse, points: 0.0, attempt };
            };
            let better = scores.iter().flatten().filter(|&&other| other < score).count();
            let equal = scores.iter().filter(|&&other| other == Some(score)).count();
            let worse = scores.len() - better - equal;
            let points = count(worse) + 0.5 * count(equal - 1);
            ContestEntry { rank: Some(better + 1), mouse, points, attempt }
        };
        let mut entries: Vec<ContestEntry> = attempts.into_iter().map(entry).collect();
        // Mice without a score come last, in the given order.
        entries.sort_by_key(|entry| entry.rank.unwrap_or(usize::MAX));
        Self { maze: MazeColumns::new(maze, name), vehicle: vehicle.into(), entries }
    }

    /// Returns the attempt of a mouse.
    pub fn entry(&self, mouse: &str) -> Option<&ContestEntry> {
        self.entries.iter().find(|entry| entry.mouse == mouse)
    }
}

impl Standing {
    /// Returns the ranking, best mice first. Of mice with equal points, one with a score in more mazes
    /// is better, then one that wins more mazes.
    fn all<'m>(mice: impl Iterator<Item = &'m str>, results: &[MazeResult]) -> Vec<Self> {
        let standing = |mouse: &str| {
            let entries = || results.iter().filter_map(|result| result.entry(mouse));
            let common = results.iter().filter(|result| result.is_scored_by_all());
            let common = common.filter_map(|result| result.entry(mouse)?.attempt.score_s);
            let (sum, mazes) =
                common.fold((0.0, 0), |(sum, mazes), score| (sum + score, mazes + 1));
            Self {
                rank: 0,
                mouse: mouse.into(),
                // The sum of no points is -0.
                points: entries().map(|entry| entry.points).sum::<f64>() + 0.0,
                scored: entries().filter(|entry| entry.rank.is_some()).count(),
                wins: entries().filter(|entry| entry.rank == Some(1)).count(),
                mean_score_s: (mazes > 0).then(|| tenth_of_ms(sum / count(mazes))),
            }
        };
        let mut standings: Vec<Self> = mice.map(standing).collect();
        let is_better = |a: &Self, b: &Self| {
            let counts = |standing: &Self| (standing.scored, standing.wins);
            b.points.total_cmp(&a.points).then_with(|| counts(b).cmp(&counts(a)))
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

/// Returns a number of mice or mazes as a floating-point number.
fn count(mice: usize) -> f64 {
    f64::from(u32::try_from(mice).unwrap_or(u32::MAX))
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
        MazeResult::new(&maze, "a", "expert", scores.iter().map(attempt).collect())
    }

    fn ranks(standings: &[Standing]) -> Vec<(usize, &str, f64)> {
        standings.iter().map(|one| (one.rank, &*one.mouse, one.points)).collect()
    }

    #[test]
    fn a_mouse_gets_a_point_for_each_mouse_that_it_beats() {
        let result = result(&[
            ("a", None),
            ("b", Some(9.0)),
            ("c", Some(8.0)),
            ("d", Some(9.0)),
            ("e", Some(10.0)),
            ("f", None),
        ]);
        let found: Vec<_> =
            result.entries.iter().map(|entry| (&*entry.mouse, entry.rank, entry.points)).collect();
        let expected = [
            ("c", Some(1), 5.0),
            ("b", Some(2), 3.5),
            ("d", Some(2), 3.5),
            ("e", Some(4), 2.0),
            ("a", None, 0.0),
            ("f", None, 0.0),
        ];
        assert_eq!(found, expected);
    }

    /// The example of docs/contest.md.
    #[test]
    fn points_of_all_mazes_are_added() {
        let results = [
            result(&[("ada", Some(5.0)), ("bo", Some(6.0)), ("cy", Some(6.0))]),
            result(&[("ada", Some(7.5)), ("bo", Some(8.0)), ("cy", None)]),
            result(&[("ada", None), ("bo", Some(60.0)), ("cy", None)]),
        ];
        let points = results.each_ref().map(|result| {
            ["ada", "bo", "cy"].map(|mouse| result.entry(mouse).map(|entry| entry.points))
        });
        let expected = [[2.0, 0.5, 0.5], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(points, expected.map(|maze| maze.map(Some)));
        let standings = Standing::all(["cy", "bo", "ada"].into_iter(), &results);
        assert_eq!(ranks(&standings), [(1, "ada", 4.0), (2, "bo", 3.5), (3, "cy", 0.5)]);
        let counts: Vec<_> = standings.iter().map(|one| (one.scored, one.wins)).collect();
        assert_eq!(counts, [(2, 2), (3, 1), (1, 0)]);
        // Only the first maze has a score of each mouse.
        let means: Vec<_> = standings.iter().map(|one| one.mean_score_s).collect();
        assert_eq!(means, [Some(5.0), Some(6.0), Some(6.0)]);
        let alone = Standing::all(
            ["ada"].into_iter(),
            &[result(&[("ada", Some(5.0))]), result(&[("ada", None)])],
        );
        assert_eq!((alone[0].points, alone[0].mean_score_s), (0.0, Some(5.0)));
    }

    #[test]
    fn equal_points_are_decided_by_scores_and_wins() {
        let first = result(&[("a", Some(1.0)), ("b", Some(2.0)), ("c", None)]);
        let results = [first, result(&[("a", None), ("b", Some(9.0)), ("c", Some(8.0))])];
        let standings = Standing::all(["a", "b", "c"].into_iter(), &results);
        assert_eq!(ranks(&standings), [(1, "b", 2.0), (2, "a", 2.0), (2, "c", 2.0)]);
        let first = result(&[("a", Some(3.0)), ("b", Some(2.0)), ("c", Some(1.0))]);
        let results = [first, result(&[("a", Some(7.0)), ("b", Some(8.0)), ("c", Some(9.0))])];
        let standings = Standing::all(["a", "b", "c"].into_iter(), &results);
        assert_eq!(ranks(&standings), [(1, "a", 2.0), (1, "c", 2.0), (3, "b", 2.0)]);
    }

    #[test]
    fn one_huge_maze_does_not_turn_the_result_of_17_others() {
        let mice = ["a", "b", "c", "d", "e", "f"];
        let usual = mice.iter().zip([10.0, 11.0, 30.0, 30.0, 30.0, 30.0]);
        let usual: Vec<_> = usual.map(|(mouse, score)| (*mouse, Some(score))).collect();
        let huge = mice.map(|mouse| (mouse, (mouse == "b").then_some(1e6)));
        let results: Vec<_> = (0..17).map(|_| result(&usual)).chain([result(&huge)]).collect();
        let standings = Standing::all(mice.into_iter(), &results);
        assert_eq!(ranks(&standings)[..2], [(1, "a", 85.0), (2, "b", 73.0)]);
    }
}
