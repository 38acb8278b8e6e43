//! The view of a log on the page.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, Query, State};
use mmsim_recording::LogEnd;
use serde::{Deserialize, Serialize};

use crate::app_state::AppState;
use crate::http::api_error::ApiError;
use crate::http::jobs::CancelToken;
use crate::source::Source;

/// The maximum number of log lines up to a state, and of later log lines, in a response.
const MAX_LINES: usize = 500;

#[derive(Deserialize)]
pub(crate) struct LogQuery {
    run: u32,
    /// The index of the state around which lines are returned.
    at: usize,
    /// The index of the first state whose lines are returned.
    #[serde(default)]
    from: usize,
    max: Option<usize>,
    /// Only lines that contain this text are returned, ignoring case.
    #[serde(default)]
    filter: String,
}

/// The matching log lines around a state.
#[derive(Debug, PartialEq, Eq, Serialize)]
pub(crate) struct LogView {
    /// The lines, each with the index of the state that follows the line.
    lines: Vec<(usize, String)>,
    /// The range of states all of whose matching lines are in `lines`.
    first: usize,
    last: usize,
    /// True if there may be matching lines after `last`.
    has_later: bool,
}

pub(crate) async fn handle(
    State(state): State<Arc<AppState>>,
    Path(id): Path<String>,
    Query(query): Query<LogQuery>,
) -> Result<Json<LogView>, ApiError> {
    let source = state.source(&id)?;
    state.run_jobs.run(move |cancel| Ok(Json(LogView::new(&source, &query, cancel)?))).await
}

impl LogView {
    fn new(source: &Source, query: &LogQuery, cancel: &CancelToken) -> Result<Self, ApiError> {
        let LogQuery { run, from, .. } = *query;
        let max = query.max.unwrap_or(MAX_LINES).min(MAX_LINES);
        let filter = query.filter.to_lowercase();
        let matches = |text: &str| filter.is_empty() || text.to_lowercase().contains(&filter);
        let states = source.states(run)?;
        let at = query.at.min(states.saturating_sub(1));
        let mut lines = source.log(run, &(from..=at), LogEnd::Last, max, cancel, matches)?;
        // Earlier lines of the first state may be missing.
        let oldest = lines.first().filter(|_| lines.len() == max);
        let first = oldest.map_or(from, |line| (line.state + 1).min(at));
        // One more line shows whether there are more than `max`.
        let rest = at + 1..=states.saturating_sub(1);
        let mut later = source.log(run, &rest, LogEnd::First, max + 1, cancel, matches)?;
        let has_later = later.len() > max;
        later.truncate(max);
        let last = match later.last() {
            _ if !has_later => states.saturating_sub(1),
            Some(line) => (line.state - 1).max(at),
            None => at,
        };
        lines.append(&mut later);
        let lines = lines.into_iter().map(|line| (line.state, line.text)).collect();
        Ok(Self { lines, first, last, has_later })
    }
}
