//! `mmsim solve`: run a bundled strategy against a simulator.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Duration;
use std::{io, thread};

use clap::Args;
use clap::builder::PossibleValue;
use mmsim_client::{BrokenRun, Named, SearchRun, Transport, search_run_with};
use mmsim_compare::Exploration;
use mmsim_fastrun::Vehicle;
use mmsim_maze::Pose;
use mmsim_protocol::Info;
use mmsim_recording::Clock;
use mmsim_run::{Ending, FastestRun, MovementRules, PhaseReport, Verdict};
use mmsim_solvers::{BundledStrategy, Mouse, SearchDriver, Strategy, Tolerance, WallVotes};
use serde::Serialize;

use crate::args::{
    CommandResult, KnownMazeArgs, RECORDING, RecordingArgs, UsageError, one_of, parse_seconds,
};
use crate::connection::{
    KnownSimulator, ask_maze, connect, endpoint, endpoint_help, explain, maze_from_args,
};
use crate::grid::wrapped;
use crate::output::{print, print_json, warn};
use crate::phase_table::PhaseTimes;
use crate::recording_transport::RecordingTransport;
use crate::screen::{Screen, goal_text};
use crate::vehicle::{VEHICLES, parse_vehicle};

#[derive(Debug, Args)]
#[command(override_usage = "mmsim solve <STRATEGY> [OPTIONS]")]
pub(crate) struct SolveArgs {
    /// Search strategy
    #[arg(value_parser = one_of(BundledStrategy::ALL.iter().copied(), strategy_value))]
    strategy: BundledStrategy,
    #[arg(
        long,
        value_name = "ENDPOINT",
        help = endpoint_help("Address of the simulator, which may start later,")
    )]
    connect: Option<String>,
    #[command(flatten)]
    known: KnownMazeArgs,
    /// Give up after sending N states: one for the start and one for each step [default: 10000 for
    /// swing, shortest-path-search and fastest-path-search, which also return to the start; 1000 for
    /// the others]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_steps: Option<u32>,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_vehicle,
        help = format!(
            "Vehicle that times the runs, and whose fastest run fastest-path-search explores for: \
             {VEHICLES} [default: {}]",
            Vehicle::DEFAULTS
        )
    )]
    vehicle: Option<Vehicle>,
    /// Let fastest-path-search stop exploring when its run is proven to be at most SHARE slower than
    /// the fastest run, such as 3% or 0.03 [default: 0%]
    #[arg(long, value_name = "SHARE")]
    tolerance: Option<Tolerance>,
    /// Recover from wrong wall readings, for a simulator that runs with --misread
    #[arg(long)]
    recover: bool,
    /// Wait MS milliseconds after each step and, unless MS is 0, draw each step on the terminal
    #[arg(long, value_name = "MS", default_value_t = 0)]
    pace: u64,
    /// Record the acknowledged states to FILE, which must not exist; view it with `mmsim replay`
    #[arg(long, value_name = "FILE", group = RECORDING)]
    record: Option<PathBuf>,
    #[command(flatten)]
    recording: RecordingArgs,
    /// Give up if a reply takes longer than S seconds [default: no limit for the first reply, 10
    /// for each later reply; no limit if started by `mmsim run`]
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    timeout: Option<Duration>,
    /// Print a JSON object
    #[arg(long)]
    json: bool,
}

impl SolveArgs {
    /// Returns the vehicle and the tolerance, or an error if the strategy does not use the tolerance.
    fn exploration(&self) -> Result<Exploration, UsageError> {
        if self.tolerance.is_some() && !self.strategy.uses_vehicle() {
            let message =
                format!("{} has no --tolerance; only fastest-path-search does", self.strategy);
            return Err(UsageError::new("solve", message));
        }
        Ok(Exploration::new(self.vehicle.clone(), self.tolerance.unwrap_or_default()))
    }
}

/// Returns the name of a strategy, with its description for the help text.
pub(crate) fn strategy_value(strategy: BundledStrategy) -> PossibleValue {
    PossibleValue::new(strategy.name()).help(strategy.about())
}

pub(crate) fn run(args: &SolveArgs) -> CommandResult {
    let strategy = args.strategy;
    let exploration = args.exploration()?;
    let known = maze_from_args("solve", &args.known)?;
    let endpoint = endpoint(args.connect.as_deref());
    let mut transport = connect(&endpoint, args.timeout, known.is_none())?;
    let known = known.map_or_else(|| ask_maze(&mut transport, args.known.size), Ok);
    let prepared = known.and_then(|KnownSimulator { name, map, start, has_annotations }| {
        // The address replaces an unknown name of the maze.
        let name = name.as_ref().unwrap_or(&endpoint);
        let mut info = Info::new(name, map.size(), start, map.goals(), 0);
        if !has_annotations {
            info.extensions.clear();
        }
        let file = args.record.as_deref();
        let description = (&info, map.size());
        let recording = RecordingTransport::new(transport, file, args.recording, description);
        let recording = recording.map_err(|error| match &args.record {
            Some(file) if file.exists() => format!("{error} (--record needs a new file)"),
            _ => error.to_string(),
        });
        let times = PhaseTimes::new(MovementRules::new(start, *map.goals(), None));
        Ok((map, start, has_annotations, recording?, times))
    });
    let (map, start, has_annotations, mut recording, mut times) = match prepared {
        Ok(prepared) => prepared,
        Err(error) if args.json => {
            let report = SolveReport {
                mouse: strategy.name(),
                ending: Ending::Failed,
                error: Some(error),
                ..SolveReport::default()
            };
            print_json(&report)?;
            return Ok(false);
        }
        Err(error) => return Err(error.into()),
    };
    let mut mouse = Mouse::new(exploration.strategy(strategy, map.size()), map, start);
    let pace = Duration::from_millis(args.pace);
    let max_steps = args.max_steps.unwrap_or(strategy.max_states());
    let clock = Clock::start();
    let mut screen = Screen::new(strategy, !pace.is_zero() && !args.json);
    let mut shown = Ok(());
    let mut named;
    let mut transport: &mut dyn Transport = &mut recording;
    if has_annotations {
        named = Named::new(transport, mmsim_client::BUNDLED_MOUSE_NAME, strategy.name())?;
        transport = &mut named;
    }
    let mut votes = args.recover.then(WallVotes::new);
    let driver = SearchDriver::new(&mut mouse, max_steps).recovering(votes.as_mut());
    let result = search_run_with(&mut transport, driver, |mouse, run| {
        let added = times.add(mouse.pose(), clock.now());
        shown = added.map_err(io::Error::other).and_then(|()| screen.show(mouse, run));
        thread::sleep(pace);
        if shown.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    shown?;
    let (run, error) =
        result.map_or_else(|BrokenRun { run, error }| (run, Some(error)), |run| (run, None));
    let recorded = recording.close().map_err(|error| format!("incomplete recording: {error}"));
    let size = mouse.map().size();
    let mut planner = exploration.planner(size).clone();
    let fastest_run = FastestRun::new(mouse.map(), &mut planner);
    let phases = times.report(&mut planner, size);
    let ending = match &error {
        Some(error) if error.is_given_up() => Ending::GaveUp,
        Some(_) => Ending::Failed,
        None if run.is_at_limit => Ending::StepLimit,
        None => Ending::Finished,
    };
    let reason = error.as_ref().map(ToString::to_string);
    let mut verdict = Verdict::from_goal(run.stats.goal_reached(), ending, reason, None);
    let has_succeeded = verdict.ending == Ending::Finished && recorded.is_ok();
    if args.json {
        verdict.error = verdict.error.or_else(|| recorded.clone().err());
        let fastest_run = Some(fastest_run);
        print_json(&SolveReport::new(strategy.name(), &run, &mouse, phases, fastest_run, verdict))?;
    } else {
        if run.states > 0 {
            screen.finish(&mouse, &run, &goal_text(&run), phases)?;
            print(&(wrapped(&fastest_run.to_string(), " ", 2) + "\n"))?;
        }
        if let Err(error) = &recorded {
            warn(error);
        }
    }
    match error {
        Some(error) if !args.json => Err(explain(&error).into()),
        _ => {
            if ending == Ending::StepLimit {
                warn(format_args!("gave up at the limit of {max_steps} states (see --max-steps)"));
            }
            Ok(has_succeeded)
        }
    }
}

/// The JSON report of a search. The optional fields are null if no search took place.
#[derive(Default, Serialize)]
struct SolveReport<'a> {
    mouse: &'a str,
    goal_reached: bool,
    ending: Ending,
    /// The steps of all phases.
    steps: u32,
    /// The quarter turns of all phases.
    turns: u32,
    phases: Option<PhaseReport>,
    states: u32,
    requests: u32,
    visited_cells: usize,
    width: Option<u8>,
    height: Option<u8>,
    cell: Option<[u8; 2]>,
    heading: Option<char>,
    map: Option<String>,
    #[serde(flatten)]
    fastest_run: Option<FastestRun>,
    error: Option<String>,
}

impl<'a> SolveReport<'a> {
    fn new<S: Strategy>(
        strategy: &'a str,
        run: &SearchRun,
        mouse: &Mouse<S>,
        phases: Option<PhaseReport>,
        fastest_run: Option<FastestRun>,
        verdict: Verdict,
    ) -> Self {
        let Pose { cell, heading } = mouse.pose();
        let size = mouse.map().size();
        Self {
            mouse: strategy,
            goal_reached: verdict.goal_reached,
            ending: verdict.ending,
            steps: run.stats.steps(),
            turns: run.stats.turns(),
            phases,
            states: run.states,
            requests: run.requests,
            visited_cells: mouse.map().visited().len(),
            width: Some(size.width()),
            height: Some(size.height()),
            cell: Some([cell.x, cell.y]),
            heading: Some(heading.letter()),
            map: Some(mouse.map().picture().to_string()),
            fastest_run,
            error: verdict.error,
        }
    }
}
