//! Box plots of the values of each candidate.

use std::fmt::Write as _;

use maud::{Markup, html};

use super::axis::Axis;
use super::{Chart, LINE, MARGIN, WIDTH, count, decimals, file_name, mazes};
use crate::comparison::{Comparison, Measure};
use crate::statistics::{Distribution, Values};
use crate::summary::MeasureStatistics;
use crate::text::shortened;

/// The height of a candidate's name, box and dots.
const ROW: f64 = 50.0;
/// The height of a box.
const BOX: f64 = 22.0;
/// The ratio by which the heights of neighbouring dots differ: the golden ratio, which spreads any
/// number of dots evenly.
const GOLDEN: f64 = 0.618_034;

/// Draws a box plot for each candidate, with a dot for each common maze.
pub(super) fn chart(comparison: &Comparison, measure: &Measure, values: &Values) -> Chart {
    let statistics = MeasureStatistics::new(comparison, measure, values);
    let common = values.common_mazes();
    let rows = || statistics.candidates.iter().enumerate();
    let numbers = |candidate| common.iter().filter_map(move |&maze| values.row(candidate)[maze]);
    let compared = rows().filter(|(_, one)| one.statistics.is_compared);
    let all = compared.flat_map(|(candidate, _)| numbers(candidate));
    let axis = Axis::new(all, 7.0, (MARGIN + 8.0, WIDTH - MARGIN - 8.0));
    let top = MARGIN + 2.0 * LINE + 8.0;
    let bottom = top + ROW * count(statistics.candidates.len());
    let caption = match common.len() {
        0 => statistics.caption(),
        count => format!("{}; dot: maze, line: median, box: middle half", mazes(count)),
    };
    let content = html! {
        @if !common.is_empty() {
            @for (x, label) in axis.ticks() {
                path class="grid" d={ "M" (decimals(x)) " " (top) "V" (bottom) } {}
                text class="middle" x=(decimals(x)) y=(bottom + 15.0) { (label) }
            }
            text class="middle quiet" x=(WIDTH / 2.0) y=(bottom + 32.0) {
                (shortened(&measure.heading(), 60))
            }
        }
        @for (candidate, one) in rows() {
            @let y = top + ROW * count(candidate);
            @let distribution = one.statistics.distribution.as_ref();
            @let median = distribution.map(|one| statistics.format().plain(one.median));
            text x=(MARGIN) y=(y + 13.0) { (shortened(&one.candidate, 40)) }
            text class="end" x=(WIDTH - MARGIN) y=(y + 13.0) {
                @match (median, one.statistics.mazes) {
                    (Some(median), _) => { "median " (median) }
                    (None, 0) => { (measure.verb) " none" }
                    (None, count) => { (measure.verb) " " (mazes(count)) }
                }
            }
            @if let Some(distribution) = distribution {
                (box_plot(distribution, &axis, y + 19.0))
                path class="dots" d=(dots(numbers(candidate), &axis, y + 19.0)) {}
            }
        }
    };
    Chart {
        name: file_name(&format!("{}-distribution", measure.key)),
        title: measure.heading(),
        subtitle: caption,
        height: bottom + 40.0,
        content,
    }
}

fn box_plot(distribution: &Distribution, axis: &Axis, y: f64) -> Markup {
    let Distribution { minimum, lower_quartile, median, upper_quartile, maximum, .. } =
        *distribution;
    let [minimum, lower, median, upper, maximum] =
        [minimum, lower_quartile, median, upper_quartile, maximum].map(|number| axis.at(number));
    let middle = y + BOX / 2.0;
    html! {
        path class="range" d={ "M" (decimals(minimum)) " " (middle) "H" (decimals(maximum)) } {}
        rect class="box" x=(decimals(lower)) y=(y) width=(decimals(upper - lower)) height=(BOX) {}
        path class="median" d={ "M" (decimals(median)) " " (y) "v" (BOX) } {}
    }
}

/// Returns a path with a dot for each number. A dot is a line that is too short to be seen except
/// for its round ends.
fn dots(numbers: impl Iterator<Item = f64>, axis: &Axis, y: f64) -> String {
    let mut path = String::new();
    for (index, number) in numbers.enumerate() {
        let down = 3.0 + (BOX - 6.0) * (count(index) * GOLDEN).fract();
        // Writing to a string cannot fail.
        let _ = write!(path, "M{} {}h.01", decimals(axis.at(number)), decimals(y + down));
    }
    path
}
