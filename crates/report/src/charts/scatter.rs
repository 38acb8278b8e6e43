//! Scatter plots of two candidates.

use maud::{Markup, html};

use super::axis::Axis;
use super::{Chart, LINE, MARGIN, Pair, WIDTH, class, decimals, text_width, value};
use crate::text::{clean, shortened};

/// Draws a point for each maze, with the reference's value as x and the candidate's value as y.
pub(super) fn chart(pair: &Pair<'_>) -> Chart {
    let [reference, candidate] = pair.names();
    let subtitle = format!("{candidate} against {reference}");
    let legend_top = MARGIN + 2.0 * LINE + 6.0;
    let points = pair.points();
    let top = legend_top + 3.0 * LINE + 12.0;
    let scale = Axis::new(points.iter().flat_map(|&(_, x, y)| [x, y]), 5.0, (0.0, 1.0));
    let widest = scale.ticks().iter().map(|(_, label)| text_width(label)).fold(0.0, f64::max);
    let left = MARGIN + LINE + widest + 6.0;
    let right = WIDTH - MARGIN - 8.0;
    let bottom = top + right - left;
    let x_axis = scale.with_coordinates((left, right));
    let y_axis = scale.with_coordinates((bottom, top));
    let unit = if pair.measure.unit.is_empty() { "" } else { &format!(" ({})", pair.measure.unit) };
    let middle = f64::midpoint(top, bottom);
    let content = html! {
        (pair.legend(legend_top, |difference, x, y| mark(difference, x, y, &html! {})))
        @for (x, label) in x_axis.ticks() {
            path class="grid" d={ "M" (decimals(x)) " " (decimals(top)) "V" (decimals(bottom)) } {}
            text class="middle" x=(decimals(x)) y=(decimals(bottom + 15.0)) { (label) }
        }
        @for (y, label) in y_axis.ticks() {
            path class="grid" d={ "M" (decimals(left)) " " (decimals(y)) "H" (decimals(right)) } {}
            text class="end" x=(decimals(left - 6.0)) y=(decimals(y + 4.0)) { (label) }
        }
        path class="axis" d={
            "M" (decimals(left)) " " (decimals(bottom)) "L" (decimals(right)) " " (decimals(top))
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
    pair.chart("scatter", subtitle, bottom + 40.0, content)
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
