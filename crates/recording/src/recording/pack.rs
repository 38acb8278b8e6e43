//! Compresses closed recordings. Long recordings shrink to less than a tenth of their size.
//!
//! The compressed data is written to a temporary file in the folder of the recording. Once
//! complete, the temporary file replaces the recording. Therefore no state is lost, even if the
//! process is killed.

use std::ffi::OsStr;
use std::fs::{self, File, FileTimes};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use tempfile::{Builder, NamedTempFile};
use tracing::debug;

use crate::memory;
use crate::recording::format::Description;
use crate::recording::reader::{Contents, Integrity, RecordedState, read_states};
use crate::recording::save::{NewMessages, RecordWriter};
use crate::recording::sink::{Identity, identity};

/// Data shared with the thread that compresses recordings. A server uses this data to cancel
/// compression at shutdown.
#[derive(Default)]
pub(crate) struct Packing {
    is_cancelled: AtomicBool,
    /// The path of the temporary file that is being written.
    unfinished: Mutex<Option<PathBuf>>,
}

impl Packing {
    /// Creates a temporary file next to `path`. Fails if compression has been cancelled.
    fn start(&self, path: &Path) -> io::Result<NamedTempFile> {
        let mut unfinished = self.unfinished.lock().unwrap_or_else(PoisonError::into_inner);
        self.check()?;
        let (name, folder) = (path.file_name().unwrap_or_default(), path.with_file_name("."));
        let file = Builder::new().prefix(name).suffix(SUFFIX).tempfile_in(folder)?;
        *unfinished = Some(file.path().into());
        Ok(file)
    }

    fn check(&self) -> io::Result<()> {
        let is_cancelled = self.is_cancelled.load(Ordering::SeqCst);
        if is_cancelled { Err(io::ErrorKind::Interrupted.into()) } else { Ok(()) }
    }

    /// Removes the temporary file. The process may end before the background thread can do so.
    fn abandon(&self) {
        let mut unfinished = self.unfinished.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(path) = unfinished.take() {
            let _ = fs::remove_file(path);
        }
    }
}

/// The minimum number of states that a recording must have to be compressed.
const MIN_STATES: u32 = 8;

/// The approximate memory that compression needs, in bytes.
const WORKING_BYTES: usize = 8 << 20;

/// The maximum number of recordings in the queue. Recordings that are closed while the queue is
/// full stay uncompressed.
const MAX_QUEUED: usize = 1000;

/// The maximum time that shutdown waits for the queue to become empty.
const FINISH_TIMEOUT: Duration = Duration::from_secs(1);

/// The maximum time that shutdown waits for a cancelled compression to stop.
const CANCEL_TIMEOUT: Duration = Duration::from_millis(100);

/// The nice value of the background thread.
#[cfg(target_os = "linux")]
const NICE: i32 = 10;

/// The suffix of the temporary file.
const SUFFIX: &str = ".packing";

/// A closed recording that is not yet compressed.
pub(crate) struct Unpacked {
    pub(crate) path: PathBuf,
    pub(crate) identity: Identity,
    /// The number of states that were written successfully.
    pub(crate) states: u32,
    /// The messages for other tools in the compressed recording.
    pub(crate) messages: Option<NewMessages>,
}

impl Unpacked {
    /// Compresses the recording. The file stays unchanged if compression fails or is cancelled.
    pub(crate) fn pack(&self, packing: &Packing) -> io::Result<()> {
        let Self { path, identity: expected, states, messages } = self;
        if *states < MIN_STATES {
            return Ok(());
        }
        if !memory::is_available(WORKING_BYTES) {
            return Err(io::ErrorKind::OutOfMemory.into());
        }
        let is_same = || -> io::Result<_> { Ok(identity(&fs::metadata(path)?) == *expected) };
        // Another program may have replaced the recording by a FIFO, which would block.
        if !is_same()? {
            return Err(io::ErrorKind::NotFound.into());
        }
        let original = File::open(path)?;
        let metadata = original.metadata()?;
        let target = packing.start(path)?;
        // The lock keeps another server that starts in this folder from removing the file.
        target.as_file().try_lock()?;
        let mut writer = None;
        let read = read_states(original, |description, RecordedState { time, update, state }| {
            packing.check()?;
            if writer.is_none() {
                let Description { info, maze, .. } = description;
                let to = BufWriter::new(target.as_file());
                let new = RecordWriter::new(to, true, info, maze.as_ref(), time, *messages)?;
                writer = Some(new);
            }
            Ok(writer.as_mut().map_or(Ok(()), |writer| writer.write(time, update, state))?)
        });
        let Contents { trailing, integrity, .. } = read.map_err(io::Error::other)?;
        let found = writer.as_ref().map_or(0, |writer| writer.states);
        let is_complete = found == *states && !matches!(integrity, Integrity::Damaged { .. });
        let Some(mut writer) = writer.filter(|_| is_complete) else {
            return Err(io::Error::other(format!("expected {states} states, found {found}")));
        };
        writer.write_trailing(&trailing)?;
        writer.finish()?;
        target.as_file().set_permissions(metadata.permissions())?;
        // The page shows the modification time as the time of the recording.
        let times = FileTimes::new().set_modified(metadata.modified()?);
        target.as_file().set_times(times)?;
        target.as_file().sync_all()?;
        // Another program may have removed or replaced the recording.
        if !is_same()? {
            return Err(io::ErrorKind::NotFound.into());
        }
        target.persist(path)?;
        Ok(())
    }
}

/// A background thread that compresses recordings one at a time, at a low priority on Linux.
pub(crate) struct Packer {
    queue: SyncSender<Unpacked>,
    packing: Arc<Packing>,
    /// A channel that is disconnected when the thread ends.
    done: Receiver<()>,
}

impl Packer {
    /// Starts the thread. When `start` returns, the allocator has reserved the thread's share of the
    /// address space (64 MiB with glibc).
    ///
    /// # Errors
    /// Returns an error if the thread cannot be created.
    pub(crate) fn start() -> io::Result<Self> {
        let (queue, next) = mpsc::sync_channel::<Unpacked>(MAX_QUEUED);
        let (busy, done) = mpsc::channel();
        let packing = Arc::new(Packing::default());
        let shared = Arc::clone(&packing);
        thread::Builder::new().name("packer".into()).spawn(move || {
            let _ = busy.send(());
            // The priority is not the lowest, because shutdown waits only one second for this
            // thread. Only Linux has priorities for threads.
            #[cfg(target_os = "linux")]
            let _ = rustix::process::setpriority_process(None, NICE);
            for unpacked in next {
                if let Err(error) = unpacked.pack(&shared) {
                    debug!("{} stays uncompressed: {error}", unpacked.path.display());
                }
            }
        })?;
        let _ = done.recv();
        Ok(Self { queue, packing, done })
    }

    /// Queues a recording for compression. If the queue is full, the recording stays uncompressed.
    pub(crate) fn pack(&self, unpacked: Unpacked) {
        if let Err(error) = self.queue.try_send(unpacked) {
            debug!("cannot compress a recording: {error}");
        }
    }

    /// Waits up to one second for queued recordings to be compressed. The remaining recordings stay
    /// uncompressed.
    pub(crate) fn finish(self) {
        let Self { queue, packing, done } = self;
        drop(queue);
        if done.recv_timeout(FINISH_TIMEOUT) == Err(RecvTimeoutError::Timeout) {
            packing.is_cancelled.store(true, Ordering::SeqCst);
            let _ = done.recv_timeout(CANCEL_TIMEOUT);
            packing.abandon();
        }
    }
}

/// Removes the temporary files that a killed process left in `folder`.
pub(crate) fn remove_unfinished(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
        // Opening a FIFO would block.
        let is_unfinished =
            name.ends_with(SUFFIX) && name.contains(".mcap") && entry.file_type()?.is_file();
        // A process locks the temporary file that it is writing.
        if is_unfinished && File::open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    #[cfg(unix)]
    use std::process::Command;
    use std::time::SystemTime;

    use mcap::records::MessageHeader;
    use mmsim_maze::{Maze, MazeSize, Walls, WyRand};
    use mmsim_protocol::{Cell, Info, state_bytes};

    use super::*;
    use crate::context::update::TrailingAnnotations;
    use crate::mcap::reader::MAX_COMPRESSION_RATIO;
    use crate::recording::Recording;
    use crate::recording::format::{INFO, METADATA, STATES};
    use crate::recording::save::save;
    use crate::recording::writer::RecordingWriter;

    fn open_maze(size: MazeSize) -> Maze {
        Maze::new(Walls::open(size), Cell::new(0, 0), size.central_cells()).unwrap()
    }

    fn info(maze: &Maze) -> Info {
        Info::new("open", maze.size(), maze.start(), maze.goals(), 0)
    }

    /// Returns the state with this number. As in a real search, consecutive states differ little.
    fn state(number: u32) -> Vec<u8> {
        let [low, high, ..] = number.to_le_bytes();
        let mut state = vec![7; state_bytes(MazeSize::CLASSIC)];
        state[..5].copy_from_slice(&[b'S', low % 16, high % 16, b'N', b'C']);
        state[5 + usize::from(low)] = high;
        state[261] = b'F';
        state
    }

    /// Returns a closed recording with this many states.
    fn unpacked(folder: &Path, states: u32) -> Unpacked {
        let (path, maze) = (folder.join("a.mcap"), open_maze(MazeSize::CLASSIC));
        let mut writer = RecordingWriter::create(&path, &info(&maze), Some(&maze)).unwrap();
        for number in 0..states {
            let update: &[u8] = if number % 100 == 7 { b"N" } else { b"" };
            writer.write_with_update(update, &state(number)).unwrap();
        }
        let (unpacked, closed) = writer.close_unpacked();
        closed.unwrap();
        unpacked
    }

    fn files(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn compression_preserves_the_recording() {
        let folder = tempfile::tempdir().unwrap();
        let unpacked = unpacked(folder.path(), 5000);
        let then = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
        let original = File::options().write(true).open(&unpacked.path).unwrap();
        original.set_modified(then).unwrap();
        let before = (Recording::open(&unpacked.path).unwrap(), original.metadata().unwrap());
        // Windows does not replace an open file.
        drop(original);
        unpacked.pack(&Packing::default()).unwrap();

        let after = Recording::open(&unpacked.path).unwrap();
        assert_eq!((after.info(), after.maze()), (before.0.info(), before.0.maze()));
        assert!(after.history().iter().eq((0..5000).map(state)));
        assert!(after.times().iter().eq(before.0.times().iter()));
        for index in (0..5000).step_by(49) {
            assert_eq!(after.history().context(index), before.0.history().context(index));
        }
        assert_eq!(after.maze(), Some(&open_maze(MazeSize::CLASSIC)));
        assert_eq!(*after.integrity(), Integrity::Closed);
        let metadata = fs::metadata(&unpacked.path).unwrap();
        assert!(metadata.len() * 10 < before.1.len(), "{} bytes", metadata.len());
        assert_eq!(metadata.modified().unwrap(), then);
        assert_eq!(metadata.permissions(), before.1.permissions());
        assert_eq!(files(folder.path()), 1);
    }

    #[test]
    fn other_tools_read_a_compressed_recording() {
        let folder = tempfile::tempdir().unwrap();
        let unpacked = unpacked(folder.path(), 5000);
        unpacked.pack(&Packing::default()).unwrap();
        let bytes = fs::read(&unpacked.path).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        // Readers that find only one of the two kinds of index show nothing.
        assert!(summary.chunk_indexes.is_empty());
        let statistics = summary.stats.unwrap();
        assert_eq!((statistics.message_count, statistics.chunk_count), (5051, 3));
        let mut states = 0;
        for message in mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
            match &*message.channel.topic {
                "/state" => {
                    assert_eq!(*message.data, state(states));
                    assert_eq!(message.sequence, states);
                    states += 1;
                }
                "/update" => {
                    assert_eq!((&*message.data, message.sequence), (&b"N"[..], states));
                    assert_eq!(states % 100, 7);
                }
                topic => assert_eq!((topic, states), ("/maze", 0)),
            }
        }
        assert_eq!(states, 5000);
    }

    /// Identical states have the highest compression ratio. This ratio must stay below the limit
    /// that guards against decompression bombs.
    #[test]
    fn identical_states_stay_below_the_maximum_compression_ratio() {
        let size = MazeSize::HALF_SIZE;
        let mut state = vec![7; state_bytes(size)];
        state[..5].copy_from_slice(b"S\0\0NC");
        state[5 + size.area()] = b'F';
        let (info, count) = (info(&open_maze(size)), 20_000_u64);
        let mut file = io::Cursor::new(Vec::new());
        let states = (0..count).map(|number| (1 << 60 | number << 14, [], &state));
        save(&mut file, &info, None, states, &TrailingAnnotations::default()).unwrap();
        let bytes = file.into_inner().len() as u64;
        let unpacked = count * (state.len() as u64 + 31);
        assert!(unpacked / bytes < MAX_COMPRESSION_RATIO, "{} times smaller", unpacked / bytes);
    }

    /// Returns a compressed recording of `count` identical states at these times.
    fn identical_states(count: u64, time: impl Fn(u64) -> u64) -> Vec<u8> {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let mut file = io::Cursor::new(Vec::new());
        let states = (0..count).map(|number| (time(number), [], b"S\0\0NC\x01\0C\x0d\0"));
        save(&mut file, &info(&maze), Some(&maze), states, &TrailingAnnotations::default())
            .unwrap();
        file.into_inner()
    }

    #[test]
    fn a_small_file_with_many_states_is_refused() {
        // The same message again and again, which needs almost no space.
        let options = mcap::WriteOptions::new().emit_message_indexes(false);
        let mut mcap = options.create(io::Cursor::new(Vec::new())).unwrap();
        let info = serde_json::to_string(&info(&open_maze(MazeSize::new(2, 1).unwrap()))).unwrap();
        let metadata = [(INFO.to_string(), info)].into();
        mcap.write_metadata(&mcap::records::Metadata { name: METADATA.into(), metadata }).unwrap();
        let [topic, encoding] = STATES;
        let channel = mcap.add_channel(0, topic, encoding, &BTreeMap::new()).unwrap();
        let header =
            MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
        for _ in 0..1_000_000 {
            mcap.write_to_known_channel(&header, b"S\0\0NC\x01\0C\x0d\0").unwrap();
        }
        mcap.finish().unwrap();
        let bytes = mcap.into_inner().into_inner();
        let read = Recording::read(&bytes[..]).map(|read| read.history().len());
        let error = read.unwrap_err().to_string();
        assert!(error.starts_with("cannot be opened: more than 1"), "{error}");
        // The times of a real clock are irregular.
        let mut random = WyRand::new(1);
        let jitter: Vec<u64> = (0..500_000).map(|_| u64::from(random.next_u32() >> 20)).collect();
        let bytes = identical_states(500_000, |number| {
            number * 10_000 + jitter[usize::try_from(number).unwrap()]
        });
        assert_eq!(Recording::read(&bytes[..]).unwrap().history().len(), 500_000);
        assert!(bytes.len() > 1_000_000, "{} bytes", bytes.len());
    }

    #[test]
    fn a_recording_stays_unchanged_if_compression_fails() {
        let folder = tempfile::tempdir().unwrap();
        let Unpacked { path, identity: (device, file), states, messages } =
            unpacked(folder.path(), 100);
        let bytes = fs::read(&path).unwrap();
        let pack = |states, identity, cancelled: bool| {
            let unpacked = Unpacked { path: path.clone(), identity, states, messages };
            let packing = Packing { is_cancelled: cancelled.into(), ..Packing::default() };
            let packed = unpacked.pack(&packing);
            assert!(fs::read(&path).unwrap() == bytes);
            assert_eq!(files(folder.path()), 1);
            packed
        };
        assert!(pack(states, (device, file), true).is_err());
        assert!(pack(states + 1, (device, file), false).is_err(), "a state is missing");
        assert!(pack(states - 1, (device, file), false).is_err(), "an extra state");
        assert!(pack(states, (device, file ^ 1), false).is_err(), "another file");
        assert!(pack(MIN_STATES - 1, (device, file), false).is_ok(), "too few states");
    }

    #[test]
    #[cfg_attr(windows, ignore = "Wine renames an open file that has been removed")]
    fn an_abandoned_packer_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let recording = unpacked(folder.path(), 100).path;
        let packing = Packing::default();
        let target = packing.start(&recording).unwrap();
        assert_eq!(files(folder.path()), 2);
        packing.is_cancelled.store(true, Ordering::SeqCst);
        packing.abandon();
        assert_eq!(files(folder.path()), 1);
        assert!(packing.start(&recording).is_err());
        assert!(target.persist(&recording).is_err(), "too late");
        assert_eq!(Recording::open(&recording).unwrap().history().len(), 100);
    }

    #[test]
    fn queued_recordings_are_compressed_in_the_background() {
        let folders: Vec<_> = (0..20).map(|_| tempfile::tempdir().unwrap()).collect();
        let packer = Packer::start().unwrap();
        for folder in &folders {
            packer.pack(unpacked(folder.path(), 100));
        }
        let Packer { queue, done, .. } = packer;
        drop(queue);
        assert_eq!(
            done.recv_timeout(Duration::from_secs(300)),
            Err(RecvTimeoutError::Disconnected)
        );
        for folder in &folders {
            let path = folder.path().join("a.mcap");
            assert!(Recording::open(&path).unwrap().history().iter().eq((0..100).map(state)));
            assert!(fs::metadata(&path).unwrap().len() < 10_000);
            assert_eq!(files(folder.path()), 1);
        }
    }

    #[cfg(unix)]
    #[test]
    fn special_files_do_not_block() {
        let folder = tempfile::tempdir().unwrap();
        let fifo = folder.path().join("a.mcapXyz123.packing");
        assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        let (sender, done) = mpsc::channel();
        let path = folder.path().to_path_buf();
        // A thread that waits for a writer of the FIFO would never end.
        thread::spawn(move || drop(sender.send(remove_unfinished(&path))));
        done.recv_timeout(Duration::from_secs(300)).expect("must not block").unwrap();
        assert!(fs::exists(&fifo).unwrap(), "not a temporary file of a recording");
        let unpacked = unpacked(folder.path(), 100);
        fs::rename(&fifo, &unpacked.path).unwrap();
        let (sender, done) = mpsc::channel();
        thread::spawn(move || drop(sender.send(unpacked.pack(&Packing::default()))));
        done.recv_timeout(Duration::from_secs(300)).expect("must not block").unwrap_err();
    }

    #[test]
    fn leftovers_of_a_killed_server_are_removed() {
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
