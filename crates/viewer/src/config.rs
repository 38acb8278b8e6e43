//! The configuration of a viewer.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mmsim_fastrun::Vehicle;
use mmsim_formats::Catalogue;
use mmsim_recording::{MemoryBudget, Recording};
use mmsim_server::Server;

use crate::app_state::presets;
use crate::control::MouseControl;
use crate::live::LiveServer;

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
    /// The vehicles besides the presets.
    pub(crate) vehicles: Vec<Vehicle>,
}

/// The error for two different vehicles with the same name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("two vehicles are called {0:?}; set another name in a file")]
pub struct SameName(pub String);

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

    /// Adds vehicles whose fast runs the page plays besides those of the presets. The page selects the
    /// first one.
    ///
    /// # Errors
    /// Returns an error if two different vehicles, including the presets, have the same name.
    pub fn with_vehicles(
        mut self,
        vehicles: impl IntoIterator<Item = Vehicle>,
    ) -> Result<Self, SameName> {
        for vehicle in vehicles {
            let mut known = presets().into_iter().chain(self.vehicles.iter().cloned());
            match known.find(|other| other.name() == vehicle.name()) {
                None => self.vehicles.push(vehicle),
                Some(other) if other == vehicle => {}
                Some(_) => return Err(SameName(vehicle.name().into())),
            }
        }
        Ok(self)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vehicles_have_different_names() {
        let file =
            |name: &str| Vehicle::from_toml("turns.l90.speed = 1500\nbase = \"expert\"", name);
        let (mine, other) = (file("mine").unwrap(), file("expert").unwrap());
        let config = ViewerConfig::default();
        let config = config.with_vehicles([mine.clone(), Vehicle::ares(), mine.clone()]).unwrap();
        assert_eq!(config.vehicles, [mine]);
        let Err(error) = config.with_vehicles([other]) else { panic!("expected an error") };
        assert_eq!(
            error.to_string(),
            r#"two vehicles are called "expert"; set another name in a file"#
        );
    }
}
