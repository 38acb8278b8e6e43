//! Writes a recording, a state at a time.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::MessageHeader;
use mmsim_maze::Maze;
use mmsim_protocol::Info;
use tracing::debug;

use super::RecordError;
use super::pack::{Packing, Unpacked};
use super::save::{cause, describe, options, write_maze};
use crate::clock::Clock;

/// Writes a recording. Each state is handed to the operating system before [`write`](Self::write)
/// returns, so it survives the end of the process in any way, though not that of the machine.
///
/// Closed when dropped, but only [`close`](Self::close) tells whether that went well, and packs the
/// states. A recording that is not closed can be read all the same.
pub struct RecordingWriter {
    path: PathBuf,
    identity: Identity,
    /// `None` once it is closed.
    mcap: Option<mcap::Writer<Sink<RecordingFile>>>,
    channel: u16,
    clock: Clock,
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
        let file = create(path).map_err(|error| RecordError::new(path, error))?;
        Self::begin(file, path, info, maze).map_err(|error| {
            // It holds nothing.
            let _ = fs::remove_file(path);
            RecordError::new(path, cause(error))
        })
    }

    fn begin(file: File, path: &Path, info: &Info, maze: Option<&Maze>) -> Result<Self, McapError> {
        // A chunk would hold states back until it is full.
        let options = options().use_chunks(false).compression(None);
        let (path, identity) = (path.to_path_buf(), identity(&file.metadata()?));
        let mut mcap =
            options.create(Sink::new(RecordingFile { file, path: path.clone(), identity }))?;
        let (channel, clock) = (describe(&mut mcap, info)?, Clock::start());
        if let Some(maze) = maze {
            write_maze(&mut mcap, &maze.to_string(), clock.now())?;
        }
        mcap.flush()?;
        let mcap = Some(mcap);
        Ok(Self { path, identity, mcap, channel, clock, states: 0, refused: false })
    }

    /// Records a state, the bytes of its message, with the time.
    ///
    /// # Errors
    /// The file cannot be written, has gone, or was changed by another program; the state is not in
    /// it then. A later one may be recorded again.
    pub fn write(&mut self, state: &[u8]) -> Result<(), RecordError> {
        let time = self.clock.now();
        let header = MessageHeader {
            channel_id: self.channel,
            sequence: self.states,
            log_time: time,
            publish_time: time,
        };
        let Some(mcap) = &mut self.mcap else { return Ok(()) };
        let written = mcap.write_to_known_channel(&header, state).and_then(|()| mcap.flush());
        self.refused |= written.is_err();
        written.map_err(|error| RecordError::new(&self.path, cause(error)))?;
        self.states = self.states.wrapping_add(1);
        Ok(())
    }

    /// Closes the recording, with the summary that makes it quick to open, and packs its states,
    /// which takes about a second for a million. Where that fails they stay as they are.
    ///
    /// # Errors
    /// The summary cannot be written. All states can be read nevertheless.
    pub fn close(self) -> Result<(), RecordError> {
        let (unpacked, closed) = self.close_unpacked();
        if let Err(error) = unpacked.pack(&Packing::default()) {
            debug!("a recording stays unpacked: {error}");
        }
        closed
    }

    /// Closes the recording, whose states may be packed later.
    pub(super) fn close_unpacked(mut self) -> (Unpacked, Result<(), RecordError>) {
        let closed = self.finish().map_err(|error| RecordError::new(&self.path, cause(error)));
        let (path, identity) = (self.path.clone(), self.identity);
        (Unpacked { path, identity, states: self.states }, closed)
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

/// Creates the file. Where the system can do so, each record is appended to whatever is there by
/// then, so that the length afterwards tells whether another program has cut off something.
fn create(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    // Windows does not cut off a file that is open for appending.
    options.write(true).append(cfg!(unix)).create_new(true).open(path)
}

/// What tells a file from another of the same name, where the system has such a thing.
pub(super) type Identity = (u64, u64);

#[cfg(unix)]
pub(super) fn identity(metadata: &fs::Metadata) -> Identity {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

#[cfg(not(unix))]
pub(super) fn identity(_: &fs::Metadata) -> Identity {
    (0, 0)
}

/// What can be written, and cut off again.
trait Storage: Write {
    /// Returns the length in bytes, if what is written can be found where it belongs.
    fn length(&self) -> io::Result<u64>;

    /// Cuts off this many bytes at the end and writes on there.
    fn cut(&mut self, bytes: u64) -> io::Result<()>;
}

/// The file of a recording, which others can remove, replace and change.
struct RecordingFile {
    file: File,
    path: PathBuf,
    /// Which file that was when it was created.
    identity: Identity,
}

impl Write for RecordingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Storage for RecordingFile {
    fn length(&self) -> io::Result<u64> {
        // A file that is deleted can still be written, and nobody would ever see it.
        match fs::metadata(&self.path) {
            Ok(metadata) if identity(&metadata) == self.identity => Ok(metadata.len()),
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Ok(self.file.metadata()?.len())
            }
            _ => Err(io::Error::other("the file has gone; reset begins a new one")),
        }
    }

    fn cut(&mut self, bytes: u64) -> io::Result<()> {
        let length = self.file.metadata()?.len().saturating_sub(bytes);
        self.file.set_len(length)?;
        self.file.seek(SeekFrom::Start(length)).map(|_| ())
    }
}
/// Gathers what is written until it is flushed, then writes all of it or nothing.
struct Sink<S> {
    storage: S,
    /// Bytes in the storage that count.
    whole: u64,
    gathered: Vec<u8>,
    /// Bytes behind them that do not count, or not yet.
    torn: u64,
}

impl<S: Storage> Sink<S> {
    const fn new(storage: S) -> Self {
        Self { storage, whole: 0, gathered: Vec::new(), torn: 0 }
    }

    fn write_gathered(&mut self) -> io::Result<()> {
        self.cut_torn()?;
        let written = self.append().and_then(|()| self.check());
        match written {
            Ok(()) => (self.whole, self.torn) = (self.whole + self.torn, 0),
            // If it cannot be cut off now, then before the next record.
            Err(_) => drop(self.cut_torn()),
        }
        written
    }

    fn append(&mut self) -> io::Result<()> {
        let mut rest = &self.gathered[..];
        while !rest.is_empty() {
            match self.storage.write(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(count) => {
                    rest = &rest[count..];
                    self.torn += count as u64;
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Refuses what was written if anything before it is missing, or more is there.
    fn check(&self) -> io::Result<()> {
        let (expected, found) = (self.whole + self.torn, self.storage.length()?);
        if found == expected {
            return Ok(());
        }
        let change = format!("{found} bytes in place of {expected}; reset begins a new one");
        Err(io::Error::other(format!("another program has changed the file, which has {change}")))
    }

    fn cut_torn(&mut self) -> io::Result<()> {
        if self.torn > 0 {
            self.storage.cut(self.torn)?;
            self.torn = 0;
        }
        Ok(())
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
        fn length(&self) -> io::Result<u64> {
            Ok(self.bytes.len() as u64)
        }

        fn cut(&mut self, bytes: u64) -> io::Result<()> {
            if self.stuck {
                return Err(io::ErrorKind::Other.into());
            }
            self.bytes.truncate(self.bytes.len() - usize::try_from(bytes).unwrap());
            Ok(())
        }
    }

    fn put(sink: &mut Sink<Disk>, bytes: &[u8]) -> io::Result<()> {
        sink.write_all(bytes).unwrap();
        sink.flush()
    }

    #[test]
    fn what_does_not_fit_leaves_no_trace() {
        let mut sink = Sink::new(Disk { bytes: Vec::new(), room: 10, stuck: false });
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

    #[test]
    fn what_another_program_changes_is_noticed_and_not_added_to() {
        let mut sink = Sink::new(Disk { bytes: Vec::new(), room: 100, stuck: false });
        put(&mut sink, b"abcdef").unwrap();
        for changed in [&b"abc"[..], b"", b"abcdef?"] {
            sink.storage.bytes = changed.into();
            for _ in 0..2 {
                let error = put(&mut sink, b"ghi").unwrap_err().to_string();
                let found = format!("{} bytes in place of 9; reset", changed.len() + 3);
                assert!(error.contains(&found), "{error}");
                assert_eq!(sink.storage.bytes, changed);
            }
        }
        sink.storage.bytes = b"abcdef".into();
        put(&mut sink, b"ghi").unwrap();
        assert_eq!(sink.storage.bytes, b"abcdefghi");
    }
}
