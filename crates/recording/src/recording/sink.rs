//! Writes whole records to a file that other programs may change.

use std::fs::{self, File, Metadata, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The device number and the inode number of a file. These numbers distinguish the file from
/// another file with the same name. On systems without inodes, the device number and the inode
/// number are 0.
pub(crate) type Identity = (u64, u64);

#[cfg(unix)]
pub(crate) fn identity(metadata: &Metadata) -> Identity {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

#[cfg(not(unix))]
pub(crate) fn identity(_: &Metadata) -> Identity {
    (0, 0)
}

/// Returns true if a process is writing the recording at `path`. Always returns false on Windows,
/// where such a file can be neither removed nor renamed.
pub fn is_being_written(path: &Path) -> bool {
    let is_locked = |file: File| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
    cfg!(unix) && File::open(path).is_ok_and(is_locked)
}

/// A file that supports appending and truncating.
pub(crate) trait Storage {
    /// Appends some or all of the bytes and returns the number of appended bytes.
    fn append(&mut self, bytes: &[u8]) -> io::Result<usize>;

    /// Returns the length of the file in bytes. Fails if the file is no longer at its path.
    fn length(&self) -> io::Result<u64>;

    /// Removes this many bytes from the end of the file. Later calls to `append` continue at the
    /// new end.
    fn cut(&mut self, bytes: u64) -> io::Result<()>;
}

/// The file of a recording, which other programs may remove, replace or change.
pub(crate) struct RecordingFile {
    file: File,
    path: PathBuf,
    /// The identity of the file when it was created.
    pub(crate) identity: Identity,
}

impl RecordingFile {
    /// Creates a new file.
    ///
    /// On Unix, the file is opened for appending, so records are always written at its end. If
    /// another program has changed the length of the file, the next check detects this.
    /// Append mode is not used on Windows, which cannot truncate a file that is open for appending.
    ///
    /// On Unix, the file is locked until it is closed. On Windows, where a lock would keep others from
    /// reading it, others can open it for reading and writing only.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        let mut options = File::options();
        options.write(true).append(cfg!(unix)).create_new(true);
        #[cfg(windows)]
        std::os::windows::fs::OpenOptionsExt::share_mode(&mut options, 1 | 2);
        let file = options.open(path)?;
        // Some file systems have no locks.
        let _ = if cfg!(unix) { file.try_lock() } else { Ok(()) };
        let identity = identity(&file.metadata()?);
        Ok(Self { file, path: path.into(), identity })
    }
}

impl Storage for RecordingFile {
    fn append(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn length(&self) -> io::Result<u64> {
        // Writing to a deleted file succeeds, but nobody can read what was written.
        match fs::metadata(&self.path) {
            Ok(metadata) if identity(&metadata) == self.identity => Ok(metadata.len()),
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Ok(self.file.metadata()?.len())
            }
            _ => Err(io::Error::other(
                "the file was removed or replaced (reset starts a new recording)",
            )),
        }
    }

    fn cut(&mut self, bytes: u64) -> io::Result<()> {
        let length = self.file.metadata()?.len().saturating_sub(bytes);
        self.file.set_len(length)?;
        self.file.seek(SeekFrom::Start(length)).map(|_| ())
    }
}

/// A writer that buffers the data of a file. Flushing writes either all buffered bytes or none.
pub(crate) struct Sink<S> {
    storage: S,
    /// The length of the complete records in the file, in bytes.
    whole: u64,
    buffer: Vec<u8>,
    /// The length in bytes of a partially written record after the complete records.
    torn: u64,
}

impl<S: Storage> Sink<S> {
    pub(crate) const fn new(storage: S) -> Self {
        Self { storage, whole: 0, buffer: Vec::new(), torn: 0 }
    }

    fn append(&mut self) -> io::Result<()> {
        let mut rest = &self.buffer[..];
        while !rest.is_empty() {
            match self.storage.append(rest) {
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

    /// Fails if the length of the file differs from the number of bytes written to it.
    fn check(&self) -> io::Result<()> {
        let (expected, found) = (self.whole + self.torn, self.storage.length()?);
        if found == expected {
            return Ok(());
        }
        Err(io::Error::other(format!(
            "another program changed the file: expected {expected} bytes, found {found} (reset \
             starts a new recording)"
        )))
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
        self.buffer.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let written = self.cut_torn().and_then(|()| self.append()).and_then(|()| self.check());
        match written {
            Ok(()) => (self.whole, self.torn) = (self.whole + self.torn, 0),
            // If truncating fails, the next flush truncates the file before it writes.
            Err(_) => drop(self.cut_torn()),
        }
        self.buffer.clear();
        written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk with a capacity of `room` bytes. If `stuck` is true, truncating a file fails.
    struct Disk {
        bytes: Vec<u8>,
        room: usize,
        stuck: bool,
    }

    impl Storage for Disk {
        fn append(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let count = bytes.len().min(self.room - self.bytes.len());
            if count == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.bytes.extend_from_slice(&bytes[..count]);
            Ok(count)
        }

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
    fn a_failed_write_leaves_no_trace() {
        let mut sink = Sink::new(Disk { bytes: Vec::new(), room: 10, stuck: false });
        put(&mut sink, b"abcdef").unwrap();
        assert!(put(&mut sink, b"ghijkl").is_err());
        assert_eq!(sink.whole, 6);
        assert_eq!(sink.storage.bytes, b"abcdef");
        sink.storage.stuck = true;
        assert!(put(&mut sink, b"mnopqr").is_err());
        assert_eq!(sink.storage.bytes, b"abcdefmnop");
        assert!(put(&mut sink, b"s").is_err(), "a record after a torn one is unreadable");
        sink.storage.stuck = false;
        put(&mut sink, b"tu").unwrap();
        assert_eq!(sink.storage.bytes, b"abcdeftu");
        sink.storage.room = 20;
        put(&mut sink, b"vwxyz!").unwrap();
        assert_eq!((sink.storage.bytes.len(), sink.whole), (14, 14));
    }

    #[test]
    fn a_file_that_another_program_changed_is_not_written() {
        let mut sink = Sink::new(Disk { bytes: Vec::new(), room: 100, stuck: false });
        put(&mut sink, b"abcdef").unwrap();
        for changed in [&b"abc"[..], b"", b"abcdef?"] {
            sink.storage.bytes = changed.into();
            for _ in 0..2 {
                let error = put(&mut sink, b"ghi").unwrap_err().to_string();
                let found = format!("expected 9 bytes, found {} (reset", changed.len() + 3);
                assert!(error.contains(&found), "{error}");
                assert_eq!(sink.storage.bytes, changed);
            }
        }
        sink.storage.bytes = b"abcdef".into();
        put(&mut sink, b"ghi").unwrap();
        assert_eq!(sink.storage.bytes, b"abcdefghi");
    }
}
