//! The text output: tables, and the failures of each mouse.

use mmsim_compare::{MouseSummary, SearchComparison};

use crate::grid::aligned;
use crate::output::list_reasons;

/// Returns the overview, the notes, the other tables, and the failures of each mouse.
pub(super) fn text(report: &SearchComparison) -> String {
    let measures = report.measures.iter().zip(&report.statistics);
    let tables = measures.filter(|(measure, _)| measure.is_in_text).map(|(_, statistics)| {
        let differences = match statistics.candidates.len() {
            0 | 1 => "",
            _ => " Differences over the mazes that both mice solved.",
        };
        format!("{}{}{differences}\n", aligned(&statistics.table()), statistics.caption())
    });
    let notes = report.comparison.notes.iter().map(|note| format!("{note}\n"));
    let failures = (0..report.mice.len()).filter_map(|mouse| failures(report, mouse));
    let overview = aligned(&report.comparison.overview);
    [overview].into_iter().chain(notes).chain(tables).chain(failures).collect::<Vec<_>>().join("\n")
}

/// Lists the most frequent reasons why a mouse failed.
fn failures(report: &SearchComparison, mouse: usize) -> Option<String> {
    let MouseSummary { strategy, mazes, .. } = &report.mice[mouse];
    let failures = report.comparison.failures().iter().filter(|one| one.candidate == mouse);
    let reasons = failures.map(|one| (&*one.reason, &*mazes[one.maze].maze.path));
    list_reasons(&format!("{strategy} failed"), reasons)
}
