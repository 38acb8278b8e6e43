//! Reports as HTML.

mod pictures;
mod tables;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use mmsim_maze::{Cell, Maze};

use crate::charts::{Chart, STYLE as CHART_STYLE};
use crate::comparison::{Candidate, Comparison};
use crate::summary::MeasureStatistics;
use crate::text::clean;

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
    /// largest differences in the first measure, the statistics as tables and sentences, charts,
    /// failures, and the values in each maze.
    /// `path` returns the path of a candidate in a maze for these pictures. If it returns `None`,
    /// the picture is omitted.
    ///
    /// Each number is in an HTML element such as `<data class="mean" value="12.375">12.4</data>`,
    /// whose value is the exact number and whose class is the JSON key of the number.
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
    /// assert!(page.contains(r#"<data class="mean" value="3">3.000</data>"#));
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

    /// Returns the title, the overview, the notes and the candidates.
    fn introduction(&self) -> Markup {
        let described = self.candidates().iter().filter(|one| !one.description.is_empty());
        let described: Vec<&Candidate> = described.collect();
        html! {
            h1 { (clean(&self.title)) }
            (self.overview_table())
            @for note in &self.notes { p { (clean(note)) } }
            @if !described.is_empty() {
                (tables::table(
                    None,
                    "Descriptions",
                    &html! { td {} th class="text" { "description" } },
                    &html! {
                        @for Candidate { name, description } in described {
                            tr { th { (clean(name)) } td class="text" { (clean(description)) } }
                        }
                    },
                ))
            }
        }
    }

    fn overview_table(&self) -> Markup {
        let Some((head, rows)) = self.overview.split_first() else { return html! {} };
        let head = html! {
            @for cell in head { @if cell.is_empty() { td {} } @else { th { (clean(cell)) } } }
        };
        let rows = html! {
            @for (name, cells) in rows.iter().filter_map(|row| row.split_first()) {
                tr { th { (clean(name)) } @for cell in cells { td { (clean(cell)) } } }
            }
        };
        tables::table(Some("overview"), "Overview", &head, &rows)
    }

    fn measure_section(index: usize, statistics: &MeasureStatistics, chart: &Chart) -> Markup {
        let content = html! {
            (sentences(statistics))
            (tables::statistics(statistics))
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
                        (tables::values(self, measure, values))
                    }
                }
            }
        }
    }
}

/// Returns how many mazes each candidate solved, and the differences between the candidates.
fn sentences(statistics: &MeasureStatistics) -> Markup {
    let differences = match statistics.candidates.len() {
        0 | 1 => Vec::new(),
        _ => statistics.sentences(),
    };
    let sentences = std::iter::once(statistics.coverage()).chain(differences);
    // A line does not begin with a percent sign.
    let sentences = sentences.map(|sentence| clean(&sentence).replace(" %", "\u{a0}%"));
    html! {
        @if !statistics.candidates.is_empty() {
            ul { @for sentence in sentences { li { (sentence) } } }
        }
    }
}

fn explanations() -> Markup {
    html! {
        section {
            h2 { "How to read this report" }
            ul {
                li {
                    "Lower values are better. Means, medians and quartiles refer to the mazes in which every "
                    "mouse has a value, so that all mice are compared in the same mazes. Mice with values in "
                    "fewer than half as many mazes as another one are ignored."
                }
                li {
                    "Half of the values are in the middle half, which lies between the first and the third "
                    "quartile. Quartiles are interpolated linearly between the nearest values. The standard "
                    "deviation is that of a sample."
                }
                li {
                    "Differences are paired: they are means over the mazes in which both mice have a value. "
                    "The 95\u{a0}% interval is the confidence interval of such a mean, by Student's t-distribution. An "
                    "interval that contains 0 means that the difference may be due to chance."
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::comparison::Measure;

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

    /// Returns the class and the value of each `<data>` element.
    fn data(html: &str) -> Vec<(&str, f64)> {
        let elements = html.split("<data class=\"").skip(1).map(|rest| {
            let (class, rest) = rest.split_once("\" value=\"").unwrap();
            (class, rest.split_once('"').unwrap().0.parse().unwrap())
        });
        elements.collect()
    }

    /// Adds the names and values of all numbers in an object, at any depth, except those of `skipped`
    /// keys.
    fn numbers(value: &Value, skipped: &str, found: &mut Vec<(String, f64)>) {
        for (key, value) in
            value.as_object().into_iter().flatten().filter(|(key, _)| *key != skipped)
        {
            found.extend(value.as_f64().map(|number| (key.clone(), number)));
            numbers(value, skipped, found);
        }
    }

    #[test]
    fn the_numbers_equal_those_of_the_json() {
        let comparison = comparison(&NAMES, 25);
        let page = comparison.html(|_, _| None);
        let sections: Vec<&str> = page.split("<section>").skip(1).collect();
        for (statistics, section) in comparison.statistics().iter().zip(sections) {
            let json = serde_json::to_value(statistics).unwrap();
            let candidates = json["candidates"].as_array().unwrap();
            let (mut distributions, mut differences) = (Vec::new(), Vec::new());
            for candidate in candidates {
                numbers(candidate, "difference", &mut distributions);
                numbers(&candidate["difference"], "", &mut differences);
            }
            // The caption states the number of common mazes.
            distributions.retain(|(key, _)| key != "common_maze_count");
            let mut expected = [distributions, differences].concat();
            let mut shown: Vec<_> = data(section)
                .into_iter()
                .map(|(class, value)| (class.to_string(), value))
                .collect();
            assert_eq!(shown.len(), 3 * 8 + 1 + 2 * 7, "one candidate has no values");
            // The order of columns is not that of the keys.
            let by_key = |one: &(String, f64), other: &(String, f64)| {
                one.0.cmp(&other.0).then(one.1.total_cmp(&other.1))
            };
            expected.sort_by(by_key);
            shown.sort_by(by_key);
            assert_eq!(shown, expected);
        }
    }

    #[test]
    fn values_are_shown_in_each_maze() {
        let comparison = comparison(&NAMES, 6);
        let page = comparison.html(|_, _| None);
        let (_, tables) = page.split_once("Values in each maze").unwrap();
        let shown: Vec<f64> = data(tables).into_iter().map(|(_, value)| value).collect();
        let values = comparison.measures().iter().flat_map(|(_, values)| {
            (0..6).flat_map(move |maze| values.rows().iter().filter_map(move |row| row[maze]))
        });
        assert_eq!(shown, values.collect::<Vec<_>>());
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
        let mice = vec![Candidate { description: "a mouse".into(), ..NAMES[0].into() }];
        let described = Comparison::new("Mice", mice, vec![]).html(|_, _| None);
        comparison.overview =
            vec![vec![String::new(), "solved".into()], vec!["mine".into(), "25".into()]];
        let page = comparison.html(|_, _| None) + &described;
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
        assert!(sections[..3].iter().all(|section| section.matches("<svg").count() == 1));
        assert!(sections[1].contains("<h2>score</h2><ul>"));
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
