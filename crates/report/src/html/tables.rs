//! Tables of statistics, values and failures.

use maud::{Markup, html};

use crate::comparison::{Comparison, Measure};
use crate::statistics::{Difference, Distribution, Interval, Values};
use crate::summary::MeasureStatistics;
use crate::text::{NumberFormat, clean, shortened};

/// The maximum number of reasons that are listed for a candidate.
const MAX_REASONS: usize = 10;
/// The maximum number of mazes that are named for a reason.
const MAX_EXAMPLES: usize = 3;

/// Returns a table of the distributions and, if there are several candidates, a table of the
/// differences to the reference.
pub(super) fn statistics(statistics: &MeasureStatistics) -> Markup {
    let reference = statistics.reference.as_deref().filter(|_| statistics.candidates.len() > 1);
    html! {
        (distributions(statistics))
        @if let Some(reference) = reference { (differences(statistics, reference)) }
    }
}

/// Returns a table that scrolls sideways on a narrow screen.
pub(super) fn table(class: Option<&str>, caption: &str, head: &Markup, rows: &Markup) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="group" aria-label=(caption) {
            table class=[class] {
                caption { (caption) }
                thead { tr { (head) } }
                tbody { (rows) }
            }
        }
    }
}

fn distributions(statistics: &MeasureStatistics) -> Markup {
    let format = statistics.format();
    let head = html! {
        td {} th { (clean(&statistics.measure.verb)) } th { "mean" } th { "median" }
        th { "middle half" } th { "standard deviation" } th { "minimum" } th { "maximum" }
    };
    let rows = html! {
        @for one in &statistics.candidates {
            tr {
                th { (clean(&one.candidate)) }
                td { (count("maze_count", one.statistics.mazes)) }
                @if let Some(distribution) = &one.statistics.distribution {
                    (distribution_cells(distribution, format))
                } @else {
                    td colspan="6" {}
                }
            }
        }
    };
    table(None, &statistics.caption(), &head, &rows)
}

fn distribution_cells(distribution: &Distribution, format: NumberFormat) -> Markup {
    let number = |class, number| data(class, number, &format.plain(number));
    html! {
        td { (number("mean", distribution.mean)) }
        td { (number("median", distribution.median)) }
        td {
            (number("lower_quartile", distribution.lower_quartile)) " to "
            (number("upper_quartile", distribution.upper_quartile))
        }
        td { @if let Some(one) = distribution.standard_deviation { (number("standard_deviation", one)) } }
        td { (number("minimum", distribution.minimum)) }
        td { (number("maximum", distribution.maximum)) }
    }
}

fn differences(statistics: &MeasureStatistics, reference: &str) -> Markup {
    let format = statistics.format();
    let rows = statistics.candidates.iter();
    let rows = rows.filter_map(|one| Some((one, one.statistics.difference.as_ref()?)));
    let (reference, verb) = (clean(reference), clean(&statistics.measure.verb));
    let caption = format!("Difference from {reference} in the mazes that both {verb}.");
    let head = html! {
        td {} th { "mazes" } th { "mean difference" } th { "95 % interval" }
        th { "better than " (reference) } th { "equal" } th { "worse" }
    };
    let rows = html! {
        @for (one, difference) in rows {
            tr { th { (clean(&one.candidate)) } (difference_cells(difference, format)) }
        }
    };
    table(None, &caption, &head, &rows)
}

fn difference_cells(difference: &Difference, format: NumberFormat) -> Markup {
    let number = |class, number| data(class, number, &format.signed(number));
    html! {
        td { (count("maze_count", difference.mazes)) }
        td { (number("mean", difference.mean)) }
        td {
            @if let Some(Interval { lower, upper }) = difference.confidence_interval {
                (number("lower", lower)) " to " (number("upper", upper))
            }
        }
        td { (count("better", difference.better)) }
        td { (count("equal", difference.equal)) }
        td { (count("worse", difference.worse)) }
    }
}

/// Returns a table with a row for each maze and a column for each candidate.
pub(super) fn values(comparison: &Comparison, measure: &Measure, values: &Values) -> Markup {
    let all = values.rows().iter().flatten().flatten();
    let format = NumberFormat::for_values(all.copied());
    let head = html! {
        th { "maze" }
        @for one in comparison.candidates() { th { (clean(&one.name)) } }
    };
    let rows = html! {
        @for (index, maze) in comparison.mazes().iter().enumerate() {
            tr {
                th { (clean(maze)) }
                @for row in values.rows() {
                    td {
                        @if let Some(number) = row[index] {
                            (data("value", number, &format.plain(number)))
                        } @else { "–" }
                    }
                }
            }
        }
    };
    table(None, &clean(&measure.heading()), &head, &rows)
}

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
                    div class="scroll" tabindex="0" role="group" aria-label="Failures" {
                        table class="grouped" {
                            thead {
                                tr {
                                    td {} th { "failures" } th { "mazes" }
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

    fn reason_rows(&self, candidate: &str, reasons: &[(&str, Vec<usize>)]) -> Markup {
        let total: usize = reasons.iter().map(|(_, mazes)| mazes.len()).sum();
        let (listed, others) = reasons.split_at(MAX_REASONS.min(reasons.len()));
        let other_mazes: usize = others.iter().map(|(_, mazes)| mazes.len()).sum();
        let others = match others.len() {
            0 => None,
            1 => Some("another reason".into()),
            count => Some(format!("{count} other reasons")),
        };
        let others = others.map(|text| (other_mazes, text, String::new()));
        let listed = listed
            .iter()
            .map(|(text, mazes)| (mazes.len(), shortened(text, 300), self.examples(mazes)));
        html! {
            @for (index, (mazes, reason, examples)) in listed.chain(others).enumerate() {
                tr {
                    @if index == 0 {
                        th { (clean(candidate)) }
                        td { (count("failures", total)) }
                    } @else { td {} td {} }
                    td { (mazes) }
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

fn count(class: &str, count: usize) -> Markup {
    html! { data class=(class) value=(count) { (count) } }
}

/// Returns an element with the exact number as its value. A minus sign replaces the hyphen in the
/// text.
fn data(class: &str, exact: f64, text: &str) -> Markup {
    html! { data class=(class) value=(exact) { (text.replace('-', "−")) } }
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
                    (2, _) => Some(format!("reason {}", char::from(b"abcdefghijkl"[maze % 12]))),
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
        left-wall|20|2|reason a|m0, m12|
        ||2|reason b|m1, m13|
        ||2|reason c|m2, m14|
        ||2|reason d|m3, m15|
        ||2|reason e|m4, m16|
        ||2|reason f|m5, m17|
        ||2|reason g|m6, m18|
        ||2|reason h|m7, m19|
        ||1|reason i|m8|
        ||1|reason j|m9|
        ||2|2 other reasons||
        ");
    }

    #[test]
    fn there_is_no_section_without_failures() {
        let comparison = Comparison::new("", vec!["mine".into()], vec!["maze".into()]);
        assert_eq!(comparison.failures_section().into_string(), "");
    }
}
