//! Formats the outcomes of trials as a table.

use std::fmt::Write as _;

use mmsim_trial::TrialOutcome;

use super::contender::{Contender, Job};
use super::outcome::TrialResult;
use crate::grid::{padded, widest};

/// A table with fixed column widths. Each line can be printed before the next line is known.
pub(crate) struct ResultTable {
    maze_width: usize,
    robot_width: usize,
}

impl ResultTable {
    pub(crate) fn new(jobs: &[Job<'_>]) -> Self {
        let (mazes, robots) = (
            jobs.iter().map(|(selected, _)| selected.shown_path()),
            jobs.iter().map(|(_, contender)| contender.name().to_string()),
        );
        Self {
            maze_width: widest(mazes.chain(["maze".into()])),
            robot_width: widest(robots.chain(["robot".into()])),
        }
    }

    pub(crate) fn head(&self) -> String {
        self.row("maze", "robot", "explore  race    score  optimum  race excess  score excess")
    }

    pub(crate) fn line(&self, (selected, contender): &Job<'_>, outcome: &TrialResult) -> String {
        let TrialResult { explore_steps, race_steps, .. } = outcome;
        let steps = format!("{explore_steps:>7}  {race_steps:>4}");
        let rest = match (outcome.score(), outcome.race_optimum, outcome.excess()) {
            (Some(score), Some(optimum), Some((race, excess))) => {
                format!("{score:>7}  {optimum:>7}  {race:>11}  {excess:>12.3}")
            }
            _ => failure(outcome).to_string(),
        };
        self.row(&selected.shown_path(), contender.name(), &format!("{steps}  {rest}"))
    }

    fn row(&self, maze: &str, robot: &str, results: &str) -> String {
        let Self { maze_width, robot_width } = self;
        let (maze, robot) = (padded(maze, *maze_width), padded(robot, *robot_width));
        format!("{maze}  {robot}  {results}\n")
    }
}

/// Returns the reason why a trial has no score.
pub(super) fn failure(outcome: &TrialResult) -> &str {
    match (outcome.ending, outcome.race_optimum) {
        (TrialOutcome::Failed, _) => outcome.failure.as_deref().unwrap_or("failed"),
        (TrialOutcome::GaveUp, None) => "goal unreachable",
        (TrialOutcome::GaveUp, Some(_)) => "gave up, but the goal is reachable",
        (TrialOutcome::OutOfTime, None) => "out of time, goal unreachable",
        (TrialOutcome::OutOfTime | TrialOutcome::Scored(_), _) => "out of time",
    }
}

/// Returns a summary line for each robot that ran in several mazes.
pub(crate) fn summary(jobs: &[Job<'_>], outcomes: &[TrialResult]) -> String {
    let mut contenders: Vec<&Contender> = Vec::new();
    for &(_, contender) in jobs {
        if !contenders.contains(&contender) {
            contenders.push(contender);
        }
    }
    let summaries = contenders.into_iter().filter_map(|contender| {
        let all = jobs.iter().zip(outcomes).filter(|((_, other), _)| *other == contender);
        let outcomes = all.map(|(_, outcome)| outcome);
        (outcomes.clone().count() > 1).then(|| sum_up(contender.name(), outcomes))
    });
    summaries.collect()
}

fn sum_up<'a>(robot: &str, outcomes: impl Iterator<Item = &'a TrialResult> + Clone) -> String {
    let Means { scored, explore_steps, race_steps, score, excess } = Means::new(outcomes.clone());
    let mut text = format!("{robot}: {scored} of {} trials scored", outcomes.clone().count());
    let given_up = outcomes.filter(|outcome| outcome.is_correctly_given_up()).count();
    // Writing to a string cannot fail.
    if given_up > 0 {
        let _ = write!(text, ", {given_up} correctly reported an unreachable goal");
    }
    if scored > 0 {
        let _ = write!(
            text,
            "; means: {explore_steps:.1} explore steps, {race_steps:.1} race steps, \
             score {score:.3}, score excess {excess:.3}"
        );
    }
    text + "\n"
}

/// The means over all trials with a score.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Means {
    pub(crate) scored: usize,
    pub(crate) explore_steps: f64,
    pub(crate) race_steps: f64,
    pub(crate) score: f64,
    /// The mean amount by which the scores exceed those of a robot that knows the maze.
    pub(crate) excess: f64,
}

impl Means {
    pub(crate) fn new<'a>(outcomes: impl Iterator<Item = &'a TrialResult>) -> Self {
        let (mut sums, mut count) = (Self::default(), 0.);
        for (outcome, score) in outcomes.filter_map(|outcome| Some((outcome, outcome.score()?))) {
            count += 1.;
            sums.scored += 1;
            sums.explore_steps += f64::from(score.explore_steps);
            sums.race_steps += f64::from(score.race_steps);
            sums.score += score.value();
            sums.excess += outcome.excess().map_or(0., |(_, excess)| excess);
        }
        Self {
            scored: sums.scored,
            explore_steps: sums.explore_steps / count,
            race_steps: sums.race_steps / count,
            score: sums.score / count,
            excess: sums.excess / count,
        }
    }
}
