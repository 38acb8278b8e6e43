//! The text output: tables, and the failures of each mouse.

use mmsim_maze::Escaped;

use super::measures::MEASURES;
use super::report::{CandidateReport, Report};
use crate::grid::aligned;
use crate::output::counted;

/// The number of failures of each mouse that are named.
const NAMED_FAILURES: usize = 3;

impl Report {
    /// Returns the tables, and the first failures of each mouse.
    pub(crate) fn text(&self) -> String {
        let measures = MEASURES.iter().zip(&self.statistics);
        let tables = measures.filter(|(measure, _)| measure.is_in_text).map(|(_, statistics)| {
            format!("{}{}\n", aligned(&statistics.table()), statistics.caption())
        });
        let notes = self.comparison.notes().iter().map(|note| format!("{note}\n"));
        let failures = (0..self.candidates.len()).filter_map(|candidate| self.failures(candidate));
        let sections = [aligned(self.comparison.overview())]
            .into_iter()
            .chain(tables)
            .chain(notes)
            .chain(failures);
        sections.collect::<Vec<_>>().join("\n")
    }

    /// Lists the first failures of a candidate.
    fn failures(&self, candidate: usize) -> Option<String> {
        let failures = self.comparison.failures().iter();
        let failures: Vec<_> = failures.filter(|failure| failure.candidate == candidate).collect();
        let CandidateReport { strategy, mazes, .. } = &self.candidates[candidate];
        let count = counted(failures.len() as u64, "maze");
        let mut lines = vec![format!("{} failed in {count}:\n", Escaped(strategy))];
        lines.extend(failures.iter().take(NAMED_FAILURES).map(|failure| {
            let maze = &mazes[failure.maze].maze.path;
            format!("  {}: {}\n", Escaped(maze), Escaped(&failure.reason))
        }));
        if failures.len() > NAMED_FAILURES {
            lines.push(format!("  and {} more (see --json)\n", failures.len() - NAMED_FAILURES));
        }
        (!failures.is_empty()).then(|| lines.concat())
    }
}

impl CandidateReport {
    /// Returns the overview of all candidates, with a header.
    pub(super) fn rows(candidates: &[Self]) -> Vec<Vec<String>> {
        [Self::head()].into_iter().chain(candidates.iter().map(Self::row)).collect()
    }

    fn head() -> Vec<String> {
        let head = [
            "mouse",
            "mazes",
            "goal reached",
            "correctly gave up",
            "failed",
            "shortest path found",
            "shortest path proven",
            "processor time (µs)",
        ];
        head.map(String::from).into()
    }

    fn row(&self) -> Vec<String> {
        let Self { reachable, goal_reached, rightly_given_up, .. } = self;
        let time = self.means.get("time_us").copied().flatten();
        vec![
            self.strategy.clone(),
            self.mazes.len().to_string(),
            format!("{goal_reached}/{reachable}"),
            format!("{rightly_given_up}/{}", self.mazes.len() - reachable),
            self.failed.to_string(),
            self.shortest_path_found.to_string(),
            self.proven.to_string(),
            time.map_or("-".into(), |time| format!("{time:.1}")),
        ]
    }
}
