//! The statistics of a measure as data, as a table and as sentences.

use mmsim_maze::Escaped;
use serde::Serialize;

use crate::comparison::{Comparison, Measure};
use crate::statistics::{Difference, Distribution, Interval, Statistics, Values};
use crate::text::{NumberFormat, shortened};

/// The statistics of all candidates for one measure. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasureStatistics {
    /// The measure.
    #[serde(flatten)]
    pub measure: Measure,
    /// The number of mazes in which the candidates were compared.
    #[serde(rename = "maze_count")]
    pub mazes: usize,
    /// The name of the candidate with which the others are compared: the first candidate that has
    /// any value.
    pub reference: Option<String>,
    /// The statistics of each candidate.
    pub candidates: Vec<CandidateStatistics>,
}

/// The statistics of a candidate for one measure. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateStatistics {
    /// The name of the candidate.
    pub candidate: String,
    /// The statistics.
    #[serde(flatten)]
    pub statistics: Statistics,
}

/// The cell of a table in which there is no number.
const NONE: &str = "-";

impl MeasureStatistics {
    pub(crate) fn new(comparison: &Comparison, measure: &Measure, values: &Values) -> Self {
        let names = || comparison.candidates().iter().map(|candidate| candidate.name.clone());
        let candidates = names().zip(values.statistics());
        Self {
            measure: measure.clone(),
            mazes: comparison.mazes().len(),
            reference: values.reference().and_then(|reference| names().nth(reference)),
            candidates: candidates
                .map(|(candidate, statistics)| CandidateStatistics { candidate, statistics })
                .collect(),
        }
    }

    /// Returns a table with a header and a row for each candidate. The columns after "solved" refer
    /// to the mazes that all candidates solved (see [`Self::caption`]); the columns after
    /// "difference" refer to the mazes that both the candidate and the reference solved. If there is
    /// only one candidate, the columns for differences are omitted.
    ///
    /// ```
    /// use mmsim_report::{Comparison, Measure};
    /// let table = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
    ///     .with_measure(Measure::new("turns", "turns", "turns"), |mouse, _| Some(mouse as f64 + 7.0))
    ///     .statistics()[0]
    ///     .table();
    /// assert_eq!(table[0][..3], ["turns", "solved", "mean"]);
    /// assert_eq!(table[2][..3], ["b", "1", "8.000"]);
    /// ```
    pub fn table(&self) -> Vec<Vec<String>> {
        let mut head = vec![self.measure.heading(), self.measure.verb.clone()];
        head.extend(["mean", "median", "middle half"].map(String::from));
        let is_compared = self.candidates.len() > 1;
        if is_compared {
            let reference = self.reference.as_deref().unwrap_or("the first mouse");
            head.push(format!("difference from {}", shortened(reference, 24)));
            head.extend(["95 % interval", "better", "equal", "worse"].map(String::from));
        }
        let rows = self.candidates.iter().map(|CandidateStatistics { candidate, statistics }| {
            let mut row = vec![candidate.clone(), statistics.mazes.to_string()];
            row.extend(self.distribution_cells(statistics.distribution.as_ref()));
            if is_compared {
                row.extend(self.difference_cells(statistics.difference.as_ref()));
            }
            row
        });
        std::iter::once(head).chain(rows).collect()
    }

    fn distribution_cells(&self, distribution: Option<&Distribution>) -> [String; 3] {
        let Some(distribution) = distribution else { return [NONE; 3].map(String::from) };
        let Distribution { mean, median, lower_quartile, upper_quartile, .. } = *distribution;
        let [mean, median, lower, upper] = [mean, median, lower_quartile, upper_quartile]
            .map(|number| self.format().plain(number));
        [mean, median, format!("{lower} to {upper}")]
    }

    fn difference_cells(&self, difference: Option<&Difference>) -> [String; 5] {
        let Some(difference) = difference else { return [NONE; 5].map(String::from) };
        let Difference { mean, confidence_interval, better, equal, worse, .. } = *difference;
        let format = self.format();
        let interval = confidence_interval.map_or(NONE.into(), |Interval { lower, upper }| {
            format!("{} to {}", format.signed(lower), format.signed(upper))
        });
        let [better, equal, worse] = [better, equal, worse].map(|count| count.to_string());
        [format.signed(mean), interval, better, equal, worse]
    }

    /// Returns the format of the numbers of this measure.
    pub(crate) fn format(&self) -> NumberFormat {
        let statistics = || self.candidates.iter().map(|candidate| &candidate.statistics);
        let means = statistics().filter_map(|one| Some(one.distribution.as_ref()?.mean));
        let differences = statistics().filter_map(|one| Some(one.difference.as_ref()?.mean));
        let numbers = means.chain(differences).map(f64::abs);
        NumberFormat::for_size(numbers.fold(0.0, f64::max))
    }

    /// Returns a sentence that states which mazes the means, medians and quartiles refer to.
    ///
    /// ```
    /// use mmsim_report::{Comparison, Measure};
    /// let statistics = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
    ///     .with_measure(Measure::new("turns", "turns", "turns"), |_, _| Some(7.0))
    ///     .statistics();
    /// assert_eq!(statistics[0].caption(), "Means over the one maze that both solved.");
    /// ```
    pub fn caption(&self) -> String {
        let verb = &self.measure.verb;
        let (with, without): (Vec<_>, Vec<_>) =
            self.candidates.iter().partition(|one| one.statistics.is_compared);
        let who = match &with[..] {
            [] => return format!("No mouse {verb} a maze."),
            [one] => &Escaped(&one.candidate).to_string(),
            [_, _] => "both",
            _ => "all",
        };
        let few = |one: &&CandidateStatistics| {
            let count = match one.statistics.mazes {
                0 => "none".into(),
                count => format!("only {count}"),
            };
            format!("{} {verb} {count}", Escaped(&one.candidate))
        };
        let without = match without.len() {
            0 => String::new(),
            _ => format!(" ({})", without.iter().map(few).collect::<Vec<_>>().join(", ")),
        };
        match self.candidates.first().map_or(0, |one| one.statistics.common_mazes) {
            0 => {
                format!("There are no means, because there is no maze that {who} {verb}{without}.")
            }
            count if count == self.mazes => {
                format!("Means over the {} that {who} {verb}{without}.", mazes(count))
            }
            count => {
                format!(
                    "Means over the {count} of {} that {who} {verb}{without}.",
                    mazes(self.mazes)
                )
            }
        }
    }

    /// Returns a sentence that states how many mazes each candidate solved. A candidate can have a
    /// low mean only because it failed in the difficult mazes.
    ///
    /// ```
    /// use mmsim_report::{Comparison, Measure};
    /// let statistics = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
    ///     .with_measure(Measure::new("turns", "turns", "turns"), |mouse, _| [Some(7.0), None][mouse])
    ///     .statistics();
    /// assert_eq!(statistics[0].coverage(), "Of one maze, a solved 1, b 0.");
    /// ```
    pub fn coverage(&self) -> String {
        let verb = [&*self.measure.verb, " "].concat();
        let verbs = std::iter::once(&*verb).chain(std::iter::repeat(""));
        let counts = self.candidates.iter().zip(verbs).map(|(one, verb)| {
            format!("{} {verb}{}", Escaped(&one.candidate), one.statistics.mazes)
        });
        format!("Of {}, {}.", mazes(self.mazes), counts.collect::<Vec<_>>().join(", "))
    }

    /// Returns a sentence for each candidate other than the reference, which states the difference
    /// between the reference and the candidate in plain words. The sentence states that a difference
    /// may be due to chance if its 95 % confidence interval contains 0.
    ///
    /// ```
    /// use mmsim_report::{Comparison, Measure};
    /// let statistics = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
    ///     .with_measure(Measure::new("steps", "steps to the goal", "steps"), |mouse, _| {
    ///         Some(40.0 + mouse as f64)
    ///     })
    ///     .statistics();
    /// let sentences = statistics[0].sentences();
    /// assert_eq!(sentences, ["In the one maze that both solved, a needs 1.00 fewer steps to the goal than b."]);
    /// ```
    pub fn sentences(&self) -> Vec<String> {
        let Some(reference) = &self.reference else { return vec![self.caption()] };
        let first = self.candidates.iter().position(|one| one.statistics.mazes > 0);
        let others = self.candidates.iter().enumerate().filter(|(index, _)| Some(*index) != first);
        others.map(|(_, other)| self.sentence(reference, other)).collect()
    }

    fn sentence(&self, reference: &str, other: &CandidateStatistics) -> String {
        let Measure { name, verb, .. } = &self.measure;
        let (one, two) = (Escaped(reference), Escaped(&other.candidate));
        let Some(difference) = &other.statistics.difference else {
            return match other.statistics.mazes {
                0 => format!("{two} {verb} none of the {}.", mazes(self.mazes)),
                _ => format!("There is no maze that both {one} and {two} {verb}."),
            };
        };
        let mazes = mazes(difference.mazes);
        if difference.equal == difference.mazes {
            return format!("In the {mazes} that both {verb}, {one} and {two} have equal {name}.");
        }
        if difference.mean == 0.0 {
            return format!(
                "In the {mazes} that both {verb}, {one} and {two} have equal mean {name}."
            );
        }
        let is_counted = self.measure.is_counted();
        let (less, more) = if is_counted { ("fewer", "more") } else { ("lower", "higher") };
        let is_less = difference.mean > 0.0;
        let direction = if is_less { less } else { more };
        let amount = |number: f64| self.format().plain(number.abs());
        let mean = amount(difference.mean);
        let fact = if is_counted {
            format!("{one} needs {mean} {direction} {name} than {two}")
        } else {
            let amount = [&mean, self.measure.difference_unit()].join(" ");
            format!("the {name} is {} {direction} for {one} than for {two}", amount.trim_end())
        };
        let chance = match difference.confidence_interval {
            None => String::new(),
            Some(interval) if interval.contains(0.0) => format!(
                " (95 % interval from {} {less} to {} {more}), which may be due to chance",
                amount(interval.upper),
                amount(interval.lower)
            ),
            Some(Interval { lower, upper }) => {
                let (near, far) = if is_less { (lower, upper) } else { (upper, lower) };
                format!(" (95 % interval {} to {})", amount(near), amount(far))
            }
        };
        format!("In the {mazes} that both {verb}, {fact}{chance}.")
    }
}

fn mazes(count: usize) -> String {
    if count == 1 { "one maze".into() } else { format!("{count} mazes") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the statistics of candidates a, b, c and so on with these values.
    fn statistics(measure: Measure, rows: &[&[Option<f64>]]) -> MeasureStatistics {
        let names = ('a'..).take(rows.len()).map(|name| name.to_string().into());
        let mazes = (0..rows.first().map_or(0, |row| row.len())).map(|maze| maze.to_string());
        let comparison = Comparison::new("", names.collect(), mazes.collect());
        let comparison = comparison.with_measure(measure, |one, maze| rows[one][maze]);
        comparison.statistics().remove(0)
    }

    fn steps(rows: &[&[Option<f64>]]) -> MeasureStatistics {
        statistics(Measure::new("steps", "steps to the goal", "steps"), rows)
    }

    const A: [Option<f64>; 4] = [Some(10.0), Some(20.0), Some(30.0), Some(44.0)];
    const NONE_SOLVED: [Option<f64>; 4] = [None; 4];

    #[test]
    fn a_table_has_a_row_for_each_candidate() {
        let b = [Some(12.0), Some(20.0), None, Some(40.0)];
        let table = steps(&[&A, &b, &NONE_SOLVED]).table();
        let text: Vec<String> = table.iter().map(|row| row.join(" | ")).collect();
        insta::assert_snapshot!(text.join("\n"), @"
        steps to the goal | solved | mean | median | middle half | difference from a | 95 % interval | better | equal | worse
        a | 4 | 24.67 | 20.00 | 15.00 to 32.00 | - | - | - | - | -
        b | 3 | 24.00 | 20.00 | 16.00 to 30.00 | -0.67 | -8.26 to +6.92 | 1 | 1 | 1
        c | 0 | - | - | - | - | - | - | - | -
        ");
        let alone = steps(&[&A]).table();
        assert_eq!(
            alone[0].join(" | "),
            "steps to the goal | solved | mean | median | middle half"
        );
    }

    #[test]
    fn a_caption_names_the_mazes_and_the_candidates_without_any() {
        let b = [Some(12.0), None, None, None];
        let c = [None, Some(1.0), None, None];
        let d = [Some(12.0), Some(1.0), None, None];
        let captions = [
            steps(&[&A]).caption(),
            steps(&[&A, &d]).caption(),
            steps(&[&A, &NONE_SOLVED, &d, &b]).caption(),
            steps(&[&A, &b]).caption(),
            steps(&[&A, &A, &A]).caption(),
            steps(&[&A, &NONE_SOLVED, &b, &NONE_SOLVED]).caption(),
            steps(&[&NONE_SOLVED, &A]).caption(),
            steps(&[&b, &c]).caption(),
            steps(&[&NONE_SOLVED]).caption(),
            steps(&[]).caption(),
        ];
        insta::assert_snapshot!(captions.join("\n"), @"
        Means over the 4 mazes that a solved.
        Means over the 2 of 4 mazes that both solved.
        Means over the 2 of 4 mazes that both solved (b solved none, d solved only 1).
        Means over the 4 mazes that a solved (b solved only 1).
        Means over the 4 mazes that all solved.
        Means over the 4 mazes that a solved (b solved none, c solved only 1, d solved none).
        Means over the 4 mazes that b solved (a solved none).
        There are no means, because there is no maze that both solved.
        No mouse solved a maze.
        No mouse solved a maze.
        ");
    }

    #[test]
    fn sentences_state_the_difference_and_its_uncertainty() {
        let plus = |row: [Option<f64>; 4], more: [f64; 4]| {
            let mut sums =
                row.iter().zip(more).map(|(value, more)| value.map(|value| value + more));
            std::array::from_fn::<_, 4, _>(|_| sums.next().flatten())
        };
        let (b, c) = (plus(A, [3.0, 4.0, 5.0, 4.0]), plus(A, [-3.0, 4.0, -5.0, 1.0]));
        let d = plus(A, [-3.0, -4.0, -5.0, -4.0]);
        let one = [None, None, None, Some(50.0)];
        let two = [Some(10.0), None, None, None];
        let mut sentences = steps(&[&A, &b, &c, &d, &A, &one, &NONE_SOLVED]).sentences();
        sentences.extend(steps(&[&NONE_SOLVED, &one, &two]).sentences());
        sentences.extend(steps(&[&NONE_SOLVED]).sentences());
        let score = Measure::new("score", "score", "").with_verb("scored in");
        sentences.extend(statistics(score, &[&A, &b]).sentences());
        let time = Measure::new("time", "processor time", "µs");
        sentences.extend(statistics(time, &[&A, &d]).sentences());
        let search = Measure::new("search", "time of the search", "s");
        sentences.extend(statistics(search, &[&A, &d]).sentences());
        let loss = Measure::new("loss", "loss of the fast run", "%");
        sentences.extend(statistics(loss, &[&A, &d]).sentences());
        insta::assert_snapshot!(sentences.join("\n"), @"
        In the 4 mazes that both solved, a needs 4.00 fewer steps to the goal than b (95 % interval 2.70 to 5.30).
        In the 4 mazes that both solved, a needs 0.75 more steps to the goal than c (95 % interval from 5.66 fewer to 7.16 more), which may be due to chance.
        In the 4 mazes that both solved, a needs 4.00 more steps to the goal than d (95 % interval 2.70 to 5.30).
        In the 4 mazes that both solved, a and e have equal steps to the goal.
        In the one maze that both solved, a needs 6.00 fewer steps to the goal than f.
        g solved none of the 4 mazes.
        a solved none of the 4 mazes.
        There is no maze that both b and c solved.
        No mouse solved a maze.
        In the 4 mazes that both scored in, the score is 4.00 lower for a than for b (95 % interval 2.70 to 5.30).
        In the 4 mazes that both solved, the processor time is 4.00 µs higher for a than for b (95 % interval 2.70 to 5.30).
        In the 4 mazes that both solved, the time of the search is 4.00 s higher for a than for b (95 % interval 2.70 to 5.30).
        In the 4 mazes that both solved, the loss of the fast run is 4.00 percentage points higher for a than for b (95 % interval 2.70 to 5.30).
        ");
    }

    #[test]
    fn names_cannot_control_a_terminal() {
        let names = ["a\u{1b}[2J", "b\n"].map(Into::into).into();
        let comparison = Comparison::new("", names, vec!["maze".into()]);
        let measure = Measure::new("turns", "turns", "turns");
        let statistics =
            comparison.with_measure(measure, |one, _| [Some(1.0), None][one]).statistics();
        let MeasureStatistics { candidates, .. } = &statistics[0];
        assert_eq!(candidates[1].candidate, "b\n", "the original name in JSON");
        let texts = [statistics[0].caption(), statistics[0].sentences().join(" ")];
        assert!(texts.iter().all(|text| !text.contains(char::is_control)), "{texts:?}");
    }

    #[test]
    fn the_json_has_plain_keys() {
        let json = serde_json::to_value(steps(&[&A, &[Some(9.0), None, None, None]])).unwrap();
        let expected = serde_json::json!({
            "key": "steps",
            "name": "steps to the goal",
            "unit": "steps",
            "maze_count": 4,
            "reference": "a",
            "candidates": [
                {
                    "candidate": "a",
                    "maze_count": 4,
                    "common_maze_count": 4,
                    "distribution": {
                        "mean": 26.0, "median": 25.0, "lower_quartile": 17.5, "upper_quartile": 33.5,
                        "standard_deviation": 14.514_360_704_718_161, "minimum": 10.0, "maximum": 44.0,
                    },
                    "difference": null,
                },
                {
                    "candidate": "b",
                    "maze_count": 1,
                    "common_maze_count": 4,
                    "distribution": null,
                    "difference": {
                        "maze_count": 1, "mean": -1.0, "confidence_interval": null,
                        "better": 1, "equal": 0, "worse": 0,
                    },
                },
            ],
        });
        assert_eq!(json, expected);
    }
}
