//! A trial and its outcome.

use std::cmp::Ordering;
use std::convert::Infallible;

use mmsim_maze::{Cell, Heading, KnownMaze, Maze};
use mmsim_trial::{
    BundledRobot, Score, SensorNoise, Settings, Survey, Trial, TrialOutcome, TrialPhase,
    race_optimum,
};

use crate::parallel::map_each;
use crate::selection::Selected;

/// A maze and a robot to run in it.
pub(crate) type Job<'a> = (&'a Selected, &'a Contender);

/// Runs trials on all processors. Returns the outcomes in the order of the jobs.
pub(crate) fn run_trials(jobs: &[Job<'_>]) -> Vec<TrialResult> {
    map_each(jobs, |(selected, contender)| contender.run(&selected.maze))
}

/// A robot and its settings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Contender {
    pub(crate) robot: BundledRobot,
    pub(crate) settings: Settings,
}

/// The outcome of a trial.
pub(crate) struct TrialResult {
    pub(crate) ending: TrialOutcome,
    pub(crate) explore_steps: u32,
    pub(crate) race_steps: u32,
    /// The minimum number of steps of a race in this maze; `None` if the goal is unreachable.
    pub(crate) race_optimum: Option<u16>,
    /// The part of the maze that the robot had seen when the race started.
    explored: KnownMaze,
    /// The cells of the race in order, each with a letter for the drawing.
    race: Vec<(Cell, char)>,
}

impl Contender {
    /// Runs the robot in a maze.
    fn run(&self, maze: &Maze) -> TrialResult {
        let Ok(outcome) = self.run_watched(maze, |_, _| Ok::<(), Infallible>(()));
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
        mut watch: impl FnMut(&Trial<'_>, &KnownMaze) -> Result<(), E>,
    ) -> Result<TrialResult, E> {
        let before = KnownMaze::unexplored(maze);
        let mut robot = self.robot.robot(before.clone(), &self.settings);
        // The noise must not repeat the robot's random numbers.
        let mut noise = SensorNoise::new(self.settings.noise, !self.settings.seed);
        let (mut trial, mut survey) = (Trial::new(maze), Survey::new(before));
        let (mut explored, mut race) = (survey.map().clone(), Vec::new());
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
                return Ok(TrialResult {
                    ending,
                    explore_steps: trial.explore_steps(),
                    race_steps: trial.race_steps(),
                    race_optimum: race_optimum(maze.walls(), maze.start().cell, maze.goals()),
                    explored,
                    race,
                });
            }
            trial.act(robot.next_move(noise.apply(trial.readings())));
            if phase == TrialPhase::Race {
                race.extend(letters(from, trial.pose().cell));
            }
            if matches!(trial.outcome(), Some(TrialOutcome::Scored(_))) {
                race.push((trial.pose().cell, 'X'));
            }
        }
    }
}

impl TrialResult {
    /// Returns the score if the robot scored.
    pub(crate) const fn score(&self) -> Option<Score> {
        match self.ending {
            TrialOutcome::Scored(score) => Some(score),
            TrialOutcome::OutOfTime | TrialOutcome::GaveUp => None,
        }
    }

    /// Returns true if the robot scored or correctly reported an unreachable goal.
    pub(crate) const fn succeeded(&self) -> bool {
        self.score().is_some() || self.is_correctly_given_up()
    }

    /// Returns true if the robot correctly reported an unreachable goal.
    pub(crate) const fn is_correctly_given_up(&self) -> bool {
        matches!(self.ending, TrialOutcome::GaveUp) && self.race_optimum.is_none()
    }

    /// Returns the score of a robot that knows the maze, or `None` if the goal is unreachable. Such
    /// a robot needs the minimum number of steps for each run, plus one step for the reset.
    pub(crate) fn bound(&self) -> Option<Score> {
        let optimum = u32::from(self.race_optimum?);
        Some(Score { explore_steps: optimum + 1, race_steps: optimum })
    }

    /// Returns the excess race steps and excess score compared with a robot that knows the maze.
    pub(crate) fn excess(&self) -> Option<(u32, f64)> {
        let (score, bound) = (self.score()?, self.bound()?);
        Some((score.race_steps - bound.race_steps, score.value() - bound.value()))
    }

    /// Returns the cells of the race in order, including those that the robot crossed.
    pub(crate) fn race_cells(&self) -> Vec<Cell> {
        self.race.iter().map(|&(cell, _)| cell).collect()
    }

    /// Draws the explored maze and the race as text, in a wide and a compact form.
    pub(crate) fn drawings(&self) -> [String; 2] {
        let letter = |cell| {
            let latest = self.race.iter().rfind(|(passed, _)| *passed == cell);
            latest.map(|&(_, letter)| letter)
        };
        let drawing = self.explored.picture().with_letters(&letter);
        [drawing.to_string(), drawing.compact().to_string()]
    }
}

/// Returns the cells that a step crosses, each with its letter in the drawing. The letter of the
/// first cell is uppercase.
fn letters(from: Cell, to: Cell) -> impl Iterator<Item = (Cell, char)> {
    let (heading, letter) = match (to.x.cmp(&from.x), to.y.cmp(&from.y)) {
        (_, Ordering::Greater) => (Heading::North, 'U'),
        (_, Ordering::Less) => (Heading::South, 'D'),
        (Ordering::Greater, _) => (Heading::East, 'R'),
        _ => (Heading::West, 'L'),
    };
    std::iter::successors(Some(from), move |cell| cell.neighbour(heading))
        .take_while(move |&cell| cell != to)
        .map(move |cell| (cell, if cell == from { letter } else { letter.to_ascii_lowercase() }))
}
