//! The part of the HTTP API that lists, opens and closes recordings.

use std::io::{Seek, Write};
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use mmsim_recording::Recording;
use serde::{Deserialize, Serialize};

use crate::app_state::AppState;
use crate::http::api_error::ApiError;
use crate::http::jobs::run_blocking;
use crate::http::limits::MAX_RECORDING_BYTES;
use crate::http::transfer::receive_body;
use crate::source::recordings;

type ApiResult<T> = Result<T, ApiError>;
type SharedState = State<Arc<AppState>>;

pub(crate) fn router() -> Router<Arc<AppState>> {
    Router::new()
        .route("/api/recordings", get(list_recordings))
        .route("/api/recordings/open", post(open_recording))
        .route("/api/recordings/close", post(close_recording))
}

/// Returns the route that receives a recording, whose body must not be buffered.
pub(crate) fn upload_router() -> Router<Arc<AppState>> {
    Router::new().route("/api/recordings", post(upload))
}

async fn list_recordings(State(state): SharedState) -> ApiResult<Response> {
    run_blocking(move || {
        let folder = state.recordings_dir.as_deref();
        let entries = folder.map(recordings::list).transpose()?.unwrap_or_default();
        Ok(Json(entries).into_response())
    })
    .await
}

#[derive(Deserialize)]
struct RecordingName {
    name: String,
}

#[derive(Deserialize, Serialize)]
struct RecordingId {
    id: String,
}

async fn open_recording(
    State(state): SharedState,
    Json(RecordingName { name }): Json<RecordingName>,
) -> ApiResult<Json<RecordingId>> {
    Arc::clone(&state)
        .recording_jobs
        .run(move |_| Ok(Json(RecordingId { id: recordings::open(&state, &name)? })))
        .await
}

async fn close_recording(
    State(state): SharedState,
    Json(RecordingId { id }): Json<RecordingId>,
) -> ApiResult<StatusCode> {
    state.close(&id)?;
    Ok(StatusCode::NO_CONTENT)
}

/// Receives an uploaded recording and opens it.
async fn upload(
    State(state): SharedState,
    Query(RecordingName { name }): Query<RecordingName>,
    body: Body,
) -> ApiResult<Json<RecordingId>> {
    state.check_capacity()?;
    let permit = state.uploads.acquire().await?;
    // The file has no name, so the system deletes it even if the process is killed.
    let mut file = tempfile::tempfile().map_err(ApiError::internal)?;
    receive_body(body, MAX_RECORDING_BYTES, state.limits, |chunk| file.write_all(&chunk)).await?;
    Arc::clone(&state)
        .recording_jobs
        .run(move |_| {
            let _permit = permit;
            file.rewind().map_err(ApiError::internal)?;
            let file = std::io::BufReader::new(file);
            let title = recordings::title(&name);
            let recording = Recording::read_within(file, &state.budget)
                .map_err(|error| ApiError::bad_request(format!("{title}: {error}")))?;
            Ok(Json(RecordingId { id: state.open(&title, recording)? }))
        })
        .await
}
