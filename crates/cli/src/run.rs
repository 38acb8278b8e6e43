//! `mmsim run`: run the user's own mouse.

mod button;
mod judged;
mod serving;

use std::cell::Cell;
use std::error::Error;
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::PathBuf;
use std::str::FromStr as _;
use std::sync::Arc;
use std::time::Duration;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Args, value_parser};
use mmsim_client::Transport;
use mmsim_compare::{OwnRobot, RobotKind, TrialRobot};
use mmsim_fastrun::Vehicle;
use mmsim_maze::{KnownMaze, Misreadings, WallSensor};
use mmsim_mms::ScoreRules;
use mmsim_mouse::{
    ClientExit, ExitCause, Gateway, GatewayRun, MouseControl, MouseKind, MouseProcess, PipedMouse,
    Program, RunEnd, Runs, Session, StartError,
};
use mmsim_server::{Monitor, Served, listen};
use mmsim_solvers::BundledStrategy;
use mmsim_trial::Settings;

use crate::args::{KnownMazeArgs, ServerArgs, UsageError, one_of, parse_seconds};
use crate::connection::{
    ENDPOINT_FORM, KnownSimulator, ask_maze, connect, endpoint, explain, maze_from_args,
};
use crate::interrupt::Interrupt;
use crate::local_server::{HOST, bind_or_free, in_process};
use crate::output::{note, print, print_json, warn};
use crate::selection::{DEFAULT_MAZES, MAZE_HELP};
use crate::trial::{DEFAULT_ANSWER_LIMIT, ResultForm, run_watched};
use button::press_on_input;
use judged::{Judgements, judge, note_judged};
use serving::{Serving, control, serve};

const AFTER_HELP: &str = "\
Examples:
  mmsim run --open ./my-mouse                    watch the mouse in a browser
  mmsim run --open --watch python3 mouse.py      run it again each time mouse.py changes
  mmsim run --maze hedgerow ./my-mouse           use the first maze whose path contains this word
  mmsim run --record runs ./my-mouse             record each run to a new file
  mmsim run --pace 50 java -jar mouse.jar        run slowly
  mmsim run --score --limit 2000 ./my-mouse      print the scores of a mouse for mms
  mmsim run ./my-mouse {endpoint}                pass the address to a client as an argument
  mmsim run --connect tcp://127.0.0.1:6574 ./my-mouse
                                                 use the maze of a running simulator

All words after COMMAND are passed to the mouse. The mouse may be
  - a mouse for mms, which writes commands to stdout and reads replies from stdin,
  - a client of the protocol, which connects to the address in the environment variable
    MMSIM_ENDPOINT or to port 6574, and waits for replies without a timeout, or
  - a robot of the two-run trial: a Python file with a class Robot.
The first command or request decides which one it is; --as decides before.

Press Enter to press the reset button of a mouse for mms. On the viewer page, you can also run the
mouse again, stop it, pause it, and change its pace.

The exit code is that of the mouse, or 128 plus the number of the signal that killed it; 1 if the
mouse jumped, did not start, was stopped, exceeded --limit or --time-limit, or lost the simulator;
130 after Ctrl-C. For a robot, it is 0 if the robot has scored.";

/// The help for `--port`.
const PORT_HELP: &str = "\
    Port to listen on; 0 picks a free port [default: 6574, or a free port if 6574 is in use]";

/// The help for `--viewer-port`.
const VIEWER_PORT_HELP: &str = "\
    Port of the viewer page; 0 picks a free port [default: 6575, or a free port if 6575 is in use]";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("port", |port| port.help(PORT_HELP)))]
#[command(mut_arg("viewer_port", |port| port.help(VIEWER_PORT_HELP)))]
pub(crate) struct RunArgs {
    #[arg(long, value_name = "MAZE", help = format!("{MAZE_HELP} [default: {DEFAULT_MAZES}]"))]
    maze: Option<PathBuf>,
    /// What the mouse is [default: the first command or request decides]
    #[arg(long = "as", value_name = "KIND", value_parser = kinds())]
    kind: Option<Kind>,
    /// Wait MS milliseconds after each state; the viewer page can change this [default: 50 with
    /// --open, else 0]
    #[arg(long, value_name = "MS")]
    pace: Option<u64>,
    /// Stop the mouse after S seconds, not counting pauses
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    time_limit: Option<Duration>,
    /// Stop the mouse when it reaches the goal
    #[arg(long)]
    stop_at_goal: bool,
    /// Run the mouse again each time its file changes; implies --stay
    #[arg(long)]
    watch: bool,
    /// Keep serving after the mouse exits, until Ctrl-C; implied by --open
    #[arg(long)]
    stay: bool,
    /// Run the mouse N times, and report whether its runs differ
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u16).range(1..))]
    repeat: u16,
    /// Print a JSON object when the mouse exits
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    server: ServerArgs,
    #[command(flatten)]
    mms: MmsArgs,
    #[command(flatten)]
    remote: RemoteArgs,
    /// Program to run as the mouse, and its arguments
    #[arg(trailing_var_arg = true, required = true, value_name = "COMMAND")]
    command: Vec<OsString>,
}

/// Options for mice for mms.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options for mice for mms")]
struct MmsArgs {
    /// Print the scores when the mouse exits
    #[arg(long, conflicts_with = "json")]
    score: bool,
    /// Rules for the scores and for the replies to getStat [default: mms-1.2]
    #[arg(long, value_name = "RULES", value_parser = score_rules())]
    scores: Option<ScoreRules>,
    /// Stop the mouse when its number of turns plus its effective distance in cells exceeds N
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
}

impl MmsArgs {
    /// Returns the name of an option that is set, if there is one.
    fn first_set(&self) -> Option<&'static str> {
        let set = [
            ("--score", self.score),
            ("--scores", self.scores.is_some()),
            ("--limit", self.limit.is_some()),
        ];
        set.into_iter().find_map(|(name, is_set)| is_set.then_some(name))
    }
}

/// Options for a simulator in another process.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options for --connect (mice for mms)")]
struct RemoteArgs {
    #[arg(
        long,
        value_name = "ENDPOINT",
        help = format!(
            "Run the mouse in the maze of a simulator at {ENDPOINT_FORM} instead of serving a maze"
        ),
        conflicts_with_all = [
            "maze",
            "stay",
            "watch",
            "repeat",
            "port",
            "misread",
            "misread_fixed",
            "misread_seed",
            "record",
            "history_limit",
            "viewer_port",
            "no_viewer",
            "open",
            "vehicle",
        ],
    )]
    connect: Option<String>,
    #[command(flatten)]
    known: KnownMazeArgs,
}

/// What the program of the user is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Mouse(MouseKind),
    Robot,
}

fn kinds() -> impl TypedValueParser<Value = Kind> {
    let all = [Kind::Mouse(MouseKind::Mms), Kind::Mouse(MouseKind::Client), Kind::Robot];
    one_of(all, |kind| match kind {
        Kind::Mouse(MouseKind::Mms) => {
            PossibleValue::new("mms").help("A mouse for mms: commands on stdout, replies on stdin")
        }
        Kind::Mouse(MouseKind::Client) => PossibleValue::new("client")
            .help("A client of the ZeroMQ protocol, whose output goes straight to the terminal"),
        Kind::Robot => PossibleValue::new("robot").help("A robot of the two-run trial"),
    })
}

fn score_rules() -> impl TypedValueParser<Value = ScoreRules> {
    one_of(ScoreRules::ALL, |rules| {
        PossibleValue::new(rules.name()).help(match rules {
            ScoreRules::Mms12 => {
                "Count half steps, and the full distance of movements that crash, as mms 1.2 does"
            }
            ScoreRules::Cells => "Count the cells that the mouse has travelled",
        })
    })
}

/// Runs the mouse and returns the exit code.
pub(crate) fn run(args: &RunArgs) -> Result<i32, Box<dyn Error>> {
    let program = Program::new(&args.command);
    note_misplaced_options(&program, &args.command);
    let kind = args.kind.or_else(|| program.is_published_robot().then_some(Kind::Robot));
    check(args, kind, &program)?;
    match (kind, &args.remote.connect) {
        (Some(Kind::Robot), _) => run_robot(args, &program),
        (_, Some(address)) => run_remotely(&endpoint(Some(address)), args, &program),
        (_, None) => run_locally(args, &program),
    }
}

/// Notes options of this command among the arguments of the mouse, which may have been meant for this
/// command.
fn note_misplaced_options(program: &Program, command: &[OsString]) {
    let options = RunArgs::augment_args(clap::Command::new("run"));
    let is_option = |word: &&str| {
        let name = word.strip_prefix("--").and_then(|word| word.split('=').next());
        name.is_some_and(|name| options.get_arguments().any(|arg| arg.get_long() == Some(name)))
    };
    if let Some(option) = command.iter().skip(1).filter_map(|word| word.to_str()).find(is_option) {
        let name = &program.name;
        note(format_args!("{option} is passed to {name} (options of mmsim run come before it)"));
    }
}

/// Checks that each option has an effect on a mouse of this kind.
fn check(args: &RunArgs, kind: Option<Kind>, program: &Program) -> Result<(), UsageError> {
    let usage = |message: String| Err(UsageError::new("run", message));
    if let [maze, end, _, ..] = &args.command[..]
        && end == "--"
    {
        let maze = maze.display();
        return usage(format!("{maze} before -- is no option (for a maze, use --maze {maze})"));
    }
    let name = args.command[0].to_str().unwrap_or_default();
    if BundledStrategy::from_str(name).is_ok() {
        return usage(format!(
            "{name} is a bundled strategy (to run it, use mmsim run mmsim solve {name})"
        ));
    }
    let RunArgs { remote, server, .. } = args;
    let known = &remote.known;
    if remote.connect.is_none() && (known.size.is_some() || !known.goal.is_empty()) {
        return usage("--size and --goal require --connect".into());
    }
    let without_effect = match kind {
        Some(Kind::Mouse(MouseKind::Client)) => args
            .mms
            .first_set()
            .or_else(|| remote.connect.is_some().then_some("--connect"))
            .map(|option| (option, "a client")),
        Some(Kind::Robot) => {
            let set = [
                ("--connect", remote.connect.is_some()),
                ("--stop-at-goal", args.stop_at_goal),
                ("--repeat", args.repeat > 1),
                ("--misread", server.misread.misreadings().probability > 0.0),
            ];
            let set = set.into_iter().find_map(|(name, is_set)| is_set.then_some(name));
            args.mms.first_set().or(set).map(|option| (option, "a robot of the two-run trial"))
        }
        _ => None,
    };
    if let Some((option, what)) = without_effect {
        let name = &program.name;
        return usage(format!("{option} has no effect on {name}, which is {what} (see --as)"));
    }
    if args.watch && program.file.is_none() {
        return usage(match program.missing_file() {
            Some(file) => {
                format!("--watch: {} does not exist (build the mouse first)", file.display())
            }
            None => "--watch: the command names no file to watch (example: mmsim run --watch \
                     python3 mouse.py)"
                .into(),
        });
    }
    Ok(())
}

/// Says what the program is, unless the user has said so, and how to choose something else.
fn note_kind(args: &RunArgs, program: &Program, what: &str, other: &str) {
    if args.kind.is_none() {
        note(format_args!("{} is {what} (if not, use --as {other})", program.name));
    }
}

fn run_locally(args: &RunArgs, program: &Program) -> Result<i32, Box<dyn Error>> {
    let control = control(args, program);
    // The simulator itself listens on another port: the gateway answers on this one.
    let listener = bind_or_free(args.server.port, |port| listen(HOST, port))?;
    let address = format!("tcp://{}", listener.local_addr()?);
    let misreadings = args.server.misread.misreadings();
    let has_button = Cell::new(args.kind == Some(Kind::Mouse(MouseKind::Mms)));
    if has_button.get() {
        press_on_input(Arc::clone(&control));
    }
    let serving = Serving { program, control: &control, misreadings, is_trial: false };
    serve(args, &serving, Some(0), Some(&address), |monitor, _| {
        let gateway = Gateway::start(listener, monitor.clone(), Arc::clone(&control))?;
        let (control, judgements) = (&control, Judgements::new(args, &program.name));
        Ok(move || {
            let listen = || {
                if !has_button.replace(true) {
                    press_on_input(Arc::clone(control));
                }
            };
            run_once(args, program, &monitor, &gateway, control, &judgements, listen)
        })
    })
}

/// Runs the mouse once, in the maze that is being served. Calls `listen` if the mouse has a reset button.
fn run_once(
    args: &RunArgs,
    program: &Program,
    monitor: &Monitor,
    gateway: &Gateway,
    control: &Arc<MouseControl>,
    judgements: &Judgements<'_>,
    listen: impl Fn(),
) -> Result<RunEnd, Box<dyn Error>> {
    let Served { info, maze, .. } = monitor.served()?;
    let misreadings = args.server.misread.misreadings();
    monitor.misread(misreadings)?;
    let run = gateway.begin_run()?;
    let name = &*program.name;
    if args.kind == Some(Kind::Mouse(MouseKind::Client)) {
        let started = MouseProcess::start(program, run.address());
        let not_started = |error: StartError| ExitCause::NotStarted(error.into());
        let cause = started.map_or_else(not_started, |mut mouse| mouse.wait(control));
        return end_client(args, name, (&info.maze, monitor), cause, run, control, judgements);
    }
    let prints_result = args.json || args.mms.score;
    let copy: Box<dyn Write + Send> =
        if prints_result { Box::new(io::stderr()) } else { Box::new(io::stdout()) };
    let mut mouse =
        PipedMouse::start(program, Some(run.address()), maze.size(), true, control, copy);
    let kind = match &mut mouse {
        _ if args.kind.is_some() => Ok(control.kind()),
        Ok(mouse) => mouse.recognize(control, |text| warn(format_args!("{text}"))),
        Err(_) => Ok(None),
    };
    if let Ok(Some(MouseKind::Mms)) = kind {
        note_kind(args, program, "a mouse for mms", "client");
        listen();
        // The mouse misreads walls, but this process, its client, must not.
        monitor.misread(Misreadings::default())?;
        let known = KnownSimulator {
            name: Some(info.maze),
            map: KnownMaze::unexplored(&maze),
            start: maze.start(),
            has_annotations: true,
        };
        let sensor = WallSensor::new(misreadings, &maze);
        return drive(
            args,
            name,
            in_process(monitor),
            &known,
            (mouse, Some(&sensor), Some(monitor)),
            control,
            judgements,
        );
    }
    if let Ok(Some(_)) = kind {
        note_kind(args, program, "a client of the ZeroMQ protocol", "mms");
    }
    let cause = mouse.map_or_else(ExitCause::NotStarted, |mouse| mouse.wait(control));
    end_client(args, name, (&info.maze, monitor), cause, run, control, judgements)
}

/// Ends the run of a mouse that is a client, or that was not recognized, and reports the outcome.
fn end_client(
    args: &RunArgs,
    name: &str,
    (maze, monitor): (&str, &Monitor),
    cause: ExitCause,
    run: GatewayRun<'_>,
    control: &MouseControl,
    judgements: &Judgements<'_>,
) -> Result<RunEnd, Box<dyn Error>> {
    let progress = run.finish();
    // The last request may have been answered after the mouse exited.
    let kind = control.kind();
    let judge = judge(monitor, &progress.phases);
    let mut exit = ClientExit { cause, kind, progress, judge };
    let (end, facts) = (exit.end(), exit.facts());
    report_cause(&exit.cause);
    if kind == Some(MouseKind::Client)
        && let Some(option) = args.mms.first_set()
    {
        warn(format_args!("{option} has no effect: {name} is not a mouse for mms"));
    }
    let judge = exit.judge.as_mut();
    let judged =
        judge.and_then(|judge| judgements.add(monitor, judge, &end.outcome.verdict, &facts));
    if args.json {
        print_json(&exit.report(Some(maze), name).with_judged(judged))?;
    } else {
        judged.iter().for_each(note_judged);
    }
    Ok(end)
}

fn run_remotely(endpoint: &str, args: &RunArgs, program: &Program) -> Result<i32, Box<dyn Error>> {
    let control = control(args, program);
    let known = maze_from_args("run", &args.remote.known)?;
    let mut transport = connect(endpoint, None, known.is_none())?;
    let known = known.map_or_else(|| ask_maze(&mut transport, args.remote.known.size), Ok)?;
    // Until the simulator replies, Ctrl-C terminates the process directly.
    transport.exchange(b"ping", &mut Vec::new())?;
    press_on_input(Arc::clone(&control));
    let closing = Arc::clone(&control);
    Interrupt::catch()?.then(move || closing.close());
    Runs::new(&control, endpoint, |text| note(text)).run(|| {
        let (size, has_log) = (known.map.size(), known.has_annotations);
        let mouse = PipedMouse::start(program, None, size, has_log, &control, io::sink());
        let (mouse, judgements) = ((mouse, None, None), Judgements::new(args, &program.name));
        drive(args, &program.name, &mut transport, &known, mouse, &control, &judgements)
    })
}

/// Runs a mouse for mms once in the maze, and reports the outcome. The mouse may have a sensor that
/// misreads walls. `monitor` is that of a simulator in this process.
fn drive(
    args: &RunArgs,
    name: &str,
    transport: impl Transport,
    known: &KnownSimulator,
    (mouse, sensor, monitor): (Result<PipedMouse, String>, Option<&WallSensor>, Option<&Monitor>),
    control: &MouseControl,
    judgements: &Judgements<'_>,
) -> Result<RunEnd, Box<dyn Error>> {
    let own_vehicle = args.server.viewer.vehicle.first();
    let session = Session {
        name,
        vehicle: &own_vehicle.cloned().unwrap_or_else(|| Vehicle::default_for(known.map.size())),
        maze: &known.map,
        sensor,
        rules: args.mms.scores.unwrap_or(ScoreRules::Mms12),
        limit: args.mms.limit,
        has_annotations: known.has_annotations,
        is_remote: args.remote.connect.is_some(),
        control,
        warn: |text| warn(text),
    };
    let mut exit = session.run(transport, mouse)?;
    exit.judge = monitor.and_then(|monitor| judge(monitor, exit.phases()));
    report_cause(&exit.cause);
    let (end, facts) = (exit.end(), exit.facts());
    let judge = exit.judge.as_mut().zip(monitor);
    let judged = judge
        .and_then(|(judge, monitor)| judgements.add(monitor, judge, &end.outcome.verdict, &facts));
    if args.json {
        print_json(&exit.report(known.name.as_deref(), name).with_judged(judged))?;
        return Ok(end);
    }
    judged.iter().for_each(note_judged);
    if args.mms.score && end.was_started {
        print(&exit.scores())?;
    }
    Ok(end)
}

/// Prints why a mouse could not start or go on.
fn report_cause(cause: &ExitCause) {
    match cause {
        ExitCause::LostSimulator(error) => warn(format_args!("mmsim: {}", explain(error))),
        ExitCause::NotStarted(error) | ExitCause::Failed(error) => {
            warn(format_args!("mmsim: {error}"));
        }
        ExitCause::Exited(_) | ExitCause::Limit(_) | ExitCause::Stopped(_) => {}
    }
}

/// Runs a robot of the two-run trial.
fn run_robot(args: &RunArgs, program: &Program) -> Result<i32, Box<dyn Error>> {
    note_kind(args, program, "a robot of the two-run trial", "mms or --as client");
    let name = program.name.clone();
    let program = if program.is_published_robot() {
        let robot = program.to_published_robot();
        robot.map_err(|error| format!("cannot run {name}: {error}"))?
    } else {
        program.clone()
    };
    let answer_limit = DEFAULT_ANSWER_LIMIT;
    let kind = RobotKind::Own(OwnRobot { name, program: program.clone(), answer_limit });
    let robot = TrialRobot { kind, settings: Settings::default() };
    let control = control(args, &program);
    let misreadings = Misreadings::default();
    let serving = Serving { program: &program, control: &control, misreadings, is_trial: true };
    serve(args, &serving, args.server.port, None, |monitor, selected| {
        let (control, form) = (&control, ResultForm { path: false, json: args.json });
        Ok(move || run_watched(&monitor, &robot, &selected, control, form))
    })
}
