//! The robots that take part in trials.

use std::sync::Arc;
use std::time::Duration;

use mmsim_maze::{KnownMaze, Maze};
use mmsim_mouse::{Program, RobotProcess, Shortage, StopCheck};
use mmsim_trial::{
    BundledRobot, Robot, SensorNoise, Settings, Survey, Trial, TrialOutcome, TrialPhase,
    race_optimum,
};

use super::result::{TrialResult, letters};
use crate::named_maze::NamedMaze;
use crate::parallel::{Gate, map_each};

/// A maze and a robot to run in it.
pub type TrialJob<'a> = (&'a NamedMaze, &'a TrialRobot);

/// How the robots of the user run.
pub struct RunContext {
    /// Returns true once the robots must stop.
    pub must_stop: StopCheck,
    /// True if stderr of a robot is copied to stderr of this process.
    pub shows_stderr: bool,
}

/// Runs trials on all processors. Returns the results in the order of the jobs, or `None` if the robots
/// had to stop.
///
/// # Errors
/// The system lacks something even for one robot at a time.
pub fn run_trials(
    jobs: &[TrialJob<'_>],
    context: &RunContext,
) -> Result<Option<Vec<TrialResult>>, Shortage> {
    let gate = Gate::new();
    let run = |(maze, robot): &TrialJob<'_>| gate.run(|| robot.run(&maze.maze, context));
    let results: Result<Vec<_>, _> = map_each(jobs, run).into_iter().collect();
    Ok(results?.into_iter().collect())
}

/// The reason why a trial has no result.
#[derive(Debug)]
pub enum TrialStop<E> {
    /// The watcher has stopped the trial.
    Watch(E),
    /// The system lacks something that the robot needs.
    Shortage(Shortage),
}

/// A robot and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialRobot {
    /// The robot.
    pub kind: RobotKind,
    /// The settings.
    pub settings: Settings,
}

/// A bundled robot or a robot of the user.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotKind {
    /// A bundled robot.
    Bundled(BundledRobot),
    /// A robot of the user.
    Own(OwnRobot),
}

/// A robot that runs in another process.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnRobot {
    /// The name.
    pub name: String,
    /// The program.
    pub program: Program,
    /// The maximum time for an answer.
    pub answer_limit: Duration,
}

impl TrialRobot {
    /// Returns the name.
    pub fn name(&self) -> &str {
        match &self.kind {
            RobotKind::Bundled(robot) => robot.name(),
            RobotKind::Own(robot) => &robot.name,
        }
    }

    /// Returns true for a robot of the user.
    pub const fn is_own(&self) -> bool {
        matches!(self.kind, RobotKind::Own(_))
    }

    /// Prepares the robot for a trial.
    fn robot(
        &self,
        unexplored: KnownMaze,
        context: &RunContext,
    ) -> Result<Box<dyn Robot>, Shortage> {
        Ok(match &self.kind {
            RobotKind::Bundled(robot) => robot.robot(unexplored, &self.settings),
            RobotKind::Own(OwnRobot { program, answer_limit, .. }) => {
                let (stop, shows) = (Arc::clone(&context.must_stop), context.shows_stderr);
                Box::new(RobotProcess::start(program, &unexplored, *answer_limit, stop, shows)?)
            }
        })
    }

    /// Runs the robot in a maze. Returns `None` if it must stop.
    fn run(&self, maze: &Maze, context: &RunContext) -> Result<Option<TrialResult>, Shortage> {
        let watch = |_: &Trial<'_>, _: &KnownMaze| {
            if (context.must_stop)() { Err(()) } else { Ok(()) }
        };
        match self.run_watched(maze, context, watch) {
            Ok(result) => Ok(Some(result)),
            Err(TrialStop::Watch(())) => Ok(None),
            Err(TrialStop::Shortage(shortage)) => Err(shortage),
        }
    }

    /// Runs the robot. Calls `watch` before each step and at the end, with the trial and the part
    /// of the maze that the robot has seen. An error from `watch` stops the trial.
    ///
    /// # Errors
    /// Returns the error from `watch`, or what the system lacks.
    pub fn run_watched<E>(
        &self,
        maze: &Maze,
        context: &RunContext,
        mut watch: impl FnMut(&Trial<'_>, &KnownMaze) -> Result<(), E>,
    ) -> Result<TrialResult, TrialStop<E>> {
        let before = KnownMaze::unexplored(maze);
        let robot = self.robot(before.clone(), context);
        let mut robot = robot.map_err(TrialStop::Shortage)?;
        // The noise must not repeat the robot's random numbers.
        let mut noise = SensorNoise::new(self.settings.noise, !self.settings.seed);
        let (mut trial, mut survey) = (Trial::new(maze), Survey::new(before));
        let (mut explored, mut race) = (survey.map().clone(), Vec::new());
        let mut explore = vec![trial.pose().cell];
        loop {
            // The robot's own pose and map may be wrong.
            survey.set_pose(trial.pose());
            survey.observe(trial.readings());
            watch(&trial, survey.map()).map_err(TrialStop::Watch)?;
            let (phase, from) = (trial.phase(), trial.pose().cell);
            if phase == TrialPhase::Explore {
                explored.clone_from(survey.map());
            }
            if let Some(ending) = trial.outcome() {
                let steps = trial.explore_steps() + trial.race_steps();
                let failure = robot.failure().filter(|_| ending == TrialOutcome::Failed);
                return Ok(TrialResult {
                    ending,
                    failure: failure.map(|reason| format!("step {steps}: {reason}")),
                    explore_steps: trial.explore_steps(),
                    race_steps: trial.race_steps(),
                    race_optimum: race_optimum(maze.walls(), maze.start().cell, maze.goals()),
                    explored,
                    explore,
                    race,
                });
            }
            trial.act(robot.next_move(noise.apply(trial.readings())));
            match phase {
                TrialPhase::Race => race.extend(letters(from, trial.pose().cell)),
                // The reset puts the robot back at the start.
                TrialPhase::Explore if trial.phase() == TrialPhase::Race => {}
                TrialPhase::Explore => {
                    let crossed = letters(from, trial.pose().cell).map(|(cell, _)| cell);
                    explore.extend(crossed.skip(1).chain([trial.pose().cell]));
                }
            }
            if matches!(trial.outcome(), Some(TrialOutcome::Scored(_))) {
                race.push((trial.pose().cell, 'X'));
            }
        }
    }
}
