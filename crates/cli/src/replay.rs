//! `mmsim replay`: show a recording.

mod state_report;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use jiff::Timestamp;
use jiff::tz::TimeZone;
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{Escaped, counted};
use mmsim_protocol::{Info, StateMessage};
use mmsim_recording::{IgnoredRecords, Integrity, LogLine, MemoryBudget, Recording};
use mmsim_run::EndFacts;
use mmsim_solvers::MazeFacts;
use mmsim_viewer::{DEFAULT_VIEWER_PORT, ViewerConfig};
use serde::{Serialize, Serializer};

use crate::args::{CommandResult, ReadingArgs, ViewerArgs};
use crate::interrupt::Interrupt;
use crate::output::{goal_away, print, print_json};
use crate::recordings::{self, is_undamaged, no_state, recording_budget};
use crate::screen::fitting;
use crate::vehicle::{parse_vehicle, timing_vehicle_help};
use crate::{page, stderr};
use state_report::{PoseAt, StateReport};

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Recording file; if the file is truncated, the intact part is shown
    file: PathBuf,
    /// Further recordings to show beside the first one
    #[arg(value_name = "FILE", requires = "serving")]
    others: Vec<PathBuf>,
    /// Show state N, counted from 0 [default: the last state]
    #[arg(long, value_name = "N")]
    at: Option<usize>,
    #[command(flatten)]
    reading: ReadingArgs,
    /// Print a JSON object
    #[arg(long)]
    json: bool,
    /// Show the recording in a browser until Ctrl-C
    #[arg(long, group = "serving", conflicts_with_all = ["at", "json"])]
    serve: bool,
    /// Port of the viewer page; 0 picks a free port [default: 6575]
    #[arg(long, value_name = "PORT", requires = "serving")]
    viewer_port: Option<u16>,
    /// Open the viewer page in a browser
    #[arg(long, requires = "serving")]
    open: bool,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_vehicle,
        help = timing_vehicle_help()
    )]
    vehicle: Vec<Vehicle>,
}

pub(crate) fn run(args: &ReplayArgs) -> CommandResult {
    let budget = recording_budget(&args.reading);
    let recording = recordings::open(&args.file, &budget)?;
    if args.serve {
        return serve(args, recording, budget);
    }
    let index = args.at.or(recording.history().len().checked_sub(1));
    let default = || Vehicle::default_for(recording.size());
    let mut planner = Planner::new(args.vehicle.first().cloned().unwrap_or_else(default));
    let shown = index.and_then(|index| StateReport::read(&recording, index, &mut planner));
    if let (Some(index), None) = (args.at, &shown) {
        return Err(no_state(&args.file, &recording, index).into());
    }
    if args.json {
        print_json(&ReplayReport::new(args, &recording, shown))?;
    } else {
        print(&text(args, &recording, shown.as_ref()))?;
    }
    Ok(is_undamaged(&args.file, &recording))
}

/// Shows recordings in a browser.
fn serve(args: &ReplayArgs, recording: Recording, budget: Arc<MemoryBudget>) -> CommandResult {
    let open = |file: &PathBuf| recordings::open(file, &budget);
    let others: Vec<Recording> = args.others.iter().map(open).collect::<Result<_, _>>()?;
    let title = |file: &Path| file.file_name().unwrap_or_default().to_string_lossy().to_string();
    let viewer_port = Some(args.viewer_port.unwrap_or(DEFAULT_VIEWER_PORT));
    let (open, vehicle) = (args.open, args.vehicle.clone());
    let viewer_args = ViewerArgs { viewer_port, open, no_viewer: false, vehicle };
    let viewer = page::bind(&viewer_args, "127.0.0.1", false)?;
    let interrupt = Interrupt::catch()?;
    stderr::write_in_background();
    print(&text(args, &recording, None))?;
    let config = ViewerConfig::default().with_budget(budget);
    let mut config = config.with_recording(&title(&args.file), recording);
    for (file, other) in args.others.iter().zip(others) {
        config = config.with_recording(&title(file), other);
    }
    page::serve(viewer, config, &viewer_args)?;
    interrupt.wait();
    Ok(true)
}

/// Formats the summary, the maze and one state of the recording.
fn text(args: &ReplayArgs, recording: &Recording, shown: Option<&StateReport>) -> String {
    let (info, size) = (recording.info(), recording.size());
    let goal = recording.maze().map(|maze| goal_away(MazeFacts::new(maze).shortest_path));
    let goal = goal.map(|goal| format!(", {goal}")).unwrap_or_default();
    let maze = recording.maze().filter(|_| args.at.is_none()).map(|maze| {
        let small = [maze.picture().compact(), maze.picture().narrow()].map(|it| it.to_string());
        fitting(&[&[maze.to_string()], &small[..]].concat()).to_string()
    });
    let names = Names::read(recording);
    let names = names.text().map(|names| format!("{names}\n")).unwrap_or_default();
    let (maze, state) = (maze.unwrap_or_default(), shown.map_or("", |shown| &shown.text));
    let (file, summary) = (Escaped(args.file.display()), summary(recording));
    format!("{file}: {}, {size}{goal}\n{summary}\n{names}{maze}{state}", info.maze)
}

/// The names that the client has sent, or `None` if it has not sent them. The field names are JSON
/// keys.
#[derive(Serialize)]
struct Names {
    mouse: Option<String>,
    strategy: Option<String>,
}

impl Names {
    /// Returns the names at the end of the run.
    fn read(recording: &Recording) -> Self {
        let context = recording.last_context();
        let notes = context.notes();
        let [mouse, strategy] =
            [notes.mouse(), notes.strategy()].map(|name| name.map(String::from));
        Self { mouse, strategy }
    }

    fn text(&self) -> Option<String> {
        let part =
            |label, name: &Option<String>| Some(format!("{label} {}", Escaped(name.as_ref()?)));
        let parts = [part("mouse", &self.mouse), part("strategy", &self.strategy)];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

/// Formats the number of states, the duration and the integrity of the recording.
fn summary(recording: &Recording) -> String {
    let states = counted(recording.history().len(), "state");
    let times = recording.times();
    let time = began(recording).map(|began| {
        let local = began.to_zoned(TimeZone::system()).strftime("%Y-%m-%d %H:%M:%S");
        let seconds = times.seconds(0, times.len().saturating_sub(1));
        format!(" in {seconds:.3} s, from {local}")
    });
    let ending = match recording.integrity() {
        Integrity::Closed => "closed properly".into(),
        Integrity::Truncated { intact, length } => {
            format!("not closed: the first {intact} of {length} bytes are intact")
        }
        Integrity::Damaged { intact, .. } => format!("damaged after byte {intact}"),
    };
    format!("{states}{}, {ending}", time.unwrap_or_default())
}

fn began(recording: &Recording) -> Option<Timestamp> {
    Timestamp::from_nanosecond(recording.times().iter().next()?.into()).ok()
}

/// The JSON report on a recording.
#[derive(Serialize)]
struct ReplayReport<'a> {
    path: &'a Path,
    #[serde(flatten)]
    info: &'a Info,
    #[serde(flatten)]
    names: Names,
    /// The time of the first state, in UTC.
    began: Option<String>,
    /// The integrity of the file: `closed`, `cut` or `damaged`.
    integrity: &'static str,
    /// The length of the intact part in bytes, or `None` if the file was closed properly.
    whole_bytes: Option<u64>,
    ignored: IgnoredRecords,
    drawing: Option<String>,
    /// The pose in each state, or `None` if `--at` is set.
    #[serde(skip_serializing_if = "Option::is_none")]
    poses: Option<Poses<'a>>,
    /// The log lines, or `None` if `--at` is set.
    #[serde(skip_serializing_if = "Option::is_none")]
    log: Option<Vec<LogLine>>,
    /// The state that `--at` selects, or the last state.
    state: Option<StateReport>,
}

/// Serializes the poses in all states as a sequence, decoding them one at a time.
struct Poses<'a>(&'a Recording);

impl Serialize for Poses<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(recording) = self;
        let (history, times) = (recording.history(), recording.times());
        serializer.collect_seq(history.iter().zip(times.iter()).map_while(|(message, time)| {
            let pose = StateMessage::new(&message, recording.size()).ok()?.pose().ok()?;
            Some(PoseAt::new(recording, time, pose))
        }))
    }
}

impl<'a> ReplayReport<'a> {
    fn new(args: &'a ReplayArgs, recording: &'a Recording, state: Option<StateReport>) -> Self {
        let (integrity, whole_bytes) = match recording.integrity() {
            Integrity::Closed => ("closed", None),
            Integrity::Truncated { intact, .. } => ("cut", Some(*intact)),
            Integrity::Damaged { intact, .. } => ("damaged", Some(*intact)),
        };
        Self {
            path: &args.file,
            info: recording.info(),
            names: Names::read(recording),
            began: began(recording).map(|began| began.to_string()),
            integrity,
            whole_bytes,
            ignored: recording.ignored(),
            drawing: recording.maze().map(ToString::to_string),
            poses: args.at.is_none().then_some(Poses(recording)),
            log: args.at.is_none().then(|| own_log(recording)),
            state,
        }
    }
}

/// Returns the log lines of the mouse.
fn own_log(recording: &Recording) -> Vec<LogLine> {
    let is_own = |line: &LogLine| !EndFacts::is_log_line(&line.text);
    recording.log().into_iter().filter(is_own).collect()
}
