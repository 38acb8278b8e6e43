//! What all requests of the page work on.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use jiff::Timestamp;
use mmsim_formats::Catalogue;
use mmsim_maze::Maze;
use mmsim_recording::{MemoryBudget, Recording};
use mmsim_server::{Monitor, Server};
use mmsim_solvers::BundledStrategy;

use crate::api_error::ApiError;
use crate::limits::{Limits, MAX_RECORDING_JOBS, MAX_UPLOADS};
use crate::mazes::Listed;
use crate::mouse::Runner;
use crate::source::Source;
use crate::work::Queue;

/// How many recordings may be open at the same time.
const MAX_RECORDINGS: usize = 8;

/// What a [`Viewer`](crate::Viewer) shows.
#[derive(Default)]
pub struct ViewerConfig {
    live: Option<Live>,
    recordings: Option<PathBuf>,
    mazes: Catalogue,
    opened: Vec<(String, Recording)>,
    budget: Arc<MemoryBudget>,
}

impl ViewerConfig {
    /// The simulation of this server, whose maze comes from this path. The bundled mice run
    /// against it.
    pub fn with_live(mut self, server: &Server, maze: &Path) -> Self {
        self.live = Some(Live::new(server.monitor(), server.address(), maze));
        self
    }

    /// Mazes from which one can be chosen to be served.
    pub fn with_mazes(mut self, mazes: Catalogue) -> Self {
        self.mazes = mazes;
        self
    }

    /// The recordings in this folder, in which the server records.
    pub fn with_recordings(mut self, folder: impl Into<Option<PathBuf>>) -> Self {
        self.recordings = folder.into();
        self
    }

    /// The memory for all recordings that are open at the same time, without which there is no limit.
    pub fn with_budget(mut self, budget: Arc<MemoryBudget>) -> Self {
        self.budget = budget;
        self
    }

    /// A recording that is open from the beginning, and its title.
    pub fn with_recording(mut self, title: &str, recording: Recording) -> Self {
        self.opened.push((title.into(), recording));
        self
    }

    pub(crate) fn into_state(self, limits: Limits) -> AppState {
        let state = AppState::new(self.live, self.recordings, self.mazes, self.budget, limits);
        for (title, recording) in self.opened {
            let source = Arc::new(Source::recording(&title, recording));
            state.opened().insert(&title, source);
        }
        state
    }
}

/// What all requests of the page work on.
pub(crate) struct AppState {
    /// Differs from that of every other start of a simulator.
    pub(crate) server: String,
    pub(crate) live: Option<Live>,
    /// Where recordings are written, which the page lists.
    pub(crate) recordings: Option<PathBuf>,
    pub(crate) catalogue: Catalogue,
    pub(crate) listed: OnceLock<Vec<Listed>>,
    pub(crate) limits: Limits,
    /// Pictures in pixels, drawn one at a time.
    pub(crate) pictures: Queue,
    /// GIFs: some hundred pictures each.
    pub(crate) animations: Queue,
    /// Recordings that are read or written.
    pub(crate) recording_jobs: Queue,
    pub(crate) uploads: Queue,
    /// For the recordings that are open.
    pub(crate) budget: Arc<MemoryBudget>,
    opened: Mutex<Opened>,
}

/// The simulation that is served.
pub(crate) struct Live {
    pub(crate) monitor: Monitor,
    /// Where clients connect.
    pub(crate) address: String,
    pub(crate) source: Arc<Source>,
    pub(crate) runner: Runner,
    /// The path of the maze, as the catalogue calls it.
    maze: Mutex<String>,
    /// Held while the maze or the mouse in it is changed.
    changing: Mutex<()>,
}

#[derive(Default)]
struct Opened {
    /// The number of the one that was opened last.
    last: u32,
    recordings: BTreeMap<u32, (String, Arc<Source>)>,
}

impl AppState {
    pub(crate) fn new(
        live: Option<Live>,
        recordings: Option<PathBuf>,
        catalogue: Catalogue,
        budget: Arc<MemoryBudget>,
        limits: Limits,
    ) -> Self {
        let queue = |kind, turns| Queue::new(kind, turns, limits.queue_time);
        Self {
            server: format!("{:x}", Timestamp::now().as_nanosecond()),
            live,
            recordings,
            catalogue,
            listed: OnceLock::new(),
            limits,
            pictures: queue("pictures", 1),
            animations: queue("animations", 1).in_background(),
            recording_jobs: queue("recordings", MAX_RECORDING_JOBS),
            uploads: queue("uploads", MAX_UPLOADS),
            budget,
            opened: Mutex::default(),
        }
    }

    /// The simulation that is served.
    pub(crate) fn live(&self) -> Result<&Live, ApiError> {
        self.live.as_ref().ok_or_else(|| ApiError::not_found("no maze is served here"))
    }

    /// The source of this name: `live`, or the number of a recording.
    pub(crate) fn source(&self, id: &str) -> Result<Arc<Source>, ApiError> {
        if id == "live" {
            return Ok(Arc::clone(&self.live()?.source));
        }
        let opened = self.opened();
        let found = id.parse().ok().and_then(|id: u32| opened.recordings.get(&id));
        found.map(|(_, source)| Arc::clone(source)).ok_or_else(|| no_source(id))
    }

    /// Number and title of each recording that is open.
    pub(crate) fn opened_recordings(&self) -> Vec<(String, String)> {
        let opened = self.opened();
        opened.recordings.iter().map(|(id, (title, _))| (id.to_string(), title.clone())).collect()
    }

    /// Refuses another recording if there are too many.
    pub(crate) fn check_room(&self) -> Result<(), ApiError> {
        self.opened().check_room()
    }

    /// Opens a recording; gives its number.
    pub(crate) fn open(&self, title: &str, recording: Recording) -> Result<String, ApiError> {
        let source = Arc::new(Source::recording(title, recording));
        let mut opened = self.opened();
        opened.check_room()?;
        Ok(opened.insert(title, source))
    }

    /// Closes a recording.
    pub(crate) fn close(&self, id: &str) -> Result<(), ApiError> {
        let closed = id.parse().ok().and_then(|id: u32| self.opened().recordings.remove(&id));
        closed.map(|_| ()).ok_or_else(|| no_source(id))
    }

    fn opened(&self) -> MutexGuard<'_, Opened> {
        self.opened.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Opened {
    fn check_room(&self) -> Result<(), ApiError> {
        if self.recordings.len() < MAX_RECORDINGS {
            return Ok(());
        }
        let text = format!("{MAX_RECORDINGS} recordings are open; close one first");
        Err(ApiError::conflict(text))
    }

    fn insert(&mut self, title: &str, source: Arc<Source>) -> String {
        self.last += 1;
        self.recordings.insert(self.last, (title.into(), source));
        self.last.to_string()
    }
}

impl Live {
    pub(crate) fn new(monitor: Monitor, address: &str, maze: &Path) -> Self {
        Self {
            source: Arc::new(Source::live(monitor.clone())),
            monitor,
            address: address.into(),
            runner: Runner::new(address),
            maze: Mutex::new(maze.display().to_string()),
            changing: Mutex::default(),
        }
    }

    /// Serves this maze of the collection from now on; gives the number of the run.
    pub(crate) fn serve(&self, path: &str, name: &str, maze: Maze) -> Result<u32, ApiError> {
        let _changing = self.changing.lock().unwrap_or_else(PoisonError::into_inner);
        // It would go on in a maze that it does not know.
        self.runner.stop();
        let status = self.monitor.serve(name, maze)?;
        self.runner.forget();
        path.clone_into(&mut self.maze.lock().unwrap_or_else(PoisonError::into_inner));
        Ok(status.run)
    }

    /// Starts a bundled mouse.
    pub(crate) fn run(&self, strategy: BundledStrategy, pace_ms: u64) -> Result<(), ApiError> {
        let _changing = self.changing.lock().unwrap_or_else(PoisonError::into_inner);
        self.runner.start(strategy, pace_ms)
    }

    /// The path of the maze that is served.
    pub(crate) fn maze(&self) -> String {
        self.maze.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

fn no_source(id: &str) -> ApiError {
    ApiError::not_found(format!("expected live or an open recording, found {id:?}"))
}
