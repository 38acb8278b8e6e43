//! Packs closed recordings: less than a tenth of the bytes, the same states.
//!
//! The packed file is written beside the recording and takes its place once it is whole, so every
//! state is in the file of this name at any time, however the process ends.

use std::ffi::OsStr;
use std::fs::{self, File, FileTimes};
use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use mcap::McapError;
use tempfile::{Builder, NamedTempFile};
use tracing::debug;

use super::reader::{STEP_BYTES, read_states};
use super::save::{PackedWriter, cause};
use super::writer::{Identity, identity};
use super::{Ending, NoRecording};
use crate::memory;

/// State shared by the packer and a server that shuts down.
#[derive(Default)]
pub(super) struct Packing {
    is_cancelled: AtomicBool,
    /// Path of the temporary file being written.
    unfinished: Mutex<Option<PathBuf>>,
}

impl Packing {
    /// Creates a temporary file next to `path`. Fails once packing is cancelled.
    fn begin(&self, path: &Path) -> io::Result<NamedTempFile> {
        let mut unfinished = self.unfinished.lock().unwrap_or_else(PoisonError::into_inner);
        self.check()?;
        let name = path.file_name().unwrap_or_default();
        let file = Builder::new().prefix(name).suffix(UNFINISHED).tempfile_in(folder(path))?;
        *unfinished = Some(file.path().into());
        Ok(file)
    }

    fn check(&self) -> io::Result<()> {
        let is_cancelled = self.is_cancelled.load(Ordering::SeqCst);
        if is_cancelled { Err(io::ErrorKind::Interrupted.into()) } else { Ok(()) }
    }

    fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::SeqCst);
    }

    /// Removes the temporary file if the packer cannot do so before the process ends.
    fn abandon(&self) {
        let mut unfinished = self.unfinished.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(path) = unfinished.take() {
            let _ = fs::remove_file(path);
        }
    }
}

/// Fewer states are not worth packing: they take no more than a file system's block.
const MIN_STATES: u32 = 8;

/// What packing needs in memory, about, in bytes.
const WORKING_BYTES: usize = 8 << 20;

/// Recordings that wait to be packed; further ones stay as they are.
const MAX_WAITING: usize = 1000;

/// How long the end of a server waits for the recordings that are not packed yet …
const PATIENCE: Duration = Duration::from_secs(1);

/// … and for the one that is not packed by then to be given up.
const GIVE_UP: Duration = Duration::from_millis(100);

/// How the name ends of a file that is being written in place of a recording.
const UNFINISHED: &str = ".packing";

/// A closed recording whose states are not packed.
pub(super) struct Unpacked {
    pub(super) path: PathBuf,
    pub(super) identity: Identity,
    /// How many states were acknowledged.
    pub(super) states: u32,
}

impl Unpacked {
    /// Packs the recording, unless that fails or is cancelled. It stays as it is then.
    pub(super) fn pack(&self, packing: &Packing) -> io::Result<()> {
        let Self { path, identity: expected, states } = self;
        if *states < MIN_STATES {
            return Ok(());
        }
        if !memory::is_available(WORKING_BYTES) {
            return Err(io::ErrorKind::OutOfMemory.into());
        }
        let original = File::open(path)?;
        let metadata = original.metadata()?;
        let beside = packing.begin(path)?;
        // Tells a server that starts in this folder that somebody still writes it.
        beside.as_file().try_lock()?;
        let (mut writer, mut count) = (None, 0);
        let original = BufReader::with_capacity(STEP_BYTES, original);
        let read = read_states(original, |description, state, time| {
            packing.check()?;
            let mut add = || -> Result<(), McapError> {
                let writer = match &mut writer {
                    Some(writer) => writer,
                    none => none.insert(PackedWriter::new(
                        BufWriter::new(beside.as_file()),
                        &description.info,
                        description.maze.as_ref(),
                    )?),
                };
                writer.write(time, state)
            };
            count += 1;
            add().map_err(|error| cause(error).into())
        });
        let (_, ending) = read.map_err(|error| match error {
            NoRecording::Io(error) => error,
            error => io::Error::other(error.to_string()),
        })?;
        let is_whole = count == *states && !matches!(ending, Ending::Damaged { .. });
        let Some(writer) = writer.filter(|_| is_whole) else {
            return Err(io::Error::other(format!("{count} states in place of {states}")));
        };
        drop(writer.finish().map_err(cause)?);
        beside.as_file().set_permissions(metadata.permissions())?;
        // The page shows when a recording was last written.
        let times = FileTimes::new().set_modified(metadata.modified()?);
        beside.as_file().set_times(times)?;
        beside.as_file().sync_all()?;
        // Somebody may have removed it, or put another one there.
        if identity(&fs::metadata(path)?) != *expected {
            return Err(io::ErrorKind::NotFound.into());
        }
        beside.persist(path)?;
        Ok(())
    }
}

/// Packs recordings one after the other, in the background, on Linux at a low priority.
pub(super) struct Packer {
    waiting: SyncSender<Unpacked>,
    packing: Arc<Packing>,
    /// Disconnected when all is done.
    done: Receiver<()>,
}

impl Packer {
    /// Begins with nothing to do.
    ///
    /// # Errors
    /// The system has no thread left.
    pub(super) fn start() -> io::Result<Self> {
        let (waiting, next) = mpsc::sync_channel::<Unpacked>(MAX_WAITING);
        let (busy, done) = mpsc::channel();
        let packing = Arc::new(Packing::default());
        let shared = Arc::clone(&packing);
        thread::Builder::new().name("packer".into()).spawn(move || {
            let _busy: mpsc::Sender<()> = busy;
            lower_priority();
            for unpacked in next {
                if let Err(error) = unpacked.pack(&shared) {
                    debug!("{} stays unpacked: {error}", unpacked.path.display());
                }
            }
        })?;
        Ok(Self { waiting, packing, done })
    }

    /// Packs this one as soon as those before it are packed. If too many wait, it stays as it is.
    pub(super) fn pack(&self, unpacked: Unpacked) {
        if let Err(error) = self.waiting.try_send(unpacked) {
            debug!("a recording stays unpacked: {error}");
        }
    }

    /// Waits until all are packed, for a second. Those that are not stay as they are.
    pub(super) fn finish(self) {
        let Self { waiting, packing, done } = self;
        drop(waiting);
        if done.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
            packing.cancel();
            let _ = done.recv_timeout(GIVE_UP);
            packing.abandon();
        }
    }
}

/// Removes what a server that was killed while it packed has left in this folder.
pub(super) fn remove_unfinished(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
        let is_unfinished = name.ends_with(UNFINISHED) && name.contains(".mcap");
        // Another server holds a lock on the one that it writes.
        if is_unfinished && File::open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Lowers the priority of this thread, but not to the minimum: a server that shuts down waits only a
/// second for it. Only Linux has a priority for each thread.
fn lower_priority() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, NICE);
}

#[cfg(target_os = "linux")]
const NICE: i32 = 10;

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use mmsim_maze::{Maze, MazeSize, Walls};
    use mmsim_protocol::{Cell, state_bytes};

    use super::super::reader::MAX_UNPACKED_FOR_EACH;
    use super::*;
    use crate::{Recording, RecordingWriter, Simulation};

    fn simulation() -> Simulation {
        let size = MazeSize::CLASSIC;
        let maze = Maze::new(Walls::open(size), Cell::new(0, 0), size.central_cells()).unwrap();
        Simulation::new("open", maze)
    }

    /// A state like those of a search: little changes from one to the next.
    fn state(number: u32) -> Vec<u8> {
        let [low, high, ..] = number.to_le_bytes();
        let mut state = vec![7; state_bytes(MazeSize::CLASSIC)];
        state[..5].copy_from_slice(&[b'S', low % 16, high % 16, b'N', b'C']);
        state[5 + usize::from(low)] = high;
        state[261] = b'F';
        state
    }

    /// A closed recording of so many states, as it was written.
    fn unpacked(folder: &Path, states: u32) -> Unpacked {
        let (path, simulation) = (folder.join("a.mcap"), simulation());
        let mut writer =
            RecordingWriter::create(&path, &simulation.info(), Some(simulation.maze())).unwrap();
        for number in 0..states {
            writer.write(&state(number)).unwrap();
        }
        let (unpacked, closed) = writer.close_unpacked();
        closed.unwrap();
        unpacked
    }

    fn files(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn a_packed_recording_is_the_same_recording() {
        let folder = tempfile::tempdir().unwrap();
        let unpacked = unpacked(folder.path(), 5000);
        let then = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
        let original = File::options().write(true).open(&unpacked.path).unwrap();
        original.set_modified(then).unwrap();
        let before = (Recording::open(&unpacked.path).unwrap(), original.metadata().unwrap());
        unpacked.pack(&Packing::default()).unwrap();

        let after = Recording::open(&unpacked.path).unwrap();
        assert_eq!((after.info(), after.maze()), (before.0.info(), before.0.maze()));
        assert!(after.history().iter().eq((0..5000).map(state)));
        assert!(after.times().iter().eq(before.0.times().iter()));
        assert_eq!((after.ending(), after.maze()), (&Ending::Closed, Some(simulation().maze())));
        let metadata = fs::metadata(&unpacked.path).unwrap();
        assert!(metadata.len() * 10 < before.1.len(), "{} bytes", metadata.len());
        assert_eq!(metadata.modified().unwrap(), then);
        assert_eq!(metadata.permissions(), before.1.permissions());
        assert_eq!(files(folder.path()), 1);
    }

    #[test]
    fn other_tools_read_a_packed_recording_from_the_beginning_to_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let unpacked = unpacked(folder.path(), 5000);
        unpacked.pack(&Packing::default()).unwrap();
        let bytes = fs::read(&unpacked.path).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        // Readers that find an index of one kind but not the other show nothing at all.
        assert!(summary.chunk_indexes.is_empty());
        let statistics = summary.stats.unwrap();
        assert_eq!((statistics.message_count, statistics.chunk_count), (5001, 3));
        let mut states = 0;
        for message in mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
            match &*message.channel.topic {
                "/state" => {
                    assert_eq!(*message.data, state(states));
                    assert_eq!(message.sequence, states);
                    states += 1;
                }
                topic => assert_eq!((topic, states), ("/maze", 0)),
            }
        }
        assert_eq!(states, 5000);
    }

    /// The most that packing can gain must not look like a file that was made to fill memory.
    #[test]
    fn the_same_state_again_and_again_is_read_however_well_it_is_packed() {
        let size = MazeSize::HALF_SIZE;
        let maze = Maze::new(Walls::open(size), Cell::new(0, 0), size.central_cells()).unwrap();
        let mut state = vec![7; state_bytes(size)];
        state[..5].copy_from_slice(b"S\0\0NC");
        state[5 + size.area()] = b'F';
        let (info, count) = (Simulation::new("", maze).info(), 20_000_u64);
        let mut file = io::Cursor::new(Vec::new());
        let states = (0..count).map(|number| (1 << 60 | number << 14, &state));
        crate::save_recording(&mut file, &info, None, states).unwrap();
        let bytes = file.into_inner().len() as u64;
        let unpacked = count * (state.len() as u64 + 31);
        assert!(unpacked / bytes < MAX_UNPACKED_FOR_EACH, "{} times smaller", unpacked / bytes);
    }

    #[test]
    fn what_cannot_be_packed_stays_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let Unpacked { path, identity: (device, file), states } = unpacked(folder.path(), 100);
        let bytes = fs::read(&path).unwrap();
        let pack = |states, identity, cancelled: bool| {
            let unpacked = Unpacked { path: path.clone(), identity, states };
            let packing = Packing { is_cancelled: cancelled.into(), ..Packing::default() };
            let packed = unpacked.pack(&packing);
            assert!(fs::read(&path).unwrap() == bytes);
            assert_eq!(files(folder.path()), 1);
            packed
        };
        assert!(pack(states, (device, file), true).is_err());
        assert!(pack(states + 1, (device, file), false).is_err(), "a state is missing");
        assert!(pack(states - 1, (device, file), false).is_err(), "one too many");
        assert!(pack(states, (device, file ^ 1), false).is_err(), "another file");
        assert!(pack(MIN_STATES - 1, (device, file), false).is_ok(), "not worth it");
    }

    #[test]
    fn a_packer_that_is_abandoned_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let recording = unpacked(folder.path(), 100).path;
        let packing = Packing::default();
        let beside = packing.begin(&recording).unwrap();
        assert_eq!(files(folder.path()), 2);
        packing.cancel();
        packing.abandon();
        assert_eq!(files(folder.path()), 1);
        assert!(packing.begin(&recording).is_err());
        assert!(beside.persist(&recording).is_err(), "too late");
        assert_eq!(Recording::open(&recording).unwrap().history().len(), 100);
    }

    #[test]
    fn recordings_that_wait_are_packed_in_the_background() {
        let folders: Vec<_> = (0..20).map(|_| tempfile::tempdir().unwrap()).collect();
        let packer = Packer::start().unwrap();
        for folder in &folders {
            packer.pack(unpacked(folder.path(), 100));
        }
        let Packer { waiting, done, .. } = packer;
        drop(waiting);
        assert_eq!(done.recv_timeout(Duration::from_secs(60)), Err(RecvTimeoutError::Disconnected));
        for folder in &folders {
            let path = folder.path().join("a.mcap");
            assert!(Recording::open(&path).unwrap().history().iter().eq((0..100).map(state)));
            assert!(fs::metadata(&path).unwrap().len() < 10_000);
            assert_eq!(files(folder.path()), 1);
        }
    }

    #[test]
    fn what_a_killed_server_has_left_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| {
            let path = folder.path().join(name);
            fs::write(&path, "").unwrap();
            path
        };
        let left = write("a.mcapXyz123.packing");
        let others = ["a.mcap", "notes.packing", "b.mcap.packing.txt"].map(write);
        let busy = write("b.mcapXyz123.packing");
        let lock = File::open(&busy).unwrap();
        lock.try_lock().unwrap();
        remove_unfinished(folder.path()).unwrap();
        assert!(!left.exists() && busy.exists() && others.iter().all(|path| path.exists()));
        drop(lock);
        remove_unfinished(folder.path()).unwrap();
        assert!(!busy.exists());
    }
}
