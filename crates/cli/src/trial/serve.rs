//! `mmsim trial --serve`: show a trial in a browser. The robot sends states to a
//! simulator.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use mmsim_client::{Exchange, RunError, Transport};
use mmsim_maze::{KnownMaze, Maze, Unknown, Wall, WallState, Walls};
use mmsim_protocol::Annotation;
use mmsim_server::Monitor;
use mmsim_trial::{RaceSteps, Trial, TrialOutcome, TrialStatus};
use mmsim_viewer::{Ending, EndingKind, MouseControl, OwnMouse, Pace, StopReason};

use super::args::TrialArgs;
use super::contender::{Contender, RunContext};
use super::outcome::TrialResult;
use super::results::Results;
use super::table::failure;
use crate::local_server::{self, in_process};
use crate::own_mouse::{RunEnd, Runs};
use crate::screen::pace;
use crate::selection::Selected;
use crate::usage::{CommandResult, UsageError};

/// The interval between checks whether a trial is over.
const STOP_INTERVAL: Duration = Duration::from_millis(50);

/// Runs one robot in one maze.
pub(crate) fn run(args: &TrialArgs, mazes: Vec<Selected>) -> CommandResult {
    let (contenders, paths) = (args.contenders()?, mazes.len());
    let [contender] = &contenders[..] else {
        return Err(not_one("robot", contenders.len()).into());
    };
    let Ok([selected]) = <[Selected; 1]>::try_from(mazes) else {
        return Err(not_one("maze", paths).into());
    };
    let watch = &args.watch;
    let viewer = (!watch.once).then_some(&watch.viewer);
    let own = OwnMouse { name: contender.name().into(), has_reset_button: false };
    let control = Arc::new(MouseControl::new(Pace::from_interval(pace(watch.pace)), Some(own)));
    let ready = local_server::prepare_trial(
        selected.clone(),
        Arc::clone(&control),
        watch.port,
        &watch.retention,
        viewer,
    )?;
    let monitor = ready.server.monitor();
    let server = ready.server.spawn(ready.simulation);
    let jobs = [(&selected, contender)];
    let mut succeeded = true;
    let runs = Runs {
        control: &control,
        monitor: Some(&monitor),
        address: server.address(),
        stays: !watch.once,
        watched: None,
        has_page: false,
    };
    runs.run(ready.interrupt, || {
        let outcome = run_trial(&monitor, contender, &selected, &control)?;
        let ending = if let Some(outcome) = outcome {
            let ending = ending(&outcome);
            let mut results = Results::new(&jobs, args);
            results.add(vec![outcome])?;
            succeeded = results.finish()?;
            ending
        } else {
            let reason = control.wait_for_stop(Duration::ZERO);
            let text = reason.map_or("stopped", StopReason::text).into();
            Ending { kind: EndingKind::Stopped, text }
        };
        Ok(RunEnd { ending, code: 0, was_started: true })
    })?;
    server.stop()?;
    Ok(succeeded || !watch.once)
}

/// Returns the ending of a trial for the page.
fn ending(outcome: &TrialResult) -> Ending {
    match outcome.score() {
        Some(score) => Ending { kind: EndingKind::Goal, text: format!("score {score}") },
        None => Ending { kind: EndingKind::GaveUp, text: failure(outcome).into() },
    }
}

/// Runs a robot and sends its states to the simulator. A state contains the pose, the walls that
/// the robot has seen, and for each cell a lower bound on the race steps to the goal. The robot, the
/// status of the trial and open sides between unvisited cells are sent as annotations. Passes the
/// throttle after each state, and returns `None` if the robot is stopped.
fn run_trial(
    monitor: &Monitor,
    contender: &Contender,
    selected: &Selected,
    control: &MouseControl,
) -> Result<Option<TrialResult>, Box<dyn Error>> {
    let mut simulator = Exchange::new(in_process(monitor));
    simulator.reset()?;
    let mut reporter = Reporter::new(contender, &selected.maze);
    let context = RunContext { shows_stderr: true, ..RunContext::default() };
    let mut run = || {
        contender.run_watched(&selected.maze, &context, |trial, seen| {
            reporter.report(&mut simulator, trial, seen).map_err(Some)?;
            let steps = RaceSteps::flood(seen.walls(Unknown::Open), seen.goals());
            let number = |cell| steps.at(cell).unwrap_or(u16::MAX);
            simulator.state(trial.pose(), seen, number).map_err(Some)?;
            if control.throttle().wait() { Err(None::<RunError>) } else { Ok(()) }
        })
    };
    let outcome = if contender.is_own() { stopped_with(control, &context, run) } else { run() };
    let is_stopped = context.is_interrupted.load(Ordering::SeqCst);
    match outcome {
        Ok(outcome) if outcome.ending == TrialOutcome::Failed && is_stopped => Ok(None),
        Ok(outcome) => Ok(Some(outcome)),
        Err(None) => Ok(None),
        Err(Some(error)) => Err(error.into()),
    }
}

/// Runs a robot of the user, which is interrupted as soon as it must stop.
fn stopped_with<T>(control: &MouseControl, context: &RunContext, run: impl FnOnce() -> T) -> T {
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::SeqCst) {
                if control.wait_for_stop(STOP_INTERVAL).is_some() {
                    context.is_interrupted.store(true, Ordering::SeqCst);
                    return;
                }
            }
        });
        let result = run();
        is_over.store(true, Ordering::SeqCst);
        result
    })
}

/// Sends annotations about a trial.
struct Reporter<'a> {
    robot: &'a str,
    /// The status that was reported last.
    status: Option<TrialStatus>,
    /// Contains a wall for each open side that was declared.
    declared: Walls,
}

impl<'a> Reporter<'a> {
    fn new(contender: &'a Contender, maze: &Maze) -> Self {
        let declared = Walls::open(maze.size());
        Self { robot: contender.name(), status: None, declared }
    }

    /// Reports the changes since the previous state.
    fn report(
        &mut self,
        simulator: &mut Exchange<impl Transport>,
        trial: &Trial<'_>,
        seen: &KnownMaze,
    ) -> Result<(), RunError> {
        let status = TrialStatus::new(trial);
        if self.status.replace(status) != Some(status) {
            let (strategy, line) = (status.strategy(), log_line(trial, status));
            let names = [Annotation::Mouse(self.robot), Annotation::Strategy(&strategy)];
            simulator.annotate(names.into_iter().chain([Annotation::Log(&line)]))?;
        }
        let visited = seen.visited();
        let mut open_sides = Vec::new();
        for wall in seen.size().inner_walls() {
            let Wall { cell, heading, .. } = wall;
            let is_open = seen.wall(cell, heading) == WallState::Absent
                && !wall.cells().any(|cell| visited.contains(cell));
            if is_open && !self.declared.has(cell, heading) {
                self.declared.set(cell, heading, true);
                let state = Some(WallState::Absent);
                open_sides.push(Annotation::Wall { cell, heading, state });
            }
        }
        simulator.annotate(open_sides)
    }
}

/// Returns the log line for a change of the status.
fn log_line(trial: &Trial<'_>, status: TrialStatus) -> String {
    let (explore, race) = (trial.explore_steps(), trial.race_steps());
    match (status, trial.outcome()) {
        (TrialStatus::Explore, _) => "run 1 begins".into(),
        (TrialStatus::Race, _) => format!("run 2 begins after {explore} explore steps"),
        (_, Some(TrialOutcome::Scored(score))) => {
            format!("score {score} after {explore} explore steps and {race} race steps")
        }
        _ => format!("{status} after {explore} explore steps and {race} race steps"),
    }
}

fn not_one(thing: &str, found: usize) -> UsageError {
    UsageError::new("trial", format!("--serve takes one {thing}, found {found}"))
}
