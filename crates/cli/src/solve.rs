//! `mmsim solve`: run a bundled strategy against a simulator.

use std::ops::ControlFlow;
use std::thread;
use std::time::Duration;

use mmsim_client::{
    BrokenRun, RunError, SearchRun, TransportError, Waiting, Zmq, ask_info, search_run,
};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose};
use mmsim_protocol::Info;
use mmsim_solvers::{Mouse, Strategy};
use serde::Serialize;

use crate::Outcome;
use crate::args::{Goal, SolveArgs, ToldArgs, wrong_usage};
use crate::output::{complain, own_command, print_json};
use crate::recorded::Recorded;
use crate::screen::{Screen, ending};

pub(crate) fn run(args: &SolveArgs) -> Outcome {
    let strategy = args.strategy.0;
    let told = told_goals("solve", &args.told);
    let endpoint = endpoint(&args.connect);
    let asks_server = told.is_none();
    let on_wait = |waiting: Waiting<'_>| say_waiting(&waiting, asks_server);
    let mut transport = Zmq::connect(&endpoint, args.timeout, on_wait)?;
    let known = match told {
        Some((size, goals)) => {
            let start = Pose::new(Cell::new(0, 0), Heading::North);
            Ok((KnownMaze::new(size, start.cell, goals), start))
        }
        None => ask_goals(&mut transport, args.told.size),
    };
    let prepared = known.and_then(|(map, start)| {
        // What the simulator calls the maze is not asked for; where it is, tells as much.
        let info = Info::new(&endpoint, map.size(), start, map.goals(), 0);
        let recorded = Recorded::new(transport, args.record.as_deref(), &info);
        let recorded = recorded.map_err(|error| match &args.record {
            Some(file) if file.exists() => format!("{error}; --record takes a new file"),
            _ => error.to_string(),
        });
        Ok((map, start, recorded?))
    });
    let (map, start, mut transport) = match prepared {
        Ok(prepared) => prepared,
        Err(error) if args.json => {
            let report =
                Report { strategy: strategy.name(), error: Some(error), ..Report::default() };
            print_json(&serde_json::to_string(&report)?)?;
            return Ok(false);
        }
        Err(error) => return Err(error.into()),
    };
    let mut mouse = Mouse::new(strategy.strategy(), map, start);
    let pace = Duration::from_millis(args.pace);
    let max_steps = args.max_steps.unwrap_or(strategy.max_states());
    let mut screen = Screen::new(strategy, !pace.is_zero() && !args.json);
    let mut shown = Ok(());
    let result = search_run(&mut transport, &mut mouse, max_steps, |mouse, run| {
        shown = screen.show(mouse, run);
        thread::sleep(pace);
        if shown.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    shown?;
    let (run, error) = match result {
        Ok(run) => (run, None),
        Err(BrokenRun { run, error }) => (run, Some(error)),
    };
    let recorded =
        transport.close().map_err(|error| format!("the recording lacks states: {error}"));
    if args.json {
        let error = error.as_ref().map(ToString::to_string).or_else(|| recorded.clone().err());
        let report = Report::new(strategy.name(), &run, &mouse, error);
        print_json(&serde_json::to_string(&report)?)?;
    } else if run.states > 0 {
        screen.finish(&mouse, &run, ending(&run))?;
    }
    if let Some(error) = recorded.as_ref().err().filter(|_| !args.json) {
        complain(error);
    }
    match error {
        Some(error) if !args.json => Err(explain(&error).into()),
        Some(_) => Ok(false),
        None => {
            // Some come through the goal before they are done.
            let is_in_goal = mouse.map().goals().contains(mouse.pose().cell);
            let gave_up = run.states == max_steps && !is_in_goal;
            if gave_up {
                complain(format_args!("gave up at --max-steps {max_steps}"));
            }
            Ok(run.stats.goal_reached() && !gave_up && recorded.is_ok())
        }
    }
}

/// The error, and what to try where the mouse was told another maze than the one that is served.
pub(crate) fn explain(error: &RunError) -> String {
    let hint = match error {
        RunError::Refused { request: "S", .. } | RunError::LargerMaze { .. } => {
            "; --size and --goal tell the mouse its maze, --goal server lets it ask"
        }
        RunError::Transport(TransportError::NoReply { .. }) => {
            return format!("{error}; start a simulator with {}", own_command(""));
        }
        _ => "",
    };
    format!("{error}{hint}")
}

/// Where a simulator listens, as ZeroMQ writes it.
pub(crate) fn endpoint(connect: &str) -> String {
    if connect.contains("://") { connect.into() } else { format!("tcp://{connect}") }
}

/// Size and goals as far as they do not come from the server, for a subcommand of this name.
pub(crate) fn told_goals(
    command: &str,
    ToldArgs { size, goal }: &ToldArgs,
) -> Option<(MazeSize, CellSet)> {
    let size = size.unwrap_or(MazeSize::CLASSIC);
    if goal.contains(&Goal::Server) {
        if goal.len() > 1 {
            wrong_usage(command, "expected --goal server or cells, found both");
        }
        return None;
    }
    let mut goals = CellSet::EMPTY;
    for goal in goal {
        match *goal {
            Goal::Cell(cell) if size.contains(cell) => goals.extend([cell]),
            Goal::Cell(cell) => {
                let found = format!("expected --goal inside a maze of {size} cells, found {cell}");
                wrong_usage(command, &found);
            }
            Goal::Server => {}
        }
    }
    Some((size, if goals.is_empty() { size.central_cells() } else { goals }))
}

/// Size, start and goals as the server says.
pub(crate) fn ask_goals(
    transport: &mut Zmq<'_>,
    size: Option<MazeSize>,
) -> Result<(KnownMaze, Pose), String> {
    let info = ask_info(transport).map_err(|error| error.to_string())?;
    let (Some(map), Some(start)) = (info.known_maze(), info.start_pose()) else {
        return Err(format!("expected a maze of 1x1 to 32x32 cells, found {info:?}"));
    };
    let served = map.size();
    if let Some(size) = size.filter(|&size| size != served) {
        return Err(format!(
            "expected a maze of {size} cells, found the server has one of {served}"
        ));
    }
    Ok((map, start))
}

/// Says after a second, and then now and again, that there is no reply yet.
pub(crate) fn say_waiting(waiting: &Waiting<'_>, asks_server: bool) {
    let Waiting { endpoint, since, times, answered } = waiting;
    if *times != 1 && times % 10 != 0 {
        return;
    }
    let seconds = since.as_secs();
    let hint = match (answered, asks_server) {
        (true, _) => String::new(),
        (false, false) => format!("; start a simulator with {}", own_command("")),
        (false, true) => "; only a simulator of this project answers --goal server".into(),
    };
    complain(format_args!(
        "no reply from {endpoint} for {seconds} s, waiting{hint}; Ctrl-C gives up"
    ));
}

/// What `--json` prints; null is what there was no search to tell of.
#[derive(Default, Serialize)]
struct Report<'a> {
    strategy: &'a str,
    goal_reached: bool,
    steps: u32,
    states: u32,
    requests: u32,
    visited_cells: usize,
    width: Option<u8>,
    height: Option<u8>,
    cell: Option<[u8; 2]>,
    heading: Option<char>,
    map: Option<String>,
    error: Option<String>,
}

impl<'a> Report<'a> {
    fn new<S: Strategy>(
        strategy: &'a str,
        run: &SearchRun,
        mouse: &Mouse<S>,
        error: Option<String>,
    ) -> Self {
        let Pose { cell, heading } = mouse.pose();
        let size = mouse.map().size();
        Self {
            strategy,
            goal_reached: run.stats.goal_reached(),
            steps: run.stats.steps(),
            states: run.states,
            requests: run.requests,
            visited_cells: mouse.map().visited().len(),
            width: Some(size.width()),
            height: Some(size.height()),
            cell: Some([cell.x, cell.y]),
            heading: Some(heading.letter()),
            map: Some(mouse.map().picture().to_string()),
            error,
        }
    }
}
