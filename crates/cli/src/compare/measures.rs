//! The measures by which mice are compared.

use super::figures::Figures;

/// A measure of a search in which the mouse reached the goal.
pub(super) struct SearchMeasure {
    /// The JSON key, which is also that of [`Figures`].
    pub(super) key: &'static str,
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    /// True if the text output has a table of this measure.
    pub(super) is_in_text: bool,
    pub(super) value: fn(&Figures) -> Option<f64>,
}

pub(super) const MEASURES: [SearchMeasure; 7] = [
    SearchMeasure {
        key: "steps_to_goal",
        name: "steps to the goal",
        unit: "steps",
        is_in_text: true,
        value: |search| search.steps_to_goal.map(f64::from),
    },
    SearchMeasure {
        key: "steps_in_all",
        name: "steps of the whole search",
        unit: "steps",
        is_in_text: true,
        value: |search| Some(search.steps_in_all.into()),
    },
    SearchMeasure {
        key: "turns",
        name: "quarter turns of the whole search",
        unit: "turns",
        is_in_text: true,
        value: |search| Some(search.turns.into()),
    },
    SearchMeasure {
        key: "path_found",
        name: "length of the path found",
        unit: "steps",
        is_in_text: true,
        value: |search| search.path_found.map(f64::from),
    },
    SearchMeasure {
        key: "steps_until_proven",
        name: "steps until the shortest path is proven",
        unit: "steps",
        is_in_text: false,
        value: |search| search.steps_until_proven.map(f64::from),
    },
    SearchMeasure {
        key: "fast_run_steps",
        name: "steps of the best fast run",
        unit: "steps",
        is_in_text: false,
        value: |search| search.fast_run_steps.map(f64::from),
    },
    SearchMeasure {
        key: "time_us",
        name: "processor time",
        unit: "µs",
        is_in_text: false,
        value: |search| search.time_us,
    },
];
