//! Error responses.

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use mmsim_server::MonitorError;

/// An error response: a status and a message that the page shows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub(crate) struct ApiError {
    pub(crate) status: StatusCode,
    pub(crate) text: String,
}

#[expect(clippy::needless_pass_by_value, reason = "`map_err` passes errors by value")]
impl ApiError {
    pub(crate) fn new(status: StatusCode, text: impl ToString) -> Self {
        Self { status, text: text.to_string() }
    }

    pub(crate) fn not_found(text: impl ToString) -> Self {
        Self::new(StatusCode::NOT_FOUND, text)
    }

    pub(crate) fn bad_request(text: impl ToString) -> Self {
        Self::new(StatusCode::BAD_REQUEST, text)
    }

    pub(crate) fn conflict(text: impl ToString) -> Self {
        Self::new(StatusCode::CONFLICT, text)
    }

    pub(crate) fn internal(text: impl ToString) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, text)
    }
}

impl From<MonitorError> for ApiError {
    fn from(error: MonitorError) -> Self {
        let status = match error {
            MonitorError::RunEnded { .. } => StatusCode::GONE,
            MonitorError::HasClient => StatusCode::CONFLICT,
            MonitorError::Ended => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error)
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        (self.status, self.text).into_response()
    }
}
