//! The mice of `mmsim compare` and `mmsim contest`, and their searches.

use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_compare::{ComparedMouse, Exploration, NamedMaze, NamedMouse, Searches};
use mmsim_fastrun::Vehicle;
use mmsim_mouse::{SearchLimits, Shortage};
use mmsim_run::{SearchFigures, Senses};
use mmsim_solvers::{BundledStrategy, Tolerance};

use crate::args::{MisreadArgs, UsageError, each_once, one_of, parse_seconds};
use crate::interrupt::StopFlag;
use crate::local_server::raise_file_limit;
use crate::selection::{DEFAULT_MAZES, MAZES_HELP};
use crate::solve::strategy_value;
use crate::terminal::progress_bar;

/// The limit of open files to request from the system.
const MAX_FILES: u64 = 4096;

/// The default time limit of a mouse in a maze, in s.
pub(crate) const DEFAULT_TIME_LIMIT: &str = "10";

/// The mazes, the mice and their limits.
#[derive(Debug, Args)]
pub(crate) struct SearchArgs {
    #[arg(value_name = "MAZE", help = format!("{MAZES_HELP} [default: all in {DEFAULT_MAZES}]"))]
    pub(crate) mazes: Vec<PathBuf>,
    /// Run a mouse of your own: a mouse for mms, or a client of the ZeroMQ protocol. The words of
    /// COMMAND may be quoted; may be repeated
    #[arg(long, value_name = "NAME=COMMAND")]
    mouse: Vec<NamedMouse>,
    /// Comma-separated list of strategies; may be repeated
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "all",
        value_parser = strategies()
    )]
    strategies: Vec<&'static [BundledStrategy]>,
    /// Let fastest-path-search stop exploring when its run is proven to be at most SHARE slower than
    /// the fastest run, such as 3% or 0.03 [default: 0%]
    #[arg(long, value_name = "SHARE")]
    pub(crate) tolerance: Option<Tolerance>,
    /// Stop the program of a mouse of your own after S seconds in a maze
    #[arg(long, value_name = "S", default_value = DEFAULT_TIME_LIMIT, requires = "mouse", value_parser = parse_seconds)]
    pub(crate) time_limit: Duration,
    /// Stop a mouse of your own after N states in a maze: one for each cell that it enters and one for
    /// each turn
    #[arg(long, value_name = "N", default_value_t = 10_000, requires = "mouse", value_parser = clap::value_parser!(u32).range(1..))]
    max_states: u32,
    #[command(flatten)]
    misread: MisreadArgs,
    /// Let strategies recover from wrong readings
    #[arg(long, requires = "misread")]
    recover: bool,
    /// Run N searches at a time [default: the number of processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
}

impl SearchArgs {
    /// Returns the user's mice and then the selected strategies, each once. `command` is the command
    /// for usage errors.
    pub(crate) fn select(&self, command: &'static str) -> Result<Vec<ComparedMouse>, UsageError> {
        let own = self.mouse.iter().cloned().map(ComparedMouse::Own);
        let bundled = each_once(&self.strategies).into_iter().map(ComparedMouse::Bundled);
        let mice: Vec<ComparedMouse> = own.chain(bundled).collect();
        for (index, mouse) in mice.iter().enumerate() {
            let name = mouse.name();
            if mice[..index].iter().any(|other| other.name() == name) {
                let message = format!("two mice are called {name:?}; choose another NAME");
                return Err(UsageError::new(command, message));
            }
        }
        for mouse in &self.mouse {
            if let Some(file) = mouse.program.missing_file() {
                let message = format!("{}: {} does not exist", mouse.name, file.display());
                return Err(UsageError::new(command, message));
            }
        }
        if mice.is_empty() {
            let message = "no mice: --strategies none requires --mouse";
            return Err(UsageError::new(command, message));
        }
        let uses_vehicle = |mouse: &ComparedMouse| match mouse {
            ComparedMouse::Bundled(strategy) => strategy.uses_vehicle(),
            ComparedMouse::Own(_) => false,
        };
        if self.tolerance.is_some() && !mice.iter().any(uses_vehicle) {
            let message = "--tolerance has no effect without fastest-path-search";
            return Err(UsageError::new(command, message));
        }
        Ok(mice)
    }

    /// Returns how mice read walls.
    pub(crate) fn senses(&self) -> Senses {
        Senses { misreadings: self.misread.misreadings(), recovers: self.recover }
    }

    /// Runs the mice in all mazes, and shows a progress bar on a terminal. Strategies explore for the
    /// vehicle, or for the default one of each maze. If `stops_at_goal` is true, the searches of the
    /// user's mice end at the goal. These searches are run `repetitions` times, of which the first one
    /// counts and the others may differ. After Ctrl-C, stops the mice of the user and exits.
    pub(crate) fn run(
        &self,
        mice: &[ComparedMouse],
        mazes: &[NamedMaze],
        vehicle: Option<Vehicle>,
        stops_at_goal: bool,
        repetitions: u16,
    ) -> Result<Vec<Vec<SearchFigures>>, Box<dyn Error>> {
        let has_own = mice.iter().any(ComparedMouse::is_own);
        if has_own {
            // Each search needs about twelve open files. If the request fails, the limit may suffice.
            raise_file_limit(MAX_FILES);
        }
        let stop = StopFlag::catch_if(has_own)?;
        let own: Vec<_> = mice.iter().filter(|mouse| mouse.is_own()).cloned().collect();
        let length = mazes.len() * (mice.len() + usize::from(repetitions - 1) * own.len());
        let bar = progress_bar(Some(length as u64), "{pos} of {len} searches, {eta} left");
        let searches = Searches {
            exploration: &Exploration::new(vehicle, self.tolerance.unwrap_or_default()),
            senses: self.senses(),
            limits: SearchLimits { time: self.time_limit, states: self.max_states, stops_at_goal },
            max_states: None,
            jobs: self.jobs,
        };
        let run = |mice: &[_]| searches.run(mice, mazes, &|| bar.inc(1), || stop.is_set());
        let mut figures = run(mice);
        for repetition in 2..=repetitions {
            let Ok(first) = &mut figures else { break };
            match run(&own) {
                // The user's mice come first.
                Ok(others) => first
                    .iter_mut()
                    .flatten()
                    .zip(others.iter().flatten())
                    .for_each(|(figures, other)| figures.compare_repetition(repetition, other)),
                Err(shortage) => figures = Err(shortage),
            }
        }
        stop.end();
        figures.map_err(|shortage| explain_shortage(&shortage))
    }
}

/// Returns the error for something that the system lacks even for one program at a time.
pub(crate) fn explain_shortage(shortage: &Shortage) -> Box<dyn Error> {
    format!("{shortage} (end other programs, or raise the limits of this process)").into()
}

/// Parses the name of a strategy, `all` or `none`.
fn strategies() -> impl TypedValueParser<Value = &'static [BundledStrategy]> {
    let all = BundledStrategy::ALL;
    one_of(all.chunks(1).chain([all, &[]]), |strategies| match strategies {
        [] => PossibleValue::new("none").help("only your own mice"),
        [strategy] => strategy_value(*strategy),
        _ => PossibleValue::new("all").help("all strategies"),
    })
}
