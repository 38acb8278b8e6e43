//! Charts as SVG.

mod axis;
mod distribution;

use std::fmt::Display;

use maud::{Markup, PreEscaped, html};
use mmsim_maze::{Counted, counted};

use crate::comparison::Comparison;
use crate::text::{clean, shortened};

/// The width of a chart in viewBox units. A unit is a pixel on a phone's screen.
const WIDTH: f64 = 480.0;
const MARGIN: f64 = 12.0;
/// The height of a line of text.
const LINE: f64 = 18.0;
/// The number of pixels per viewBox unit in a file.
const FILE_SCALE: f64 = 1.5;

/// The style rules of the charts. All selectors begin with the class of the charts, so that they
/// can be added to the rules of a page.
pub(crate) const STYLE: &str = include_str!("charts/style.css");

/// A chart, which adapts to the reader's preference for light or dark colours.
///
/// ```
/// use mmsim_report::{Comparison, Measure};
/// let comparison = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
///     .with_measure(Measure::new("turns", "turns", "turns"), |_, _| Some(7.0));
/// let charts = comparison.charts();
/// assert_eq!(charts[0].name(), "turns-distribution");
/// assert!(charts[0].svg().starts_with("<svg "));
/// ```
#[derive(Clone, Debug)]
pub struct Chart {
    name: String,
    title: String,
    /// A line below the title.
    subtitle: String,
    height: f64,
    content: Markup,
}

impl Chart {
    /// Returns a name without an extension that is unique among the charts of a comparison and valid
    /// as a file name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the chart as an SVG file with its own style rules.
    pub fn svg(&self) -> String {
        let style = html! { style { (PreEscaped(STYLE)) } };
        self.draw(Some(FILE_SCALE), &style).into_string() + "\n"
    }

    /// Returns the chart as an element of a page that contains the style rules ([`STYLE`]).
    pub(crate) fn inline(&self) -> Markup {
        self.draw(None, &html! {})
    }

    fn draw(&self, scale: Option<f64>, style: &Markup) -> Markup {
        let Self { title, subtitle, height, content, .. } = self;
        let pixels = |length: f64| scale.map(|scale| decimals(scale * length));
        html! {
            svg xmlns="http://www.w3.org/2000/svg" class="chart"
                viewBox={ "0 0 " (WIDTH) " " (decimals(*height)) }
                width=[pixels(WIDTH)] height=[pixels(*height)] role="img"
                aria-label={ (clean(title)) ": " (clean(subtitle)) } {
                (style)
                rect class="floor" width=(WIDTH) height=(decimals(*height)) {}
                text class="title" x=(MARGIN) y=(MARGIN + 12.0) { (shortened(title, 56)) }
                text class="quiet" x=(MARGIN) y=(MARGIN + 12.0 + LINE) { (shortened(subtitle, 70)) }
                (content)
            }
        }
    }
}

impl Comparison {
    /// Returns a chart of each measure, with the distribution of the values in the common mazes.
    pub fn charts(&self) -> Vec<Chart> {
        let measures = self.measures().iter();
        measures.map(|(measure, values)| distribution::chart(self, measure, values)).collect()
    }
}

/// Returns the text with only lower-case letters and digits of ASCII, underscores and hyphens.
fn file_name(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words = text.split(|c| !is_plain(c)).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-").to_ascii_lowercase()
}

fn mazes(count: usize) -> Counted<'static> {
    counted(count, "maze")
}

/// Formats a coordinate with at most one decimal.
fn decimals(number: f64) -> impl Display {
    (number * 10.0).round() / 10.0 + 0.0
}

/// Returns the number of items.
#[expect(clippy::cast_precision_loss, reason = "candidates or mazes")]
pub(crate) fn count(items: usize) -> f64 {
    items as f64
}

#[cfg(test)]
mod tests {
    use resvg::usvg::{Options, Tree};

    use super::*;
    use crate::comparison::Measure;

    /// Returns a comparison of candidates with different and partly missing values.
    fn comparison(candidates: &[&str], mazes: usize) -> Comparison {
        let names = candidates.iter().map(|&name| name.into()).collect();
        let mazes = (0..mazes).map(|maze| format!("maze <{maze}> \"&\u{7}\u{ffff}"));
        let measure = Measure::new("steps to/goal", "steps & <turns>", "steps");
        Comparison::new("Mice", names, mazes.collect()).with_measure(measure, |candidate, maze| {
            let is_solved = candidate < 5 && (candidate + maze) % 5 < 4;
            is_solved.then(|| count(50 + maze * (3 * candidate + maze) % 71))
        })
    }

    const NAMES: [&str; 7] = [
        "mine",
        "<script>alert(1)</script>",
        "]]>\u{0}\u{1b}[2J\u{fffe} and more than forty-five characters",
        "\"quotes\" & 'apostrophes'",
        "никто",
        "solves nothing",
        "../../etc/passwd",
    ];

    #[test]
    fn charts_are_valid_and_finite_for_any_number_of_mazes_and_candidates() {
        for mazes in [0, 1, 2, 30, 300] {
            for candidates in [0, 1, 2, 7] {
                for chart in comparison(&NAMES[..candidates], mazes).charts() {
                    let svg = chart.svg();
                    Tree::from_str(&svg, &Options::default()).unwrap();
                    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
                }
            }
        }
    }

    #[test]
    fn names_of_charts_are_file_names() {
        let charts = comparison(&NAMES, 10).charts();
        let names: Vec<&str> = charts.iter().map(Chart::name).collect();
        assert_eq!(names, ["steps-to-goal-distribution"]);
    }

    #[test]
    fn the_chart_of_two_candidates_is_stable() {
        let steps = [
            [Some(40.0), Some(52.0), Some(61.0), None],
            [Some(46.0), Some(50.0), Some(61.0), Some(9.0)],
        ];
        let names = ["mine", "flood-fill"].map(Into::into).into();
        let mazes = ["one", "two", "three", "four"].map(Into::into).into();
        let measure = Measure::new("steps_to_goal", "steps to the goal", "steps");
        let comparison = Comparison::new("Mice", names, mazes)
            .with_measure(measure, |candidate, maze| steps[candidate][maze]);
        let svg = comparison.charts()[0].svg().replace(STYLE, "");
        let svg = svg.replace("</path>", "</path>\n").replace("</text>", "</text>\n");
        insta::assert_snapshot!("distribution", svg);
    }

    #[test]
    fn each_common_maze_is_a_dot() {
        let comparison = comparison(&NAMES[..2], 30);
        let statistics = &comparison.statistics()[0].candidates[1].statistics;
        let dots = comparison.charts()[0].svg().matches("h.01").count();
        assert_eq!(dots, 2 * statistics.common_mazes);
    }

    #[test]
    fn the_style_rules_apply_only_to_charts() {
        let rules = STYLE.lines().filter(|line| !line.starts_with('@') && *line != "}");
        for rule in rules {
            let (selectors, _) = rule.split_once('{').unwrap();
            assert!(selectors.split(',').all(|selector| selector.starts_with(".chart ")), "{rule}");
        }
    }
}
