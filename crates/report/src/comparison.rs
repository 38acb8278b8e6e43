//! The data of a comparison.

use std::cmp::Reverse;

use mmsim_maze::{Escaped, counted};

use crate::statistics::Values;
use crate::summary::MeasureStatistics;

/// The maximum number of mazes that a report names for a reason why a candidate failed.
const MAX_MAZES: usize = 4;
/// The maximum number of reasons that a report lists for a candidate.
const MAX_REASONS: usize = 10;

/// A comparison of candidates, such as mice or robots, in the same mazes.
///
/// The first candidate is the one that the others are compared with. Candidates and mazes are
/// identified by their indices, starting at 0.
///
/// ```
/// use mmsim_report::{Comparison, Measure};
/// let comparison = Comparison::new("Mice", vec!["a".into(), "b".into()], vec!["maze".into()])
///     .with_measure(Measure::new("steps", "steps to the goal", "steps"), |candidate, _| {
///         (candidate == 0).then_some(31.0)
///     })
///     .with_failures(|candidate, _| (candidate == 1).then(|| "crashed".into()));
/// assert_eq!(comparison.statistics()[0].candidates[1].statistics.mazes, 0);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The title.
    pub title: String,
    /// Paragraphs for the reader of a report, for example where the mazes come from.
    pub notes: Vec<String>,
    /// A table for the beginning of a report, for example with the number of mazes in which each
    /// candidate succeeded. The first row is the header, and the first column contains the names of
    /// the candidates. Without rows, there is no table.
    pub overview: Vec<Vec<String>>,
    /// Sentences that state which paths the pictures of a report show, or an empty string.
    pub pictures_caption: String,
    candidates: Vec<String>,
    mazes: Vec<String>,
    measures: Vec<(Measure, Values)>,
    /// Why each candidate failed in each maze, if it did.
    failures: Vec<Vec<Option<String>>>,
}

/// A measure for which lower values are better.
///
/// ```
/// use mmsim_report::Measure;
/// let steps = Measure::new("steps_to_goal", "steps to the goal", "steps");
/// assert_eq!(steps.heading(), "steps to the goal");
/// assert_eq!(Measure::new("time", "search time", "s").heading(), "search time (s)");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Measure {
    /// The name for programs.
    pub key: String,
    /// The name for people.
    pub name: String,
    /// The unit in the plural, or an empty string.
    pub unit: String,
    /// What a candidate has done with a maze in which it has a value, in the past tense: `solved`
    /// in "the mazes that all solved".
    pub verb: String,
}

impl Measure {
    /// Creates a measure that has a value in each maze that a candidate `solved`.
    pub fn new(key: impl Into<String>, name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { key: key.into(), name: name.into(), unit: unit.into(), verb: "solved".into() }
    }

    /// Sets what a candidate has done with a maze in which it has a value.
    pub fn with_verb(mut self, verb: impl Into<String>) -> Self {
        self.verb = verb.into();
        self
    }

    /// Returns the name, followed by the unit unless the name contains it.
    pub fn heading(&self) -> String {
        let Self { name, unit, .. } = self;
        // Steps are counted, and a time is measured.
        let has_unit = unit.is_empty() || name.split(' ').any(|word| word == unit);
        if has_unit { name.clone() } else { format!("{name} ({unit})") }
    }
}

/// Lists the reasons that belong to mazes, the most frequent ones first, each after the names of its
/// mazes. Reasons that differ only in digits are one reason, which is shown as in its first maze. Shows
/// at most `max_mazes` for a reason and at most `max_reasons`, and adds `hint` if there are more reasons.
///
/// ```
/// let mazes = [("lost", "one"), ("stuck after step 9", "two"), ("stuck after step 15", "three")];
/// let lines = mmsim_report::list_reasons(mazes, 1, 2, "");
/// assert_eq!(lines, ["two and 1 more: such as stuck after step 9", "one: lost"]);
/// ```
pub fn list_reasons<'a>(
    reasons: impl IntoIterator<Item = (&'a str, &'a str)>,
    max_mazes: usize,
    max_reasons: usize,
    hint: &str,
) -> Vec<String> {
    let words = |text: &'a str| text.split(|letter: char| letter.is_ascii_digit());
    let words = |text| words(text).filter(|word| !word.is_empty());
    let mut groups: Vec<(&str, Vec<(&str, &str)>)> = Vec::new();
    for one @ (reason, _) in reasons {
        match groups.iter_mut().find(|&&mut (other, _)| words(other).eq(words(reason))) {
            Some((_, group)) => group.push(one),
            None => groups.push((reason, vec![one])),
        }
    }
    groups.sort_by_key(|(_, group)| Reverse(group.len()));
    let others = groups.iter().skip(max_reasons).map(|(_, group)| group.len()).sum::<usize>();
    let others =
        (others > 0).then(|| format!("{} for other reasons{hint}", counted(others, "maze")));
    let line = |(reason, group): &(&str, Vec<(&str, &str)>)| {
        let names = group.iter().take(max_mazes).map(|(_, maze)| Escaped(maze).to_string());
        let names = names.collect::<Vec<_>>().join(", ");
        let more = match group.len().saturating_sub(max_mazes) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        // The numbers in a reason are those of its first maze.
        let such_as = if group.iter().any(|(other, _)| other != reason) { "such as " } else { "" };
        format!("{names}{more}: {such_as}{}", Escaped(reason))
    };
    groups.iter().take(max_reasons).map(line).chain(others).collect()
}

impl Comparison {
    /// Creates a comparison of these candidates in the mazes with these names, without measures.
    pub fn new(title: impl Into<String>, candidates: Vec<String>, mazes: Vec<String>) -> Self {
        Self { title: title.into(), candidates, mazes, ..Self::default() }
    }

    /// Adds a measure. `value` returns the value of a candidate in a maze, or `None` if there is no
    /// value, for example because the candidate did not solve the maze. A number that is not finite
    /// counts as no value (see [`Values::new`]).
    pub fn with_measure(
        mut self,
        measure: Measure,
        value: impl FnMut(usize, usize) -> Option<f64>,
    ) -> Self {
        let values = Values::new(self.candidates.len(), self.mazes.len(), value);
        self.measures.push((measure, values));
        self
    }

    /// Sets the failures. `reason` returns the reason why a candidate failed in a maze, or `None` if
    /// it did not fail.
    pub fn with_failures(mut self, reason: impl Fn(usize, usize) -> Option<String>) -> Self {
        let reasons = |one| (0..self.mazes.len()).map(|maze| reason(one, maze)).collect();
        self.failures = (0..self.candidates.len()).map(reasons).collect();
        self
    }

    /// Sets the sentences that state which paths the pictures of a report show.
    pub fn with_pictures_caption(mut self, caption: impl Into<String>) -> Self {
        self.pictures_caption = caption.into();
        self
    }

    /// Returns the names of the candidates.
    pub fn candidates(&self) -> &[String] {
        &self.candidates
    }

    /// Returns the names of the mazes.
    pub fn mazes(&self) -> &[String] {
        &self.mazes
    }

    /// Returns the measures and their values.
    pub fn measures(&self) -> &[(Measure, Values)] {
        &self.measures
    }

    /// Returns lines that state why a candidate failed.
    pub(crate) fn failures(&self, candidate: usize) -> Vec<String> {
        let reasons = self.failures.get(candidate).into_iter().flatten().zip(&self.mazes);
        let reasons = reasons.filter_map(|(reason, maze)| Some((reason.as_deref()?, &**maze)));
        list_reasons(reasons, MAX_MAZES, MAX_REASONS, "")
    }

    /// Returns the statistics of each measure.
    pub fn statistics(&self) -> Vec<MeasureStatistics> {
        let measures = self.measures.iter();
        measures.map(|(measure, values)| MeasureStatistics::new(self, measure, values)).collect()
    }
}
