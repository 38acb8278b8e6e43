//! Tables that compare robots and their settings.

use mmsim_mouse::Shortage;
use mmsim_report::{Comparison, Measure, MousePath};
use mmsim_trial::{BundledRobot, KeyPoints, Score, Settings, TrialStatus, Variant};
use serde::Serialize;

use super::result::{Means, TrialResult};
use super::robot::{RobotKind, RunContext, TrialJob, TrialRobot, run_trials};
use crate::named_maze::NamedMaze;

/// The maximum number of mazes in a table with one column for each maze. Tables of more mazes show
/// only means.
const MAX_COLUMNS: usize = 6;

/// The number of trials of the random robot. Each trial has a different seed.
const RANDOM_TRIALS: u64 = 6;

/// The result of a trial. The field names are JSON keys.
#[derive(Serialize)]
pub struct TrialRow {
    /// The path of the maze, or an empty string.
    path: String,
    maze: String,
    mouse: String,
    ending: &'static str,
    /// The step in which the robot failed, and the reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    explore_steps: u32,
    race_steps: u32,
    /// The score, rounded to three decimals, or null if the robot did not score.
    score: Option<f64>,
    /// The minimum number of race steps, or null if the goal is unreachable.
    race_optimum: Option<u16>,
    seed: u64,
    noise: f64,
    /// A drawing of the explored maze and the race, if it is wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawing: Option<String>,
}

impl TrialRow {
    /// Creates the row for a trial.
    pub fn new(maze: &NamedMaze, robot: &TrialRobot, result: &TrialResult) -> Self {
        let TrialResult { ending, explore_steps, race_steps, race_optimum, .. } = *result;
        Self {
            path: maze.path.display().to_string(),
            maze: maze.name.clone(),
            mouse: robot.name().into(),
            ending: TrialStatus::from_outcome(ending).key(),
            error: result.failure.clone(),
            explore_steps,
            race_steps,
            score: result.score().map(Score::rounded),
            race_optimum,
            seed: robot.settings.seed,
            noise: robot.settings.noise,
            drawing: None,
        }
    }
}

/// A table that compares several robots, or several settings of one robot.
pub struct TrialTable {
    /// The title.
    pub title: &'static str,
    /// The JSON value.
    pub key: &'static str,
    /// The robots with their names in the table.
    pub rows: Vec<(String, TrialRobot)>,
}

impl TrialTable {
    /// Returns the table of these robots.
    pub fn from_robots(robots: impl IntoIterator<Item = TrialRobot>) -> Self {
        let rows = robots.into_iter().map(|robot| (robot.name().to_string(), robot));
        Self { title: "Robots", key: "robots", rows: rows.collect() }
    }

    /// Returns the tables of benchmark robots, of variants of swing, of swing by number of key points,
    /// and of all robots, including those of the user. Robots have these settings, except where a table
    /// compares others.
    pub fn all(settings: Settings, own: Vec<TrialRobot>) -> Vec<Self> {
        let robot = |robot, settings| TrialRobot { kind: RobotKind::Bundled(robot), settings };
        let random = (0..RANDOM_TRIALS).map(|more| {
            let seed = settings.seed.wrapping_add(more);
            (
                format!("random, seed {seed}"),
                robot(BundledRobot::Random, Settings { seed, ..settings }),
            )
        });
        let count = robot(BundledRobot::CountExpansion, settings);
        let benchmarks = random.chain([(count.name().to_string(), count)]);
        let swings = |name: String, settings| {
            [(BundledRobot::Swing, ""), (BundledRobot::SwingAsPublished, ", as published")]
                .map(|(swing, suffix)| (format!("{name}{suffix}"), robot(swing, settings)))
        };
        let variants = Variant::ALL
            .iter()
            .flat_map(|&variant| swings(variant.to_string(), Settings { variant, ..settings }));
        let key_points = KeyPoints::ALL.iter().flat_map(|&key_points| {
            swings(key_points.to_string(), Settings { key_points, ..settings })
        });
        let bundled = BundledRobot::ALL.iter().map(|&bundled| robot(bundled, settings));
        let table = |title, key, rows| Self { title, key, rows };
        vec![
            table("Benchmarks", "benchmarks", benchmarks.collect()),
            table("Variants of swing", "variants", variants.collect()),
            table("Swing by number of key points", "key-points", key_points.collect()),
            Self::from_robots(bundled.chain(own)),
        ]
    }
}

/// The results of all trials in tables.
pub struct TrialTables<'a> {
    /// The tables.
    pub tables: &'a [TrialTable],
    mazes: &'a [NamedMaze],
    /// The results of each robot in all mazes. A robot that is in two tables runs only once.
    results: Vec<(&'a TrialRobot, Vec<TrialResult>)>,
}

/// A trial in a table. The field names are JSON keys.
#[derive(Serialize)]
pub struct TableRow<'a> {
    table: &'a str,
    #[serde(rename = "row")]
    name: &'a str,
    #[serde(flatten)]
    trial: TrialRow,
}

impl<'a> TrialTables<'a> {
    /// Returns the robots in the tables, each once.
    pub fn robots(tables: &[TrialTable]) -> Vec<&TrialRobot> {
        let mut robots: Vec<&TrialRobot> = Vec::new();
        for (_, robot) in tables.iter().flat_map(|table| &table.rows) {
            if !robots.contains(&robot) {
                robots.push(robot);
            }
        }
        robots
    }

    /// Runs the robots in all mazes. Returns `None` if they had to stop.
    ///
    /// # Errors
    /// The system lacks something even for one robot at a time.
    pub fn run(
        tables: &'a [TrialTable],
        mazes: &'a [NamedMaze],
        context: &RunContext,
    ) -> Result<Option<Self>, Shortage> {
        let robots = Self::robots(tables);
        let jobs: Vec<TrialJob<'_>> = (robots.iter())
            .flat_map(|&robot| mazes.iter().map(move |maze| (maze, robot)))
            .collect();
        let Some(all) = run_trials(&jobs, context)? else { return Ok(None) };
        let mut all = all.into_iter();
        let results =
            robots.into_iter().map(|robot| (robot, all.by_ref().take(mazes.len()).collect()));
        Ok(Some(Self { tables, mazes, results: results.collect() }))
    }

    fn results_of(&self, robot: &TrialRobot) -> &[TrialResult] {
        let mut all = self.results.iter();
        all.find(|(other, _)| *other == robot).map_or(&[], |(_, results)| results)
    }

    fn has_columns(&self) -> bool {
        self.mazes.len() <= MAX_COLUMNS
    }

    /// Returns the cells of a table, with a column for each maze or for each mean.
    pub fn cells(&self, table: &TrialTable) -> Vec<Vec<String>> {
        let mut head = vec![table.title.to_string()];
        if self.has_columns() {
            head.extend(self.mazes.iter().map(|maze| maze.name.clone()));
            head.push("sum".into());
        } else {
            let means = ["scored", "unreachable", "failed", "explore", "race", "score", "excess"];
            head.extend(means.map(String::from));
        }
        let rows = table.rows.iter().map(|(name, robot)| {
            let results = self.results_of(robot);
            let cells = if self.has_columns() { each(results) } else { means(results) };
            [vec![name.clone()], cells].concat()
        });
        [head].into_iter().chain(rows).collect()
    }

    /// Returns a row for each trial, table by table.
    pub fn rows(&self) -> Vec<TableRow<'a>> {
        let rows =
            self.tables.iter().flat_map(|table| table.rows.iter().map(move |row| (table, row)));
        rows.flat_map(|(table, (name, robot))| {
            let results = self.mazes.iter().zip(self.results_of(robot));
            results.map(move |(maze, result)| TableRow {
                table: table.key,
                name,
                trial: TrialRow::new(maze, robot, result),
            })
        })
        .collect()
    }

    /// Returns a report on the robots in a table, as an HTML page with pictures of the races.
    pub fn html(&self, table: &TrialTable) -> String {
        let results: Vec<_> = table.rows.iter().map(|(_, robot)| self.results_of(robot)).collect();
        self.comparison(table).html(|robot, maze| {
            let cells = results[robot][maze].race_cells();
            Some(MousePath::through_cells(&self.mazes[maze].maze, &cells))
        })
    }

    /// Returns the comparison of the robots in a table, maze by maze.
    pub fn comparison(&self, table: &TrialTable) -> Comparison {
        let results: Vec<&[TrialResult]> =
            table.rows.iter().map(|(_, robot)| self.results_of(robot)).collect();
        let score = |robot: usize, maze: usize| results[robot][maze].score();
        let measure = |key, name, unit| Measure::new(key, name, unit).with_verb("scored in");
        let robots = table.rows.iter().map(|(name, _)| name.clone()).collect();
        let mazes = self.mazes.iter().map(|maze| maze.name.clone()).collect();
        Comparison::new("Robots in the two-run trial", robots, mazes)
            .with_pictures_caption("The lines are the races.")
            .with_measure(measure("score", "score", ""), |robot, maze| {
                score(robot, maze).map(Score::value)
            })
            .with_measure(measure("explore-steps", "explore steps", "steps"), |robot, maze| {
                score(robot, maze).map(|score| score.explore_steps.into())
            })
            .with_measure(measure("race-steps", "race steps", "steps"), |robot, maze| {
                score(robot, maze).map(|score| score.race_steps.into())
            })
            .with_failures(|robot, maze| {
                let result = &results[robot][maze];
                (!result.succeeded()).then(|| result.reason().to_string())
            })
    }
}

/// Returns a robot's result in each maze, and the sum of the scores if the robot scored in every
/// maze.
fn each(results: &[TrialResult]) -> Vec<String> {
    let scores: Option<Vec<Score>> = results.iter().map(TrialResult::score).collect();
    let sum = scores.map(|scores| scores.into_iter().map(Score::value).sum::<f64>());
    let sum = sum.map_or("-".into(), |sum| format!("{sum:.3}"));
    results.iter().map(TrialResult::summary).chain([sum]).collect()
}

/// Returns three counts: scores, correctly reported unreachable goals, and failures. If there are
/// scores, also returns the means over the mazes with a score.
fn means(results: &[TrialResult]) -> Vec<String> {
    let Means { scored, explore_steps, race_steps, score, excess } = Means::new(results.iter());
    let unreachable = results.iter().filter(|result| result.is_correctly_given_up()).count();
    let failed = results.len() - scored - unreachable;
    let mut cells = [scored, unreachable, failed].map(|count| count.to_string()).to_vec();
    if scored > 0 {
        cells.extend([explore_steps, race_steps].map(|steps| format!("{steps:.1}")));
        cells.extend([score, excess].map(|score| format!("{score:.3}")));
    }
    cells
}
