//! The outcome of a trial.

use std::cmp::Ordering;

use mmsim_maze::{Cell, Heading, KnownMaze};
use mmsim_trial::{Score, TrialOutcome};

/// The outcome of a trial.
pub(crate) struct TrialResult {
    pub(crate) ending: TrialOutcome,
    /// The step in which the robot failed, and the reason.
    pub(crate) failure: Option<String>,
    pub(crate) explore_steps: u32,
    pub(crate) race_steps: u32,
    /// The minimum number of steps of a race in this maze; `None` if the goal is unreachable.
    pub(crate) race_optimum: Option<u16>,
    /// The part of the maze that the robot had seen when the race started.
    pub(super) explored: KnownMaze,
    /// The cells of the first run in order, including those that the robot crossed.
    pub(super) explore: Vec<Cell>,
    /// The cells of the race in order, each with a letter for the drawing.
    pub(super) race: Vec<(Cell, char)>,
}

impl TrialResult {
    /// Returns the score if the robot scored.
    pub(crate) const fn score(&self) -> Option<Score> {
        match self.ending {
            TrialOutcome::Scored(score) => Some(score),
            _ => None,
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
