//! Reports as HTML.

mod pictures;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use mmsim_maze::{Cell, Maze};

use crate::charts::{Chart, STYLE as CHART_STYLE};
use crate::comparison::{Comparison, Measure};
use crate::statistics::Values;
use crate::summary::MeasureStatistics;
use crate::text::{NumberFormat, clean};

const STYLE: &str = include_str!("html/style.css");

/// The content security policy of a report, which allows styles only.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

/// The number of measures whose sections are open. The sections of further measures are collapsed.
const OPEN_MEASURES: usize = 2;

/// The path of a candidate through a maze, for pictures in a report.
#[derive(Clone, Debug, PartialEq)]
pub struct MousePath<'a> {
    /// The maze.
    pub maze: &'a Maze,
    /// The points from the start to the end of the path, which are connected by straight lines: their
    /// distances to the east and to the north of the maze's south-west corner, in cells.
    pub points: Vec<(f64, f64)>,
}

impl<'a> MousePath<'a> {
    /// Returns the path through the centres of cells.
    pub fn through_cells(maze: &'a Maze, cells: &[Cell]) -> Self {
        let centre = |cell: &Cell| (f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5);
        Self { maze, points: cells.iter().map(centre).collect() }
    }
}

impl Comparison {
    /// Returns a report as an HTML page without scripts that needs no other files.
    ///
    /// The report begins with the overview and the notes. It contains pictures of the mazes with the
    /// largest differences in the first measure, the statistics and a chart of each measure, failures,
    /// and the values in each maze.
    /// `path` returns the path of a candidate in a maze for these pictures. If it returns `None`,
    /// the picture is omitted.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Maze};
    /// use mmsim_report::{Comparison, Measure, MousePath};
    ///
    /// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
    /// let comparison = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
    ///     .with_measure(Measure::new("steps", "steps to the goal", "steps"), |candidate, _| {
    ///         Some([1.0, 3.0][candidate])
    ///     });
    /// let page = comparison.html(|_candidate, _maze| {
    ///     Some(MousePath::through_cells(&maze, &[Cell::new(0, 0), Cell::new(1, 0)]))
    /// });
    /// assert!(page.contains("<tr><th>b</th><td>1</td><td>3.000</td>"));
    /// # Ok::<(), mmsim_maze::ParseMazeError>(())
    /// ```
    pub fn html<'a>(&self, path: impl Fn(usize, usize) -> Option<MousePath<'a>>) -> String {
        let statistics = self.statistics();
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width,initial-scale=1";
                    title { (clean(&self.title)) }
                    style { (PreEscaped(STYLE)) (PreEscaped(CHART_STYLE)) }
                }
                body {
                    main {
                        (self.introduction())
                        (self.pictures_section(path))
                        @for (index, (measure, chart)) in
                            statistics.iter().zip(self.charts()).enumerate() {
                            (Self::measure_section(index, measure, &chart))
                        }
                        (self.failures_section())
                        (self.mazes_section())
                        (explanations())
                    }
                }
            }
        };
        page.into_string() + "\n"
    }

    /// Returns the title, the overview and the notes.
    fn introduction(&self) -> Markup {
        html! {
            h1 { (clean(&self.title)) }
            (table(Some("overview"), "Overview", &self.overview))
            @for note in &self.notes { p { (clean(note)) } }
        }
    }

    fn measure_section(index: usize, statistics: &MeasureStatistics, chart: &Chart) -> Markup {
        let content = html! {
            (table(None, &statistics.caption(), &statistics.table()))
            figure { (chart.inline()) }
        };
        let heading = clean(&statistics.measure.heading());
        html! {
            section {
                h2 { (heading) }
                @if index < OPEN_MEASURES {
                    (content)
                } @else {
                    details { summary { "Table and chart" } (content) }
                }
            }
        }
    }

    fn mazes_section(&self) -> Markup {
        html! {
            section class="values" {
                h2 { "Values in each maze" }
                @for (measure, values) in self.measures() {
                    details {
                        summary class="measure" { (clean(&measure.heading())) }
                        (self.values_table(measure, values))
                    }
                }
            }
        }
    }

    /// Returns a list of failures, or nothing if there are none.
    fn failures_section(&self) -> Markup {
        let lines = self.candidates().iter().enumerate().flat_map(|(index, name)| {
            let lines = self.failures(index).into_iter();
            lines.map(|line| clean(&format!("{}: {line}", clean(name))))
        });
        let lines: Vec<String> = lines.collect();
        html! {
            @if !lines.is_empty() {
                section { h2 { "Failures" } ul { @for line in lines { li { (line) } } } }
            }
        }
    }

    /// Returns a table with a row for each maze and a column for each candidate.
    fn values_table(&self, measure: &Measure, values: &Values) -> Markup {
        let format = NumberFormat::for_values(values.rows().iter().flatten().flatten().copied());
        let head = ["maze".into()].into_iter().chain(self.candidates().iter().cloned()).collect();
        let rows = self.mazes().iter().enumerate().map(|(index, maze)| {
            let value = |value: Option<f64>| value.map_or("–".into(), |it| format.plain(it));
            let cells = values.rows().iter().map(|row| value(row[index]));
            [maze.clone()].into_iter().chain(cells).collect()
        });
        let rows: Vec<_> = [head].into_iter().chain(rows).collect();
        table(None, &measure.heading(), &rows)
    }
}

/// Returns a table that scrolls sideways on a narrow screen. The first row is the header, and the first
/// column contains the names of the rows.
fn table(class: Option<&str>, caption: &str, rows: &[Vec<String>]) -> Markup {
    let Some((head, rows)) = rows.split_first() else { return html! {} };
    let caption = clean(caption);
    html! {
        div class="scroll" tabindex="0" role="group" aria-label=(caption) {
            table class=[class] {
                caption { (caption) }
                thead { tr { @for cell in head { th { (clean(cell)) } } } }
                tbody {
                    @for (name, cells) in rows.iter().filter_map(|row| row.split_first()) {
                        tr { th { (clean(name)) } @for cell in cells { td { (clean(cell)) } } }
                    }
                }
            }
        }
    }
}

fn explanations() -> Markup {
    html! {
        section {
            h2 { "How to read this report" }
            ul {
                li {
                    "Lower values are better. Means, medians and charts refer to the mazes in which every mouse "
                    "has a value. Mice with values in fewer than half as many mazes as another one are ignored."
                }
                li {
                    "Differences are paired: they are means over the mazes in which both mice have a value. "
                    "The 95\u{a0}% interval is the confidence interval of such a mean, by Student's t-distribution. "
                    "If it contains 0, the difference may be due to chance."
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a comparison with several measures, in some of which candidates have no values.
    fn comparison(names: &[&str], mazes: usize) -> Comparison {
        let candidates = names.iter().map(|&name| name.into()).collect();
        let mazes = (0..mazes).map(|maze| format!("maze {maze} <&\">")).collect();
        let value = |one: usize, maze: usize, factor: f64| {
            let is_solved = one != 2 && (one + maze) % 4 != 3;
            is_solved.then(|| factor * crate::charts::count(40 + (7 * maze + 11 * one) % 29))
        };
        let mut comparison = Comparison::new("Mice & <mazes>", candidates, mazes)
            .with_measure(Measure::new("steps", "steps to the goal", "steps"), |one, maze| {
                value(one, maze, 1.0)
            })
            .with_measure(Measure::new("score", "score", ""), |one, maze| value(one, maze, 0.1))
            .with_measure(
                Measure::new("processor_time_us", "processor time", "µs"),
                |one, maze| value(one, maze, 1.0 / 3.0),
            )
            .with_failures(|one, maze| value(one, maze, 1.0).is_none().then(|| "crashed".into()));
        comparison.notes.push("Made-up \u{1b} values".into());
        comparison
    }

    const NAMES: [&str; 4] = ["mine", "<script>alert(1)</script>", "]]>\u{0}", "\" onload=\"x"];

    /// Returns the text of each cell of the tables that is not a name, in order.
    fn cells(html: &str) -> Vec<&str> {
        html.split("<td>").skip(1).map(|rest| rest.split_once("</td>").unwrap().0).collect()
    }

    #[test]
    fn each_measure_has_its_table_and_chart() {
        let comparison = comparison(&NAMES, 25);
        let page = comparison.html(|_, _| None);
        let sections: Vec<&str> = page.split("<section>").skip(1).collect();
        for (statistics, section) in comparison.statistics().iter().zip(sections) {
            let expected: Vec<String> =
                statistics.table()[1..].iter().flat_map(|row| row[1..].to_vec()).collect();
            assert_eq!(cells(section), expected);
            assert_eq!(section.matches("<svg").count(), 1);
        }
    }

    #[test]
    fn values_are_shown_in_each_maze() {
        let comparison = comparison(&NAMES, 6);
        let page = comparison.html(|_, _| None);
        let (_, tables) = page.split_once("Values in each maze").unwrap();
        let (shown, missing): (Vec<_>, Vec<_>) =
            cells(tables).into_iter().partition(|&cell| cell != "–");
        let shown: Vec<f64> = shown.into_iter().map(|cell| cell.parse().unwrap()).collect();
        let values = comparison.measures().iter().flat_map(|(_, values)| {
            (0..6).flat_map(move |maze| values.rows().iter().filter_map(move |row| row[maze]))
        });
        let values: Vec<f64> = values.collect();
        assert_eq!(shown.len() + missing.len(), 3 * 6 * NAMES.len());
        assert_eq!(shown.len(), values.len());
        for (shown, value) in shown.into_iter().zip(values) {
            assert!((shown - value).abs() <= 0.05, "{shown} is not {value}");
        }
    }

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
        let comparison = Comparison::new("", vec!["mine".into()], vec!["maze".into()]);
        assert_eq!(comparison.failures_section().into_string(), "");
    }

    #[test]
    fn a_report_needs_no_other_files_and_no_scripts() {
        let page = comparison(&NAMES, 25).html(|_, _| None);
        for forbidden in
            ["<script", "src=", "href=", "url(", "@import", "<link", "onload=\"", "]]>"]
        {
            assert!(!page.contains(forbidden), "{forbidden}");
        }
        let other = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        assert!(!other.contains("://"));
        assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
        assert!(!page.contains(|c: char| c.is_control() && c != '\n'));
        assert_eq!(page.matches("<style>").count(), 1);
        assert!(page.contains("content=\"default-src 'none'; style-src 'unsafe-inline'; "));
    }

    #[test]
    fn headings_have_text_and_the_keyboard_scrolls_tables() {
        let mut comparison = comparison(&NAMES, 25);
        comparison.overview =
            vec![vec!["mouse".into(), "solved".into()], vec!["mine".into(), "25".into()]];
        let page = comparison.html(|_, _| None);
        for empty in ["<th></th>", "<h1></h1>", "<h2></h2>", "<h3></h3>", "<caption></caption>"] {
            assert!(!page.contains(empty), "{empty}");
        }
        let areas: Vec<_> = page.split("<div class=\"scroll\"").skip(1).collect();
        assert_eq!(areas.len(), page.matches("<table").count());
        for area in areas {
            let (attributes, _) = area.split_once('>').unwrap();
            let (before, label) = attributes.split_once("aria-label=\"").unwrap();
            assert_eq!(before, " tabindex=\"0\" role=\"group\" ");
            assert!(!label.starts_with('"'));
        }
    }

    #[test]
    fn only_the_first_measures_are_open() {
        let names = ["a", "b", "-", "c", "d"];
        let page = comparison(&names, 25).html(|_, _| None);
        let sections: Vec<&str> = page.split("<section>").skip(1).collect();
        assert!(sections[1].contains("<h2>score</h2><div"));
        assert!(
            sections[2].contains(
                "<h2>processor time (µs)</h2><details><summary>Table and chart</summary>"
            )
        );
    }

    #[test]
    fn the_report_of_two_candidates_is_stable() {
        let comparison = comparison(&["mine", "flood-fill"], 3);
        let page = comparison.html(|_, _| None);
        let mut page = page.replace(STYLE, "").replace(CHART_STYLE, "");
        // The charts have snapshots of their own.
        while let Some(start) = page.find("<svg") {
            let end = page.find("</svg>").unwrap();
            page.replace_range(start..end + 6, "(chart)");
        }
        let page = ["</tr>", "</p>", "</li>", "</h2>", "</caption>", "<tbody>", "</summary>"]
            .into_iter()
            .fold(page, |page, tag| page.replace(tag, &format!("{tag}\n")));
        insta::assert_snapshot!(page);
    }

    #[test]
    fn an_empty_comparison_has_a_report() {
        for (candidates, mazes) in [(0, 0), (0, 2), (2, 0), (1, 1)] {
            let page = comparison(&NAMES[..candidates], mazes).html(|_, _| None);
            assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
            assert!(!page.contains("NaN") && !page.contains("inf\""));
        }
    }
}
