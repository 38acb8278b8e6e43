//! Why a request of the page is not served.

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use mmsim_server::MonitorError;

/// What a request gets in place of what it asked for: a sentence that the page can show.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub(crate) struct ApiError {
    pub(crate) status: StatusCode,
    pub(crate) text: String,
}

#[expect(clippy::needless_pass_by_value, reason = "as `map_err` hands over errors")]
impl ApiError {
    pub(crate) fn new(status: StatusCode, text: impl ToString) -> Self {
        Self { status, text: text.to_string() }
    }

    /// There is no such thing.
    pub(crate) fn not_found(text: impl ToString) -> Self {
        Self::new(StatusCode::NOT_FOUND, text)
    }

    /// The request makes no sense.
    pub(crate) fn bad(text: impl ToString) -> Self {
        Self::new(StatusCode::BAD_REQUEST, text)
    }

    /// It cannot be done now.
    pub(crate) fn conflict(text: impl ToString) -> Self {
        Self::new(StatusCode::CONFLICT, text)
    }

    /// Something here does not work.
    pub(crate) fn failed(text: impl ToString) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, text)
    }
}

impl From<MonitorError> for ApiError {
    fn from(error: MonitorError) -> Self {
        let status = match error {
            MonitorError::RunEnded { .. } => StatusCode::GONE,
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
