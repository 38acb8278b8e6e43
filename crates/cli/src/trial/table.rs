//! What came of trials, as a table for people.

use std::fmt::Write as _;

use mmsim_trial::{BundledRobot, TrialOutcome};

use super::Job;
use super::tried::Tried;

/// A table of which all is known beforehand that its columns' widths depend on, so that its lines
/// can be printed one by one.
pub(crate) struct Table {
    maze_width: usize,
    robot_width: usize,
}

impl Table {
    pub(crate) fn new(jobs: &[Job<'_>]) -> Self {
        let widest = |head: &str, names: &mut dyn Iterator<Item = String>| {
            names.map(|name| name.chars().count()).fold(head.len(), usize::max)
        };
        Self {
            maze_width: widest("maze", &mut jobs.iter().map(|(given, _)| given.shown_path())),
            robot_width: widest("robot", &mut jobs.iter().map(|(_, of)| of.robot.to_string())),
        }
    }

    pub(crate) fn head(&self) -> String {
        self.row("maze", "robot", "explore  race    score  optimum  race over  score over")
    }

    pub(crate) fn line(&self, (given, contender): &Job<'_>, tried: &Tried) -> String {
        let Tried { explore_steps, race_steps, .. } = tried;
        let steps = format!("{explore_steps:>7}  {race_steps:>4}");
        let rest = match (tried.score(), tried.race_optimum, tried.over()) {
            (Some(score), Some(optimum), Some((race, over))) => {
                format!("{score:>7}  {optimum:>7}  {race:>9}  {over:>10.3}")
            }
            _ => ending(tried).into(),
        };
        self.row(&given.shown_path(), contender.robot.name(), &format!("{steps}  {rest}"))
    }

    fn row(&self, maze: &str, robot: &str, results: &str) -> String {
        let Self { maze_width, robot_width } = self;
        format!("{maze:<maze_width$}  {robot:<robot_width$}  {results}\n")
    }
}

/// What happened instead of a score.
fn ending(tried: &Tried) -> &'static str {
    match (tried.ending, tried.race_optimum) {
        (TrialOutcome::GaveUp, None) => "goal cannot be reached",
        (TrialOutcome::GaveUp, Some(_)) => "gave up, but the goal can be reached",
        (TrialOutcome::OutOfTime, None) => "out of time, the goal cannot be reached",
        (TrialOutcome::OutOfTime | TrialOutcome::Scored(_), _) => "out of time",
    }
}

/// A line for each robot that was tried in several mazes.
pub(crate) fn summary(jobs: &[Job<'_>], tried: &[Tried]) -> String {
    let mut robots: Vec<BundledRobot> = jobs.iter().map(|(_, contender)| contender.robot).collect();
    robots.sort_by_key(|robot| BundledRobot::ALL.iter().position(|other| other == robot));
    robots.dedup();
    let of_robot = |robot| {
        let all = jobs.iter().zip(tried);
        all.filter(move |((_, contender), _)| contender.robot == robot).map(|(_, tried)| tried)
    };
    let several = robots.into_iter().filter(|&robot| of_robot(robot).count() > 1);
    several.map(|robot| sum_up(robot, of_robot(robot))).collect()
}

fn sum_up<'a>(robot: BundledRobot, tried: impl Iterator<Item = &'a Tried> + Clone) -> String {
    let Means { scored, explore_steps, race_steps, score, over } = Means::of(tried.clone());
    let mut text = format!("{robot}: {scored} of {} trials scored", tried.clone().count());
    let rightly = tried.filter(|tried| tried.is_rightly_given_up()).count();
    // Writing to a string cannot fail.
    if rightly > 0 {
        let _ = write!(text, ", {rightly} told rightly that the goal cannot be reached");
    }
    if scored > 0 {
        let _ = write!(
            text,
            "; on average {explore_steps:.1} steps explored, {race_steps:.1} raced, \
             score {score:.3}, {over:.3} over"
        );
    }
    text + "\n"
}

/// The means over those trials that scored.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Means {
    pub(crate) scored: usize,
    pub(crate) explore_steps: f64,
    pub(crate) race_steps: f64,
    pub(crate) score: f64,
    /// How much the score is above that of a robot that knows the maze.
    pub(crate) over: f64,
}

impl Means {
    pub(crate) fn of<'a>(tried: impl Iterator<Item = &'a Tried>) -> Self {
        let (mut sums, mut count) = (Self::default(), 0.);
        for (tried, score) in tried.filter_map(|tried| Some((tried, tried.score()?))) {
            count += 1.;
            sums.scored += 1;
            sums.explore_steps += f64::from(score.explore_steps);
            sums.race_steps += f64::from(score.race_steps);
            sums.score += score.value();
            sums.over += tried.over().map_or(0., |(_, over)| over);
        }
        Self {
            scored: sums.scored,
            explore_steps: sums.explore_steps / count,
            race_steps: sums.race_steps / count,
            score: sums.score / count,
            over: sums.over / count,
        }
    }
}
