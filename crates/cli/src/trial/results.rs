//! What came of trials, printed for people or programs.

use std::io;
use std::mem;

use super::report::Report;
use super::table::{Table, summary};
use super::tried::Tried;
use super::{Job, TrialArgs};
use crate::Outcome;
use crate::output::{print, print_json};
use crate::screen::wide_or_compact;

/// Prints each line as soon as it is there; where drawings are asked for those, and the table at the
/// end; as JSON everything at the end.
pub(crate) struct Results<'a> {
    jobs: &'a [Job<'a>],
    args: &'a TrialArgs,
    table: Table,
    lines: String,
    tried: Vec<Tried>,
}

impl<'a> Results<'a> {
    /// Of these trials nothing is known yet.
    pub(crate) fn new(jobs: &'a [Job<'a>], args: &'a TrialArgs) -> Self {
        let table = Table::new(jobs);
        Self { jobs, args, lines: table.head(), table, tried: Vec::new() }
    }

    /// What came of the next ones.
    pub(crate) fn add(&mut self, tried: Vec<Tried>) -> io::Result<()> {
        for (job, tried) in self.jobs[self.tried.len()..].iter().zip(&tried) {
            self.lines += &self.table.line(job, tried);
            if self.args.path && !self.args.json {
                let (given, contender) = job;
                let drawing = wide_or_compact(tried.drawings());
                print(&format!("{}, {}\n{drawing}\n", given.shown_path(), contender.robot))?;
            }
        }
        self.tried.extend(tried);
        if self.args.path || self.args.json { Ok(()) } else { print(&mem::take(&mut self.lines)) }
    }

    /// Nothing more will come. Says whether each robot did what there was to do.
    pub(crate) fn finish(self) -> Outcome {
        let Self { jobs, args, lines, tried, .. } = self;
        if args.json {
            let reports = jobs.iter().zip(&tried).map(|(&(given, contender), tried)| {
                let report = Report::of(given, contender, tried);
                if args.path { report.with_path(tried) } else { report }
            });
            print_json(&serde_json::to_string_pretty(&reports.collect::<Vec<_>>())?)?;
        } else if !jobs.is_empty() {
            print(&(lines + &summary(jobs, &tried)))?;
        }
        Ok(tried.iter().all(Tried::is_done))
    }
}
