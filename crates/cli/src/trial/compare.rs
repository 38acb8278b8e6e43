//! `mmsim trial --compare`: print tables that compare robots and their settings.

use std::error::Error;
use std::io::{self, IsTerminal};
use std::sync::Arc;

use mmsim_report::{Comparison, Measure, MousePath};
use mmsim_trial::{BundledRobot, KeyPoints, Score, Settings, TrialOutcome, Variant};
use serde::Serialize;

use super::args::TrialArgs;
use super::charts;
use super::conclusion::conclusion;
use super::contender::{Contender, RunContext, run_trials};
use super::outcome::TrialResult;
use super::report::TrialReport;
use super::stop_flag;
use super::table::{Means, failure};
use crate::grid::aligned;
use crate::output::{
    counted, create_folder, note, print, print_pretty_json, replace, write_charts,
};
use crate::selection::Selected;
use crate::usage::{CommandResult, UsageError};

/// The maximum number of mazes in a table with one column for each maze. Tables of more mazes show
/// only means.
const MAX_COLUMNS: usize = 6;

/// The number of trials of the random robot. Each trial has a different seed.
const RANDOM_TRIALS: u64 = 6;

/// A table that compares several robots, or several settings of one robot.
pub(super) struct Table {
    pub(super) title: &'static str,
    /// The name of the chart file.
    pub(super) file: &'static str,
    pub(super) rows: Vec<(String, Contender)>,
}

fn tables(args: &TrialArgs) -> Result<Vec<Table>, UsageError> {
    let row = |robot| (BundledRobot::to_string(&robot), args.contender(robot));
    let random = (0..RANDOM_TRIALS).map(|more| {
        let mut contender = args.contender(BundledRobot::Random);
        contender.settings.seed = contender.settings.seed.wrapping_add(more);
        (format!("random, seed {}", contender.settings.seed), contender)
    });
    let benchmarks = random.chain([row(BundledRobot::CountExpansion)]).collect();
    let swings = |name: String, change: &dyn Fn(&mut Settings)| {
        [(BundledRobot::Swing, ""), (BundledRobot::SwingAsPublished, ", as published")].map(
            |(robot, suffix)| {
                let mut contender = args.contender(robot);
                change(&mut contender.settings);
                (format!("{name}{suffix}"), contender)
            },
        )
    };
    let variants = (Variant::ALL.iter())
        .flat_map(|&variant| swings(variant.to_string(), &|settings| settings.variant = variant));
    let key_points = (KeyPoints::ALL.iter()).flat_map(|&key_points| {
        swings(key_points.to_string(), &|settings| settings.key_points = key_points)
    });
    let own = args.own_robots()?.into_iter().map(|own| (own.name().to_string(), own));
    let robots = BundledRobot::ALL.iter().copied().map(row).chain(own).collect();
    Ok(vec![
        Table { title: "Benchmarks", file: "benchmarks", rows: benchmarks },
        Table { title: "Variants of swing", file: "variants", rows: variants.collect() },
        Table {
            title: "Swing by number of key points",
            file: "key-points",
            rows: key_points.collect(),
        },
        Table { title: "Robots", file: "robots", rows: robots },
    ])
}

/// Runs all trials and prints the tables. Robots without a score still appear in the tables and
/// do not count as errors.
pub(crate) fn run(args: &TrialArgs, mazes: &[Selected]) -> CommandResult {
    let tables = tables(args)?;
    let trials = Trials::run(&tables, mazes)?;
    if args.json {
        print_pretty_json(&trials.reports(&tables))?;
    } else if !mazes.is_empty() {
        let texts = tables.iter().map(|table| trials.text(table)).chain(conclusion(&trials, args));
        print(&texts.collect::<Vec<_>>().join("\n"))?;
    }
    if mazes.is_empty() {
        return Ok(true);
    }
    // The last table contains all robots.
    let robots = tables.last().map(|table| trials.comparison(table));
    if let Some(folder) = &args.charts {
        create_folder(folder)?;
        tables.iter().try_for_each(|table| charts::write(folder, table, &trials))?;
        robots.iter().try_for_each(|robots| write_charts(folder, robots))?;
    }
    if let (Some(file), Some(table), Some(robots)) = (&args.html, tables.last(), &robots) {
        let outcomes: Vec<_> =
            table.rows.iter().map(|(_, contender)| trials.outcomes_of(contender)).collect();
        let page = robots.html(|robot, maze| {
            let cells = outcomes[robot][maze].race_cells();
            Some(MousePath::through_cells(&mazes[maze].maze, &cells))
        });
        replace(file, page.as_bytes())?;
    }
    Ok(true)
}

/// The outcomes of all trials in the comparisons.
pub(super) struct Trials<'a> {
    pub(super) mazes: &'a [Selected],
    /// The outcomes of each contender in all mazes. A contender that is in two tables runs only
    /// once.
    outcomes: Vec<(&'a Contender, Vec<TrialResult>)>,
}

/// A trial in a comparison, as JSON.
#[derive(Serialize)]
struct ComparisonRow<'a> {
    table: &'a str,
    #[serde(rename = "row")]
    name: &'a str,
    #[serde(flatten)]
    report: TrialReport,
}

impl<'a> Trials<'a> {
    fn run(tables: &'a [Table], mazes: &'a [Selected]) -> Result<Self, Box<dyn Error>> {
        let mut contenders: Vec<&Contender> = Vec::new();
        for (_, contender) in tables.iter().flat_map(|table| &table.rows) {
            if !contenders.contains(&contender) {
                contenders.push(contender);
            }
        }
        let jobs: Vec<_> = (contenders.iter())
            .flat_map(|&contender| mazes.iter().map(move |maze| (maze, contender)))
            .collect();
        if io::stderr().is_terminal() {
            note(format_args!("running {}", counted(jobs.len() as u64, "trial")));
        }
        let stop = stop_flag(contenders.iter().copied())?;
        let is_interrupted = Arc::clone(stop.get());
        let context = RunContext { is_interrupted, ..RunContext::default() };
        let mut all = run_trials(&jobs, &context).into_iter();
        stop.end();
        let outcomes = contenders
            .into_iter()
            .map(|contender| (contender, all.by_ref().take(mazes.len()).collect()));
        Ok(Self { mazes, outcomes: outcomes.collect() })
    }

    pub(super) fn outcomes_of(&self, contender: &Contender) -> &[TrialResult] {
        let mut all = self.outcomes.iter();
        all.find(|(other, _)| *other == contender).map_or(&[], |(_, outcomes)| outcomes)
    }

    pub(super) fn has_columns(&self) -> bool {
        self.mazes.len() <= MAX_COLUMNS
    }

    /// Formats a table as text, with a column for each maze or for each mean.
    fn text(&self, table: &Table) -> String {
        let mut head = vec![table.title.to_string()];
        if self.has_columns() {
            head.extend(self.mazes.iter().map(|maze| maze.name.clone()));
            head.push("sum".into());
        } else {
            let means = ["scored", "unreachable", "failed", "explore", "race", "score", "excess"];
            head.extend(means.map(String::from));
        }
        let rows = table.rows.iter().map(|(name, contender)| {
            let outcomes = self.outcomes_of(contender);
            let cells = if self.has_columns() { each(outcomes) } else { means(outcomes) };
            [vec![name.clone()], cells].concat()
        });
        aligned(&[vec![head], rows.collect()].concat())
    }

    fn reports<'t>(&self, tables: &'t [Table]) -> Vec<ComparisonRow<'t>> {
        let rows = tables.iter().flat_map(|table| table.rows.iter().map(move |row| (table, row)));
        rows.flat_map(|(table, (name, contender))| {
            let outcomes = self.mazes.iter().zip(self.outcomes_of(contender));
            outcomes.map(move |(maze, outcome)| ComparisonRow {
                table: table.file,
                name,
                report: TrialReport::new(maze, contender, outcome),
            })
        })
        .collect()
    }

    /// Returns the comparison of the robots in a table, maze by maze.
    fn comparison(&self, table: &Table) -> Comparison {
        let outcomes: Vec<&[TrialResult]> =
            table.rows.iter().map(|(_, contender)| self.outcomes_of(contender)).collect();
        let score = |robot: usize, maze: usize| outcomes[robot][maze].score();
        let measure = |key, name, unit| Measure::new(key, name, unit).with_verb("scored in");
        let robots = table.rows.iter().map(|(name, _)| name.as_str().into()).collect();
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
                let outcome = &outcomes[robot][maze];
                (!outcome.succeeded()).then(|| failure(outcome).to_string())
            })
            .with_limiting_candidate()
    }
}

/// Returns a robot's result in each maze, and the sum of the scores if the robot scored in every
/// maze.
fn each(outcomes: &[TrialResult]) -> Vec<String> {
    let scores: Option<Vec<Score>> = outcomes.iter().map(TrialResult::score).collect();
    let sum = scores.map(|scores| scores.into_iter().map(Score::value).sum::<f64>());
    let sum = sum.map_or("-".into(), |sum| format!("{sum:.3}"));
    outcomes.iter().map(result).chain([sum]).collect()
}

/// Returns three counts: scores, correctly reported unreachable goals, and failures. If there are
/// scores, also returns the means over the mazes with a score.
fn means(outcomes: &[TrialResult]) -> Vec<String> {
    let Means { scored, explore_steps, race_steps, score, excess } = Means::new(outcomes.iter());
    let unreachable = outcomes.iter().filter(|outcome| outcome.is_correctly_given_up()).count();
    let failed = outcomes.len() - scored - unreachable;
    let mut cells = [scored, unreachable, failed].map(|count| count.to_string()).to_vec();
    if scored > 0 {
        cells.extend([explore_steps, race_steps].map(|steps| format!("{steps:.1}")));
        cells.extend([score, excess].map(|score| format!("{score:.3}")));
    }
    cells
}

/// Returns the steps of both runs, and the score or the reason why there is none.
pub(super) fn result(outcome: &TrialResult) -> String {
    let TrialResult { explore_steps, race_steps, .. } = outcome;
    match outcome.ending {
        TrialOutcome::Scored(score) => format!("{explore_steps} + {race_steps} = {score}"),
        TrialOutcome::OutOfTime => format!("{explore_steps} + {race_steps}, out of time"),
        TrialOutcome::GaveUp => format!("{explore_steps} + {race_steps}, gave up"),
        TrialOutcome::Failed => format!("{explore_steps} + {race_steps}, failed"),
    }
}
