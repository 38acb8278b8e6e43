//! What the page can ask for.

use std::io::{Seek, Write};
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router, middleware};
use mmsim_drawing::thumbnail;
use mmsim_server::{Block, Ending, Recording};
use mmsim_solvers::{BundledStrategy, MazeFacts};
use serde::{Deserialize, Serialize};

use crate::api_error::ApiError;
use crate::costs::Costs;
use crate::limits::MAX_RECORDING_BYTES;
use crate::pictures::{self, Look};
use crate::source::Source;
use crate::state::AppState;
use crate::state_view::StateView;
use crate::transfer::{receive, receive_first};
use crate::work::work;
use crate::{assets, events, mazes, recordings};

const SVG: &str = "image/svg+xml";

pub(crate) fn router(state: Arc<AppState>) -> Router {
    Router::new()
        .route("/events", get(|State(state)| async { events::stream(state) }))
        .route("/api/page", get(page))
        .route("/api/mazes", get(list_mazes))
        .route("/api/mazes/picture.svg", get(maze_picture))
        .route("/api/maze", post(serve_maze))
        .route("/api/sources/{id}", get(describe))
        .route("/api/sources/{id}/drawing.svg", get(drawing))
        .route("/api/sources/{id}/states", get(states))
        .route("/api/sources/{id}/picture.svg", get(svg))
        .route("/api/sources/{id}/picture.png", get(png))
        .route("/api/sources/{id}/animation.gif", get(gif))
        .route("/api/sources/{id}/moment", get(moment))
        .route("/api/sources/{id}/costs", get(costs))
        .route("/api/sources/{id}/recording.mcap", get(save))
        .route("/api/recordings", get(list_recordings))
        .route("/api/recordings/open", post(open))
        .route("/api/recordings/close", post(close))
        .route("/api/mouse/run", post(run))
        .route("/api/mouse/stop", post(stop))
        .layer(middleware::from_fn_with_state(Arc::clone(&state), receive_first))
        .route("/api/recordings", post(bring))
        .with_state(state)
        .merge(assets::router())
}

type Answer<T> = Result<T, ApiError>;
type SharedState = State<Arc<AppState>>;

/// Of which run something is wanted.
#[derive(Deserialize)]
struct OfRun {
    run: u32,
}

#[derive(Serialize)]
struct Page {
    server: String,
    live: bool,
    records: bool,
    version: &'static str,
    zmq: Option<String>,
    strategies: Vec<Named>,
    opened: Vec<Opened>,
}

#[derive(Serialize)]
struct Named {
    name: &'static str,
    about: &'static str,
}

#[derive(Serialize)]
struct Opened {
    id: String,
    title: String,
}

async fn page(State(state): SharedState) -> Json<Page> {
    let opened = state.opened_recordings().into_iter();
    Json(Page {
        server: state.server.clone(),
        live: state.live.is_some(),
        records: state.recordings.is_some(),
        version: env!("CARGO_PKG_VERSION"),
        zmq: state.live.as_ref().map(|live| live.address.clone()),
        strategies: BundledStrategy::ALL
            .iter()
            .map(|strategy| Named { name: strategy.name(), about: strategy.about() })
            .collect(),
        opened: opened.map(|(id, title)| Opened { id, title }).collect(),
    })
}

async fn list_mazes(State(state): SharedState) -> Answer<Response> {
    work(move || Ok(Json(mazes::list(&state)).into_response())).await
}

#[derive(Deserialize)]
struct OfPath {
    path: String,
}

async fn maze_picture(
    State(state): SharedState,
    Query(OfPath { path }): Query<OfPath>,
) -> Answer<Response> {
    work(move || {
        let (_, maze) = mazes::find(&state.catalogue, &path)?;
        Ok(([(header::CONTENT_TYPE, SVG)], thumbnail(&maze)).into_response())
    })
    .await
}

#[derive(Serialize)]
struct Run {
    run: u32,
}

async fn serve_maze(
    State(state): SharedState,
    Json(OfPath { path }): Json<OfPath>,
) -> Answer<Json<Run>> {
    work(move || {
        let live = state.live()?;
        let (name, maze) = mazes::find(&state.catalogue, &path)?;
        Ok(Json(Run { run: live.serve(&path, &name, maze)? }))
    })
    .await
}

#[derive(Serialize)]
struct Description {
    id: String,
    run: u32,
    title: String,
    width: u8,
    height: u8,
    start: [u8; 2],
    goals: Vec<[u8; 2]>,
    states: usize,
    state_bytes: usize,
    /// Whether the true maze is known.
    truth: bool,
    shortest_path: Option<u16>,
    /// How a recording ends.
    ending: Option<&'static str>,
    note: Option<String>,
}

async fn describe(State(state): SharedState, Path(id): Path<String>) -> Answer<Json<Description>> {
    work(move || {
        let source = state.source(&id)?;
        let (run, described, states) = source.now()?;
        let info = &described.info;
        let (ending, note) = match source.ending() {
            None => (None, None),
            Some(Ending::Closed) => (Some("closed"), None),
            Some(Ending::Cut { .. }) => (
                Some("cut"),
                Some("not closed: it was cut off, or is still being written".to_string()),
            ),
            Some(Ending::Damaged { whole, reason }) => {
                (Some("damaged"), Some(format!("damaged after byte {whole}: {reason}")))
            }
        };
        let truth = described.truth.as_ref();
        Ok(Json(Description {
            id,
            run,
            title: described.title.clone(),
            width: info.width,
            height: info.height,
            start: info.start,
            goals: info.goals.clone(),
            states,
            state_bytes: mmsim_protocol::state_bytes(described.size),
            truth: truth.is_some(),
            shortest_path: truth.and_then(|maze| MazeFacts::new(maze).shortest_path),
            ending,
            note,
        }))
    })
    .await
}

/// Which states are wanted.
#[derive(Deserialize)]
struct Range {
    run: u32,
    from: usize,
    #[serde(default = "one")]
    count: usize,
}

const fn one() -> usize {
    1
}

async fn states(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(Range { run, from, count }): Query<Range>,
) -> Answer<Response> {
    work(move || {
        let (source, count) = (state.source(&id)?, count.min(Block::STATES));
        let mut bytes = Vec::new();
        // They lie in one block, or in two that follow one another.
        let end = from.saturating_add(count).min(source.states(run)?);
        let next = (from / Block::STATES + 1).saturating_mul(Block::STATES);
        let first = source.around(run, end.min(next).saturating_sub(1).max(from))?;
        bytes.extend_from_slice(first.range(from, end.saturating_sub(from)));
        let rest = end.saturating_sub(next);
        if rest > 0 {
            bytes.extend_from_slice(source.around(run, end - 1)?.range(next, rest));
        }
        Ok(([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response())
    })
    .await
}

#[derive(Deserialize)]
struct AtState {
    run: u32,
    at: usize,
}

async fn moment(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(AtState { run, at }): Query<AtState>,
) -> Answer<Json<StateView>> {
    work(move || Ok(Json(StateView::of(&*state.source(&id)?, run, at)?))).await
}

async fn costs(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(OfRun { run }): Query<OfRun>,
) -> Answer<Json<Costs>> {
    work(move || Ok(Json(Costs::over(&*state.source(&id)?, run)?))).await
}

async fn drawing(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(OfRun { run }): Query<OfRun>,
) -> Answer<Response> {
    work(move || {
        Ok(([(header::CONTENT_TYPE, SVG)], pictures::before(&*state.source(&id)?, run)?)
            .into_response())
    })
    .await
}

/// A picture to keep, of the state with this number.
#[derive(Deserialize)]
struct Picture {
    run: u32,
    #[serde(default)]
    at: usize,
}

async fn svg(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(Picture { run, at }): Query<Picture>,
    Query(look): Query<Look>,
) -> Answer<Response> {
    work(move || {
        let source = state.source(&id)?;
        let svg = pictures::at(&source, run, at, look, |scene| scene.svg())?;
        Ok(download(&file_name(&source, run, "svg")?, SVG, svg.into()))
    })
    .await
}

async fn png(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(Picture { run, at }): Query<Picture>,
    Query(look): Query<Look>,
) -> Answer<Response> {
    Arc::clone(&state)
        .pictures
        .work(move |_| {
            let source = state.source(&id)?;
            let png = pictures::png(&source, run, at, look)?;
            Ok(download(&file_name(&source, run, "png")?, "image/png", png.into()))
        })
        .await
}

async fn gif(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(OfRun { run }): Query<OfRun>,
    Query(look): Query<Look>,
) -> Answer<Response> {
    Arc::clone(&state)
        .animations
        .work(move |wanted| {
            let source = state.source(&id)?;
            let gif = pictures::gif(&source, run, look, wanted)?;
            Ok(download(&file_name(&source, run, "gif")?, "image/gif", gif.into()))
        })
        .await
}

async fn save(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(OfRun { run }): Query<OfRun>,
) -> Answer<Response> {
    let (name, file) = Arc::clone(&state)
        .recording_jobs
        .work(move |wanted| {
            let source = state.source(&id)?;
            Ok((file_name(&source, run, "mcap")?, recordings::save(&source, run, wanted)?))
        })
        .await?;
    let content = Body::from_stream(crate::stream::from_file(file));
    Ok(download(&name, "application/octet-stream", content))
}

/// The name of a file that shows a run.
fn file_name(source: &Source, run: u32, ending: &str) -> Answer<String> {
    let title = source.describe(run)?.title.clone();
    let stem = title.strip_suffix(".mcap").unwrap_or(&title);
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    Ok(format!("{}.{ending}", stem.chars().map(plain).take(100).collect::<String>()))
}

fn download(name: &str, kind: &'static str, content: Body) -> Response {
    let disposition = HeaderValue::from_str(&format!("attachment; filename=\"{name}\""));
    let disposition = disposition.unwrap_or(HeaderValue::from_static("attachment"));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static(kind)),
        (header::CONTENT_DISPOSITION, disposition),
    ];
    (headers, content).into_response()
}

async fn list_recordings(State(state): SharedState) -> Answer<Response> {
    work(move || {
        let folder = state.recordings.as_deref();
        let listed = folder.map(recordings::list).transpose()?.unwrap_or_default();
        Ok(Json(listed).into_response())
    })
    .await
}

#[derive(Deserialize)]
struct OfName {
    name: String,
}

#[derive(Deserialize, Serialize)]
struct Id {
    id: String,
}

async fn open(State(state): SharedState, Json(OfName { name }): Json<OfName>) -> Answer<Json<Id>> {
    Arc::clone(&state)
        .recording_jobs
        .work(move |_| Ok(Json(Id { id: recordings::open_listed(&state, &name)? })))
        .await
}

async fn close(State(state): SharedState, Json(Id { id }): Json<Id>) -> Answer<StatusCode> {
    state.close(&id)?;
    Ok(StatusCode::NO_CONTENT)
}

/// Takes a recording that a page brings.
async fn bring(
    State(state): SharedState,
    Query(OfName { name }): Query<OfName>,
    body: Body,
) -> Answer<Json<Id>> {
    state.check_room()?;
    let turn = state.uploads.turn().await?;
    // Without a name, so that nothing is left of it however the server ends.
    let mut file = tempfile::tempfile().map_err(ApiError::failed)?;
    receive(body, MAX_RECORDING_BYTES, state.limits, |piece| file.write_all(&piece)).await?;
    Arc::clone(&state)
        .recording_jobs
        .work(move |_| {
            let _turn = turn;
            file.rewind().map_err(ApiError::failed)?;
            let file = std::io::BufReader::new(file);
            let title = recordings::title(&name);
            let recording = Recording::read_within(file, &state.budget)
                .map_err(|error| ApiError::bad(format!("{title}: {error}")))?;
            Ok(Json(Id { id: state.open(&title, recording)? }))
        })
        .await
}

#[derive(Deserialize)]
struct Start {
    strategy: String,
    pace_ms: u64,
}

async fn run(
    State(state): SharedState,
    Json(Start { strategy, pace_ms }): Json<Start>,
) -> Answer<StatusCode> {
    let strategy: BundledStrategy = strategy.parse().map_err(ApiError::bad)?;
    work(move || {
        state.live()?.run(strategy, pace_ms)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

async fn stop(State(state): SharedState) -> Answer<StatusCode> {
    work(move || {
        state.live()?.runner.stop();
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}
