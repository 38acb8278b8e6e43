//! What the page learns about the server: the description at its start, and the event stream that
//! keeps it up to date.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use axum::http::StatusCode;
use axum::response::Sse;
use axum::response::sse::Event;
use futures_util::stream::{self, Stream};
use mmsim_mouse::MouseStatus;
use mmsim_server::Status;
use mmsim_solvers::BundledStrategy;
use serde::Serialize;
use tokio::time::sleep;

use crate::app::{AppState, ViewerConfig};
use crate::http::jobs::{ApiError, ApiResult};
use crate::http::limits::Limits;
use crate::http::shares::{Connection, Shares};
use crate::live::LiveServer;
use crate::source::fast_runs::Vehicles;

/// What the page shows and what it can do.
#[derive(Serialize)]
pub(crate) struct PageInfo {
    #[serde(rename = "server")]
    server_id: String,
    live: bool,
    /// True if the page lists the recordings in a folder.
    records: bool,
    /// The address of the simulator.
    zmq: Option<String>,
    strategies: Vec<StrategyInfo>,
    /// The names of the vehicles whose fast runs the page shows.
    vehicles: Vec<String>,
    /// The name of the user's own mouse, if the simulator runs one.
    own: Option<String>,
    /// True if the live simulation is a two-run trial, so the page can neither load mazes nor run
    /// mice.
    #[serde(rename = "trial")]
    is_trial: bool,
    /// The IDs of the open recordings.
    opened: Vec<String>,
}

#[derive(Serialize)]
struct StrategyInfo {
    strategy: &'static str,
    about: &'static str,
}

impl PageInfo {
    pub(crate) fn new(state: &AppState) -> Self {
        let ViewerConfig { live, recordings_dir, vehicles, is_trial, .. } = &state.config;
        Self {
            server_id: state.server_id.clone(),
            live: live.is_some(),
            records: recordings_dir.is_some(),
            zmq: live.as_ref().map(|live| live.address.clone()),
            strategies: BundledStrategy::ALL
                .iter()
                .map(|strategy| StrategyInfo { strategy: strategy.name(), about: strategy.about() })
                .collect(),
            vehicles: vehicles.names(),
            own: live.as_ref().and_then(|live| live.control.own().map(String::from)),
            is_trial: *is_trial,
            opened: state.open_recordings(),
        }
    }

    /// Describes an exported page, which shows the recording with this ID.
    pub(crate) fn exported(id: &str, vehicles: &Vehicles) -> Self {
        let config = ViewerConfig::default().with_vehicles(vehicles.clone());
        let nothing = AppState::new(config, Limits::default());
        Self { server_id: String::new(), opened: vec![id.into()], ..Self::new(&nothing) }
    }
}

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

/// An event that summarizes the state of the server.
#[derive(Debug, PartialEq, Serialize)]
struct ServerEvent {
    #[serde(rename = "server")]
    server_id: String,
    run: Option<u32>,
    states: Option<usize>,
    /// The number of states that a reset deletes.
    unsaved_states: usize,
    /// The number of requests with annotations that the server has answered.
    annotations: Option<u64>,
    maze: Option<String>,
    mouse_status: Option<MouseStatus>,
    /// The pace of mice in steps per second, or `None` if there is no limit.
    pace: Option<f64>,
    #[serde(rename = "paused")]
    is_paused: bool,
    /// True if a client is searching the maze that is not a mouse of the page.
    #[serde(rename = "client")]
    has_client: bool,
    /// A number that changes when a recording may have been created, closed, renamed or deleted.
    recordings: u64,
    /// The IDs of the open recordings.
    opened: Vec<String>,
}

impl ServerEvent {
    fn new(state: &AppState) -> Self {
        let live = state.config.live.as_ref();
        let status = live.map(|live| live.monitor.status());
        // The end of a run closes a recording, and the first state of a run creates one.
        let recordings =
            status.map_or(0, |Status { run, states }| 2 * u64::from(run) + states.min(1) as u64);
        Self {
            server_id: state.server_id.clone(),
            run: status.map(|status| status.run),
            states: status.map(|status| status.states),
            unsaved_states: live.map_or(0, |live| live.monitor.unsaved_states()),
            annotations: live.map(|live| live.monitor.annotations()),
            maze: live.map(LiveServer::maze),
            mouse_status: live.and_then(LiveServer::mouse_status),
            pace: live.and_then(|live| live.control.pace().rate()),
            is_paused: live.is_some_and(|live| live.control.is_paused()),
            has_client: live.is_some_and(|live| live.monitor.has_client()),
            recordings: recordings + state.recording_changes.load(Ordering::Relaxed),
            opened: state.open_recordings(),
        }
    }
}

/// The event that was sent last.
struct LastEvent {
    event: ServerEvent,
    sent_at: Instant,
    /// True if the search is fast.
    is_fast: bool,
}

impl LastEvent {
    fn new(event: ServerEvent, before: Option<&Self>, sent_at: Instant) -> Self {
        let is_fast = before.is_some_and(|before| {
            event.states > before.event.states.map(|states| states + FAST_SEARCH_STATES)
        });
        Self { event, sent_at, is_fast }
    }

    /// Returns the time until the stream polls again.
    fn poll_interval(&self, now: Instant) -> Duration {
        let is_idle = now - self.sent_at >= IDLE_AFTER;
        if is_idle || self.is_fast { SLOW_POLL_INTERVAL } else { POLL_INTERVAL }
    }

    /// Returns true if `event` need not be sent.
    fn is_current(&self, event: &ServerEvent, now: Instant) -> bool {
        self.event == *event && now - self.sent_at < HEARTBEAT_INTERVAL
    }
}

/// Streams an event whenever the state of the server changes.
pub(crate) fn stream(
    state: Arc<AppState>,
    connection: &Arc<Connection>,
    shares: &Shares,
) -> ApiResult<Sse<impl Stream<Item = Result<Event, Infallible>> + use<>>> {
    if !shares.begin_stream(connection) {
        let text =
            format!("{} browsers already show this page (close one first)", state.limits.streams);
        return Err(ApiError::new(StatusCode::SERVICE_UNAVAILABLE, text));
    }
    let last: Option<LastEvent> = None;
    Ok(Sse::new(stream::unfold((state, last), |(state, last)| async move {
        loop {
            if let Some(last) = &last {
                sleep(last.poll_interval(Instant::now())).await;
            }
            let (event, now) = (ServerEvent::new(&state), Instant::now());
            if !last.as_ref().is_some_and(|last| last.is_current(&event, now)) {
                let data = Event::default().json_data(&event).unwrap_or_default();
                let last = LastEvent::new(event, last.as_ref(), now);
                return Some((Ok(data), (state, Some(last))));
            }
        }
    })))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(states: usize) -> ServerEvent {
        ServerEvent {
            server_id: "a".into(),
            run: Some(1),
            states: Some(states),
            unsaved_states: states,
            annotations: Some(0),
            maze: None,
            mouse_status: None,
            pace: None,
            is_paused: false,
            has_client: false,
            recordings: 0,
            opened: Vec::new(),
        }
    }

    #[test]
    fn fast_and_idle_searches_are_polled_less_often() {
        let start = Instant::now();
        let first = LastEvent::new(event(1), None, start);
        assert_eq!(first.poll_interval(start), POLL_INTERVAL);
        assert_eq!(first.poll_interval(start + IDLE_AFTER), SLOW_POLL_INTERVAL);
        for (states, expected) in
            [(1 + FAST_SEARCH_STATES, POLL_INTERVAL), (2 + FAST_SEARCH_STATES, SLOW_POLL_INTERVAL)]
        {
            let next = LastEvent::new(event(states), Some(&first), start);
            assert_eq!(next.poll_interval(start), expected);
        }
    }

    #[test]
    fn an_event_without_changes_is_sent_only_as_a_heartbeat() {
        let start = Instant::now();
        let last = LastEvent::new(event(1), None, start);
        assert!(!last.is_current(&event(2), start));
        let millisecond = Duration::from_millis(1);
        assert!(last.is_current(&event(1), start + HEARTBEAT_INTERVAL.saturating_sub(millisecond)));
        assert!(!last.is_current(&event(1), start + HEARTBEAT_INTERVAL));
    }
}
