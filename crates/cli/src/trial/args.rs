//! Arguments of `mmsim trial`.

use std::error::Error;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Args, Command, FromArgMatches, ValueHint};
use mmsim_compare::{OwnRobot, RobotKind, TrialRobot};
use mmsim_drawing::Theme;
use mmsim_mouse::Program;
use mmsim_protocol::DEFAULT_PORT;
use mmsim_trial::{BundledRobot, KeyPoints, Settings, Variant};

use super::results::ResultForm;
use crate::args::{
    RetentionArgs, UsageError, ViewerArgs, each_once, extension, one_of, parse_probability,
    parse_seconds, wrong_extension,
};
use crate::picture::{PictureFile, PictureFormat, parse_picture, themes};
use crate::selection::MAZES_HELP;

const AFTER_HELP: &str = "\
Examples:
  mmsim trial harbour                             run a robot in a bundled maze
  mmsim trial mazes/ --robot all                  run each robot in each maze of a folder
  mmsim trial my-maze.txt --path                  draw the explored maze and the race
  mmsim trial harbour -o race.svg                 draw the paths of both runs as a picture
  mmsim trial mazes/ --compare --charts out       compare robots in tables and charts
  mmsim trial harbour --serve --open              watch a robot in a browser
  mmsim trial mazes/ --published my_robot.py      run a robot with the published interface
  mmsim trial mazes/ --published my_robot.py dfs  give it a word of the published command line
  mmsim trial mazes/ -- ./my-robot                run your own robot, in any language

The exit code is 0 if each robot scored or correctly reported an unreachable goal. With --serve and
without --once, it is 0 after Ctrl-C.";

/// clap would put the mazes after `--published`, where they would be words of the robot.
const USAGE: &str = "mmsim trial <MAZE>... [OPTIONS] [-- <COMMAND>...]";

/// The time after which a robot that does not answer is stopped.
pub(crate) const DEFAULT_ANSWER_LIMIT: Duration = Duration::from_secs(10);

const PUBLISHED_HELP: &str = "\
    Run a robot.py with the published interface, which has a class Robot. Put the mazes before \
    this option: each WORD after FILE follows the maze in the sys.argv of the robot. May be \
    repeated";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, override_usage = USAGE)]
#[command(group(ArgGroup::new("pictures").multiple(true)))]
#[command(group(ArgGroup::new("own").multiple(true)))]
pub(crate) struct TrialArgs {
    #[arg(required = true, value_name = "MAZE", help = MAZES_HELP)]
    pub(crate) mazes: Vec<PathBuf>,
    /// Bundled robot to run; may be repeated [default: champion, unless you run your own robot]
    #[arg(long, value_name = "NAME", value_parser = robots())]
    robot: Vec<&'static [BundledRobot]>,
    /// Run swing step by step like the published program (with --robot swing)
    #[arg(long)]
    as_published: bool,
    /// Your own robot: a program and its arguments. It reads the sensors from stdin and writes its
    /// answers to stdout, see docs/robots.md
    #[arg(last = true, value_name = "COMMAND", group = "own")]
    command: Vec<OsString>,
    #[command(flatten)]
    published: PublishedArgs,
    /// Python for the robots of --published [default: the Python 3 or 2 on the PATH that accepts the file]
    #[arg(long, value_name = "EXE", requires = "published")]
    python: Option<PathBuf>,
    /// Stop your own robot if an answer takes longer than S seconds [default: 10]
    #[arg(long, value_name = "S", requires = "own", value_parser = parse_seconds)]
    answer_limit: Option<Duration>,
    /// Random seed for robots and noisy sensors
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Probability that a sensor reading is off by one cell, such as 1% or 0.01
    #[arg(long, value_name = "P", default_value_t = 0., value_parser = parse_probability)]
    noise: f64,
    /// Number of corners to visit, 0 to 3 (swing, swing-as-published and swing-timed only) [default:
    /// 3]
    #[arg(long, value_name = "N")]
    key_points: Option<KeyPoints>,
    /// Places to visit while exploring (swing, swing-as-published and swing-timed only) [default: all]
    #[arg(long, value_parser = variants())]
    variant: Option<Variant>,
    /// Draw the explored maze and the race. A step is drawn as U, R, D or L in its first cell and
    /// as the same letter in lowercase in any further cells. X marks the goal
    #[arg(long)]
    pub(crate) path: bool,
    /// Draw the explored cells and the paths of both runs in one maze, or the races of several robots:
    /// .svg or .png. An existing file is replaced
    #[arg(short, long, value_name = "FILE", group = "pictures", conflicts_with = "serve", value_parser = parse_still)]
    pub(crate) output: Option<PictureFile>,
    /// Draw the key points of swing and the legs between them on one maze: .svg or .png
    #[arg(long, value_name = "FILE", group = "pictures", conflicts_with = "serve", value_parser = parse_still)]
    pub(crate) tour: Option<PictureFile>,
    /// Colour theme of the pictures
    #[arg(long, default_value = "light", requires = "pictures", value_parser = themes())]
    pub(crate) theme: Theme,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
    /// Print four tables: benchmark robots, variants of swing, swing by number of key points, and
    /// all robots. With more than 6 mazes, the tables show only means
    #[arg(long, group = "comparison", conflicts_with_all = ["robot", "as_published", "key_points", "variant", "path", "output", "tour", "serve"])]
    pub(crate) compare: bool,
    /// Draw the scores, explore steps and race steps of all robots as charts in DIR
    #[arg(long, value_name = "DIR", requires = "comparison")]
    pub(crate) charts: Option<PathBuf>,
    /// Write a report on all robots to FILE: one HTML page with tables, charts and pictures
    #[arg(long, value_name = "FILE", requires = "comparison")]
    pub(crate) html: Option<PathBuf>,
    /// Show the trial of one robot in one maze in a browser until Ctrl-C
    #[arg(long, group = "serving")]
    pub(crate) serve: bool,
    #[command(flatten)]
    pub(crate) watch: WatchArgs,
}

/// Each robot of `--published FILE [WORD]...`. The option may be repeated, so `derive` would join the
/// words of all robots.
#[derive(Debug)]
struct PublishedArgs(Vec<Vec<OsString>>);

impl Args for PublishedArgs {
    fn augment_args(command: Command) -> Command {
        let published = Arg::new("published")
            .long("published")
            .value_names(["FILE", "WORD"])
            .num_args(1..)
            .action(ArgAction::Append)
            .value_parser(clap::value_parser!(OsString))
            .value_hint(ValueHint::FilePath)
            .group("own")
            .help(PUBLISHED_HELP);
        command.arg(published)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for PublishedArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let robots = matches.get_occurrences("published").into_iter().flatten();
        Ok(Self(robots.map(|words| words.cloned().collect()).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        Self::from_arg_matches(matches).map(|robots| *self = robots)
    }
}

/// Options for `--serve`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options for --serve")]
pub(crate) struct WatchArgs {
    /// Port to listen on; 0 picks a free port
    #[arg(short, long, default_value_t = DEFAULT_PORT, requires = "serving")]
    pub(crate) port: u16,
    /// Wait MS milliseconds after each step [default: 50 on a terminal, else 0]
    #[arg(long, value_name = "MS", requires = "serving")]
    pub(crate) pace: Option<u64>,
    /// Exit after the trial, without serving a viewer page
    #[arg(long, requires = "serving", conflicts_with_all = ["viewer_port", "open", "vehicle"])]
    pub(crate) once: bool,
    #[command(flatten)]
    pub(crate) retention: RetentionArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
}

impl WatchArgs {
    /// Returns true if any recording, history or viewer option is set.
    pub(crate) fn is_set(&self) -> bool {
        self.retention != RetentionArgs::default() || self.viewer != ViewerArgs::default()
    }
}

impl TrialArgs {
    /// Returns the selected bundled robots and the user's robots, with the settings from the command
    /// line.
    ///
    /// # Errors
    /// Returns a usage error if an option does not match the robots or if a robot's file is missing, and
    /// another error if there is no Python for a robot.
    pub(crate) fn robots(&self) -> Result<Vec<TrialRobot>, Box<dyn Error>> {
        let mut own = self.own_robots()?;
        let mut robots = each_once(&self.robot);
        if robots.is_empty() && own.is_empty() {
            robots.push(BundledRobot::Champion);
        }
        if self.as_published {
            let error = || UsageError::new("trial", "--as-published requires --robot swing");
            let swing = robots.iter_mut().find(|robot| **robot == BundledRobot::Swing);
            *swing.ok_or_else(error)? = BundledRobot::SwingAsPublished;
            robots = each_once(&[&robots]);
        }
        let settings = self.settings();
        if (self.key_points.is_some() || self.variant.is_some())
            && !robots.iter().any(|robot| robot.has_key_points())
        {
            let message = "--key-points and --variant require a robot: swing, swing-as-published or swing-timed";
            return Err(UsageError::new("trial", message).into());
        }
        let bundled = |robot| TrialRobot { kind: RobotKind::Bundled(robot), settings };
        let mut robots: Vec<TrialRobot> = robots.into_iter().map(bundled).collect();
        robots.append(&mut own);
        Ok(robots)
    }

    /// Returns how outcomes are printed.
    pub(crate) const fn form(&self) -> ResultForm {
        ResultForm { path: self.path, json: self.json }
    }

    /// Returns the settings of all robots.
    pub(crate) fn settings(&self) -> Settings {
        let Self { seed, noise, key_points, variant, .. } = *self;
        let (key_points, variant) = (key_points.unwrap_or_default(), variant.unwrap_or_default());
        Settings { seed, key_points, variant, noise }
    }

    /// Returns the user's robots.
    pub(crate) fn own_robots(&self) -> Result<Vec<TrialRobot>, Box<dyn Error>> {
        let mut programs = Vec::new();
        if !self.command.is_empty() {
            programs.push(Program::new(&self.command));
        }
        for robot in &self.published.0 {
            let Some((file, words)) = robot.split_first() else { continue };
            let (file, python) = (Path::new(file), self.python.as_deref().map(Path::as_os_str));
            if !file.is_file() {
                let message = format!("--published: {} is not a file", file.display());
                return Err(UsageError::new("trial", message).into());
            }
            let program = Program::from_published_robot(file, words, python)
                .map_err(|error| format!("cannot run {}: {error}", file.display()))?;
            programs.push(program);
        }
        let named = |(index, program): (usize, &Program)| {
            let same = programs[..index].iter().filter(|other| other.name == program.name).count();
            let name = match same {
                0 => program.name.clone(),
                _ => format!("{} ({})", program.name, same + 1),
            };
            let answer_limit = self.answer_limit.unwrap_or(DEFAULT_ANSWER_LIMIT);
            let program = program.clone();
            let kind = RobotKind::Own(OwnRobot { name, program, answer_limit });
            TrialRobot { kind, settings: self.settings() }
        };
        Ok(programs.iter().enumerate().map(named).collect())
    }
}

fn robots() -> impl TypedValueParser<Value = &'static [BundledRobot]> {
    let all = BundledRobot::ALL;
    one_of(all.chunks(1).chain([all]), |robots| match robots {
        [robot] => PossibleValue::new(robot.name()).help(robot.about()),
        _ => PossibleValue::new("all").help("all robots"),
    })
}

fn variants() -> impl TypedValueParser<Value = Variant> {
    one_of(Variant::ALL.iter().copied(), |variant| variant.name().into())
}

/// Parses the path of a picture that is not animated.
fn parse_still(text: &str) -> Result<PictureFile, String> {
    let picture = parse_picture(text).ok().filter(|picture| picture.format != PictureFormat::Gif);
    picture.ok_or_else(|| wrong_extension(".svg or .png", &extension(text.as_ref())))
}
