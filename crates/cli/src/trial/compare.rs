//! `mmsim trial --compare`: the tables of the published report afresh, and one of all robots.

use std::fs;
use std::io::{self, IsTerminal};
use std::path::Path;

use mmsim_drawing::{Bar, BarChart, BarGroup};
use mmsim_trial::{BundledRobot, KeyPoints, Score, Settings, TrialOutcome, Variant};
use serde::Serialize;

use super::report::Report;
use super::table::Means;
use super::tried::{Contender, Tried};
use super::{TrialArgs, stand_trial};
use crate::Outcome;
use crate::grid::aligned;
use crate::output::{counted, print, print_json, replace, say};
use crate::selection::Selected;

/// With more mazes than that, only means are told.
const MAX_COLUMNS: usize = 6;

/// How often the random robot is tried, each time with another seed.
const RANDOM_TRIES: u64 = 6;

/// A table: robots, or one robot differently told, against each other.
struct Table {
    title: &'static str,
    /// What its chart is called.
    file: &'static str,
    rows: Vec<(String, Contender)>,
}

/// The tables.
fn tables(args: &TrialArgs) -> Vec<Table> {
    let row = |robot| (BundledRobot::to_string(&robot), args.contender(robot));
    let random = (0..RANDOM_TRIES).map(|more| {
        let mut contender = args.contender(BundledRobot::Random);
        contender.settings.seed = contender.settings.seed.wrapping_add(more);
        (format!("random, seed {}", contender.settings.seed), contender)
    });
    let benchmarks = random.chain([row(BundledRobot::CountExpansion)]).collect();
    let swing = args.contender(BundledRobot::Swing);
    let variants = Variant::ALL.iter().map(|&variant| {
        let settings = Settings { variant, ..swing.settings };
        (variant.to_string(), Contender { settings, ..swing.clone() })
    });
    let key_points = KeyPoints::ALL.iter().map(|&key_points| {
        let settings = Settings { key_points, ..swing.settings };
        (key_points.to_string(), Contender { settings, ..swing.clone() })
    });
    let robots = BundledRobot::ALL.iter().copied().map(row).collect();
    vec![
        Table { title: "Benchmarks", file: "benchmarks", rows: benchmarks },
        Table { title: "Variants of swing", file: "variants", rows: variants.collect() },
        Table { title: "Key points of swing", file: "key-points", rows: key_points.collect() },
        Table { title: "Robots", file: "robots", rows: robots },
    ]
}

/// Puts all that is in the tables on trial. What a robot did is what the tables tell, so that one
/// without a score is no failure here.
pub(crate) fn run(args: &TrialArgs, mazes: &[Selected]) -> Outcome {
    let tables = tables(args);
    let trials = Trials::of(&tables, mazes);
    if args.json {
        print_json(&serde_json::to_string_pretty(&trials.reports(&tables))?)?;
    } else if !mazes.is_empty() {
        let texts = tables.iter().map(|table| trials.text(table));
        print(&texts.collect::<Vec<_>>().join("\n"))?;
    }
    if let Some(folder) = args.charts.as_deref().filter(|_| !mazes.is_empty()) {
        draw(folder, &tables, &trials)?;
    }
    Ok(true)
}

fn draw(folder: &Path, tables: &[Table], trials: &Trials<'_>) -> Result<(), String> {
    let error = |error| format!("{}: cannot be made: {error}", folder.display());
    fs::create_dir_all(folder).map_err(error)?;
    for table in tables {
        let file = folder.join(table.file).with_extension("svg");
        replace(&file, trials.chart(table).svg().as_bytes())?;
    }
    Ok(())
}

/// What came of each trial of a comparison.
struct Trials<'a> {
    mazes: &'a [Selected],
    /// What each contender did in all mazes; one that stands in two tables is tried once.
    tried: Vec<(&'a Contender, Vec<Tried>)>,
}

/// A trial as JSON.
#[derive(Serialize)]
struct Row<'a> {
    table: &'a str,
    #[serde(rename = "row")]
    name: &'a str,
    #[serde(flatten)]
    report: Report,
}

impl<'a> Trials<'a> {
    fn of(tables: &'a [Table], mazes: &'a [Selected]) -> Self {
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
            say(format_args!("running {}", counted(jobs.len() as u64, "trial")));
        }
        let mut tried = stand_trial(&jobs).into_iter();
        let of_each = contenders.into_iter();
        let tried = of_each.map(|one| (one, tried.by_ref().take(mazes.len()).collect()));
        Self { mazes, tried: tried.collect() }
    }

    fn of_contender(&self, contender: &Contender) -> &[Tried] {
        self.tried.iter().find(|(other, _)| *other == contender).map_or(&[], |(_, tried)| tried)
    }

    fn has_columns(&self) -> bool {
        self.mazes.len() <= MAX_COLUMNS
    }

    /// A table as text: a column for each maze, or the means.
    fn text(&self, table: &Table) -> String {
        let mut head = vec![table.title.to_string()];
        if self.has_columns() {
            head.extend(self.mazes.iter().map(|maze| maze.name.clone()));
            head.push("sum".into());
        } else {
            let means = ["scored", "unreachable", "failed", "explore", "race", "score", "over"];
            head.extend(means.map(String::from));
        }
        let rows = table.rows.iter().map(|(name, contender)| {
            let tried = self.of_contender(contender);
            let cells = if self.has_columns() { each(tried) } else { means(tried) };
            [vec![name.clone()], cells].concat()
        });
        aligned(&[vec![head], rows.collect()].concat())
    }

    fn reports<'t>(&self, tables: &'t [Table]) -> Vec<Row<'t>> {
        let rows = tables.iter().flat_map(|table| table.rows.iter().map(move |row| (table, row)));
        rows.flat_map(|(table, (name, contender))| {
            let tried = self.mazes.iter().zip(self.of_contender(contender));
            tried.map(move |(maze, tried)| Row {
                table: table.file,
                name,
                report: Report::of(maze, contender, tried),
            })
        })
        .collect()
    }

    /// A table as bars: a group for each maze, or the means.
    fn chart(&self, table: &Table) -> BarChart {
        let rows = || table.rows.iter().map(|(name, of)| (name.clone(), self.of_contender(of)));
        let from_maze = |(index, maze): (usize, &Selected)| BarGroup {
            name: maze.name.clone(),
            bars: rows().map(|(name, tried)| bar(name, &tried[index])).collect(),
            limit: rows().find_map(|(_, tried)| Some(tried[index].bound()?.value())),
        };
        let groups = if self.has_columns() {
            self.mazes.iter().enumerate().map(from_maze).collect()
        } else {
            let name = format!("Means over {} mazes", self.mazes.len());
            let bars = rows().map(|(name, tried)| mean_bar(name, tried)).collect();
            vec![BarGroup { name, bars, limit: None }]
        };
        BarChart {
            title: format!("{}: score, less is better", table.title),
            parts: ["race steps".into(), "explore steps / 30".into()],
            limit: "a robot that knows the maze".into(),
            groups,
        }
    }
}

/// What a robot did in each maze, and the sum of its scores if it has one in each.
fn each(tried: &[Tried]) -> Vec<String> {
    let scores: Option<Vec<Score>> = tried.iter().map(Tried::score).collect();
    let sum = scores.map(|scores| scores.into_iter().map(Score::value).sum::<f64>());
    let sum = sum.map_or("-".into(), |sum| format!("{sum:.3}"));
    tried.iter().map(result).chain([sum]).collect()
}

/// In how many mazes a robot scored, said rightly that the goal cannot be reached, and did neither;
/// and the means over the first.
fn means(tried: &[Tried]) -> Vec<String> {
    let Means { scored, explore_steps, race_steps, score, over } = Means::of(tried.iter());
    let unreachable = tried.iter().filter(|tried| tried.is_rightly_given_up()).count();
    let failed = tried.len() - scored - unreachable;
    let mut cells = [scored, unreachable, failed].map(|count| count.to_string()).to_vec();
    if scored > 0 {
        cells.extend([explore_steps, race_steps].map(|steps| format!("{steps:.1}")));
        cells.extend([score, over].map(|score| format!("{score:.3}")));
    }
    cells
}

fn result(tried: &Tried) -> String {
    let Tried { explore_steps, race_steps, .. } = tried;
    match tried.ending {
        TrialOutcome::Scored(score) => format!("{explore_steps} + {race_steps} = {score}"),
        TrialOutcome::OutOfTime => "out of time".into(),
        TrialOutcome::GaveUp => "gave up".into(),
    }
}

fn bar(name: String, tried: &Tried) -> Bar {
    let parts =
        |score: Score| [f64::from(score.race_steps), score.value() - f64::from(score.race_steps)];
    Bar { name, parts: tried.score().map(parts), value: result(tried) }
}

fn mean_bar(name: String, tried: &[Tried]) -> Bar {
    let Means { scored, explore_steps, race_steps, score, .. } = Means::of(tried.iter());
    if scored == 0 {
        return Bar { name, parts: None, value: "no score".into() };
    }
    let steps = format!("{explore_steps:.1} + {race_steps:.1} = {score:.3}");
    let parts = Some([race_steps, score - race_steps]);
    Bar { name, parts, value: format!("{steps} in {}", counted(scored as u64, "maze")) }
}
