//! Bar charts of trial scores.

use maud::{Markup, html};

use super::{ChartFrame, MARGIN, clean, count, decimals, text_width};

/// The width of a chart in viewBox units. A unit is a pixel unless the chart is scaled.
const WIDTH: f64 = 760.0;
const BAR: f64 = 18.0;
const PITCH: f64 = 25.0;
/// The height of a line of text, such as the title, the legend or a group name.
const LINE: f64 = 28.0;
/// The space between a bar and the text beside it.
const GAP: f64 = 8.0;

/// The classes of the parts.
const PARTS: [&str; 2] = ["one", "second"];

/// A horizontal bar chart with groups of bars. Each bar has one part, or two stacked
/// parts.
///
/// All bars share one scale that begins at 0. Each bar's value is written beside it.
///
/// ```
/// use mmsim_report::{Bar, BarChart, BarGroup};
/// let bar = Bar { name: "a".into(), parts: Some(vec![3.0, 0.5]), value: "3.5".into() };
/// let group = BarGroup { name: "All".into(), bars: vec![bar], limit: Some(2.0) };
/// let chart = BarChart {
///     title: "Costs".into(),
///     parts: vec!["material".into(), "work".into()],
///     limit: "the least".into(),
///     groups: vec![group],
/// };
/// assert!(chart.svg().starts_with("<svg "));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BarChart {
    /// The title of the chart.
    pub title: String,
    /// The names of the parts of a bar, for the legend.
    pub parts: Vec<String>,
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

/// A bar with one part, or with two stacked parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// The label of the bar.
    pub name: String,
    /// The lengths of the parts, or `None` to show only the text.
    pub parts: Option<Vec<f64>>,
    /// The bar's value as text, or the reason why it has none.
    pub value: String,
}

impl BarChart {
    /// Returns the chart as an SVG file that adapts to the reader's preference for light or dark
    /// colours.
    pub fn svg(&self) -> String {
        let scale = BarScale::for_chart(self);
        let mut bottom = MARGIN + 2.0 * LINE;
        let mut tops = Vec::new();
        for group in &self.groups {
            tops.push(bottom);
            bottom += LINE + PITCH * count(group.bars.len());
        }
        let content = html! {
            (self.legend(MARGIN + LINE))
            @for (group, top) in self.groups.iter().zip(tops) { (scale.group(top, group)) }
        };
        let (title, height) = (&*self.title, bottom + MARGIN);
        ChartFrame { title, subtitle: "", max_title: 90, width: WIDTH, height, scale: 1.0 }
            .file(&content)
    }

    fn legend(&self, y: f64) -> Markup {
        let limit = self.groups.iter().any(|group| group.limit.is_some()).then_some(&self.limit);
        let entries = PARTS.into_iter().zip(&self.parts);
        let entries = entries.chain(limit.map(|limit| ("limit", limit)));
        let entries = entries.scan(MARGIN, |right, (class, name)| {
            let left = *right;
            *right += 12.0 + 3.0 * GAP + text_width(name);
            Some((class, name, left))
        });
        html! {
            @for (class, name, x) in entries {
                @if class == "limit" {
                    (line(x + 6.0, y, y + 14.0))
                } @else {
                    (rect(class, x, y + 1.0, 12.0, 12.0))
                }
                text x=(decimals(x + 12.0 + GAP)) y=(y + 12.0) { (clean(name)) }
            }
        }
    }
}

/// The origin and the scale of the bars.
struct BarScale {
    left: f64,
    /// The width of a bar of length 1, in viewBox units.
    unit: f64,
}

impl BarScale {
    /// Chooses the largest scale that leaves enough space for the text beside the bars.
    fn for_chart(chart: &BarChart) -> Self {
        let bars = || chart.groups.iter().flat_map(|group| &group.bars);
        let widest = bars().map(|bar| text_width(&bar.name)).fold(0.0, f64::max);
        let left = MARGIN + widest + GAP;
        let room = (WIDTH - MARGIN - left).max(LINE);
        let beside = |bar: &Bar| {
            let length: f64 = bar.parts.as_ref()?.iter().sum();
            Some(((room - GAP - text_width(&bar.value)).max(LINE), length))
        };
        let limits = chart.groups.iter().filter_map(|group| Some((room, group.limit?)));
        let units = bars().filter_map(beside).chain(limits).map(|(room, length)| room / length);
        let unit = units.filter(|unit| unit.is_finite()).fold(f64::INFINITY, f64::min);
        Self { left, unit: if unit.is_finite() { unit } else { 0.0 } }
    }

    fn group(&self, top: f64, group: &BarGroup) -> Markup {
        let Self { left, unit } = *self;
        let rows = (0..).map(|row| top + LINE + PITCH * count(row));
        let bottom = top + LINE + PITCH * (count(group.bars.len()) - 1.0) + BAR;
        html! {
            text class="heading" x=(MARGIN) y=(decimals(top + BAR)) { (clean(&group.name)) }
            @for (Bar { name, parts, value }, y) in group.bars.iter().zip(rows) {
                @let lengths: Vec<f64> = parts.iter().flatten().map(|length| length * unit).collect();
                @let start = |part: usize| left + lengths[..part].iter().sum::<f64>();
                @let base = decimals(y + BAR - 5.0);
                text class="end" x=(decimals(left - GAP)) y=(base) { (clean(name)) }
                @for (part, (class, &length)) in PARTS.into_iter().zip(&lengths).enumerate() {
                    (rect(class, start(part), y, length, BAR))
                }
                text x=(decimals(start(lengths.len()) + GAP)) y=(base) { (clean(value)) }
            }
            @if let Some(limit) = group.limit {
                (line(left + limit * unit, top + LINE - 3.0, bottom + 3.0))
            }
        }
    }
}

fn rect(class: &str, x: f64, y: f64, width: f64, height: f64) -> Markup {
    let [x, y, width, height] = [x, y, width, height].map(decimals);
    html! { rect class=(class) x=(x) y=(y) width=(width) height=(height) {} }
}

fn line(x: f64, from: f64, to: f64) -> Markup {
    html! { path class="limit" d={ "M" (decimals(x)) " " (decimals(from)) "V" (decimals(to)) } {} }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> BarChart {
        let bar = |name: &str, parts: Option<[f64; 2]>, value: &str| Bar {
            name: name.into(),
            parts: parts.map(Vec::from),
            value: value.into(),
        };
        let bars = vec![
            bar("one", Some([30.0, 10.0]), "30 + 10"),
            bar("t<o", None, "none & void"),
            bar("three", Some([5.0, 0.0]), "5"),
        ];
        BarChart {
            title: "A \"chart\"".into(),
            parts: vec!["first".into(), "second".into()],
            limit: "the least".into(),
            groups: vec![BarGroup { name: "group".into(), bars, limit: Some(5.0) }],
        }
    }

    #[test]
    fn bars_are_as_long_as_their_values() {
        let svg = chart().svg();
        let width = |class: &str| -> Vec<f64> {
            let start = format!("class=\"{class}\"");
            let bars = svg.split("<rect ").filter(|bar| bar.starts_with(&start));
            let bars = bars.filter(|bar| bar.contains("height=\"18\""));
            bars.map(|bar| {
                bar.split("width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
            })
            .collect()
        };
        let (first, second) = (width("one"), width("second"));
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
    fn wide_names_have_room_for_twice_as_many_letters() {
        let scale = |name: &str| {
            let mut chart = chart();
            chart.groups[0].bars[0].name = name.into();
            BarScale::for_chart(&chart)
        };
        let (wide, narrow) = (scale("全日本決勝"), scale("10 letters"));
        assert_eq!((wide.left, wide.unit), (narrow.left, narrow.unit));
        assert!(scale(&"e\u{301}".repeat(10)).left <= narrow.left);
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
