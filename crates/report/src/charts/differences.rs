//! Bar charts of the difference between two candidates in each maze.

use maud::{Markup, html};

use super::axis::Axis;
use super::{Chart, LINE, MARGIN, Pair, WIDTH, class, count, decimals, text_width, value};
use crate::text::{clean, shortened};

const HEIGHT: f64 = 240.0;
/// The maximum width of a bar.
const MAX_BAR: f64 = 24.0;

/// Draws a bar for each maze, sorted by the candidate's value minus that of the reference.
pub(super) fn chart(pair: &Pair<'_>) -> Chart {
    let [reference, candidate] = pair.names();
    let subtitle = format!("{candidate} minus {reference}");
    let legend_top = MARGIN + 2.0 * LINE + 6.0;
    let mut bars: Vec<(&str, f64)> =
        pair.points().into_iter().map(|(maze, one, other)| (maze, other - one)).collect();
    bars.sort_by(|(_, one), (_, other)| other.total_cmp(one));
    let top = legend_top + 3.0 * LINE + 12.0;
    let bottom = top + HEIGHT;
    let numbers = bars.iter().map(|&(_, difference)| difference).chain([0.0]);
    let axis = Axis::new(numbers, 5.0, (bottom, top));
    let ticks = axis.ticks();
    let widest = ticks.iter().map(|(_, label)| text_width(label)).fold(0.0, f64::max);
    let (left, right) = (MARGIN + widest + 6.0, WIDTH - MARGIN);
    let pitch = ((right - left) / count(bars.len())).min(MAX_BAR);
    let width = if pitch > 3.0 { pitch - 1.0 } else { pitch };
    let zero = axis.at(0.0);
    let caption = match pair.measure.difference_unit() {
        "" => "one bar per maze".into(),
        unit => format!("one bar per maze, in {unit}"),
    };
    let content = html! {
        (pair.legend(legend_top, square))
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
    pair.chart("differences", subtitle, bottom + 30.0, content)
}

fn square(difference: f64, x: f64, y: f64) -> Markup {
    html! { rect class=(class(difference)) x=(x - 4.0) y=(y - 4.0) width="8" height="8" {} }
}

/// Rounds a coordinate to two decimals, so that the gaps between thin bars are equal.
fn hundredths(number: f64) -> f64 {
    (number * 100.0).round() / 100.0
}
