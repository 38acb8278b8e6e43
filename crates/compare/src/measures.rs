//! The measures by which mice are compared.

use mmsim_run::SearchFigures;

/// A measure of a search in which the mouse reached the goal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SearchMeasure {
    /// The JSON key, which is also that of [`SearchFigures`] or [`SearchTimes`](mmsim_run::SearchTimes).
    pub(crate) key: &'static str,
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    /// What a mouse has done in a maze in which it has a value.
    pub(crate) verb: &'static str,
    /// True if the text output has a table of this measure.
    pub(crate) is_in_text: bool,
    pub(crate) value: Value,
}

type Value = fn(&SearchFigures) -> Option<f64>;

/// Creates a measure with a table in the text output. Each mouse that solved a maze has a value.
const fn shown(
    key: &'static str,
    name: &'static str,
    unit: &'static str,
    value: Value,
) -> SearchMeasure {
    SearchMeasure { key, name, unit, verb: "solved", is_in_text: true, value }
}

const fn hidden([key, name, unit, verb]: [&'static str; 4], value: Value) -> SearchMeasure {
    SearchMeasure { key, name, unit, verb, is_in_text: false, value }
}

/// All measures. Those of a vehicle come first.
pub(crate) const MEASURES: [SearchMeasure; 12] = [
    shown("total_time_s", "time until the end of the fast run", "s", |it| it.times?.total_time_s),
    shown("search_time_s", "time of the search", "s", |it| {
        Some(it.times?.search_time_s).filter(|_| it.is_complete)
    }),
    shown("fast_run_time_s", "time of the fast run", "s", |it| it.times?.fast_run_time_s),
    shown("fast_run_loss_percent", "loss of the fast run", "%", |it| {
        it.times?.fast_run_loss_percent
    }),
    shown("known_run_time_s", "time of the fastest known run", "s", |it| {
        it.times?.known_run_time_s
    }),
    shown("steps_to_goal", "steps to the goal", "steps", |it| it.steps_to_goal.map(f64::from)),
    shown("search_steps", "steps in all", "steps", |it| {
        it.is_complete.then(|| it.search_steps.into())
    }),
    shown("search_turns", "quarter turns in all", "turns", |it| {
        it.is_complete.then(|| it.search_turns.into())
    }),
    shown("path_found", "length of the path found", "steps", |it| {
        it.path_found.filter(|_| it.is_complete).map(f64::from)
    }),
    hidden(
        ["steps_until_proven", "steps until the shortest path is proven", "steps", "proved"],
        |it| it.steps_until_proven.map(f64::from),
    ),
    hidden(
        ["fast_run_steps", "steps in the best fast run", "steps", "completed a fast run in"],
        |it| it.fast_run_steps.map(f64::from),
    ),
    hidden(["processor_time_us", "processor time", "µs", "had a time in"], |it| {
        it.processor_time_us
    }),
];
