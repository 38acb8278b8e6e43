//! The event stream that keeps a page up to date.

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
use crate::app_state::AppState;
use crate::limits::MAX_EVENT_STREAMS;
use crate::live::LiveServer;
use crate::mouse_status::MouseStatus;

/// The usual interval at which an event stream polls the state of the server. Users do not notice a
/// delay of 33 ms. More frequent events would leave the browser less time to draw.
const POLL_INTERVAL: Duration = Duration::from_millis(33);

/// The polling interval of an event stream while the simulation is idle or the search is fast. A
/// page takes three times as long to draw a state as to handle an event. During a fast search,
/// fewer events are enough, since each state that a page fetches also contains the number of
/// states.
const SLOW_POLL_INTERVAL: Duration = Duration::from_millis(100);

/// A search counts as fast if more states than this arrive between two events.
const FAST_SEARCH_STATES: usize = 50;

/// The time without changes after which a simulation counts as idle.
const IDLE_AFTER: Duration = Duration::from_secs(2);

/// The maximum time between events. Regular events allow the server and the page to notice a closed
/// connection.
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(10);

static EVENT_STREAMS: Semaphore = Semaphore::const_new(MAX_EVENT_STREAMS);

/// An event that summarizes the state of the server.
#[derive(Debug, PartialEq, Serialize)]
struct ServerEvent {
    #[serde(rename = "server")]
    server_id: String,
    run: Option<u32>,
    states: Option<usize>,
    maze: Option<String>,
    mouse: Option<MouseStatus>,
    /// The pace of mice in steps per second, or `None` if there is no limit.
    pace: Option<f64>,
    #[serde(rename = "paused")]
    is_paused: bool,
    /// True if a client is searching the maze that is not a mouse of the page.
    #[serde(rename = "client")]
    has_client: bool,
    /// A number that changes when a recording may have been created or closed.
    recordings: u64,
    /// The IDs of the open recordings.
    opened: Vec<String>,
}

impl ServerEvent {
    fn new(state: &AppState) -> Self {
        let live = state.live.as_ref();
        let status = live.map(|live| live.monitor.status());
        // The end of a run closes a recording, and the first state of a run creates one.
        let recordings =
            status.map_or(0, |Status { run, states }| 2 * u64::from(run) + states.min(1) as u64);
        Self {
            server_id: state.server_id.clone(),
            run: status.map(|status| status.run),
            states: status.map(|status| status.states),
            maze: live.map(LiveServer::maze),
            mouse: live.and_then(LiveServer::mouse_status),
            pace: live.and_then(|live| live.control.throttle().pace().rate()),
            is_paused: live.is_some_and(|live| live.control.is_paused()),
            has_client: live.is_some_and(|live| live.monitor.has_client()),
            recordings,
            opened: state.open_recordings(),
        }
    }
}

/// The event that was sent last.
struct LastEvent {
    event: ServerEvent,
    sent_at: Instant,
    poll_interval: Duration,
}

/// Streams an event whenever the state of the server changes.
pub(crate) fn stream(
    state: Arc<AppState>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, ApiError> {
    let permit = EVENT_STREAMS.try_acquire().map_err(|_| {
        let text = format!("{MAX_EVENT_STREAMS} pages are already open (close one first)");
        ApiError::new(StatusCode::SERVICE_UNAVAILABLE, text)
    })?;
    let last: Option<LastEvent> = None;
    Ok(Sse::new(stream::unfold((state, last, permit), |(state, last, permit)| async move {
        loop {
            if let Some(LastEvent { sent_at, poll_interval, .. }) = &last {
                let is_idle = sent_at.elapsed() >= IDLE_AFTER;
                sleep(if is_idle { SLOW_POLL_INTERVAL } else { *poll_interval }).await;
            }
            let event = ServerEvent::new(&state);
            let is_current = |last: &LastEvent| {
                last.event == event && last.sent_at.elapsed() < HEARTBEAT_INTERVAL
            };
            if !last.as_ref().is_some_and(is_current) {
                let data = Event::default().json_data(&event).unwrap_or_default();
                let is_fast = last.is_some_and(|last| {
                    event.states > last.event.states.map(|states| states + FAST_SEARCH_STATES)
                });
                let poll_interval = if is_fast { SLOW_POLL_INTERVAL } else { POLL_INTERVAL };
                let last = LastEvent { event, sent_at: Instant::now(), poll_interval };
                return Some((Ok(data), (state, Some(last), permit)));
            }
        }
    })))
}
