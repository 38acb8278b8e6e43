//! The configuration of a viewer.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mmsim_formats::Catalogue;
use mmsim_mouse::MouseControl;
use mmsim_recording::{MemoryBudget, Recording};
use mmsim_server::Server;

use crate::live::LiveServer;
use crate::source::vehicles::Vehicles;

/// The simulation, recordings and mazes that a [`Viewer`](crate::Viewer) shows.
#[derive(Default)]
pub struct ViewerConfig {
    pub(crate) live: Option<LiveServer>,
    pub(crate) recordings_dir: Option<PathBuf>,
    pub(crate) mazes: Catalogue,
    pub(crate) recordings: Vec<(String, Recording)>,
    pub(crate) budget: Arc<MemoryBudget>,
    /// True if the live simulation is a two-run trial.
    pub(crate) is_trial: bool,
    pub(crate) vehicles: Vehicles,
}

impl ViewerConfig {
    /// Shows the simulation of a server and allows the page to run bundled mice against it.
    /// `maze` is the path of the maze that the server simulates.
    pub fn with_live(mut self, server: &Server, maze: &Path) -> Self {
        self.live = Some(LiveServer::new(server.monitor(), server.address(), maze));
        self
    }

    /// Sets the control of the mice that the page starts. Call this after
    /// [`with_live`](Self::with_live).
    pub fn with_mouse(mut self, control: Arc<MouseControl>) -> Self {
        if let Some(live) = &mut self.live {
            live.control = control;
        }
        self
    }

    /// Sets the address that the page shows for clients, by default the address of the server. Call
    /// this after [`with_live`](Self::with_live).
    pub fn with_address(mut self, address: &str) -> Self {
        if let Some(live) = &mut self.live {
            live.address = address.into();
        }
        self
    }

    /// Shows the live simulation as the two-run trial of the user's own mouse. The page then neither
    /// loads other mazes nor runs bundled mice.
    pub fn with_trial(self) -> Self {
        Self { is_trial: true, ..self }
    }

    /// Sets the mazes that can be loaded from the page.
    pub fn with_mazes(self, mazes: Catalogue) -> Self {
        Self { mazes, ..self }
    }

    /// Sets the vehicles whose fast runs the page plays.
    pub fn with_vehicles(self, vehicles: Vehicles) -> Self {
        Self { vehicles, ..self }
    }

    /// Sets the folder whose recordings the page lists, usually the folder to which the server
    /// records.
    pub fn with_recordings(self, folder: impl Into<Option<PathBuf>>) -> Self {
        Self { recordings_dir: folder.into(), ..self }
    }

    /// Limits the total memory of all open recordings, which is unlimited by default.
    pub fn with_budget(self, budget: Arc<MemoryBudget>) -> Self {
        Self { budget, ..self }
    }

    /// Adds a recording that is already open when the viewer starts.
    pub fn with_recording(mut self, title: &str, recording: Recording) -> Self {
        self.recordings.push((title.into(), recording));
        self
    }
}
