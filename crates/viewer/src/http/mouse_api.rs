//! The part of the HTTP API that controls mice.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::routing::post;
use axum::{Json, Router};
use mmsim_mouse::Pace;
use mmsim_solvers::BundledStrategy;
use serde::Deserialize;

use crate::app_state::AppState;
use crate::http::api_error::ApiError;
use crate::http::jobs::CancelToken;

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

pub(crate) fn router() -> Router<Arc<AppState>> {
    Router::new().route("/api/mouse", post(act))
}

/// Carries out an action. Only the wait for a mouse to stop takes time.
async fn act(
    State(state): State<Arc<AppState>>,
    Json(action): Json<MouseAction>,
) -> Result<StatusCode, ApiError> {
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
