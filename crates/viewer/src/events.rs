//! The stream of events by which a page learns what there is.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::http::StatusCode;
use axum::response::Sse;
use axum::response::sse::Event;
use futures_util::stream::{self, Stream};
use mmsim_server::Status;
use serde::Serialize;
use tokio::sync::Semaphore;
use tokio::time::sleep;

use crate::api_error::ApiError;
use crate::limits::MAX_LISTENERS;
use crate::mouse::RunnerStatus;
use crate::state::{AppState, Live};

/// Between two looks while something happens: an eye takes it for at once, and a browser that hears
/// more often has less time to draw.
const LOOK: Duration = Duration::from_millis(33);

/// Between two looks once nothing has happened for some time, or while states rush past: hearing of
/// them took a page a third as long as drawing them, and it hears with every draw anyway.
const SELDOM_LOOK: Duration = Duration::from_millis(100);

/// States between two looks from which on they rush past.
const RUSH: usize = 50;

/// How long nothing has to happen for that.
const QUIET: Duration = Duration::from_secs(2);

/// Something is said at least so often, so that both sides learn if the other has gone.
const PULSE: Duration = Duration::from_secs(10);

static LISTENERS: Semaphore = Semaphore::const_new(MAX_LISTENERS);

/// What there is.
#[derive(Debug, PartialEq, Eq, Serialize)]
struct News {
    server: String,
    run: Option<u32>,
    states: Option<usize>,
    maze: Option<String>,
    mouse: Option<RunnerStatus>,
    recordings: u64,
    /// The numbers of the recordings that are open.
    opened: Vec<String>,
}

impl News {
    fn of(state: &AppState) -> Self {
        let live = state.live.as_ref();
        let status = live.map(|live| live.monitor.status());
        // A run that ends closes its recording, and its first state begins another.
        let recordings =
            status.map_or(0, |Status { run, states }| 2 * u64::from(run) + states.min(1) as u64);
        Self {
            server: state.server.clone(),
            run: status.map(|status| status.run),
            states: status.map(|status| status.states),
            maze: live.map(Live::maze),
            mouse: live.and_then(|live| live.runner.told()),
            recordings,
            opened: state.opened_recordings().into_iter().map(|(id, _)| id).collect(),
        }
    }
}

/// What was told last, when, and after how long to look again.
struct Last {
    news: News,
    when: Instant,
    look: Duration,
}

/// News whenever there are any.
pub(crate) fn stream(
    state: Arc<AppState>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, ApiError> {
    let place = LISTENERS.try_acquire().map_err(|_| {
        let text = format!("expected at most {MAX_LISTENERS} pages, found one more");
        ApiError::new(StatusCode::SERVICE_UNAVAILABLE, text)
    })?;
    let untold: Option<Last> = None;
    Ok(Sse::new(stream::unfold((state, untold, place), |(state, told, place)| async move {
        loop {
            if let Some(Last { when, look, .. }) = &told {
                sleep(if when.elapsed() < QUIET { *look } else { SELDOM_LOOK }).await;
            }
            let news = News::of(&state);
            let is_old = |last: &Last| last.news == news && last.when.elapsed() < PULSE;
            if !told.as_ref().is_some_and(is_old) {
                let event = Event::default().json_data(&news).unwrap_or_default();
                let rushes =
                    told.is_some_and(|last| news.states > last.news.states.map(|n| n + RUSH));
                let look = if rushes { SELDOM_LOOK } else { LOOK };
                let last = Last { news, when: Instant::now(), look };
                return Some((Ok(event), (state, Some(last), place)));
            }
        }
    })))
}
