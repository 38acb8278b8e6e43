//! What a viewer shows: its configuration, and the state that all HTTP handlers share.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use axum::extract::State;
use jiff::Timestamp;
use mmsim_drawing::thumbnail;
use mmsim_formats::{Catalogue, Choice, Entry, ParsedMaze};
use mmsim_maze::{Maze, MazeSize};
use mmsim_mouse::MouseControl;
use mmsim_recording::{MemoryBudget, Recording};
use mmsim_server::Server;
use mmsim_solvers::MazeFacts;
use serde::Serialize;

use crate::http::jobs::{ApiError, ApiResult, JobQueue};
use crate::http::limits::{Limits, MAX_MOUSE_JOBS, MAX_RECORDING_JOBS, MAX_RUN_JOBS, MAX_UPLOADS};
use crate::live::LiveServer;
use crate::source::StateSource;
use crate::source::fast_runs::Vehicles;

/// The simulation, recordings and mazes that a [`Viewer`](crate::Viewer) shows.
#[derive(Default)]
pub struct ViewerConfig {
    pub(crate) live: Option<LiveServer>,
    /// The folder whose recordings the page lists.
    pub(crate) recordings_dir: Option<PathBuf>,
    pub(crate) mazes: MazeList,
    recordings: Vec<(String, Recording)>,
    /// The memory limit for all open recordings.
    pub(crate) budget: Arc<MemoryBudget>,
    /// True if the live simulation is a two-run trial.
    pub(crate) is_trial: bool,
    pub(crate) vehicles: Vehicles,
}

impl ViewerConfig {
    /// Shows the simulation of a server and allows the page to run bundled mice against it.
    /// `maze` is the path of the maze that the server simulates.
    pub fn with_live(mut self, server: &Server, maze: &std::path::Path) -> Self {
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
        Self { mazes: MazeList::new(mazes), ..self }
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

/// The maximum number of open recordings.
const MAX_OPEN_RECORDINGS: usize = 8;

/// The argument with which handlers receive the state.
pub(crate) type SharedState = State<Arc<AppState>>;

/// The state that all HTTP handlers share.
pub(crate) struct AppState {
    /// The ID of this server process. If the ID changes, a page knows that the server was
    /// restarted.
    pub(crate) server_id: String,
    /// What the viewer shows, without its recordings.
    pub(crate) config: ViewerConfig,
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
    /// The number of times that the page has deleted or renamed a recording.
    pub(crate) recording_changes: AtomicU64,
    recordings: Mutex<OpenRecordings>,
}

#[derive(Default)]
pub(crate) struct OpenRecordings {
    last_id: u32,
    by_id: BTreeMap<u32, Arc<StateSource>>,
}

impl AppState {
    pub(crate) fn new(mut config: ViewerConfig, limits: Limits) -> Self {
        let mut open = OpenRecordings::default();
        for (title, recording) in std::mem::take(&mut config.recordings) {
            open.insert(&title, recording);
        }
        let queue = |kind, max_jobs| JobQueue::new(kind, max_jobs, limits.queue_time);
        Self {
            server_id: format!("{:x}", Timestamp::now().as_nanosecond()),
            config,
            limits,
            mouse_jobs: queue("mice", MAX_MOUSE_JOBS),
            run_jobs: queue("runs", MAX_RUN_JOBS),
            pictures: queue("pictures", 1),
            exports: queue("exports", 1).in_background(),
            recording_jobs: queue("recordings", MAX_RECORDING_JOBS),
            uploads: queue("uploads", MAX_UPLOADS),
            recording_changes: AtomicU64::new(0),
            recordings: Mutex::new(open),
        }
    }

    pub(crate) fn live(&self) -> ApiResult<&LiveServer> {
        let live = self.config.live.as_ref();
        live.ok_or_else(|| ApiError::not_found("no simulation is being served"))
    }

    /// Returns the live simulation, unless it is a two-run trial.
    pub(crate) fn search(&self) -> ApiResult<&LiveServer> {
        let live = self.live()?;
        if self.config.is_trial {
            return Err(ApiError::conflict("not available during a two-run trial"));
        }
        Ok(live)
    }

    /// Returns the source with this ID, which is `live` or the number of an open recording.
    pub(crate) fn source(&self, id: &str) -> ApiResult<Arc<StateSource>> {
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

    /// Adds an open recording and returns its ID.
    pub(crate) fn open(&self, title: &str, recording: Recording) -> ApiResult<String> {
        let mut recordings = self.recordings();
        recordings.check_capacity()?;
        Ok(recordings.insert(title, recording))
    }

    /// Closes a recording.
    pub(crate) fn close(&self, id: &str) -> ApiResult<()> {
        let closed = id.parse().ok().and_then(|id: u32| self.recordings().by_id.remove(&id));
        closed.map(|_| ()).ok_or_else(|| source_not_found(id))
    }

    pub(crate) fn recordings(&self) -> MutexGuard<'_, OpenRecordings> {
        self.recordings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl OpenRecordings {
    /// Returns an error if the maximum number of recordings is already open.
    pub(crate) fn check_capacity(&self) -> ApiResult<()> {
        if self.by_id.len() < MAX_OPEN_RECORDINGS {
            return Ok(());
        }
        let text = format!("{MAX_OPEN_RECORDINGS} recordings are already open (close one first)");
        Err(ApiError::conflict(text))
    }

    /// Adds an open recording, even if the maximum number of recordings is already open.
    fn insert(&mut self, title: &str, recording: Recording) -> String {
        self.last_id += 1;
        self.by_id.insert(self.last_id, Arc::new(StateSource::recording(title, recording)));
        self.last_id.to_string()
    }
}

fn source_not_found(id: &str) -> ApiError {
    ApiError::not_found(format!("no simulation or open recording has the ID {id:?}"))
}

/// A catalogue of mazes, with the size and shortest path length of each maze.
#[derive(Default)]
pub(crate) struct MazeList {
    catalogue: Catalogue,
    entries: OnceLock<Vec<MazeEntry>>,
}

/// An entry in the page's list of mazes.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MazeEntry {
    path: String,
    maze: String,
    width: Option<u8>,
    height: Option<u8>,
    /// The length of the shortest path in steps, or `None` if the goal is unreachable.
    shortest_path: Option<u16>,
    /// The error if the maze cannot be read.
    error: Option<String>,
}

impl MazeList {
    pub(crate) const fn new(catalogue: Catalogue) -> Self {
        Self { catalogue, entries: OnceLock::new() }
    }

    /// Returns all mazes, reading the maze files on the first call.
    pub(crate) fn entries(&self) -> &[MazeEntry] {
        let read = || self.catalogue.entries().iter().map(MazeEntry::new).collect();
        self.entries.get_or_init(read)
    }

    /// Reads the maze with the path `wanted`, which must be in the catalogue. Returns the name and
    /// the maze.
    pub(crate) fn read(&self, wanted: &str) -> ApiResult<(String, Maze)> {
        let entry = self.catalogue.entries().iter().find(|entry| path(entry) == wanted);
        let not_found = || ApiError::not_found(format!("no listed maze has the path {wanted:?}"));
        let entry = entry.ok_or_else(not_found)?;
        Ok((entry.name(), entry.maze().map_err(ApiError::internal)?))
    }
}

impl MazeEntry {
    fn new(entry: &Entry) -> Self {
        let maze = entry.maze();
        let size = maze.as_ref().ok().map(Maze::size);
        Self {
            path: path(entry),
            maze: entry.name(),
            width: size.map(MazeSize::width),
            height: size.map(MazeSize::height),
            shortest_path: maze.as_ref().ok().and_then(|maze| MazeFacts::new(maze).shortest_path),
            error: maze.err().map(|error| error.to_string()),
        }
    }
}

/// A maze file of the user.
#[derive(Serialize)]
pub(crate) struct MazeFile {
    maze: String,
    readings: Vec<MazeReading>,
}

/// A maze that a file can be read as.
#[derive(Serialize)]
struct MazeReading {
    /// The options of the command that select this reading.
    options: String,
    width: u8,
    height: u8,
    shortest_path: Option<u16>,
    /// The maze as a drawing, from which it is loaded.
    drawing: String,
    /// A thumbnail of the maze as SVG.
    picture: String,
}

impl MazeFile {
    /// Reads a file. The name of the maze is the name of the file without the extension.
    pub(crate) fn read(file: &str, content: &[u8]) -> ApiResult<Self> {
        let file = title(file);
        let readings = match Choice::default().read(content) {
            Ok(parsed) => vec![MazeReading::new(&parsed.maze, String::new())],
            Err(errors) if errors[0].readings.is_empty() => {
                return Err(ApiError::bad_request(format!("{file}: {}", errors[0])));
            }
            Err(errors) => {
                let options = |reading: &ParsedMaze| reading.encodings[0].to_string();
                let readings = errors[0].readings.iter();
                readings.map(|reading| MazeReading::new(&reading.maze, options(reading))).collect()
            }
        };
        let maze = Path::new(&file).file_stem().unwrap_or_default().to_string_lossy().into();
        Ok(Self { maze, readings })
    }
}

impl MazeReading {
    fn new(maze: &Maze, options: String) -> Self {
        Self {
            options,
            width: maze.size().width(),
            height: maze.size().height(),
            shortest_path: MazeFacts::new(maze).shortest_path,
            drawing: maze.to_string(),
            picture: thumbnail(maze),
        }
    }
}

/// Returns a title for a file of the user: the file name, shortened and without control characters.
pub(crate) fn title(name: &str) -> String {
    let title: String = name.chars().filter(|c| !c.is_control()).take(100).collect();
    if title.is_empty() { "unnamed".into() } else { title }
}

fn path(entry: &Entry) -> String {
    entry.path().display().to_string()
}

#[cfg(test)]
mod tests {
    use axum::http::StatusCode;

    use super::*;

    #[test]
    fn titles_are_short_single_lines() {
        assert_eq!(title("a\nb\u{1b}[2J.mcap"), "ab[2J.mcap");
        assert_eq!(title(&"x".repeat(1000)).len(), 100);
        assert_eq!(title("\n"), "unnamed");
    }

    #[test]
    fn a_file_is_named_without_its_extension() {
        let text = "+---+---+\n| S   G |\n+---+---+\n";
        let file = MazeFile::read("own.maze\n.txt", text.as_bytes()).unwrap();
        assert_eq!((&file.maze[..], file.readings.len()), ("own.maze", 1));
        let MazeReading { width, height, shortest_path, drawing, .. } = &file.readings[0];
        assert_eq!((*width, *height, *shortest_path), (2, 1, Some(1)));
        assert_eq!(drawing, "o---o---o\n| S   G |\no---o---o\n");
        let error = MazeFile::read("photo.png", b"\x89PNG").err().unwrap();
        assert!(error.text.starts_with("photo.png: line 1, column 1: "), "{error}");
        assert_eq!(error.status, StatusCode::BAD_REQUEST);
    }

    #[test]
    fn readable_mazes_have_facts_and_others_have_errors() {
        let list = MazeList::new(Catalogue::from_texts(&[
            ("a/open.txt", "o---o---o\n| S   G |\no---o---o\n"),
            ("a/closed.txt", "o---o---o\n| S | G |\no---o---o\n"),
            ("invalid.txt", "invalid"),
        ]));
        let [open, closed, invalid] = list.entries() else { panic!() };
        assert_eq!((open.path.as_str(), open.maze.as_str()), ("a/open.txt", "open"));
        assert_eq!((open.width, open.height, open.shortest_path), (Some(2), Some(1), Some(1)));
        assert_eq!((closed.shortest_path, &closed.error), (None, &None));
        assert!(invalid.error.as_ref().unwrap().contains("invalid.txt: line 1"));
        assert_eq!(list.read("a/open.txt").unwrap().0, "open");
        for path in ["", "open", "../a/open.txt", "a/../a/open.txt", "/etc/passwd"] {
            let error = list.read(path).unwrap_err();
            assert_eq!(error.status, StatusCode::NOT_FOUND);
        }
        assert!(list.read("invalid.txt").is_err());
    }
}
