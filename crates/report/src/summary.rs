//! The statistics of a measure as a table.

use mmsim_maze::{Escaped, counted};

use crate::comparison::{Comparison, Measure};
use crate::statistics::{Difference, Interval, Statistics, Values};
use crate::text::NumberFormat;

/// The statistics of all candidates for one measure.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasureStatistics {
    /// The measure.
    pub measure: Measure,
    /// The number of mazes in which the candidates were compared.
    pub mazes: usize,
    /// The name of the candidate with which the others are compared: the first candidate that has
    /// any value.
    pub reference: Option<String>,
    /// The statistics of each candidate.
    pub candidates: Vec<CandidateStatistics>,
}

/// The statistics of a candidate for one measure.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateStatistics {
    /// The name of the candidate.
    pub candidate: String,
    /// The statistics.
    pub statistics: Statistics,
}

/// The cell of a table in which there is no number.
const NONE: &str = "-";

impl MeasureStatistics {
    pub(crate) fn new(comparison: &Comparison, measure: &Measure, values: &Values) -> Self {
        let names = || comparison.candidates().iter().cloned();
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

    /// Returns a table with a header and a row for each candidate, which the [caption](Self::caption)
    /// explains. If there is only one candidate, the columns for differences are omitted.
    ///
    /// ```
    /// use mmsim_report::{Comparison, Measure};
    /// let table = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
    ///     .with_measure(Measure::new("turns", "turns", "turns"), |mouse, _| Some(mouse as f64 + 7.0))
    ///     .statistics()[0]
    ///     .table();
    /// assert_eq!(table[0], ["mouse", "solved", "mean", "median", "difference", "95 % interval"]);
    /// assert_eq!(table[2], ["b", "1", "8.000", "8.000", "+1.000", "-"]);
    /// ```
    pub fn table(&self) -> Vec<Vec<String>> {
        let mut head = vec!["mouse", &self.measure.verb, "mean", "median"];
        let is_compared = self.candidates.len() > 1;
        head.extend(is_compared.then_some(["difference", "95 % interval"]).into_iter().flatten());
        let head = head.into_iter().map(String::from).collect();
        let rows = self.candidates.iter().map(|CandidateStatistics { candidate, statistics }| {
            let number = |number: Option<f64>| {
                number.map_or(NONE.into(), |number| self.format().plain(number))
            };
            let distribution = statistics.distribution.as_ref();
            let means = [distribution.map(|it| it.mean), distribution.map(|it| it.median)];
            let mut row = vec![candidate.clone(), statistics.mazes.to_string()];
            row.extend(means.map(number));
            if is_compared {
                row.extend(self.difference_cells(statistics.difference.as_ref()));
            }
            row
        });
        std::iter::once(head).chain(rows).collect()
    }

    fn difference_cells(&self, difference: Option<&Difference>) -> [String; 2] {
        let Some(difference) = difference else { return [NONE; 2].map(String::from) };
        let format = self.format();
        let interval = difference.confidence_interval;
        let interval = interval.map_or(NONE.into(), |Interval { lower, upper }| {
            format!("{} to {}", format.signed(lower), format.signed(upper))
        });
        [format.signed(difference.mean), interval]
    }

    /// Returns the format of the numbers of this measure.
    pub(crate) fn format(&self) -> NumberFormat {
        let statistics = || self.candidates.iter().map(|candidate| &candidate.statistics);
        let means = statistics().filter_map(|one| Some(one.distribution.as_ref()?.mean));
        let differences = statistics().filter_map(|one| Some(one.difference.as_ref()?.mean));
        let numbers = means.chain(differences).map(f64::abs);
        NumberFormat::for_size(numbers.fold(0.0, f64::max))
    }

    /// Returns which mazes the means, medians and quartiles refer to, which candidates they ignore, and
    /// which candidate the others are compared with.
    ///
    /// ```
    /// use mmsim_report::{Comparison, Measure};
    /// let statistics = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
    ///     .with_measure(Measure::new("turns", "turns", "turns"), |_, _| Some(7.0))
    ///     .statistics();
    /// let caption = "Means over the 1 of 1 maze that all solved. Differences from a, where both have a value.";
    /// assert_eq!(statistics[0].caption(), caption);
    /// ```
    pub fn caption(&self) -> String {
        let verb = &self.measure.verb;
        let ignored = self.candidates.iter().filter(|one| !one.statistics.is_compared);
        let ignored = ignored
            .map(|one| format!("{} only {}", Escaped(&one.candidate), one.statistics.mazes))
            .collect::<Vec<_>>()
            .join(", ");
        let ignored = if ignored.is_empty() { ignored } else { format!(" ({ignored})") };
        let mazes = counted(self.mazes, "maze");
        let means = match self.candidates.first().map_or(0, |one| one.statistics.common_mazes) {
            0 => format!("No means: there is no maze that all {verb}{ignored}."),
            count => format!("Means over the {count} of {mazes} that all {verb}{ignored}."),
        };
        match self.reference.as_ref().filter(|_| self.candidates.len() > 1) {
            Some(reference) => {
                format!("{means} Differences from {}, where both have a value.", Escaped(reference))
            }
            None => means,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the statistics of candidates a, b, c and so on with these values.
    fn steps(rows: &[&[Option<f64>]]) -> MeasureStatistics {
        let names = ('a'..).take(rows.len()).map(String::from);
        let mazes = (0..rows.first().map_or(0, |row| row.len())).map(|maze| maze.to_string());
        let comparison = Comparison::new("", names.collect(), mazes.collect());
        let measure = Measure::new("steps", "steps to the goal", "steps");
        let comparison = comparison.with_measure(measure, |one, maze| rows[one][maze]);
        comparison.statistics().remove(0)
    }

    const A: [Option<f64>; 4] = [Some(10.0), Some(20.0), Some(30.0), Some(44.0)];
    const NONE_SOLVED: [Option<f64>; 4] = [None; 4];

    #[test]
    fn a_table_has_a_row_for_each_candidate() {
        let b = [Some(12.0), Some(20.0), None, Some(40.0)];
        let table = steps(&[&A, &b, &NONE_SOLVED]).table();
        let text: Vec<String> = table.iter().map(|row| row.join(" | ")).collect();
        insta::assert_snapshot!(text.join("\n"), @"
        mouse | solved | mean | median | difference | 95 % interval
        a | 4 | 24.67 | 20.00 | - | -
        b | 3 | 24.00 | 20.00 | -0.67 | -8.26 to +6.92
        c | 0 | - | - | - | -
        ");
        let alone = steps(&[&A]).table();
        assert_eq!(alone[0].join(" | "), "mouse | solved | mean | median");
    }

    #[test]
    fn a_caption_names_the_mazes_and_the_candidates_with_few_values() {
        let b = [Some(12.0), None, None, None];
        let c = [None, Some(1.0), None, None];
        let d = [Some(12.0), Some(1.0), None, None];
        let captions = [
            steps(&[&A]).caption(),
            steps(&[&A, &d]).caption(),
            steps(&[&A, &NONE_SOLVED, &d, &b]).caption(),
            steps(&[&A, &b]).caption(),
            steps(&[&NONE_SOLVED, &A]).caption(),
            steps(&[&b, &c]).caption(),
            steps(&[&NONE_SOLVED]).caption(),
            steps(&[]).caption(),
        ];
        insta::assert_snapshot!(captions.join("\n"), @"
        Means over the 4 of 4 mazes that all solved.
        Means over the 2 of 4 mazes that all solved. Differences from a, where both have a value.
        Means over the 2 of 4 mazes that all solved (b only 0, d only 1). Differences from a, where both have a value.
        Means over the 4 of 4 mazes that all solved (b only 1). Differences from a, where both have a value.
        Means over the 4 of 4 mazes that all solved (a only 0). Differences from b, where both have a value.
        No means: there is no maze that all solved. Differences from a, where both have a value.
        No means: there is no maze that all solved (a only 0).
        No means: there is no maze that all solved.
        ");
    }
}
