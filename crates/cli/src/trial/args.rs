//! The command line of `mmsim trial`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use mmsim_protocol::DEFAULT_PORT;
use mmsim_trial::{BundledRobot, KeyPoints, Settings, Variant};

use super::tried::Contender;
use crate::args::{KeepArgs, ViewerArgs};

const AFTER_HELP: &str = "\
Examples:
  mmsim trial harbour                             a bundled maze
  mmsim trial mazes/ --robot all                  each robot in each maze of a folder
  mmsim trial my-maze.txt --path                  the race and what was explored, drawn
  mmsim trial mazes/ --compare --charts out       compare robots, as tables and as bar charts
  mmsim trial harbour --serve --open              watch a robot in a browser

Exit code 0 says that each robot scored, or said that the goal cannot be reached where that is so;
with --serve and without --once, that it was stopped.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct TrialArgs {
    /// Maze files, folders, which are searched with their subfolders, and words of the path of a
    /// maze in ~/.mmsim or, where that holds none, of a bundled one
    #[arg(required = true, value_name = "MAZE")]
    pub(crate) mazes: Vec<PathBuf>,
    /// The robot; may be given several times [default: champion]
    #[arg(long, value_name = "NAME")]
    robot: Vec<Robots>,
    /// Where all that is random comes from, in robots and in sensors that err
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// How probable it is, 0 to 1, that a sensor reading is wrong by one cell
    #[arg(long, value_name = "P", default_value_t = 0., value_parser = parse_probability)]
    noise: f64,
    /// Over how many corners swing and swing-timed go, 0 to 3
    #[arg(long, value_name = "N", default_value_t)]
    key_points: KeyPoints,
    /// How far swing and swing-timed go to explore
    #[arg(long, default_value_t, value_parser = variants())]
    variant: Variant,
    /// Draw what was explored, and the race in it: in each cell in which a step began, where it
    /// went (U, R, D, L), in those it crossed the same small, X where it reached the goal
    #[arg(long)]
    pub(crate) path: bool,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the tables of a comparison: benchmarks, variants and numbers of key points of swing,
    /// all robots; of many mazes only the means
    #[arg(long, conflicts_with_all = ["robot", "key_points", "variant", "path", "serve"])]
    pub(crate) compare: bool,
    /// Draw a bar chart of each table as an SVG file in this folder
    #[arg(long, value_name = "DIR", requires = "compare")]
    pub(crate) charts: Option<PathBuf>,
    /// Show the trial of one robot in one maze in a browser, until Ctrl-C
    #[arg(long)]
    pub(crate) serve: bool,
    #[command(flatten)]
    pub(crate) watch: WatchArgs,
}

/// What concerns `--serve`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options of --serve")]
pub(crate) struct WatchArgs {
    /// The port to listen on, 0 for any that is free
    #[arg(short, long, default_value_t = DEFAULT_PORT, requires = "serve")]
    pub(crate) port: u16,
    /// Wait this long after each step [default: 50 on a terminal, else 0]
    #[arg(long, value_name = "MS", requires = "serve")]
    pub(crate) pace: Option<u64>,
    /// End after the trial instead of serving on; there is no page then
    #[arg(long, requires = "serve")]
    pub(crate) once: bool,
    #[command(flatten)]
    pub(crate) keep: KeepArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
}

impl WatchArgs {
    /// Whether something is said of keeping states or of the page.
    pub(crate) const fn is_told(&self) -> bool {
        let Self { keep, viewer, .. } = self;
        keep.record.is_some()
            || keep.history_limit.is_some()
            || viewer.viewer_port.is_some()
            || viewer.no_viewer
            || viewer.open
    }
}

impl TrialArgs {
    /// The robots that are asked for and what they are told.
    pub(crate) fn contenders(&self) -> Vec<Contender> {
        self.robots().into_iter().map(|robot| self.contender(robot)).collect()
    }

    /// A robot and what it is told.
    pub(crate) const fn contender(&self, robot: BundledRobot) -> Contender {
        let Self { seed, noise, key_points, variant, .. } = *self;
        Contender { robot, settings: Settings { seed, key_points, variant, noise } }
    }

    /// The robots that are asked for, each once.
    fn robots(&self) -> Vec<BundledRobot> {
        let mut robots = Vec::new();
        for asked in &self.robot {
            let asked: &[BundledRobot] = match asked {
                Robots::All => BundledRobot::ALL,
                Robots::One(robot) => std::slice::from_ref(robot),
            };
            let new = asked.iter().filter(|robot| !robots.contains(*robot));
            robots.extend(new.copied().collect::<Vec<_>>());
        }
        if robots.is_empty() {
            robots.push(BundledRobot::Champion);
        }
        robots
    }
}

fn variants() -> impl TypedValueParser<Value = Variant> {
    PossibleValuesParser::new(Variant::ALL.iter().map(|variant| variant.name()))
        .try_map(|name| name.parse())
}

/// A value of `--robot`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Robots {
    One(BundledRobot),
    All,
}

impl ValueEnum for Robots {
    fn value_variants<'a>() -> &'a [Self] {
        const VALUES: [Robots; BundledRobot::ALL.len() + 1] = {
            let mut values = [Robots::All; BundledRobot::ALL.len() + 1];
            let mut index = 0;
            while index < BundledRobot::ALL.len() {
                values[index] = Robots::One(BundledRobot::ALL[index]);
                index += 1;
            }
            values
        };
        &VALUES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::One(robot) => PossibleValue::new(robot.name()).help(robot.about()),
            Self::All => PossibleValue::new("all").help("all of them"),
        })
    }
}

fn parse_probability(text: &str) -> Result<f64, String> {
    let probability = text.parse().ok().filter(|probability| (0. ..=1.).contains(probability));
    probability.ok_or_else(|| "expected a probability from 0 to 1".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_go_from_0_to_1() {
        assert_eq!(parse_probability("0.25"), Ok(0.25));
        assert_eq!(parse_probability("1"), Ok(1.));
        assert!(
            ["-0.1", "1.01", "nan", "inf", "often", ""]
                .map(parse_probability)
                .iter()
                .all(Result::is_err)
        );
    }
}
