//! Prints the outcomes of trials as text or JSON.

use std::{io, mem};

use mmsim_compare::{TrialJob, TrialResult, TrialRow};

use super::args::TrialArgs;
use super::table::{ResultTable, summary};
use crate::args::CommandResult;
use crate::output::{print, print_pretty_json};
use crate::screen::wide_or_compact;

/// A printer for the outcomes of trials. Table lines are printed immediately, or after all drawings
/// if `--path` is set. JSON is printed after the last trial.
pub(crate) struct Results<'a> {
    jobs: &'a [TrialJob<'a>],
    args: &'a TrialArgs,
    table: ResultTable,
    lines: String,
    outcomes: Vec<TrialResult>,
}

impl<'a> Results<'a> {
    /// Creates a printer for the outcomes of `jobs`.
    pub(crate) fn new(jobs: &'a [TrialJob<'a>], args: &'a TrialArgs) -> Self {
        let table = ResultTable::new(jobs);
        Self { jobs, args, lines: table.head(), table, outcomes: Vec::new() }
    }

    /// Adds the outcomes of the next trials.
    pub(crate) fn add(&mut self, outcomes: Vec<TrialResult>) -> io::Result<()> {
        for (job, outcome) in self.jobs[self.outcomes.len()..].iter().zip(&outcomes) {
            self.lines += &self.table.line(job, outcome);
            if self.args.path && !self.args.json {
                let (selected, robot) = job;
                let drawing = wide_or_compact(outcome.drawings());
                print(&format!("{}, {}\n{drawing}\n", selected.shown_path(), robot.name()))?;
            }
        }
        self.outcomes.extend(outcomes);
        if self.args.path || self.args.json { Ok(()) } else { print(&mem::take(&mut self.lines)) }
    }

    /// Returns the outcomes so far, in the order of the jobs.
    pub(crate) fn outcomes(&self) -> &[TrialResult] {
        &self.outcomes
    }

    /// Prints the remaining output. Returns true if all trials succeeded.
    pub(crate) fn finish(self) -> CommandResult {
        let Self { jobs, args, lines, outcomes, .. } = self;
        if args.json {
            let reports = jobs.iter().zip(&outcomes).map(|(&(selected, robot), outcome)| {
                let mut report = TrialRow::new(selected, robot, outcome);
                report.path = args.path.then(|| outcome.drawings()).map(|[path, _]| path);
                report
            });
            print_pretty_json(&reports.collect::<Vec<_>>())?;
        } else if !jobs.is_empty() {
            print(&(lines + &summary(jobs, &outcomes)))?;
        }
        Ok(outcomes.iter().all(TrialResult::succeeded))
    }
}
