//! A trial and what came of it.

use std::convert::Infallible;

use mmsim_maze::{Cell, Heading, KnownMaze, Maze};
use mmsim_trial::{
    BundledRobot, Score, SensorNoise, Settings, Survey, Trial, TrialOutcome, TrialPhase,
    race_optimum,
};

/// A robot and what it is told.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Contender {
    pub(crate) robot: BundledRobot,
    pub(crate) settings: Settings,
}

/// What came of a trial.
pub(crate) struct Tried {
    pub(crate) ending: TrialOutcome,
    pub(crate) explore_steps: u32,
    pub(crate) race_steps: u32,
    /// The fewest steps that a race takes in this maze; `None` if the goal cannot be reached.
    pub(crate) race_optimum: Option<u16>,
    /// What the robot could know of the maze when its race began.
    explored: KnownMaze,
    /// Where the race went on from a cell, in the order in which it did.
    race: Vec<(Cell, char)>,
}

impl Contender {
    /// Puts it on trial in this maze.
    pub(crate) fn stand_trial(&self, maze: &Maze) -> Tried {
        let Ok(tried) = self.stand_watched(maze, |_, _| Ok::<(), Infallible>(()));
        tried
    }

    /// The same with somebody who watches: before each step and at the end, `watch` is shown the
    /// trial and what there was to be seen until then. It may break the trial off.
    ///
    /// # Errors
    /// Those of `watch`.
    pub(crate) fn stand_watched<E>(
        &self,
        maze: &Maze,
        mut watch: impl FnMut(&Trial<'_>, &KnownMaze) -> Result<(), E>,
    ) -> Result<Tried, E> {
        let before = KnownMaze::unexplored(maze);
        let mut robot = self.robot.robot(before.clone(), &self.settings);
        // Another stream than the robot's own.
        let mut noise = SensorNoise::new(self.settings.noise, !self.settings.seed);
        let (mut trial, mut survey) = (Trial::new(maze), Survey::new(before));
        let (mut explored, mut race) = (survey.map().clone(), Vec::new());
        loop {
            // The robot may reckon wrongly where it is and what it sees.
            survey.set_pose(trial.pose());
            survey.observe(trial.readings());
            watch(&trial, survey.map())?;
            let (run, from) = (trial.phase(), trial.pose().cell);
            if run == TrialPhase::Explore {
                explored.clone_from(survey.map());
            }
            if let Some(ending) = trial.outcome() {
                return Ok(Tried {
                    ending,
                    explore_steps: trial.explore_steps(),
                    race_steps: trial.race_steps(),
                    race_optimum: race_optimum(maze.walls(), maze.start().cell, maze.goals()),
                    explored,
                    race,
                });
            }
            trial.act(robot.next_move(noise.apply(trial.readings())));
            if run == TrialPhase::Race {
                race.extend(letters(from, trial.pose().cell));
            }
            if matches!(trial.outcome(), Some(TrialOutcome::Scored(_))) {
                race.push((trial.pose().cell, 'X'));
            }
        }
    }
}

impl Tried {
    /// The score, if there is one.
    pub(crate) const fn score(&self) -> Option<Score> {
        match self.ending {
            TrialOutcome::Scored(score) => Some(score),
            TrialOutcome::OutOfTime | TrialOutcome::GaveUp => None,
        }
    }

    /// Whether the robot did what there was to do: scored, or said rightly that the goal cannot be
    /// reached.
    pub(crate) const fn is_done(&self) -> bool {
        self.score().is_some() || self.is_rightly_given_up()
    }

    /// Whether it said rightly that the goal cannot be reached.
    pub(crate) const fn is_rightly_given_up(&self) -> bool {
        matches!(self.ending, TrialOutcome::GaveUp) && self.race_optimum.is_none()
    }

    /// The score of a robot that knows the maze: it explores as fast as it races, with one step more
    /// for the reset. `None` if the goal cannot be reached.
    pub(crate) fn bound(&self) -> Option<Score> {
        let optimum = u32::from(self.race_optimum?);
        Some(Score { explore_steps: optimum + 1, race_steps: optimum })
    }

    /// How many steps the race took beyond the fewest, and how much the score is above the bound.
    pub(crate) fn over(&self) -> Option<(u32, f64)> {
        let (score, bound) = (self.score()?, self.bound()?);
        Some((score.race_steps - bound.race_steps, score.value() - bound.value()))
    }

    /// What was explored and the race in it, as text: wide and compact.
    pub(crate) fn drawings(&self) -> [String; 2] {
        let letter = |cell| {
            let latest = self.race.iter().rfind(|(passed, _)| *passed == cell);
            latest.map(|&(_, letter)| letter)
        };
        let drawing = self.explored.picture().with_letters(&letter);
        [drawing.to_string(), drawing.compact().to_string()]
    }
}

/// The letters of a step in the cells that it leaves: large where it begins.
fn letters(from: Cell, to: Cell) -> impl Iterator<Item = (Cell, char)> {
    let (heading, letter) = if to.y > from.y {
        (Heading::North, 'U')
    } else if to.y < from.y {
        (Heading::South, 'D')
    } else if to.x > from.x {
        (Heading::East, 'R')
    } else {
        (Heading::West, 'L')
    };
    std::iter::successors(Some(from), move |cell| cell.neighbour(heading))
        .take_while(move |&cell| cell != to)
        .map(move |cell| (cell, if cell == from { letter } else { letter.to_ascii_lowercase() }))
}
