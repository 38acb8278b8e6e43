//! `mmsim trial --serve`: show a trial in a browser. The robot sends states to a
//! simulator.

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use mmsim_client::{Exchange, RunError, Transport};
use mmsim_compare::{NamedMaze, RunContext, TrialResult, TrialRobot, TrialStop};
use mmsim_maze::{KnownMaze, Misreadings, Unknown};
use mmsim_mouse::{MouseControl, Outcome, Pace, RunEnd, Runs, StopReason, wall_declarations};
use mmsim_protocol::Annotation;
use mmsim_run::{Ending, Verdict};
use mmsim_server::Monitor;
use mmsim_trial::{RaceSteps, Trial, TrialOutcome, TrialStatus};
use mmsim_viewer::ViewerConfig;

use super::args::TrialArgs;
use super::results::{ResultForm, ResultPrinter};
use crate::args::{CommandResult, UsageError};
use crate::local_server::{HOST, in_process, prepare};
use crate::output::note;
use crate::screen::pace;

/// Runs one robot in one maze.
pub(crate) fn run(args: &TrialArgs, mazes: Vec<NamedMaze>) -> CommandResult {
    let (robots, paths) = (args.robots()?, mazes.len());
    let [robot] = &robots[..] else {
        return Err(UsageError::not_one("trial", "--serve", "robot", robots.len()).into());
    };
    let Ok([selected]) = <[NamedMaze; 1]>::try_from(mazes) else {
        return Err(UsageError::not_one("trial", "--serve", "maze", paths).into());
    };
    let watch = &args.watch;
    let viewer = (!watch.once).then_some(&watch.viewer);
    let (pace, name) = (Pace::from_interval(pace(watch.pace)), robot.name().to_string());
    let control = Arc::new(MouseControl::new(pace, Some(name)));
    // The page can neither load other mazes nor run other mice.
    let config = ViewerConfig::default().with_trial();
    let (address, mouse) = ((HOST, Some(watch.port)), Some((Arc::clone(&control), None)));
    let (maze, exact) = (selected.clone(), Misreadings::default());
    let ready = prepare(maze, exact, config, address, &watch.retention, viewer, mouse)?;
    let monitor = ready.server.monitor();
    let server = ready.server.spawn(ready.simulation);
    let closing = Arc::clone(&control);
    ready.interrupt.then(move || closing.close());
    let runs = Runs {
        monitor: Some(&monitor),
        stays: !watch.once,
        ..Runs::new(&control, server.address(), |text| note(text))
    };
    let code = runs.run(|| run_watched(&monitor, robot, &selected, &control, args.form()))?;
    server.stop()?;
    // Ctrl-C is no failure of the robot.
    Ok([0, StopReason::Exit.exit_code()].contains(&code) || !watch.once)
}

/// Runs a robot in the maze that a simulator serves, and prints the result. The exit code is 0 if the
/// trial has succeeded.
pub(crate) fn run_watched(
    monitor: &Monitor,
    robot: &TrialRobot,
    selected: &NamedMaze,
    control: &Arc<MouseControl>,
    form: ResultForm,
) -> Result<RunEnd, Box<dyn Error>> {
    let Some(result) = run_trial(monitor, robot, selected, control)? else {
        let reason = control.wait_for_stop(Duration::ZERO).unwrap_or(StopReason::Stop);
        let (text, code) = (reason.text(), reason.exit_code());
        let error = Some(text.clone());
        let verdict = Verdict { ending: reason.ending(), error, ..Verdict::default() };
        return Ok(RunEnd { outcome: Outcome { verdict, text }, code, was_started: true });
    };
    let outcome = end(&result);
    let jobs = [(selected, robot)];
    let mut results = ResultPrinter::new(&jobs, form);
    results.add(vec![result])?;
    let code = i32::from(!results.finish()?);
    Ok(RunEnd { outcome, code, was_started: true })
}

/// Returns the outcome of a trial for the page.
fn end(result: &TrialResult) -> Outcome {
    let score = result.score().map(|score| format!("score {score}"));
    let (goal_reached, error) = (score.is_some(), result.reason().to_string());
    let ending = match result.ending {
        TrialOutcome::Scored(_) => Ending::Finished,
        TrialOutcome::OutOfTime => Ending::StepLimit,
        TrialOutcome::GaveUp => Ending::GaveUp,
        TrialOutcome::Failed => Ending::Failed,
    };
    let text = score.unwrap_or_else(|| error.clone());
    let error = Some(error).filter(|_| !goal_reached);
    Outcome { verdict: Verdict { goal_reached, ending, error, cause: None }, text }
}

/// Runs a robot and sends its states to the simulator. A state contains the pose, the walls that
/// the robot has seen, and for each cell a lower bound on the race steps to the goal. The robot, the
/// status of the trial and walls that a state cannot express are sent as annotations. Passes the
/// throttle after each state, and returns `None` if the robot is stopped.
fn run_trial(
    monitor: &Monitor,
    robot: &TrialRobot,
    selected: &NamedMaze,
    control: &Arc<MouseControl>,
) -> Result<Option<TrialResult>, Box<dyn Error>> {
    let mut simulator = Exchange::new(in_process(monitor));
    simulator.reset()?;
    let mut reporter = Reporter::new(robot);
    let stopping = Arc::clone(control);
    let must_stop = Arc::new(move || stopping.wait_for_stop(Duration::ZERO).is_some());
    let context = RunContext { must_stop, shows_stderr: true };
    let outcome = robot.run_watched(&selected.maze, &context, |trial, seen| {
        reporter.report(&mut simulator, trial, seen).map_err(Some)?;
        let steps = RaceSteps::flood(seen.walls(Unknown::Open), seen.goals());
        let number = |cell| steps.at(cell).unwrap_or(u16::MAX);
        simulator.state(trial.pose(), seen, number).map_err(Some)?;
        if control.wait_for_step() { Err(None::<RunError>) } else { Ok(()) }
    });
    let is_stopped = control.wait_for_stop(Duration::ZERO).is_some();
    match outcome {
        Ok(outcome) if outcome.ending == TrialOutcome::Failed && is_stopped => Ok(None),
        Ok(outcome) => Ok(Some(outcome)),
        Err(TrialStop::Watch(None)) => Ok(None),
        Err(TrialStop::Watch(Some(error))) => Err(error.into()),
        Err(TrialStop::Shortage(shortage)) => Err(shortage.into()),
    }
}

/// Sends annotations about a trial.
struct Reporter<'a> {
    robot: &'a str,
    /// The status that was reported last.
    status: Option<TrialStatus>,
    /// What the robot had seen in the previous state.
    seen: Option<KnownMaze>,
}

impl<'a> Reporter<'a> {
    fn new(robot: &'a TrialRobot) -> Self {
        Self { robot: robot.name(), status: None, seen: None }
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
        let before = self.seen.replace(seen.clone());
        simulator.annotate(wall_declarations(before.as_ref(), seen))
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
