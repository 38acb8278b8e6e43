//! The measures by which mice are compared.

use super::figures::Figures;

/// A measure of a search in which the mouse reached the goal.
#[derive(Clone, Copy)]
pub(super) struct SearchMeasure {
    /// The JSON key, which is also that of [`Figures`] or [`Times`](super::times::Times).
    pub(super) key: &'static str,
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    /// What a mouse has done in a maze in which it has a value.
    pub(super) verb: &'static str,
    /// True if the text output has a table of this measure.
    pub(super) is_in_text: bool,
    pub(super) value: fn(&Figures) -> Option<f64>,
}

pub(super) const MEASURES: [SearchMeasure; 7] = [
    SearchMeasure {
        key: "steps_to_goal",
        name: "steps to the goal",
        unit: "steps",
        verb: "solved",
        is_in_text: true,
        value: |search| search.steps_to_goal.map(f64::from),
    },
    SearchMeasure {
        key: "steps_in_all",
        name: "steps in all",
        unit: "steps",
        verb: "solved",
        is_in_text: true,
        value: |search| search.is_complete.then(|| search.steps_in_all.into()),
    },
    SearchMeasure {
        key: "turns",
        name: "quarter turns in all",
        unit: "turns",
        verb: "solved",
        is_in_text: true,
        value: |search| search.is_complete.then(|| search.turns.into()),
    },
    SearchMeasure {
        key: "path_found",
        name: "length of the path found",
        unit: "steps",
        verb: "solved",
        is_in_text: true,
        value: |search| search.path_found.filter(|_| search.is_complete).map(f64::from),
    },
    SearchMeasure {
        key: "steps_until_proven",
        name: "steps until the shortest path is proven",
        unit: "steps",
        verb: "proved",
        is_in_text: false,
        value: |search| search.steps_until_proven.map(f64::from),
    },
    SearchMeasure {
        key: "fast_run_steps",
        name: "steps in the best fast run",
        unit: "steps",
        verb: "completed a fast run in",
        is_in_text: false,
        value: |search| search.fast_run_steps.map(f64::from),
    },
    SearchMeasure {
        key: "time_us",
        name: "processor time",
        unit: "µs",
        verb: "had a time in",
        is_in_text: false,
        value: |search| search.time_us,
    },
];

/// The measures of a vehicle, which come before [`MEASURES`].
pub(super) const TIMED_MEASURES: [SearchMeasure; 5] = [
    SearchMeasure {
        key: "fast_run_time_s",
        name: "time of the fast run",
        unit: "s",
        verb: "solved",
        is_in_text: true,
        value: |search| search.times?.fast_run_time_s,
    },
    SearchMeasure {
        key: "total_time_s",
        name: "time until the end of the fast run",
        unit: "s",
        verb: "solved",
        is_in_text: true,
        value: |search| search.times?.total_time_s,
    },
    SearchMeasure {
        key: "search_time_s",
        name: "time of the search",
        unit: "s",
        verb: "solved",
        is_in_text: true,
        value: |search| Some(search.times?.search_time_s).filter(|_| search.is_complete),
    },
    SearchMeasure {
        key: "fast_run_loss_percent",
        name: "loss of the fast run",
        unit: "%",
        verb: "solved",
        is_in_text: true,
        value: |search| search.times?.fast_run_loss_percent,
    },
    SearchMeasure {
        key: "known_run_time_s",
        name: "time of the fastest known run",
        unit: "s",
        verb: "solved",
        is_in_text: true,
        value: |search| search.times?.known_run_time_s,
    },
];
