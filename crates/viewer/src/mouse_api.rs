//! The part of the HTTP API that controls mice.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::routing::post;
use axum::{Json, Router};
use mmsim_solvers::BundledStrategy;
use serde::Deserialize;

use crate::api_error::ApiError;
use crate::app_state::AppState;
use crate::jobs::run_blocking;
use crate::throttle::Pace;

/// An order of the page to a mouse.
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

pub(crate) fn router() -> Router<Arc<AppState>> {
    Router::new().route("/api/mouse", post(control))
}

async fn control(
    State(state): State<Arc<AppState>>,
    Json(action): Json<MouseAction>,
) -> Result<StatusCode, ApiError> {
    run_blocking(move || {
        let live = state.live()?;
        let throttle = live.control.throttle();
        match action {
            MouseAction::Run { strategy } => {
                let strategy: BundledStrategy = strategy.parse().map_err(ApiError::bad_request)?;
                state.search()?.start_mouse(strategy)?;
            }
            MouseAction::RunAgain => live.run_own_mouse()?,
            MouseAction::Stop => live.stop_mouse(),
            MouseAction::Pause => throttle.pause(),
            MouseAction::Resume => throttle.resume(),
            MouseAction::Step => throttle.step(),
            MouseAction::PressReset => live.control.press_reset(),
            MouseAction::SetPace { pace: None } => throttle.set_pace(Pace::UNLIMITED),
            MouseAction::SetPace { pace: Some(rate) } => {
                let invalid = || format!("expected a pace of at least 0.01 steps/s, found {rate}");
                throttle.set_pace(
                    Pace::from_rate(rate).ok_or_else(invalid).map_err(ApiError::bad_request)?,
                );
            }
        }
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}
