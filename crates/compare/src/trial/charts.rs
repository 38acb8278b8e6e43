//! Bar charts of the tables of `mmsim trial --compare`.

use mmsim_maze::counted;
use mmsim_report::{Bar, BarChart, BarGroup};
use mmsim_trial::Score;

use super::result::{Means, TrialResult};
use super::tables::{TrialTable, TrialTables};

/// What the bars of a chart show.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Bars {
    /// The score, divided into the parts of both runs.
    Parts,
    Score,
    ExploreSteps,
    RaceSteps,
}

impl Bars {
    const ALL: [Self; 4] = [Self::Parts, Self::Score, Self::ExploreSteps, Self::RaceSteps];

    /// Returns what follows the name of the table in the name of the file.
    const fn suffix(self) -> &'static str {
        match self {
            Self::Parts => "",
            Self::Score => "-score",
            Self::ExploreSteps => "-explore-steps",
            Self::RaceSteps => "-race-steps",
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Parts | Self::Score => "score",
            Self::ExploreSteps => "explore steps",
            Self::RaceSteps => "race steps",
        }
    }

    /// Returns what follows the name in the title. Few explore steps alone are not better.
    const fn note(self) -> &'static str {
        match self {
            Self::Parts | Self::Score | Self::RaceSteps => ", lower is better",
            Self::ExploreSteps => "",
        }
    }

    /// Returns the lengths of the parts of a bar for a number of steps in each run.
    fn lengths(self, explore_steps: f64, race_steps: f64) -> Vec<f64> {
        match self {
            Self::Parts => vec![race_steps, explore_steps / 30.],
            Self::Score => vec![race_steps + explore_steps / 30.],
            Self::ExploreSteps => vec![explore_steps],
            Self::RaceSteps => vec![race_steps],
        }
    }

    /// Returns the text beside the bar of a trial with a score.
    fn value(self, score: Score) -> String {
        match self {
            Self::Parts | Self::Score => score.to_string(),
            Self::ExploreSteps => score.explore_steps.to_string(),
            Self::RaceSteps => score.race_steps.to_string(),
        }
    }
}

impl TrialTables<'_> {
    /// Returns a table as bar charts with the names of their files: one with the score in two parts,
    /// and one for each of the score, the explore steps and the race steps.
    pub fn charts(&self, table: &TrialTable) -> Vec<(String, BarChart)> {
        let chart =
            |bars: Bars| (format!("{}{}", table.key, bars.suffix()), chart(table, self, bars));
        Bars::ALL.map(chart).into()
    }
}

/// Returns a chart with a group of bars for each maze, or with a single group of means.
fn chart(table: &TrialTable, trials: &TrialTables<'_>, bars: Bars) -> BarChart {
    let rows = || table.rows.iter().map(|(name, one)| (name.clone(), trials.results_of(one)));
    let groups = if trials.has_columns() {
        let group = |(maze, name): (usize, String)| BarGroup {
            name,
            bars: rows().map(|(name, results)| bar(bars, name, &results[maze])).collect(),
            limit: rows().find_map(|(_, results)| results[maze].bound()).map(|score| {
                bars.lengths(score.explore_steps.into(), score.race_steps.into()).iter().sum()
            }),
        };
        let names = trials.mazes.iter().map(|maze| maze.name.clone());
        names.enumerate().map(group).collect()
    } else {
        let name = format!("Means over {} mazes", trials.mazes.len());
        let bars = rows().map(|(name, results)| mean_bar(bars, name, results)).collect();
        vec![BarGroup { name, bars, limit: None }]
    };
    let parts = match bars {
        Bars::Parts => vec!["race steps".into(), "explore steps / 30".into()],
        _ => vec![bars.name().into()],
    };
    BarChart {
        title: format!("{}: {}{}", table.title, bars.name(), bars.note()),
        parts,
        limit: "a robot that knows the maze".into(),
        groups,
    }
}

fn bar(bars: Bars, name: String, result: &TrialResult) -> Bar {
    let value = match result.score() {
        Some(score) if bars != Bars::Parts => bars.value(score),
        _ => result.summary(),
    };
    let lengths = |score: Score| bars.lengths(score.explore_steps.into(), score.race_steps.into());
    Bar { name, parts: result.score().map(lengths), value }
}

fn mean_bar(bars: Bars, name: String, results: &[TrialResult]) -> Bar {
    let Means { scored, explore_steps, race_steps, score, .. } = Means::new(results.iter());
    if scored == 0 {
        return Bar { name, parts: None, value: "no score".into() };
    }
    let value = match bars {
        Bars::Parts => format!("{explore_steps:.1} + {race_steps:.1} = {score:.3}"),
        Bars::Score => format!("{score:.3}"),
        Bars::ExploreSteps => format!("{explore_steps:.1}"),
        Bars::RaceSteps => format!("{race_steps:.1}"),
    };
    let value = format!("{value} in {}", counted(scored, "maze"));
    Bar { name, parts: Some(bars.lengths(explore_steps, race_steps)), value }
}
