//! Prints the outcomes of trials as tables or JSON.

use std::fmt::Write as _;
use std::{io, mem, ptr};

use mmsim_compare::{Means, TrialJob, TrialResult, TrialRow};

use crate::args::CommandResult;
use crate::grid::{padded, widest, wrapped};
use crate::output::{print, print_pretty_json};
use crate::screen::fitting;
use crate::terminal::columns;

/// How outcomes are printed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ResultForm {
    /// True to draw the explored maze and the race.
    pub(crate) path: bool,
    /// True for a JSON array.
    pub(crate) json: bool,
}

/// A printer for the outcomes of trials. Table lines are printed immediately, or after all drawings
/// if `--path` is set. JSON is printed after the last trial.
pub(crate) struct ResultPrinter<'a> {
    jobs: &'a [TrialJob<'a>],
    form: ResultForm,
    table: ResultTable,
    lines: String,
    outcomes: Vec<TrialResult>,
}

impl<'a> ResultPrinter<'a> {
    /// Creates a printer for the outcomes of `jobs`.
    pub(crate) fn new(jobs: &'a [TrialJob<'a>], form: ResultForm) -> Self {
        let table = ResultTable::new(jobs);
        Self { jobs, form, lines: table.head(), table, outcomes: Vec::new() }
    }

    /// Adds the outcomes of the next trials.
    pub(crate) fn add(&mut self, outcomes: Vec<TrialResult>) -> io::Result<()> {
        let jobs = self.jobs.iter().enumerate().skip(self.outcomes.len());
        for ((index, job), outcome) in jobs.zip(&outcomes) {
            let is_first = index == 0 || !ptr::eq(self.jobs[index - 1].0, job.0);
            self.lines += &self.table.line(job, outcome, is_first);
            if self.form.path && !self.form.json {
                let (selected, robot) = job;
                let drawings = outcome.drawings();
                let drawing = fitting(&drawings);
                print(&format!("{}, {}\n{drawing}\n", selected.shown_path(), robot.name()))?;
            }
        }
        self.outcomes.extend(outcomes);
        if self.form.path || self.form.json { Ok(()) } else { print(&mem::take(&mut self.lines)) }
    }

    /// Returns the outcomes so far, in the order of the jobs.
    pub(crate) fn outcomes(&self) -> &[TrialResult] {
        &self.outcomes
    }

    /// Prints the remaining output. Returns true if all trials succeeded.
    pub(crate) fn finish(self) -> CommandResult {
        let Self { jobs, form, lines, outcomes, .. } = self;
        if form.json {
            let reports = jobs.iter().zip(&outcomes).map(|(&(selected, robot), outcome)| {
                let mut report = TrialRow::new(selected, robot, outcome);
                report.drawing = form.path.then(|| outcome.drawings()).map(|[path, _]| path);
                report
            });
            print_pretty_json(&reports.collect::<Vec<_>>())?;
        } else if !jobs.is_empty() {
            print(&(lines + &summary(jobs, &outcomes)))?;
        }
        Ok(outcomes.iter().all(TrialResult::succeeded))
    }
}

/// The heads of the columns after those of the maze and the robot.
const HEADS: &str = "explore  race    score  optimum  race excess  score excess";

/// A table with fixed column widths. Each line can be printed before the next line is known.
struct ResultTable {
    /// The width of the column of mazes, or `None` if the table is too wide for the terminal. Each maze
    /// then has its own line.
    maze_width: Option<usize>,
    robot_width: usize,
}

impl ResultTable {
    fn new(jobs: &[TrialJob<'_>]) -> Self {
        let (mazes, robots) = (
            jobs.iter().map(|(selected, _)| selected.shown_path()),
            jobs.iter().map(|(_, robot)| robot.name().to_string()),
        );
        let maze_width = widest(mazes.chain(["maze".into()]));
        let robot_width = widest(robots.chain(["robot".into()]));
        let width = maze_width + 2 + robot_width + 2 + HEADS.len();
        Self { maze_width: Some(maze_width).filter(|_| width <= columns()), robot_width }
    }

    fn head(&self) -> String {
        self.row("maze", true, "robot", HEADS)
    }

    /// Formats the outcome of a trial, which may be the first in its maze.
    fn line(&self, (maze, robot): &TrialJob<'_>, outcome: &TrialResult, is_first: bool) -> String {
        let TrialResult { explore_steps, race_steps, .. } = outcome;
        let steps = format!("{explore_steps:>7}  {race_steps:>4}");
        let rest = match (outcome.score(), outcome.race_optimum, outcome.excess()) {
            (Some(score), Some(optimum), Some((race, excess))) => {
                format!("{score:>7}  {optimum:>7}  {race:>11}  {excess:>12.3}")
            }
            _ => outcome.reason().to_string(),
        };
        self.row(&maze.shown_path(), is_first, robot.name(), &format!("{steps}  {rest}"))
    }

    fn row(&self, maze: &str, is_first: bool, robot: &str, results: &str) -> String {
        let maze = match self.maze_width {
            Some(width) => padded(maze, width),
            None if is_first => format!("{maze}\n"),
            None => String::new(),
        };
        let results = format!("  {}  {results}", padded(robot, self.robot_width));
        maze + &if self.maze_width.is_some() { results } else { wrapped(&results, " ", 4) } + "\n"
    }
}

/// Returns a summary line for each robot that ran in several mazes.
fn summary(jobs: &[TrialJob<'_>], outcomes: &[TrialResult]) -> String {
    // Each maze has the same robots.
    let is_first = |(maze, _): &&TrialJob<'_>| ptr::eq(*maze, jobs[0].0);
    let robots = jobs.iter().take_while(is_first).count();
    let summaries = jobs.iter().take(robots).enumerate().map(|(index, (_, robot))| {
        sum_up(robot.name(), outcomes.iter().skip(index).step_by(robots))
    });
    summaries.filter(|_| robots < jobs.len()).collect()
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
    wrapped(&text, " ", 2) + "\n"
}
