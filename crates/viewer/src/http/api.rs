//! The HTTP API of the page.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router, middleware};
use mmsim_drawing::{Scene, thumbnail};
use mmsim_recording::Block;
use mmsim_run::{BoundsHistory, RunEvents};
use serde::{Deserialize, Serialize};

use crate::app_state::AppState;
use crate::export;
use crate::http::api_error::ApiError;
use crate::http::jobs::run_blocking;
use crate::http::page_info::PageInfo;
use crate::http::transfer::buffer_body;
use crate::http::{assets, events, mouse_api, stream};
use crate::source::Source;
use crate::source::pictures::{self, PictureOptions};
use crate::source::source_info::SourceInfo;
use crate::source::state_view::StateView;
use crate::source::{fast_runs, find, log_view, recording_api, recordings};

const SVG: &str = "image/svg+xml";
pub(crate) const BINARY: &str = "application/octet-stream";

/// Returns the routes of the API. Exported pages contain the responses that the page needs to show a
/// recording (see `export::responses`).
pub(crate) fn router(state: Arc<AppState>) -> Router {
    Router::new()
        .route("/events", get(|State(state)| async { events::stream(state) }))
        .route("/api/page", get(page_info))
        .route("/api/mazes", get(list_mazes))
        .route("/api/mazes/picture.svg", get(maze_picture))
        .route("/api/maze", post(load_maze))
        .route("/api/sources/{id}", get(describe_source))
        .route("/api/sources/{id}/drawing.svg", get(page_svg))
        .route("/api/sources/{id}/states", get(states))
        .route("/api/sources/{id}/picture.svg", get(svg_picture))
        .route("/api/sources/{id}/picture.png", get(png_picture))
        .route("/api/sources/{id}/animation.gif", get(gif_animation))
        .route("/api/sources/{id}/moment", get(state_view))
        .route("/api/sources/{id}/costs", get(bounds))
        .route("/api/sources/{id}/events", get(run_events))
        .route("/api/sources/{id}/log", get(log_view::handle))
        .route("/api/sources/{id}/find", get(find::handle))
        .route("/api/sources/{id}/fast-runs/{vehicle}", get(fast_runs::handle))
        .route("/api/sources/{id}/known-fast-run/{vehicle}", get(fast_runs::handle_known))
        .route("/api/sources/{id}/recording.mcap", get(save_recording))
        .route("/api/sources/{id}/page.html", get(export_page))
        .merge(recording_api::router())
        .merge(mouse_api::router())
        .layer(middleware::from_fn_with_state(Arc::clone(&state), buffer_body))
        .merge(recording_api::upload_router())
        .with_state(state)
        .merge(assets::router())
}

type ApiResult<T> = Result<T, ApiError>;
type SharedState = State<Arc<AppState>>;

#[derive(Deserialize, Serialize)]
struct RunNumber {
    run: u32,
}

async fn page_info(State(state): SharedState) -> Json<PageInfo> {
    Json(PageInfo::new(&state))
}

async fn list_mazes(State(state): SharedState) -> ApiResult<Response> {
    run_blocking(move || Ok(Json(state.mazes.entries()).into_response())).await
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
        let (_, maze) = state.mazes.read(&path)?;
        Ok(([(header::CONTENT_TYPE, SVG)], thumbnail(&maze)).into_response())
    })
    .await
}

#[derive(Deserialize)]
struct MazeChoice {
    path: String,
    /// True if the user's own mouse should run in the maze.
    #[serde(default)]
    run: bool,
}

async fn load_maze(
    State(state): SharedState,
    Json(MazeChoice { path, run }): Json<MazeChoice>,
) -> ApiResult<Json<RunNumber>> {
    Arc::clone(&state)
        .mouse_jobs
        .run(move |_| {
            let live = state.search()?;
            let (name, maze) = state.mazes.read(&path)?;
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
        let live = state.live.as_ref().filter(|_| state.is_trial && id == "live");
        let robot = live.and_then(|live| Some(live.control.own()?.name.clone()));
        Ok(Json(SourceInfo::new(id.clone(), &*state.source(&id)?, robot)?))
    })
    .await
}

#[derive(Deserialize)]
struct StatesQuery {
    run: u32,
    from: usize,
    count: Option<usize>,
}

async fn states(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(StatesQuery { run, from, count }): Query<StatesQuery>,
) -> ApiResult<Response> {
    run_blocking(move || {
        let (source, count) = (state.source(&id)?, count.unwrap_or(1).min(Block::STATES));
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
struct StateQuery {
    run: u32,
    at: usize,
}

async fn state_view(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(StateQuery { run, at }): Query<StateQuery>,
) -> ApiResult<Json<StateView>> {
    let source = state.source(&id)?;
    if at < source.states(run)? && source.is_trail_long(run, at) {
        let source = Arc::clone(&source);
        state.run_jobs.run(move |cancel| source.run_to(run, at, cancel).map(drop)).await?;
    }
    run_blocking(move || Ok(Json(StateView::new(&source, run, at)?))).await
}

async fn bounds(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(RunNumber { run }): Query<RunNumber>,
) -> ApiResult<Json<BoundsHistory>> {
    let source = state.source(&id)?;
    state.run_jobs.run(move |cancel| Ok(Json(source.bounds(run, cancel)?))).await
}

async fn run_events(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(RunNumber { run }): Query<RunNumber>,
) -> ApiResult<Json<RunEvents>> {
    let source = state.source(&id)?;
    state.run_jobs.run(move |cancel| Ok(Json(source.events(run, cancel)?))).await
}

async fn page_svg(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(RunNumber { run }): Query<RunNumber>,
) -> ApiResult<Response> {
    run_blocking(move || {
        Ok(([(header::CONTENT_TYPE, SVG)], pictures::page_svg(&*state.source(&id)?, run)?)
            .into_response())
    })
    .await
}

#[derive(Deserialize)]
struct PictureQuery {
    run: u32,
    /// The index of the state.
    #[serde(default)]
    at: usize,
}

async fn svg_picture(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(PictureQuery { run, at }): Query<PictureQuery>,
    Query(options): Query<PictureOptions>,
) -> ApiResult<Response> {
    Arc::clone(&state)
        .pictures
        .run(move |cancel| {
            let source = state.source(&id)?;
            let draw = |scene: Scene<'_>| scene.svg();
            let svg = pictures::draw_state(&source, run, at, options, cancel, draw)?;
            download(&source, run, "svg", SVG, svg)
        })
        .await
}

async fn png_picture(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(PictureQuery { run, at }): Query<PictureQuery>,
    Query(options): Query<PictureOptions>,
) -> ApiResult<Response> {
    Arc::clone(&state)
        .pictures
        .run(move |cancel| {
            let source = state.source(&id)?;
            let draw = |scene: Scene<'_>| pictures::png(&scene);
            let png = pictures::draw_state(&source, run, at, options, cancel, draw)?;
            download(&source, run, "png", "image/png", png?)
        })
        .await
}

async fn gif_animation(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(RunNumber { run }): Query<RunNumber>,
    Query(options): Query<PictureOptions>,
) -> ApiResult<Response> {
    Arc::clone(&state)
        .exports
        .run(move |cancel| {
            let source = state.source(&id)?;
            let gif = pictures::gif(&source, run, options, cancel)?;
            download(&source, run, "gif", "image/gif", gif)
        })
        .await
}

async fn save_recording(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(RunNumber { run }): Query<RunNumber>,
) -> ApiResult<Response> {
    Arc::clone(&state)
        .recording_jobs
        .run(move |cancel| {
            let source = state.source(&id)?;
            let file = recordings::save(&source, run, cancel)?;
            download(&source, run, "mcap", BINARY, Body::from_stream(stream::from_reader(file)))
        })
        .await
}

async fn export_page(
    State(state): SharedState,
    Path(id): Path<String>,
    Query(RunNumber { run }): Query<RunNumber>,
) -> ApiResult<Response> {
    Arc::clone(&state)
        .exports
        .run(move |cancel| {
            let source = state.source(&id)?;
            let file = export::to_file(&source, run, &state.vehicles, &state.budget, cancel)?;
            // A browser must never show the page as a page of this server.
            download(&source, run, "html", BINARY, Body::from_stream(stream::from_reader(file)))
        })
        .await
}

/// Returns a response that browsers save as a file.
fn download(
    source: &Source,
    run: u32,
    extension: &str,
    media_type: &'static str,
    content: impl Into<Body>,
) -> ApiResult<Response> {
    let title = source.describe(run)?.title.clone();
    let stem = title.strip_suffix(".mcap").unwrap_or(&title);
    let sanitize = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = stem.chars().map(sanitize).take(100).collect();
    let disposition = format!("attachment; filename=\"{name}.{extension}\"");
    let headers = [(header::CONTENT_TYPE, media_type), (header::CONTENT_DISPOSITION, &disposition)];
    Ok((headers, content.into()).into_response())
}
