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
    pub(crate) value: Value,
}

type Value = fn(&SearchFigures) -> Option<f64>;

const fn measure([key, name, unit, verb]: [&'static str; 4], value: Value) -> SearchMeasure {
    SearchMeasure { key, name, unit, verb, value }
}

/// All measures. Those of a vehicle come first.
pub(crate) const MEASURES: [SearchMeasure; 12] = [
    measure(["total_time_s", "time until the end of the fast run", "s", "solved"], |it| {
        it.times?.total_time_s
    }),
    measure(["search_time_s", "time of the search", "s", "solved"], |it| {
        Some(it.times?.search_time_s).filter(|_| it.is_complete)
    }),
    measure(["fast_run_time_s", "time of the fast run", "s", "solved"], |it| {
        it.times?.fast_run_time_s
    }),
    measure(["fast_run_loss_percent", "loss of the fast run", "%", "solved"], |it| {
        it.times?.fast_run_loss_percent
    }),
    measure(["known_run_time_s", "time of the fastest known run", "s", "solved"], |it| {
        it.times?.known_run_time_s
    }),
    measure(["steps_to_goal", "steps to the goal", "steps", "solved"], |it| {
        it.steps_to_goal.map(f64::from)
    }),
    measure(["search_steps", "steps in all", "steps", "solved"], |it| {
        it.is_complete.then(|| it.search_steps.into())
    }),
    measure(["search_turns", "quarter turns in all", "turns", "solved"], |it| {
        it.is_complete.then(|| it.search_turns.into())
    }),
    measure(["path_found", "length of the path found", "steps", "solved"], |it| {
        it.path_found.filter(|_| it.is_complete).map(f64::from)
    }),
    measure(
        ["steps_until_proven", "steps until the shortest path is proven", "steps", "proved"],
        |it| it.steps_until_proven.map(f64::from),
    ),
    measure(
        ["fast_run_steps", "steps in the best fast run", "steps", "completed a fast run in"],
        |it| it.fast_run_steps.map(f64::from),
    ),
    measure(["processor_time_us", "processor time", "µs", "had a time in"], |it| {
        it.processor_time_us
    }),
];
