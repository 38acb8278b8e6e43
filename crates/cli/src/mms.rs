//! `mmsim mms`: run a mouse written for the mms simulator.

mod button;

use std::error::Error;
use std::sync::Arc;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_client::Transport;
use mmsim_maze::{KnownMaze, Misreadings, WallSensor};
use mmsim_mms::ScoreRules;
use mmsim_mouse::{ExitCause, MouseControl, Program, RunEnd, Runs, Session};
use mmsim_server::Served;

use crate::args::{KnownMazeArgs, UsageError, one_of};
use crate::connection::{
    ENDPOINT_FORM, KnownSimulator, ask_maze, connect, endpoint, explain, maze_from_args,
};
use crate::interrupt::Interrupt;
use crate::local_server::in_process;
use crate::output::{note, print, print_json, warn};
use crate::own_mouse::OwnMouseArgs;
use button::press_on_input;

const AFTER_HELP: &str = "\
Examples:
  mmsim mms --open -- ./my-mouse                 watch the mouse in a browser
  mmsim mms --maze hedgerow -- python3 Main.py   use the first maze whose path contains this word
  mmsim mms --open --watch -- python3 Main.py    run it again each time Main.py changes
  mmsim mms --pace 50 -- java -jar mouse.jar     run slowly
  mmsim mms --score --limit 2000 -- ./my-mouse   print its scores
  mmsim mms --connect tcp://127.0.0.1:6574 -- ./my-mouse
                                                 use the maze of a running simulator

Press Enter to press the reset button. On the viewer page, you can also run the mouse again, stop
it, pause it, and change its pace. The exit code is that of the mouse, or 128 plus the number of the
signal that killed it; 1 if the mouse did not start, was stopped, exceeded --limit or --time-limit,
or lost the simulator; 130 after Ctrl-C.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct MmsArgs {
    /// Print the scores when the mouse exits
    #[arg(long)]
    score: bool,
    /// Print a JSON object when the mouse exits
    #[arg(long, conflicts_with = "score")]
    json: bool,
    /// Rules for the scores and for the replies to getStat
    #[arg(long, value_name = "RULES", value_parser = score_rules(), default_value = "mms-1.2")]
    scores: ScoreRules,
    /// Stop the mouse when its number of turns plus its effective distance in cells exceeds N
    #[arg(long, value_name = "N")]
    limit: Option<u32>,
    #[command(flatten)]
    own: OwnMouseArgs,
    #[command(flatten)]
    remote: RemoteArgs,
}

/// Options for a simulator in another process.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options for --connect")]
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
pub(crate) fn run(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let program = args.own.program();
    match &args.remote.connect {
        None => run_locally(args, &program),
        Some(address) => run_remotely(&endpoint(address), args, &program),
    }
}

fn run_locally(args: &MmsArgs, program: &Program) -> Result<i32, Box<dyn Error>> {
    let known = &args.remote.known;
    if known.size.is_some() || !known.goal.is_empty() {
        return Err(UsageError::new("mms", "--size and --goal require --connect").into());
    }
    let control = args.own.control("mms", program, true)?;
    // The mouse misreads walls, but this process, its client, must not.
    let (server, exact) = (&args.own.server, Misreadings::default());
    args.own.serve(program, &control, server.port, None, exact, |monitor| {
        press_on_input(Arc::clone(&control));
        let control = &control;
        Ok(move || {
            let Served { info, maze, .. } = monitor.served()?;
            let sensor = WallSensor::new(server.misread.misreadings(), &maze);
            let known = KnownSimulator {
                name: Some(info.name),
                map: KnownMaze::unexplored(&maze),
                start: maze.start(),
                has_annotations: true,
            };
            search(args, program, in_process(&monitor), &known, Some(&sensor), control)
        })
    })
}

fn run_remotely(endpoint: &str, args: &MmsArgs, program: &Program) -> Result<i32, Box<dyn Error>> {
    let control = args.own.control("mms", program, true)?;
    let known = maze_from_args("mms", &args.remote.known)?;
    let mut transport = connect(endpoint, None, known.is_none())?;
    let known = known.map_or_else(|| ask_maze(&mut transport, args.remote.known.size), Ok)?;
    // Until the simulator replies, Ctrl-C terminates the process directly.
    transport.exchange(b"ping", &mut Vec::new())?;
    press_on_input(Arc::clone(&control));
    let closing = Arc::clone(&control);
    Interrupt::catch()?.then(move || closing.close());
    Runs::new(&control, endpoint, |text| note(text))
        .run(|| search(args, program, &mut transport, &known, None, &control))
}

/// Runs the mouse once in the maze, and reports the outcome.
fn search(
    args: &MmsArgs,
    program: &Program,
    transport: impl Transport,
    known: &KnownSimulator,
    sensor: Option<&WallSensor>,
    control: &MouseControl,
) -> Result<RunEnd, Box<dyn Error>> {
    let own_vehicle = args.own.server.viewer.vehicle.first();
    let session = Session {
        program,
        vehicle: &own_vehicle.cloned().unwrap_or_default(),
        maze: &known.map,
        sensor,
        rules: args.scores,
        limit: args.limit,
        has_annotations: known.has_annotations,
        is_remote: args.remote.connect.is_some(),
        control,
        warn: |text| warn(text),
    };
    let exit = session.run(transport)?;
    match &exit.cause {
        ExitCause::LostSimulator(error) => warn(format_args!("mmsim: {}", explain(error))),
        ExitCause::NotStarted(error) | ExitCause::Failed(error) => {
            warn(format_args!("mmsim: {error}"));
        }
        ExitCause::Exited(_) | ExitCause::Limit(_) | ExitCause::Stopped(_) => {}
    }
    let end = exit.end();
    if args.json {
        print_json(&exit.report(known.name.as_deref()))?;
    } else if args.score && end.was_started {
        print(&exit.scores())?;
    }
    Ok(end)
}
