//! Charts that compare two candidates: a scatter plot, and a bar chart of the sorted differences.

use std::fmt::Display;

use maud::{Markup, html};

use super::axis::Axis;
use super::{Chart, LINE, MARGIN, WIDTH, count, decimals, file_name, mazes, text_width};
use crate::comparison::{Comparison, Measure};
use crate::statistics::Values;
use crate::text::{clean, shortened};

/// The top of the legend.
const LEGEND: f64 = MARGIN + 2.0 * LINE + 6.0;
/// The top of the area of a chart, below the three lines of the legend.
const TOP: f64 = LEGEND + 3.0 * LINE + 12.0;
/// The height of the bars.
const HEIGHT: f64 = 240.0;
/// The maximum width of a bar.
const MAX_BAR: f64 = 24.0;

/// Two candidates to be compared maze by maze.
pub(super) struct Pair<'a> {
    pub(super) comparison: &'a Comparison,
    pub(super) measure: &'a Measure,
    pub(super) values: &'a Values,
    pub(super) reference: usize,
    pub(super) candidate: usize,
}

impl Pair<'_> {
    /// Returns the shortened name of the reference and of the candidate.
    fn names(&self) -> [String; 2] {
        [self.reference, self.candidate].map(|index| self.candidate_name(index, 22))
    }

    fn candidate_name(&self, index: usize, max: usize) -> String {
        self.comparison
            .candidates()
            .get(index)
            .map_or(String::new(), |one| shortened(&one.name, max))
    }

    /// Returns the mazes in which both have a value, the value of the reference, and the value of
    /// the candidate.
    pub(super) fn points(&self) -> Vec<(&str, f64, f64)> {
        let [reference, candidate] =
            [self.reference, self.candidate].map(|index| self.values.row(index));
        let mazes = self.comparison.mazes().iter().zip(reference).zip(candidate);
        mazes.filter_map(|((maze, one), other)| Some((maze.as_str(), (*one)?, (*other)?))).collect()
    }

    /// Returns a legend of three lines, each with the number of mazes and the mark for them.
    fn legend(&self, mark: impl Fn(f64, f64, f64) -> Markup) -> Markup {
        let [reference, candidate] = self.names();
        let differences = self.values.differences(self.candidate, self.reference);
        let count = |is: fn(f64) -> bool| differences.iter().filter(|(_, one)| is(*one)).count();
        let lines = [
            (1.0, format!("{reference} better: {}", mazes(count(|one| one > 0.0)))),
            (-1.0, format!("{candidate} better: {}", mazes(count(|one| one < 0.0)))),
            (0.0, format!("equal: {}", mazes(count(|one| one == 0.0)))),
        ];
        html! {
            @for ((difference, line), row) in lines.into_iter().zip([0.0, LINE, 2.0 * LINE]) {
                (mark(difference, MARGIN + 5.0, LEGEND + row + 8.0))
                text x=(MARGIN + 16.0) y=(LEGEND + row + 12.0) { (line) }
            }
        }
    }

    fn chart(&self, kind: &str, subtitle: String, height: f64, content: Markup) -> Chart {
        let number = self.candidate + 1;
        let name = self.candidate_name(self.candidate, 22);
        let name = file_name(&format!("{}-{kind}-{number}-{name}", self.measure.key));
        Chart { name, title: self.measure.heading(), subtitle, height, content }
    }

    /// Draws a point for each maze, with the reference's value as x and the candidate's value as y.
    pub(super) fn scatter(&self) -> Chart {
        let [reference, candidate] = self.names();
        let subtitle = format!("{candidate} against {reference}");
        let points = self.points();
        let scale = Axis::new(points.iter().flat_map(|&(_, x, y)| [x, y]), 5.0, (0.0, 1.0));
        let widest = scale.ticks().iter().map(|(_, label)| text_width(label)).fold(0.0, f64::max);
        let left = MARGIN + LINE + widest + 6.0;
        let right = WIDTH - MARGIN - 8.0;
        let bottom = TOP + right - left;
        let x_axis = scale.with_coordinates((left, right));
        let y_axis = scale.with_coordinates((bottom, TOP));
        let unit =
            if self.measure.unit.is_empty() { "" } else { &format!(" ({})", self.measure.unit) };
        let middle = f64::midpoint(TOP, bottom);
        let content = html! {
            (self.legend(|difference, x, y| mark(difference, x, y, &html! {})))
            @for (x, label) in x_axis.ticks() {
                path class="grid" d={ "M" (decimals(x)) " " (decimals(TOP)) "V" (decimals(bottom)) } {}
                text class="middle" x=(decimals(x)) y=(decimals(bottom + 15.0)) { (label) }
            }
            @for (y, label) in y_axis.ticks() {
                path class="grid" d={ "M" (decimals(left)) " " (decimals(y)) "H" (decimals(right)) } {}
                text class="end" x=(decimals(left - 6.0)) y=(decimals(y + 4.0)) { (label) }
            }
            path class="axis" d={
                "M" (decimals(left)) " " (decimals(bottom)) "L" (decimals(right)) " " (decimals(TOP))
            } {}
            text class="middle quiet" x=(decimals(f64::midpoint(left, right))) y=(decimals(bottom + 33.0)) {
                (shortened(&(reference + unit), 50))
            }
            text class="middle quiet"
                transform={ "translate(" (MARGIN + 10.0) " " (decimals(middle)) ")rotate(-90)" } {
                (shortened(&(candidate + unit), 50))
            }
            @for &(maze, x, y) in &points {
                @let title = html! { title { (clean(maze)) ": " (value(x)) ", " (value(y)) } };
                (mark(y - x, x_axis.at(x), y_axis.at(y), &title))
            }
        };
        self.chart("scatter", subtitle, bottom + 40.0, content)
    }

    /// Draws a bar for each maze, sorted by the candidate's value minus that of the reference.
    pub(super) fn differences(&self) -> Chart {
        let [reference, candidate] = self.names();
        let subtitle = format!("{candidate} minus {reference}");
        let mut bars: Vec<(&str, f64)> =
            self.points().into_iter().map(|(maze, one, other)| (maze, other - one)).collect();
        bars.sort_by(|(_, one), (_, other)| other.total_cmp(one));
        let bottom = TOP + HEIGHT;
        let numbers = bars.iter().map(|&(_, difference)| difference).chain([0.0]);
        let axis = Axis::new(numbers, 5.0, (bottom, TOP));
        let ticks = axis.ticks();
        let widest = ticks.iter().map(|(_, label)| text_width(label)).fold(0.0, f64::max);
        let (left, right) = (MARGIN + widest + 6.0, WIDTH - MARGIN);
        let pitch = ((right - left) / count(bars.len())).min(MAX_BAR);
        let width = if pitch > 3.0 { pitch - 1.0 } else { pitch };
        let zero = axis.at(0.0);
        let caption = match self.measure.difference_unit() {
            "" => "one bar per maze".into(),
            unit => format!("one bar per maze, in {unit}"),
        };
        let content = html! {
            (self.legend(square))
            @for (y, label) in &ticks {
                path class="grid" d={ "M" (decimals(left)) " " (decimals(*y)) "H" (right) } {}
                text class="end" x=(decimals(left - 6.0)) y=(decimals(y + 4.0)) { (label) }
            }
            @for (index, &(maze, difference)) in bars.iter().enumerate() {
                @let end = axis.at(difference);
                rect class=(class(difference)) x=(hundredths(left + pitch * count(index)))
                    y=(decimals(zero.min(end))) width=(hundredths(width))
                    height=(decimals((zero - end).abs())) {
                    title { (clean(maze)) ": " (value(difference)) }
                }
            }
            path class="axis" d={ "M" (decimals(left)) " " (decimals(zero)) "H" (right) } {}
            text class="middle quiet" x=(WIDTH / 2.0) y=(bottom + 22.0) { (shortened(&caption, 60)) }
        };
        self.chart("differences", subtitle, bottom + 30.0, content)
    }
}

/// Returns the class of a difference, given as the candidate's value minus that of the reference.
fn class(difference: f64) -> &'static str {
    match difference {
        difference if difference > 0.0 => "one",
        difference if difference < 0.0 => "two",
        _ => "same",
    }
}

/// Formats a value of a measure without the digits that come from rounding errors.
fn value(number: f64) -> impl Display {
    (number * 1e6).round() / 1e6 + 0.0
}

/// Draws a circle if the reference is better, a triangle if the candidate is better, and a square if
/// they are equal.
fn mark(difference: f64, x: f64, y: f64, title: &Markup) -> Markup {
    let [x, y] = [x, y].map(decimals);
    let shape = match class(difference) {
        "one" => "m-3.5 0a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0z",
        "two" => "m0-4.5l4.3 7.5h-8.6z",
        _ => "m-3-3h6v6h-6z",
    };
    html! { path class={ "point " (class(difference)) } d={ "M" (x) " " (y) (shape) } { (title) } }
}

fn square(difference: f64, x: f64, y: f64) -> Markup {
    html! { rect class=(class(difference)) x=(x - 4.0) y=(y - 4.0) width="8" height="8" {} }
}

/// Rounds a coordinate to two decimals, so that the gaps between thin bars are equal.
fn hundredths(number: f64) -> f64 {
    (number * 100.0).round() / 100.0
}
