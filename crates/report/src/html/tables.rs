//! Tables of statistics, values and failures.

use maud::{Markup, html};

use crate::comparison::{Comparison, Measure};
use crate::statistics::{Difference, Distribution, Interval, Values};
use crate::summary::MeasureStatistics;
use crate::text::{NumberFormat, clean};

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
    /// Returns a list of failures, or nothing if there are none.
    pub(super) fn failures_section(&self) -> Markup {
        let lines = self.candidates().iter().enumerate().flat_map(|(index, candidate)| {
            let lines = self.failures(index).into_iter();
            lines.map(|line| clean(&format!("{}: {line}", candidate.name)))
        });
        let lines: Vec<String> = lines.collect();
        html! {
            @if !lines.is_empty() {
                section { h2 { "Failures" } ul { @for line in lines { li { (line) } } } }
            }
        }
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
                    (0, 3..8) => Some(format!("crashed <hard> in cell {maze}")),
                    (2, _) => Some(format!("reason {}", char::from(b"abcdefghijkl"[maze % 12]))),
                    _ => None,
                }
            });
        let text = comparison.failures_section().into_string();
        let lines: Vec<&str> = text.split("<li>").skip(1).collect();
        insta::assert_snapshot!(lines.join("\n").replace("</li>", ""), @"
        mine: m3, m4, m5, m6 and 1 more: such as crashed &lt;hard&gt; in cell 3
        mine: m2: stopped
        left-wall: m0, m12: reason a
        left-wall: m1, m13: reason b
        left-wall: m2, m14: reason c
        left-wall: m3, m15: reason d
        left-wall: m4, m16: reason e
        left-wall: m5, m17: reason f
        left-wall: m6, m18: reason g
        left-wall: m7, m19: reason h
        left-wall: m8: reason i
        left-wall: m9: reason j
        left-wall: 2 mazes for other reasons</ul></section>
        ");
    }

    #[test]
    fn there_is_no_section_without_failures() {
        let comparison = Comparison::new("", vec!["mine".into()], vec!["maze".into()]);
        assert_eq!(comparison.failures_section().into_string(), "");
    }
}
