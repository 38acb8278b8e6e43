//! The state that all HTTP handlers share.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jiff::Timestamp;
use mmsim_recording::{MemoryBudget, Recording};

use crate::config::ViewerConfig;
use crate::http::api_error::ApiError;
use crate::http::jobs::JobQueue;
use crate::http::limits::{Limits, MAX_MOUSE_JOBS, MAX_RECORDING_JOBS, MAX_RUN_JOBS, MAX_UPLOADS};
use crate::live::LiveServer;
use crate::mazes::MazeList;
use crate::source::Source;
use crate::source::vehicles::Vehicles;

/// The maximum number of open recordings.
const MAX_OPEN_RECORDINGS: usize = 8;

/// The state that all HTTP handlers share.
pub(crate) struct AppState {
    /// The ID of this server process. If the ID changes, a page knows that the server was
    /// restarted.
    pub(crate) server_id: String,
    pub(crate) live: Option<LiveServer>,
    /// The folder whose recordings the page lists.
    pub(crate) recordings_dir: Option<PathBuf>,
    pub(crate) mazes: MazeList,
    pub(crate) limits: Limits,
    /// The queue for jobs that wait until a mouse has stopped. Each job has already stopped the
    /// mouse that it waits for, so a full queue delays no stop.
    pub(crate) mouse_jobs: JobQueue,
    /// The queue for jobs that may read all states of a run.
    pub(crate) run_jobs: JobQueue,
    /// The queue for pictures, which are drawn one at a time.
    pub(crate) pictures: JobQueue,
    /// The queue for GIFs and HTML files of whole runs, which are created one at a time.
    pub(crate) exports: JobQueue,
    /// The queue for reading and writing recordings.
    pub(crate) recording_jobs: JobQueue,
    pub(crate) uploads: JobQueue,
    /// True if the live simulation is a two-run trial.
    pub(crate) is_trial: bool,
    pub(crate) vehicles: Vehicles,
    /// The memory limit for all open recordings.
    pub(crate) budget: Arc<MemoryBudget>,
    recordings: Mutex<OpenRecordings>,
}

#[derive(Default)]
struct OpenRecordings {
    last_id: u32,
    by_id: BTreeMap<u32, Arc<Source>>,
}

impl AppState {
    pub(crate) fn new(config: ViewerConfig, limits: Limits) -> Self {
        let ViewerConfig { live, recordings_dir, mazes, recordings, budget, is_trial, vehicles } =
            config;
        let mut open = OpenRecordings::default();
        for (title, recording) in recordings {
            open.insert(&title, recording);
        }
        let queue = |kind, max_jobs| JobQueue::new(kind, max_jobs, limits.queue_time);
        Self {
            server_id: format!("{:x}", Timestamp::now().as_nanosecond()),
            live,
            recordings_dir,
            mazes: MazeList::new(mazes),
            limits,
            mouse_jobs: queue("mice", MAX_MOUSE_JOBS),
            run_jobs: queue("runs", MAX_RUN_JOBS),
            pictures: queue("pictures", 1),
            exports: queue("exports", 1).in_background(),
            recording_jobs: queue("recordings", MAX_RECORDING_JOBS),
            uploads: queue("uploads", MAX_UPLOADS),
            is_trial,
            vehicles,
            budget,
            recordings: Mutex::new(open),
        }
    }

    pub(crate) fn live(&self) -> Result<&LiveServer, ApiError> {
        self.live.as_ref().ok_or_else(|| ApiError::not_found("no simulation is being served"))
    }

    /// Returns the live simulation, unless it is a two-run trial.
    pub(crate) fn search(&self) -> Result<&LiveServer, ApiError> {
        let live = self.live()?;
        if self.is_trial {
            return Err(ApiError::conflict("not available during a two-run trial"));
        }
        Ok(live)
    }

    /// Returns the source with this ID, which is `live` or the number of an open recording.
    pub(crate) fn source(&self, id: &str) -> Result<Arc<Source>, ApiError> {
        if id == "live" {
            return Ok(Arc::clone(&self.live()?.source));
        }
        let found = id.parse().ok().and_then(|id: u32| self.recordings().by_id.get(&id).cloned());
        found.ok_or_else(|| source_not_found(id))
    }

    /// Returns the IDs of the open recordings.
    pub(crate) fn open_recordings(&self) -> Vec<String> {
        self.recordings().by_id.keys().map(u32::to_string).collect()
    }

    /// Returns an error if the maximum number of recordings is already open.
    pub(crate) fn check_capacity(&self) -> Result<(), ApiError> {
        self.recordings().check_capacity()
    }

    /// Adds an open recording and returns its ID.
    pub(crate) fn open(&self, title: &str, recording: Recording) -> Result<String, ApiError> {
        let mut recordings = self.recordings();
        recordings.check_capacity()?;
        Ok(recordings.insert(title, recording))
    }

    /// Closes a recording.
    pub(crate) fn close(&self, id: &str) -> Result<(), ApiError> {
        let closed = id.parse().ok().and_then(|id: u32| self.recordings().by_id.remove(&id));
        closed.map(|_| ()).ok_or_else(|| source_not_found(id))
    }

    fn recordings(&self) -> MutexGuard<'_, OpenRecordings> {
        self.recordings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl OpenRecordings {
    fn check_capacity(&self) -> Result<(), ApiError> {
        if self.by_id.len() < MAX_OPEN_RECORDINGS {
            return Ok(());
        }
        let text = format!("{MAX_OPEN_RECORDINGS} recordings are already open (close one first)");
        Err(ApiError::conflict(text))
    }

    /// Adds an open recording, even if the maximum number of recordings is already open.
    fn insert(&mut self, title: &str, recording: Recording) -> String {
        self.last_id += 1;
        self.by_id.insert(self.last_id, Arc::new(Source::recording(title, recording)));
        self.last_id.to_string()
    }
}

fn source_not_found(id: &str) -> ApiError {
    ApiError::not_found(format!("no simulation or open recording has the ID {id:?}"))
}
