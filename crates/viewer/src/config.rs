//! The configuration of a viewer.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mmsim_formats::Catalogue;
use mmsim_recording::{MemoryBudget, Recording};
use mmsim_server::Server;

use crate::app_state::AppState;
use crate::limits::Limits;
use crate::live::LiveServer;

/// The simulation, recordings and mazes that a [`Viewer`](crate::Viewer) shows.
#[derive(Default)]
pub struct ViewerConfig {
    live: Option<LiveServer>,
    recordings_dir: Option<PathBuf>,
    mazes: Catalogue,
    recordings: Vec<(String, Recording)>,
    budget: Arc<MemoryBudget>,
}

impl ViewerConfig {
    /// Shows the simulation of a server and allows the page to run bundled mice against the server.
    /// `maze` is the path of the maze that the server simulates.
    pub fn with_live(mut self, server: &Server, maze: &Path) -> Self {
        self.live = Some(LiveServer::new(server.monitor(), server.address(), maze));
        self
    }

    /// Sets the mazes that the page offers to load.
    pub fn with_mazes(mut self, mazes: Catalogue) -> Self {
        self.mazes = mazes;
        self
    }

    /// Lists the recordings in a folder, usually the folder that the server records to.
    pub fn with_recordings(mut self, folder: impl Into<Option<PathBuf>>) -> Self {
        self.recordings_dir = folder.into();
        self
    }

    /// Limits the total memory of all open recordings, which is unlimited by default.
    pub fn with_budget(mut self, budget: Arc<MemoryBudget>) -> Self {
        self.budget = budget;
        self
    }

    /// Adds a recording that is open from the start.
    pub fn with_recording(mut self, title: &str, recording: Recording) -> Self {
        self.recordings.push((title.into(), recording));
        self
    }

    pub(crate) fn into_state(self, limits: Limits) -> AppState {
        let Self { live, recordings_dir, mazes, recordings, budget } = self;
        let state = AppState::new(live, recordings_dir, mazes, budget, limits);
        for (title, recording) in recordings {
            state.insert(&title, recording);
        }
        state
    }
}
