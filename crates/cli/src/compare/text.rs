//! The text output: tables, and the failures of each mouse.

use super::report::{CandidateReport, Report};
use crate::grid::aligned;
use crate::output::list_reasons;

impl Report {
    /// Returns the overview, the notes, the other tables, and the failures of each mouse.
    pub(crate) fn text(&self) -> String {
        let measures = self.measures.iter().zip(&self.statistics);
        let tables = measures.filter(|(measure, _)| measure.is_in_text).map(|(_, statistics)| {
            let differences = match statistics.candidates.len() {
                0 | 1 => "",
                _ => " Differences over the mazes that both mice solved.",
            };
            format!("{}{}{differences}\n", aligned(&statistics.table()), statistics.caption())
        });
        let notes = self.comparison.notes().iter().map(|note| format!("{note}\n"));
        let failures = (0..self.candidates.len()).filter_map(|candidate| self.failures(candidate));
        let sections = [aligned(self.comparison.overview())]
            .into_iter()
            .chain(notes)
            .chain(tables)
            .chain(failures);
        sections.collect::<Vec<_>>().join("\n")
    }

    /// Lists the most frequent reasons why a candidate failed.
    fn failures(&self, candidate: usize) -> Option<String> {
        let CandidateReport { strategy, mazes, .. } = &self.candidates[candidate];
        let path = |maze: usize| &*mazes[maze].maze.path;
        let reasons = self.comparison.failure_reasons(candidate);
        let reasons = reasons.iter().map(|reason| {
            let paths = reason.mazes.iter().map(|&maze| path(maze));
            (reason.text, paths.collect())
        });
        list_reasons(&format!("{strategy} failed"), reasons.collect())
    }
}

impl CandidateReport {
    /// Returns the overview of all candidates, with a header.
    pub(super) fn rows(candidates: &[Self]) -> Vec<Vec<String>> {
        let has_times = candidates.iter().any(|one| one.fastest_run_found.is_some());
        let rows = candidates.iter().map(Self::row);
        [Self::head(has_times)].into_iter().chain(rows).collect()
    }

    fn head(has_times: bool) -> Vec<String> {
        let mut head = vec![
            "mouse",
            "mazes",
            "goal reached",
            "correctly gave up",
            "failed",
            "shortest path found",
            "shortest path proven",
            "processor time (µs)",
        ];
        if has_times {
            head.insert(head.len() - 1, "fastest run found");
        }
        head.into_iter().map(String::from).collect()
    }

    fn row(&self) -> Vec<String> {
        let Self { reachable, goal_reached, rightly_given_up, .. } = self;
        let time = self.means.get("time_us").copied().flatten();
        let mut row = vec![
            self.strategy.clone(),
            self.mazes.len().to_string(),
            format!("{goal_reached}/{reachable}"),
            format!("{rightly_given_up}/{}", self.mazes.len() - reachable),
            self.failed.to_string(),
            self.shortest_path_found.to_string(),
            self.proven.to_string(),
            time.map_or("-".into(), |time| format!("{time:.1}")),
        ];
        if let Some(fastest) = self.fastest_run_found {
            row.insert(row.len() - 1, fastest.to_string());
        }
        row
    }
}
