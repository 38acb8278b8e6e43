//! Bar charts.

use std::fmt::Write as _;

use mmsim_maze::Escaped;

use crate::font::decimals;
use crate::theme::Theme;

/// The width of a chart in viewBox units. A unit is a pixel unless the chart is scaled.
const WIDTH: f64 = 760.0;
const MARGIN: f64 = 16.0;
const BAR: f64 = 18.0;
const PITCH: f64 = 25.0;
/// The height of a line of text, such as the title, the legend or a group name.
const LINE: f64 = 28.0;
/// A generous estimate of the mean width of a character. The actual width depends on the reader's
/// font.
const LETTER: f64 = 7.6;
/// The space between a bar and the text beside it.
const GAP: f64 = 8.0;

/// A horizontal bar chart with groups of bars. Each bar has two stacked parts.
///
/// All bars share one scale that begins at 0. Each bar's value is written beside it.
///
/// ```
/// use mmsim_drawing::{Bar, BarChart, BarGroup};
/// let bar = Bar { name: "a".into(), parts: Some([3.0, 0.5]), value: "3.5".into() };
/// let group = BarGroup { name: "All".into(), bars: vec![bar], limit: Some(2.0) };
/// let chart = BarChart {
///     title: "Costs".into(),
///     parts: ["material".into(), "work".into()],
///     limit: "the least".into(),
///     groups: vec![group],
/// };
/// assert!(chart.svg().starts_with("<svg "));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BarChart {
    /// The title of the chart.
    pub title: String,
    /// The names of the two parts of a bar, for the legend.
    pub parts: [String; 2],
    /// The name of the limit lines, shown in the legend if a group has a limit.
    pub limit: String,
    /// The groups, from top to bottom.
    pub groups: Vec<BarGroup>,
}

/// A named group of bars.
#[derive(Clone, Debug, PartialEq)]
pub struct BarGroup {
    /// The heading of the group.
    pub name: String,
    /// The bars, from top to bottom.
    pub bars: Vec<Bar>,
    /// A lower bound on the lengths of the bars, drawn as a line across all bars of the group.
    pub limit: Option<f64>,
}

/// A bar with two stacked parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// The label of the bar.
    pub name: String,
    /// The lengths of the two parts, or `None` to show only the text.
    pub parts: Option<[f64; 2]>,
    /// The bar's value as text, or the reason why it has none.
    pub value: String,
}

impl BarChart {
    /// Returns the chart as an SVG file that adapts to the reader's preference for light or dark
    /// colours.
    pub fn svg(&self) -> String {
        let rows = self.groups.iter().map(|group| LINE + PITCH * count(group.bars.iter()));
        let height = 2.0 * MARGIN + 2.0 * LINE + rows.sum::<f64>();
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
             width=\"{WIDTH}\" height=\"{height}\" role=\"img\" aria-label=\"{title}\">\n\
             <style>\n{style}</style>\n\
             <rect class=\"floor\" width=\"{WIDTH}\" height=\"{height}\"/>\n",
            title = escaped(&self.title),
            style = style(),
        );
        let mut y = MARGIN;
        text(&mut svg, "title", MARGIN, y + BAR, &self.title);
        y += LINE;
        self.write_legend(&mut svg, y);
        y += LINE;
        let scale = Scale::for_chart(self);
        for group in &self.groups {
            scale.write_group(&mut svg, y, group);
            y += LINE + PITCH * count(group.bars.iter());
        }
        svg + "</svg>\n"
    }

    fn write_legend(&self, svg: &mut String, y: f64) {
        let mut x = MARGIN;
        let limit = self.groups.iter().any(|group| group.limit.is_some()).then_some(&self.limit);
        let entries = self.parts.iter().map(Some).chain([limit]);
        for (class, name) in ["first", "second", "limit"].into_iter().zip(entries) {
            let Some(name) = name else { continue };
            if class == "limit" {
                line(svg, x + 6.0, y, y + 14.0);
            } else {
                rect(svg, class, x, y + 1.0, 12.0, 12.0);
            }
            text(svg, "value", x + 12.0 + GAP, y + 12.0, name);
            x += 12.0 + 3.0 * GAP + LETTER * count(name.chars());
        }
    }
}

/// The origin and the scale of the bars.
struct Scale {
    left: f64,
    /// The width of a bar of length 1, in viewBox units.
    unit: f64,
}

impl Scale {
    /// Chooses the largest scale that leaves enough space for the text beside the bars.
    fn for_chart(chart: &BarChart) -> Self {
        let bars = || chart.groups.iter().flat_map(|group| &group.bars);
        let widest = bars().map(|bar| LETTER * count(bar.name.chars())).fold(0.0, f64::max);
        let left = MARGIN + widest + GAP;
        let room = (WIDTH - MARGIN - left).max(LINE);
        let beside = |bar: &Bar| {
            let length: f64 = bar.parts?.iter().sum();
            Some(((room - GAP - LETTER * count(bar.value.chars())).max(LINE), length))
        };
        let limits = chart.groups.iter().filter_map(|group| Some((room, group.limit?)));
        let units = bars().filter_map(beside).chain(limits).map(|(room, length)| room / length);
        let unit = units.filter(|unit| unit.is_finite()).fold(f64::INFINITY, f64::min);
        Self { left, unit: if unit.is_finite() { unit } else { 0.0 } }
    }

    fn write_group(&self, svg: &mut String, top: f64, group: &BarGroup) {
        let Self { left, unit } = *self;
        text(svg, "group", MARGIN, top + BAR, &group.name);
        let top = top + LINE;
        let mut y = top;
        for Bar { name, parts, value } in &group.bars {
            let base = y + BAR - 5.0;
            text(svg, "name", left - GAP, base, name);
            let [first, second] = parts.unwrap_or_default().map(|length| length * unit);
            if parts.is_some() {
                rect(svg, "first", left, y, first, BAR);
                rect(svg, "second", left + first, y, second, BAR);
            }
            text(svg, "value", left + first + second + GAP, base, value);
            y += PITCH;
        }
        if let Some(limit) = group.limit {
            line(svg, left + limit * unit, top - 3.0, y - PITCH + BAR + 3.0);
        }
    }
}

fn rect(svg: &mut String, class: &str, x: f64, y: f64, width: f64, height: f64) {
    let [x, y, width, height] = [x, y, width, height].map(decimals);
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>"
    );
}

fn line(svg: &mut String, x: f64, from: f64, to: f64) {
    let [x, from, to] = [x, from, to].map(decimals);
    let _ = writeln!(svg, "<path class=\"limit\" d=\"M{x} {from}V{to}\"/>");
}

fn text(svg: &mut String, class: &str, x: f64, y: f64, text: &str) {
    let ([x, y], text) = ([x, y].map(decimals), escaped(text));
    let _ = writeln!(svg, "<text class=\"{class}\" x=\"{x}\" y=\"{y}\">{text}</text>");
}

/// Escapes text for XML. Control characters, which XML cannot represent, are replaced by visible
/// escape sequences.
fn escaped(text: &str) -> String {
    let text = Escaped(text).to_string();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[expect(clippy::cast_precision_loss, reason = "the bars of a chart or the letters of a name")]
fn count(items: impl Iterator) -> f64 {
    items.count() as f64
}

fn style() -> String {
    let colours = |theme: Theme| {
        let colours = theme.colours();
        let (floor, text, bar, limit) =
            (colours.floor, colours.number, colours.trail.1, colours.mistaken);
        format!(
            ".floor{{fill:{floor}}}\ntext{{fill:{text}}}\n.first,.second{{fill:{bar}}}\n\
             .limit{{stroke:{limit}}}\n"
        )
    };
    format!(
        "text{{font:13px system-ui,sans-serif}}\n.title{{font-size:16px;font-weight:600}}\n\
         .group{{font-weight:600}}\n.name{{text-anchor:end}}\n.second{{fill-opacity:.45}}\n\
         .limit{{fill:none;stroke-width:1.5;stroke-dasharray:3 2}}\n{}\
         @media (prefers-color-scheme:dark){{\n{}}}\n",
        colours(Theme::Light),
        colours(Theme::Dark)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> BarChart {
        let bar =
            |name: &str, parts, value: &str| Bar { name: name.into(), parts, value: value.into() };
        let bars = vec![
            bar("one", Some([30.0, 10.0]), "30 + 10"),
            bar("t<o", None, "none & void"),
            bar("three", Some([5.0, 0.0]), "5"),
        ];
        BarChart {
            title: "A \"chart\"".into(),
            parts: ["first".into(), "second".into()],
            limit: "the least".into(),
            groups: vec![BarGroup { name: "group".into(), bars, limit: Some(5.0) }],
        }
    }

    #[test]
    fn bars_are_as_long_as_their_values() {
        let svg = chart().svg();
        let width = |text: &str| -> Vec<f64> {
            let bars =
                svg.lines().filter(|line| line.starts_with(text) && line.contains("height=\"18\""));
            bars.map(|bar| {
                bar.split("width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
            })
            .collect()
        };
        let (first, second) = (width("<rect class=\"first\""), width("<rect class=\"second\""));
        assert!((first[0] - 6.0 * first[1]).abs() < 0.1, "{svg}");
        assert!((first[0] - 3.0 * second[0]).abs() < 0.1 && second[1] == 0.0, "{svg}");
        assert_eq!((first.len(), second.len()), (2, 2));
        assert!(
            svg.contains(">t&lt;o</text>")
                && svg.contains("none &amp; void")
                && svg.contains("A &quot;chart")
        );
        assert_eq!(svg.matches("class=\"limit\"").count(), 2, "in the group and in the legend");
    }

    #[test]
    fn control_characters_in_names_keep_the_svg_valid() {
        let svg = BarChart { title: "a\u{1b}[2J\n\0b".into(), ..chart() }.svg();
        assert!(svg.contains(r">a\u{1b}[2J\n\u{0}b</text>"), "{svg}");
        resvg::usvg::Tree::from_str(&svg, &resvg::usvg::Options::default()).unwrap();
    }

    #[test]
    fn an_empty_chart_is_valid() {
        let empty = BarChart { groups: Vec::new(), ..chart() }.svg();
        assert!(!empty.contains("NaN") && !empty.contains("class=\"limit\""), "{empty}");
        let mut none = chart();
        none.groups[0].bars.retain(|bar| bar.parts.is_none());
        none.groups[0].limit = None;
        assert!(!none.svg().contains("NaN") && !none.svg().contains("inf"));
    }
}
