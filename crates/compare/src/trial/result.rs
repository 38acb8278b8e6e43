//! The outcome of a trial.

use std::cmp::Ordering;

use mmsim_maze::{Cell, Heading, KnownMaze};
use mmsim_trial::{Score, TrialOutcome, TrialStatus};

/// The outcome of a trial.
pub struct TrialResult {
    /// How the trial ended.
    pub ending: TrialOutcome,
    /// The step in which the robot failed, and the reason.
    pub failure: Option<String>,
    /// The number of steps of the first run.
    pub explore_steps: u32,
    /// The number of steps of the race.
    pub race_steps: u32,
    /// The minimum number of steps of a race in this maze; `None` if the goal is unreachable.
    pub race_optimum: Option<u16>,
    /// The part of the maze that the robot had seen when the race started.
    pub explored: KnownMaze,
    /// The cells of the first run in order, including those that the robot crossed.
    pub explore: Vec<Cell>,
    /// The cells of the race in order, each with a letter for the drawing.
    pub(super) race: Vec<(Cell, char)>,
}

impl TrialResult {
    /// Returns the score if the robot scored.
    pub const fn score(&self) -> Option<Score> {
        match self.ending {
            TrialOutcome::Scored(score) => Some(score),
            _ => None,
        }
    }

    /// Returns true if the robot scored or correctly reported an unreachable goal.
    pub const fn succeeded(&self) -> bool {
        self.score().is_some() || self.is_correctly_given_up()
    }

    /// Returns true if the robot correctly reported an unreachable goal.
    pub const fn is_correctly_given_up(&self) -> bool {
        matches!(self.ending, TrialOutcome::GaveUp) && self.race_optimum.is_none()
    }

    /// Returns the score of a robot that knows the maze, or `None` if the goal is unreachable. Such
    /// a robot needs the minimum number of steps for each run, plus one step for the reset.
    pub fn bound(&self) -> Option<Score> {
        let optimum = u32::from(self.race_optimum?);
        Some(Score { explore_steps: optimum + 1, race_steps: optimum })
    }

    /// Returns the excess race steps and excess score compared with a robot that knows the maze.
    pub fn excess(&self) -> Option<(u32, f64)> {
        let (score, bound) = (self.score()?, self.bound()?);
        Some((score.race_steps - bound.race_steps, score.value() - bound.value()))
    }

    /// Returns the reason why the trial has no score.
    pub fn reason(&self) -> &str {
        match (self.ending, self.race_optimum) {
            (TrialOutcome::Failed, _) => self.failure.as_deref().unwrap_or("failed"),
            (TrialOutcome::GaveUp, None) => "goal unreachable",
            (TrialOutcome::GaveUp, Some(_)) => "gave up, but the goal is reachable",
            (TrialOutcome::OutOfTime, None) => "out of time, goal unreachable",
            (TrialOutcome::OutOfTime | TrialOutcome::Scored(_), _) => "out of time",
        }
    }

    /// Returns the steps of both runs, and the score or how the trial ended.
    pub(super) fn summary(&self) -> String {
        let Self { explore_steps, race_steps, .. } = self;
        let ending = match self.score() {
            Some(score) => format!(" = {score}"),
            None => format!(", {}", TrialStatus::from_outcome(self.ending)),
        };
        format!("{explore_steps} + {race_steps}{ending}")
    }

    /// Returns the cells of the race in order, including those that the robot crossed.
    pub fn race_cells(&self) -> Vec<Cell> {
        self.race.iter().map(|&(cell, _)| cell).collect()
    }

    /// Draws the explored maze and the race as text, in a wide and a compact form.
    pub fn drawings(&self) -> [String; 2] {
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
pub(super) fn letters(from: Cell, to: Cell) -> impl Iterator<Item = (Cell, char)> {
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

/// The means over all trials with a score.
#[derive(Clone, Copy, Debug, Default)]
pub struct Means {
    /// The number of trials with a score.
    pub scored: usize,
    /// The mean number of steps of the first run.
    pub explore_steps: f64,
    /// The mean number of steps of the race.
    pub race_steps: f64,
    /// The mean score.
    pub score: f64,
    /// The mean amount by which the scores exceed those of a robot that knows the maze.
    pub excess: f64,
}

impl Means {
    /// Calculates the means. Without a score, they are not numbers.
    pub fn new<'a>(results: impl Iterator<Item = &'a TrialResult> + Clone) -> Self {
        let scored = results.filter_map(|result| Some((result.score()?, result.excess()?.1)));
        let count = scored.clone().map(|_| 1.).sum::<f64>();
        let mean = |value: fn((Score, f64)) -> f64| scored.clone().map(value).sum::<f64>() / count;
        Self {
            scored: scored.clone().count(),
            explore_steps: mean(|(score, _)| score.explore_steps.into()),
            race_steps: mean(|(score, _)| score.race_steps.into()),
            score: mean(|(score, _)| score.value()),
            excess: mean(|(_, excess)| excess),
        }
    }
}
