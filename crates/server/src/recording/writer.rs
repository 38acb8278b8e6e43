//! Writes a recording, a state at a time.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use mcap::McapError;
use mcap::records::MessageHeader;
use mmsim_maze::Maze;
use mmsim_protocol::Info;

use super::RecordError;
use super::save::{cause, describe, options};

/// Writes a recording. Each state is handed to the operating system before [`write`](Self::write)
/// returns, so it survives the end of the process in any way, though not that of the machine.
///
/// Closed when dropped, but only [`close`](Self::close) tells whether that went well. A recording
/// that is not closed can be read all the same.
pub struct RecordingWriter {
    path: PathBuf,
    /// Which file that was when it was created.
    identity: (u64, u64),
    /// `None` once it is closed.
    mcap: Option<mcap::Writer<Sink<File>>>,
    channel: u16,
    began: (Instant, u64),
    states: u32,
    /// Whether a state was refused. The counts that close a file would be wrong then, so it is left
    /// as it is.
    refused: bool,
}

impl RecordingWriter {
    /// Begins a recording in a new file, of the simulation that `info` tells of. The true maze
    /// belongs into it where it is known.
    ///
    /// # Errors
    /// The file exists, or cannot be created or written.
    pub fn create(path: &Path, info: &Info, maze: Option<&Maze>) -> Result<Self, RecordError> {
        let file = File::create_new(path).map_err(|error| RecordError::io(path, error))?;
        Self::begin(file, path, info, maze).map_err(|error| {
            // It holds nothing.
            let _ = fs::remove_file(path);
            RecordError::io(path, cause(error))
        })
    }

    fn begin(file: File, path: &Path, info: &Info, maze: Option<&Maze>) -> Result<Self, McapError> {
        // A chunk would hold states back until it is full.
        let options = options().use_chunks(false).compression(None);
        let identity = identity(&file.metadata()?);
        let mut mcap = options.create(Sink::new(file))?;
        let channel = describe(&mut mcap, info, maze)?;
        mcap.flush()?;
        let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let began = (Instant::now(), u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX));
        let path = path.into();
        Ok(Self { path, identity, mcap: Some(mcap), channel, began, states: 0, refused: false })
    }

    /// Records a state, the bytes of its message, with the time.
    ///
    /// # Errors
    /// The file has gone, or cannot be written; the state is not in it then, and those before it
    /// are. A later one may be recorded again.
    pub fn write(&mut self, state: &[u8]) -> Result<(), RecordError> {
        // A file that is deleted can still be written, and nobody would ever see it.
        let gone = match fs::metadata(&self.path) {
            Ok(metadata) => identity(&metadata) != self.identity,
            Err(error) => error.kind() == io::ErrorKind::NotFound,
        };
        if gone {
            return Err(RecordError::Gone { path: self.path.clone() });
        }
        let (since, began) = self.began;
        let nanoseconds = u64::try_from(since.elapsed().as_nanos()).unwrap_or(u64::MAX);
        let time = began.saturating_add(nanoseconds);
        let header = MessageHeader {
            channel_id: self.channel,
            sequence: self.states,
            log_time: time,
            publish_time: time,
        };
        let Some(mcap) = &mut self.mcap else { return Ok(()) };
        let written = mcap.write_to_known_channel(&header, state).and_then(|()| mcap.flush());
        self.refused |= written.is_err();
        written.map_err(|error| RecordError::io(&self.path, cause(error)))?;
        self.states = self.states.wrapping_add(1);
        Ok(())
    }

    /// Closes the recording, with the summary that makes it quick to open.
    ///
    /// # Errors
    /// The summary cannot be written. All states can be read nevertheless.
    pub fn close(mut self) -> Result<(), RecordError> {
        self.finish().map_err(|error| RecordError::io(&self.path, cause(error)))
    }

    fn finish(&mut self) -> Result<(), McapError> {
        match self.mcap.take() {
            Some(mut mcap) if !self.refused => {
                mcap.finish()?;
                Ok(mcap.into_inner().flush()?)
            }
            // Dropped as it is, it would be given the summary.
            Some(mcap) => {
                mcap.into_inner();
                Ok(())
            }
            None => Ok(()),
        }
    }
}

impl Drop for RecordingWriter {
    fn drop(&mut self) {
        let _ = self.finish();
    }
}

/// What tells a file from another of the same name, where the system has such a thing.
#[cfg(unix)]
fn identity(metadata: &fs::Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

#[cfg(not(unix))]
fn identity(_: &fs::Metadata) -> (u64, u64) {
    (0, 0)
}

/// What can be written, and cut off again.
trait Storage: Write {
    /// Leaves only the first `length` bytes and writes on after them.
    fn cut(&mut self, length: u64) -> io::Result<()>;
}

impl Storage for File {
    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)?;
        self.seek(SeekFrom::Start(length)).map(|_| ())
    }
}

/// Gathers what is written until it is flushed, then writes all of it or nothing.
struct Sink<S> {
    storage: S,
    /// Bytes in the storage that count.
    whole: u64,
    gathered: Vec<u8>,
    /// Whether the storage has bytes that do not count and could not be cut off.
    torn: bool,
}

impl<S: Storage> Sink<S> {
    const fn new(storage: S) -> Self {
        Self { storage, whole: 0, gathered: Vec::new(), torn: false }
    }

    fn write_gathered(&mut self) -> io::Result<()> {
        if self.torn {
            self.storage.cut(self.whole)?;
            self.torn = false;
        }
        let written = self.storage.write_all(&self.gathered);
        match &written {
            Ok(()) => self.whole += self.gathered.len() as u64,
            Err(_) => self.torn = self.storage.cut(self.whole).is_err(),
        }
        written
    }
}

impl<S: Storage> Write for Sink<S> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.gathered.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let written = self.write_gathered();
        self.gathered.clear();
        written
    }
}

impl<S> Seek for Sink<S> {
    /// Tells where it is; that is all that is asked of it.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.whole + self.gathered.len() as u64),
            _ => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk with room for so many bytes; `stuck` while nothing can be cut off.
    struct Disk {
        bytes: Vec<u8>,
        room: usize,
        stuck: bool,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let count = bytes.len().min(self.room - self.bytes.len());
            if count == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.bytes.extend_from_slice(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Storage for Disk {
        fn cut(&mut self, length: u64) -> io::Result<()> {
            if self.stuck {
                return Err(io::ErrorKind::Other.into());
            }
            self.bytes.truncate(usize::try_from(length).unwrap());
            Ok(())
        }
    }

    #[test]
    fn what_does_not_fit_leaves_no_trace() {
        let mut sink = Sink::new(Disk { bytes: Vec::new(), room: 10, stuck: false });
        let put = |sink: &mut Sink<Disk>, bytes: &[u8]| {
            sink.write_all(bytes).unwrap();
            sink.flush()
        };
        put(&mut sink, b"abcdef").unwrap();
        assert!(put(&mut sink, b"ghijkl").is_err());
        assert_eq!(sink.stream_position().unwrap(), 6);
        assert_eq!(sink.storage.bytes, b"abcdef");
        sink.storage.stuck = true;
        assert!(put(&mut sink, b"mnopqr").is_err());
        assert_eq!(sink.storage.bytes, b"abcdefmnop");
        assert!(put(&mut sink, b"s").is_err(), "behind a torn record nothing could be read");
        sink.storage.stuck = false;
        put(&mut sink, b"tu").unwrap();
        assert_eq!(sink.storage.bytes, b"abcdeftu");
        sink.storage.room = 20;
        put(&mut sink, b"vwxyz!").unwrap();
        assert_eq!((sink.storage.bytes.len(), sink.stream_position().unwrap()), (14, 14));
    }
}
