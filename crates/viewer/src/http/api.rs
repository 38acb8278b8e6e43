//! The HTTP API of the page.

use std::io::{self, Read};
use std::sync::Arc;

use axum::body::{Body, Bytes};
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use axum::{Extension, Json, Router, middleware};
use futures_util::stream;
use mmsim_drawing::{Scene, thumbnail};
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_mouse::Pace;
use mmsim_recording::Block;
use mmsim_solvers::BundledStrategy;
use serde::Deserialize;

use crate::app::{AppState, MazeFile, SharedState, title};
use crate::export::{self, Content};
use crate::http::events::PageInfo;
use crate::http::jobs::{ApiError, ApiResult, CancelToken, run_blocking};
use crate::http::limits::buffer_body;
use crate::http::requested_run::{RequestedRun, RunNumber};
use crate::http::shares::{Connection, Shares};
use crate::http::{assets, events};
use crate::source::fast_runs::RouteRun;
use crate::source::pictures::{PictureOptions, download};
use crate::source::views::{SourceInfo, StateView};
use crate::source::{RunResult, StateSource, fast_runs, pictures, recordings, search};

const SVG: &str = "image/svg+xml";
pub(crate) const BINARY: &str = "application/octet-stream";

/// A path and its handlers.
type Route = (&'static str, MethodRouter<Arc<AppState>>);

/// Returns the routes of the API. Exported pages contain the responses that the page needs to show a
/// recording (see `export::responses`).
pub(crate) fn router(state: Arc<AppState>) -> Router {
    let add = |router: Router<_>, (path, methods): Route| router.route(path, methods);
    let buffered = buffered_routes().into_iter().fold(Router::new(), add);
    let buffered = buffered.layer(middleware::from_fn_with_state(state.limits, buffer_body));
    let router = streamed_routes().into_iter().fold(buffered, add);
    let wrong_method = || async {
        let text = "the path does not support this method (the Allow header lists those it does)";
        ApiError::new(StatusCode::METHOD_NOT_ALLOWED, text)
    };
    router
        .with_state(state)
        .merge(assets::router())
        .method_not_allowed_fallback(wrong_method)
        .fallback(|| async { ApiError::not_found("nothing has this path (the page is at /)") })
}

/// Returns the paths of the API. The names of parameters are in braces.
pub(crate) fn paths() -> impl Iterator<Item = &'static str> {
    buffered_routes().into_iter().chain(streamed_routes()).map(|(path, _)| path)
}

/// Returns the routes whose request bodies arrive before their handlers run.
fn buffered_routes() -> Vec<Route> {
    vec![
        ("/events", get(event_stream)),
        ("/api/page", get(page_info)),
        ("/api/mazes", get(list_mazes)),
        ("/api/mazes/picture.svg", get(maze_picture)),
        ("/api/mazes/read", post(read_maze)),
        ("/api/maze", post(load_maze)),
        ("/api/sources/{id}", get(describe_source)),
        ("/api/sources/{id}/drawing.svg", get(page_svg)),
        ("/api/sources/{id}/states", get(states)),
        (
            "/api/sources/{id}/picture.svg",
            get(|run, query, options| {
                let svg = |scene: &Scene<'_>| Ok(scene.svg());
                pictures::picture(run, query, options, ("svg", SVG), svg)
            }),
        ),
        (
            "/api/sources/{id}/picture.png",
            get(|run, query, options| {
                pictures::picture(run, query, options, ("png", "image/png"), pictures::png)
            }),
        ),
        ("/api/sources/{id}/animation.gif", get(gif_animation)),
        ("/api/sources/{id}/moment", get(state_view)),
        ("/api/sources/{id}/costs", get(|run: RequestedRun| run.read(StateSource::bounds))),
        ("/api/sources/{id}/events", get(|run: RequestedRun| run.read(StateSource::events))),
        ("/api/sources/{id}/result", get(run_result)),
        ("/api/sources/{id}/log", get(search::log_lines)),
        ("/api/sources/{id}/find", get(search::find_state)),
        ("/api/sources/{id}/fast-runs/{vehicle}", get(true_fast_runs)),
        ("/api/sources/{id}/mouse-fast-runs/{vehicle}", get(mouse_fast_runs)),
        ("/api/sources/{id}/recording.mcap", get(save_recording)),
        ("/api/sources/{id}/page.html", get(|run, timed| export_run(run, timed, Content::Page))),
        ("/api/sources/{id}/data.html", get(|run, timed| export_run(run, timed, Content::Data))),
        ("/api/recordings", get(recordings::list_recordings)),
        ("/api/recordings/open", post(recordings::open_recording)),
        ("/api/recordings/close", post(recordings::close_recording)),
        ("/api/recordings/summary", get(recordings::summarize_recording)),
        ("/api/recordings/rename", post(recordings::rename_recording)),
        ("/api/recordings/delete", post(recordings::delete_recording)),
        ("/api/mouse", post(act)),
    ]
}

/// Returns the routes whose request bodies are not buffered.
fn streamed_routes() -> [Route; 1] {
    [("/api/recordings", post(recordings::upload))]
}

async fn event_stream(
    State(state): State<Arc<AppState>>,
    Extension(connection): Extension<Arc<Connection>>,
    Extension(shares): Extension<Arc<Shares>>,
) -> ApiResult<impl IntoResponse> {
    events::stream(state, &connection, &shares)
}

async fn page_info(State(state): SharedState) -> Json<PageInfo> {
    Json(PageInfo::new(&state))
}

async fn list_mazes(State(state): SharedState) -> ApiResult<Response> {
    run_blocking(move || Ok(Json(state.config.mazes.entries()).into_response())).await
}

#[derive(Deserialize)]
struct MazePath {
    path: String,
}

async fn maze_picture(
    State(state): SharedState,
    Query(MazePath { path }): Query<MazePath>,
) -> ApiResult<Response> {
    run_blocking(move || {
        let (_, maze) = state.config.mazes.read(&path)?;
        Ok(([(header::CONTENT_TYPE, SVG)], thumbnail(&maze)).into_response())
    })
    .await
}

#[derive(Deserialize)]
struct FileName {
    name: String,
}

/// Reads a maze file of the user, without loading the maze.
async fn read_maze(
    Query(FileName { name }): Query<FileName>,
    content: Bytes,
) -> ApiResult<Json<MazeFile>> {
    run_blocking(move || Ok(Json(MazeFile::read(&name, &content)?))).await
}

/// The path of a listed maze, or the name of a maze and its drawing.
#[derive(Deserialize)]
struct MazeChoice {
    path: Option<String>,
    maze: Option<String>,
    drawing: Option<String>,
    /// True if the user's own mouse should run in the maze.
    #[serde(default)]
    run: bool,
}

async fn load_maze(
    State(state): SharedState,
    Json(MazeChoice { path, maze, drawing, run }): Json<MazeChoice>,
) -> ApiResult<Json<RunNumber>> {
    Arc::clone(&state)
        .mouse_jobs
        .run(move |_| {
            let live = state.search()?;
            let (path, (name, maze)) = match (path, maze, drawing) {
                (Some(path), None, None) => {
                    let read = state.config.mazes.read(&path)?;
                    (path, read)
                }
                // The page highlights no listed maze.
                (None, Some(name), Some(drawing)) => {
                    let maze = drawing.parse().map_err(ApiError::bad_request)?;
                    (String::new(), (title(&name), maze))
                }
                _ => return Err(ApiError::bad_request("expected a path, or a maze and a drawing")),
            };
            Ok(Json(RunNumber {
                run: live.load_maze(&path, &name, maze, run, state.limits.stop_time)?,
            }))
        })
        .await
}

async fn describe_source(
    State(state): SharedState,
    Path(id): Path<String>,
) -> ApiResult<Json<SourceInfo>> {
    run_blocking(move || {
        let live = state.config.live.as_ref().filter(|_| state.config.is_trial && id == "live");
        let robot = live.and_then(|live| Some(live.control.own()?.to_string()));
        Ok(Json(SourceInfo::new(id.clone(), &*state.source(&id)?, &state.config.vehicles, robot)?))
    })
    .await
}

#[derive(Deserialize)]
struct StatesQuery {
    from: usize,
    count: Option<usize>,
}

async fn states(
    RequestedRun { source, run, .. }: RequestedRun,
    Query(StatesQuery { from, count }): Query<StatesQuery>,
) -> ApiResult<Response> {
    run_blocking(move || {
        let count = count.unwrap_or(1).min(Block::STATES);
        let mut bytes = Vec::new();
        // The range covers one block or two adjacent blocks.
        let end = from.saturating_add(count).min(source.states(run)?);
        let next = (from / Block::STATES + 1).saturating_mul(Block::STATES);
        let first = source.block(run, end.min(next).saturating_sub(1).max(from))?;
        bytes.extend_from_slice(first.range(from, end.saturating_sub(from)));
        let rest = end.saturating_sub(next);
        if rest > 0 {
            bytes.extend_from_slice(source.block(run, end - 1)?.range(next, rest));
        }
        Ok(([(header::CONTENT_TYPE, BINARY)], bytes).into_response())
    })
    .await
}

#[derive(Deserialize)]
struct StateIndex {
    at: usize,
}

#[derive(Deserialize)]
struct TimedState {
    at: usize,
    /// The name of the vehicle that times the runs, or `None` for that of the source.
    vehicle: Option<String>,
}

async fn state_view(
    requested: RequestedRun,
    Query(TimedState { at, vehicle }): Query<TimedState>,
) -> ApiResult<Json<StateView>> {
    let vehicle = vehicle_for(&requested, vehicle)?;
    if at < requested.source.states(requested.run)? {
        requested.index_to(at).await?;
    }
    let RequestedRun { source, run, .. } = requested;
    run_blocking(move || Ok(Json(StateView::new(&source, run, at, &mut Planner::new(vehicle))?)))
        .await
}

#[derive(Deserialize)]
struct TimedRun {
    /// The name of the vehicle that times the runs, or `None` for that of the source.
    vehicle: Option<String>,
}

async fn run_result(
    run: RequestedRun,
    Query(TimedRun { vehicle }): Query<TimedRun>,
) -> ApiResult<Json<Option<RunResult>>> {
    let vehicle = vehicle_for(&run, vehicle)?;
    run.read(move |source, run, cancel| source.result(run, vehicle, cancel)).await
}

/// Returns the vehicle with a name, or that of the source.
fn vehicle_for(requested: &RequestedRun, name: Option<String>) -> ApiResult<Vehicle> {
    let vehicles = &requested.state.config.vehicles;
    let size = requested.source.describe(requested.run)?.size;
    name.map_or_else(|| Ok(vehicles.selected(size)), |name| vehicles.find(&name))
}

/// Returns the fastest run through the true maze, and the runs along other routes.
async fn true_fast_runs(
    run: RequestedRun,
    Path((_, vehicle)): Path<(String, String)>,
) -> ApiResult<Json<Vec<RouteRun>>> {
    let vehicle = run.state.config.vehicles.find(&vehicle)?;
    run.read(move |source, run, _| {
        let description = source.describe(run)?;
        let unknown = || ApiError::conflict("the recording does not contain the true maze");
        Ok(fast_runs::in_maze(description.truth.as_ref().ok_or_else(unknown)?, &vehicle))
    })
    .await
}

/// Returns the fast runs that depend on what the mouse has done until a state.
async fn mouse_fast_runs(
    run: RequestedRun,
    Path((_, vehicle)): Path<(String, String)>,
    Query(StateIndex { at }): Query<StateIndex>,
) -> ApiResult<Json<Vec<RouteRun>>> {
    let vehicle = run.state.config.vehicles.find(&vehicle)?;
    run.read(move |source, run, cancel| fast_runs::of_mouse(source, run, at, &vehicle, cancel))
        .await
}

async fn page_svg(RequestedRun { source, run, .. }: RequestedRun) -> ApiResult<Response> {
    run_blocking(move || {
        Ok(([(header::CONTENT_TYPE, SVG)], pictures::page_svg(&source, run)?).into_response())
    })
    .await
}

async fn gif_animation(
    RequestedRun { state, source, run }: RequestedRun,
    Query(options): Query<PictureOptions>,
) -> ApiResult<Response> {
    let draw = move |cancel: &CancelToken| {
        let gif = pictures::gif(&source, run, options, cancel)?;
        download(&source, run, "gif", "image/gif", gif)
    };
    state.exports.run(draw).await
}

async fn save_recording(RequestedRun { state, source, run }: RequestedRun) -> ApiResult<Response> {
    let save = move |cancel: &CancelToken| {
        let file = recordings::save(&source, run, cancel)?;
        download(&source, run, "mcap", BINARY, read_stream(file))
    };
    state.recording_jobs.run(save).await
}

async fn export_run(
    requested: RequestedRun,
    Query(TimedRun { vehicle }): Query<TimedRun>,
    content: Content,
) -> ApiResult<Response> {
    let vehicle = vehicle_for(&requested, vehicle)?;
    let RequestedRun { state, source, run } = requested;
    Arc::clone(&state)
        .exports
        .run(move |cancel| {
            let file =
                export::to_file(&source, run, content, vehicle, &state.config.budget, cancel)?;
            // A browser must never show the page as a page of this server.
            download(&source, run, "html", BINARY, read_stream(file))
        })
        .await
}

/// An action that the page requests.
#[derive(Deserialize)]
#[serde(tag = "action", rename_all = "kebab-case")]
enum MouseAction {
    /// Run a bundled strategy.
    Run {
        strategy: String,
    },
    /// Run the user's own mouse, after stopping a running mouse.
    RunAgain,
    Stop,
    Pause,
    Resume,
    /// Take one step, then pause.
    Step,
    /// Press the reset button of the user's own mouse.
    PressReset,
    /// Change the pace to this number of steps per second, or to no limit.
    SetPace {
        pace: Option<f64>,
    },
}

/// Carries out an action. Only the wait for a mouse to stop takes time.
async fn act(State(state): SharedState, Json(action): Json<MouseAction>) -> ApiResult<StatusCode> {
    let live = state.live()?;
    let control = &live.control;
    match action {
        MouseAction::Run { strategy } => {
            let strategy: BundledStrategy = strategy.parse().map_err(ApiError::bad_request)?;
            state.search()?.start_mouse(strategy)?;
        }
        MouseAction::RunAgain => live.run_own_mouse()?,
        MouseAction::Stop => {
            let (run, control) = (control.stop(), Arc::clone(control));
            let stop_time = state.limits.stop_time;
            let wait = move |_: &CancelToken| {
                control.wait_for_end(run, stop_time);
                Ok(())
            };
            state.mouse_jobs.run(wait).await?;
        }
        MouseAction::Pause => control.pause_after(0),
        MouseAction::Resume => control.resume(),
        MouseAction::Step => control.pause_after(1),
        MouseAction::PressReset => control.press_reset(),
        MouseAction::SetPace { pace: None } => control.set_pace(Pace::UNLIMITED),
        MouseAction::SetPace { pace: Some(rate) } => {
            let invalid = || format!("expected a pace of at least 0.01 steps/s, found {rate}");
            let pace = Pace::from_rate(rate).ok_or_else(invalid).map_err(ApiError::bad_request)?;
            control.set_pace(pace);
        }
    }
    Ok(StatusCode::NO_CONTENT)
}

const CHUNK_BYTES: usize = 256 * 1024;

/// Streams all bytes of a reader. Each chunk is read only after the previous one has been sent.
fn read_stream(reader: impl Read + Send + 'static) -> Body {
    Body::from_stream(stream::unfold(Some(reader), |reader| async {
        let mut reader = reader?;
        let read = tokio::task::spawn_blocking(move || {
            let mut chunk = Vec::with_capacity(CHUNK_BYTES);
            let count = reader.by_ref().take(CHUNK_BYTES as u64).read_to_end(&mut chunk)?;
            Ok((count > 0).then_some((chunk, reader)))
        });
        match read.await.map_err(io::Error::other).and_then(|read| read) {
            Ok(Some((chunk, reader))) => Some((Ok(chunk), Some(reader))),
            Ok(None) => None,
            Err(error) => Some((Err(error), None)),
        }
    }))
}
