//! The failures of each candidate, grouped by reason.

use maud::{Markup, html};

use crate::comparison::{Comparison, FailureReason};
use crate::text::{clean, shortened};

/// The maximum number of reasons that are listed for a candidate.
const MAX_REASONS: usize = 10;
/// The maximum number of mazes that are named for a reason.
const MAX_EXAMPLES: usize = 3;

impl Comparison {
    /// Returns a table of failures, the most frequent reasons first, or nothing if there are no
    /// failures.
    pub(super) fn failures_section(&self) -> Markup {
        let candidates = self.candidates().iter().enumerate();
        let reasons: Vec<_> = candidates
            .map(|(index, candidate)| (candidate, self.failure_reasons(index)))
            .filter(|(_, reasons)| !reasons.is_empty())
            .collect();
        html! {
            @if !self.failures().is_empty() {
                section {
                    h2 { "Failures" }
                    div class="scroll" {
                        table class="grouped" {
                            thead {
                                tr {
                                    th {} th { "failures" } th { "mazes" }
                                    th class="text" { "reason" } th class="text" { "for example in" }
                                }
                            }
                            @for (candidate, reasons) in &reasons { tbody { (self.reason_rows(&candidate.name, reasons)) } }
                        }
                    }
                }
            }
        }
    }

    fn reason_rows(&self, candidate: &str, reasons: &[FailureReason<'_>]) -> Markup {
        let total: usize = reasons.iter().map(|reason| reason.mazes.len()).sum();
        let (listed, others) = reasons.split_at(MAX_REASONS.min(reasons.len()));
        let other_mazes: usize = others.iter().map(|reason| reason.mazes.len()).sum();
        let others = match others.len() {
            0 => None,
            1 => Some("another reason".into()),
            count => Some(format!("{count} other reasons")),
        };
        let others = others.map(|text| (other_mazes, text, String::new()));
        let listed = listed.iter().map(|FailureReason { text, mazes }| {
            (mazes.len(), shortened(text, 300), self.examples(mazes))
        });
        html! {
            @for (index, (count, reason, examples)) in listed.chain(others).enumerate() {
                tr {
                    @if index == 0 {
                        th { (clean(candidate)) }
                        td { data class="failures" value=(total) { (total) } }
                    } @else { th {} td {} }
                    td { (count) }
                    td class="text" { (reason) }
                    td class="text" { (examples) }
                }
            }
        }
    }

    fn examples(&self, mazes: &[usize]) -> String {
        let names = mazes.iter().take(MAX_EXAMPLES).filter_map(|&maze| self.mazes().get(maze));
        let more = if mazes.len() > MAX_EXAMPLES { ", …" } else { "" };
        names.map(|name| clean(name)).collect::<Vec<_>>().join(", ") + more
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_grouped_by_reason() {
        let mazes = (0..20).map(|maze| format!("m{maze}")).collect();
        let names = vec!["mine".into(), "flood-fill".into(), "left-wall".into()];
        let comparison =
            Comparison::new("", names, mazes).with_failures(|candidate, maze| {
                match (candidate, maze) {
                    (0, 2) => Some("stopped".into()),
                    (0, 3..8) => Some("crashed <hard>".into()),
                    (2, _) => Some(format!("reason {}", maze % 12)),
                    _ => None,
                }
            });
        let text = comparison.failures_section().into_string();
        let text = text.replace("</tr>", "\n").replace("</th>", "|").replace("</td>", "|");
        let mut plain = String::new();
        for piece in text.split('<') {
            plain += piece.split_once('>').map_or(piece, |(_, text)| text);
        }
        insta::assert_snapshot!(plain, @"
        Failures|failures|mazes|reason|for example in|
        mine|6|5|crashed &lt;hard&gt;|m3, m4, m5, …|
        ||1|stopped|m2|
        left-wall|20|2|reason 0|m0, m12|
        ||2|reason 1|m1, m13|
        ||2|reason 2|m2, m14|
        ||2|reason 3|m3, m15|
        ||2|reason 4|m4, m16|
        ||2|reason 5|m5, m17|
        ||2|reason 6|m6, m18|
        ||2|reason 7|m7, m19|
        ||1|reason 8|m8|
        ||1|reason 9|m9|
        ||2|2 other reasons||
        ");
    }

    #[test]
    fn there_is_no_section_without_failures() {
        let comparison = Comparison::new("", vec!["mine".into()], vec!["maze".into()]);
        assert_eq!(comparison.failures_section().into_string(), "");
    }
}
