//! The run of a request.

use std::sync::Arc;

use axum::Json;
use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};

use crate::app::AppState;
use crate::http::jobs::{ApiError, ApiResult, CancelToken};
use crate::source::StateSource;

/// A run that a request names by the ID of its source and its number.
pub(crate) struct RequestedRun {
    pub(crate) state: Arc<AppState>,
    pub(crate) source: Arc<StateSource>,
    pub(crate) run: u32,
}

#[derive(Deserialize)]
struct SourceId {
    id: String,
}

#[derive(Deserialize, Serialize)]
pub(crate) struct RunNumber {
    pub(crate) run: u32,
}

impl FromRequestParts<Arc<AppState>> for RequestedRun {
    type Rejection = Response;

    async fn from_request_parts(
        parts: &mut Parts,
        state: &Arc<AppState>,
    ) -> Result<Self, Response> {
        let (Path(SourceId { id }), Query(RunNumber { run })) =
            <(Path<SourceId>, Query<RunNumber>)>::from_request_parts(parts, state).await?;
        let source = state.source(&id).map_err(ApiError::into_response)?;
        Ok(Self { state: Arc::clone(state), source, run })
    }
}

impl RequestedRun {
    /// Responds with the result of a job that may read all states of the run.
    pub(crate) async fn read<T: Send + 'static>(
        self,
        job: impl FnOnce(&StateSource, u32, &CancelToken) -> ApiResult<T> + Send + 'static,
    ) -> ApiResult<Json<T>> {
        let Self { state, source, run } = self;
        state.run_jobs.run(move |cancel| Ok(Json(job(&source, run, cancel)?))).await
    }

    /// Indexes the run up to a state that exists. If that takes long, does so as a job, which ends
    /// when the request is cancelled.
    pub(crate) async fn index_to(&self, at: usize) -> ApiResult<()> {
        if self.source.is_trail_long(self.run, at) {
            let (source, run) = (Arc::clone(&self.source), self.run);
            let index = move |cancel: &CancelToken| source.run_to(run, at, cancel).map(drop);
            self.state.run_jobs.run(index).await?;
        }
        Ok(())
    }
}
