//! The description of the page: what it shows and what it can do.

use mmsim_mouse::OwnMouse;
use mmsim_solvers::BundledStrategy;
use serde::Serialize;

use crate::app_state::AppState;
use crate::config::ViewerConfig;
use crate::http::limits::Limits;
use crate::source::vehicles::Vehicles;

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
    /// The name of the vehicle that the page selects, or `None` if a preset fits the maze.
    vehicle: Option<String>,
    /// The user's own mouse, if the simulator runs one.
    own: Option<OwnMouse>,
    /// True if the live simulation is a two-run trial, so the page can neither load mazes nor run
    /// mice.
    #[serde(rename = "trial")]
    is_trial: bool,
    /// The IDs of the open recordings.
    opened: Vec<String>,
}

#[derive(Serialize)]
struct StrategyInfo {
    name: &'static str,
    about: &'static str,
}

impl PageInfo {
    pub(crate) fn new(state: &AppState) -> Self {
        Self {
            server_id: state.server_id.clone(),
            live: state.live.is_some(),
            records: state.recordings_dir.is_some(),
            zmq: state.live.as_ref().map(|live| live.address.clone()),
            strategies: BundledStrategy::ALL
                .iter()
                .map(|strategy| StrategyInfo { name: strategy.name(), about: strategy.about() })
                .collect(),
            vehicles: state.vehicles.names(),
            vehicle: state.vehicles.selected(),
            own: state.live.as_ref().and_then(|live| live.control.own().cloned()),
            is_trial: state.is_trial,
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
