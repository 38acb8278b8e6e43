//! The robots that take part in trials.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use mmsim_maze::{KnownMaze, Maze};
use mmsim_trial::{
    BundledRobot, Robot, SensorNoise, Settings, Survey, Trial, TrialOutcome, TrialPhase,
    race_optimum,
};

use super::outcome::{TrialResult, letters};
use super::robot_process::RobotProcess;
use crate::mouse_process::Program;
use crate::parallel::map_each;
use crate::selection::Selected;

/// A maze and a robot to run in it.
pub(crate) type Job<'a> = (&'a Selected, &'a Contender);

/// How the robots of the user run.
#[derive(Clone, Debug, Default)]
pub(crate) struct RunContext {
    /// True once the robots must stop.
    pub(crate) is_interrupted: Arc<AtomicBool>,
    /// True if stderr of a robot is copied to stderr of this process.
    pub(crate) shows_stderr: bool,
}

/// Runs trials on all processors. Returns the outcomes in the order of the jobs.
pub(crate) fn run_trials(jobs: &[Job<'_>], context: &RunContext) -> Vec<TrialResult> {
    map_each(jobs, |(selected, contender)| contender.run(&selected.maze, context))
}

/// A robot and its settings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Contender {
    pub(crate) kind: RobotKind,
    pub(crate) settings: Settings,
}

/// A bundled robot or a robot of the user.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RobotKind {
    Bundled(BundledRobot),
    Own(OwnRobot),
}

/// A robot that runs in another process.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OwnRobot {
    pub(crate) name: String,
    pub(crate) program: Program,
    /// The maximum time for an answer.
    pub(crate) answer_limit: Duration,
}

impl Contender {
    pub(crate) fn name(&self) -> &str {
        match &self.kind {
            RobotKind::Bundled(robot) => robot.name(),
            RobotKind::Own(robot) => &robot.name,
        }
    }

    /// Returns true for a robot of the user.
    pub(crate) const fn is_own(&self) -> bool {
        matches!(self.kind, RobotKind::Own(_))
    }

    /// Prepares the robot for a trial.
    fn robot(&self, unexplored: KnownMaze, context: &RunContext) -> Box<dyn Robot> {
        match &self.kind {
            RobotKind::Bundled(robot) => robot.robot(unexplored, &self.settings),
            RobotKind::Own(OwnRobot { program, answer_limit, .. }) => {
                Box::new(RobotProcess::start(program, &unexplored, *answer_limit, context))
            }
        }
    }

    /// Runs the robot in a maze.
    fn run(&self, maze: &Maze, context: &RunContext) -> TrialResult {
        let Ok(outcome) = self.run_watched(maze, context, |_, _| Ok::<(), Infallible>(()));
        outcome
    }

    /// Runs the robot. Calls `watch` before each step and at the end, with the trial and the part
    /// of the maze that the robot has seen. An error from `watch` stops the trial.
    ///
    /// # Errors
    /// Returns the error from `watch`.
    pub(crate) fn run_watched<E>(
        &self,
        maze: &Maze,
        context: &RunContext,
        mut watch: impl FnMut(&Trial<'_>, &KnownMaze) -> Result<(), E>,
    ) -> Result<TrialResult, E> {
        let before = KnownMaze::unexplored(maze);
        let mut robot = self.robot(before.clone(), context);
        // The noise must not repeat the robot's random numbers.
        let mut noise = SensorNoise::new(self.settings.noise, !self.settings.seed);
        let (mut trial, mut survey) = (Trial::new(maze), Survey::new(before));
        let (mut explored, mut race) = (survey.map().clone(), Vec::new());
        let mut explore = vec![trial.pose().cell];
        loop {
            // The robot's own pose and map may be wrong.
            survey.set_pose(trial.pose());
            survey.observe(trial.readings());
            watch(&trial, survey.map())?;
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
