//! Records each simulation into a new file in a folder.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use mmsim_maze::Maze;
use mmsim_protocol::Info;
use tracing::debug;

use crate::recording::format::RecordError;
use crate::recording::pack::{Packer, remove_unfinished};
use crate::recording::save::NewMessages;
use crate::recording::writer::RecordingWriter;

/// The maximum number of names tried for a new file.
const MAX_TRIES: u32 = 10_000;

/// The maximum length of the maze name in a file name, in bytes. File systems allow file names of
/// up to 255 bytes.
const MAX_NAME_BYTES: usize = 100;

/// Records simulations into a folder. Each reset ends the current file.
///
/// Each file is created when its first state arrives, and is compressed in the background after it
/// is closed. A file name such as `2026-11-21_18-19-49_harbour_0001.mcap` consists of the local
/// time of the first state, the name of the maze and a counter.
pub struct Recorder {
    folder: PathBuf,
    /// The counter in the name of the newest file.
    number: u32,
    current: Option<RecordingWriter>,
    messages: Option<NewMessages>,
    limit: Option<u64>,
    /// A temporary file that reserves a file descriptor for the next recording. Without this file,
    /// connections could use up all file descriptors. `None` on Windows, which has no such limit,
    /// and would show the file.
    spare: Option<File>,
    /// `None` if the thread could not be created.
    packer: Option<Packer>,
}

impl Recorder {
    /// Creates a recorder for `folder`, and creates the folder if it does not exist.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be created, or if no file can be created in it.
    pub fn new(folder: &Path) -> Result<Self, RecordError> {
        let failed = |error| RecordError::new(folder, error);
        fs::create_dir_all(folder).map_err(failed)?;
        if let Err(error) = remove_unfinished(folder) {
            debug!("cannot remove temporary files in {}: {error}", folder.display());
        }
        let spare = tempfile::tempfile_in(folder).map_err(failed)?;
        Ok(Self {
            folder: folder.into(),
            number: 0,
            current: None,
            messages: None,
            limit: None,
            spare: Some(spare).filter(|_| cfg!(unix)),
            // The thread starts before states take memory.
            packer: Packer::start().ok(),
        })
    }

    /// Sets the messages for other tools that recordings get when they are compressed. By default, they
    /// contain only the states.
    #[must_use]
    pub fn with_messages(mut self, messages: Option<NewMessages>) -> Self {
        self.messages = messages;
        self
    }

    /// Limits the size of each recording (see [`RecordingWriter::with_limit`]).
    #[must_use]
    pub fn with_limit(mut self, bytes: Option<u64>) -> Self {
        self.limit = bytes;
        self
    }

    /// Appends an update and the state that follows to the current file. If no file is open, calls
    /// `describe` and creates a file that begins with the returned description and maze.
    ///
    /// # Errors
    /// Returns an error if the state cannot be recorded.
    pub fn write<'m>(
        &mut self,
        update: &[u8],
        state: &[u8],
        describe: impl FnOnce() -> (Info, &'m Maze),
    ) -> Result<(), RecordError> {
        if let Some(current) = &mut self.current {
            return current.write_with_update(update, state);
        }
        let (info, maze) = describe();
        self.spare = None;
        let written = self
            .create(&info, maze)
            .and_then(|new| self.current.insert(new).write_with_update(update, state));
        self.reserve_descriptor();
        written
    }

    /// Appends an accepted request `A` to the current file. If no file is open, does nothing, because
    /// the annotations before the first state are in its update.
    ///
    /// # Errors
    /// Returns an error if the annotations cannot be recorded.
    pub fn write_annotations(&mut self, request: &[u8]) -> Result<(), RecordError> {
        self.current.as_mut().map_or(Ok(()), |current| current.write_annotations(request))
    }

    /// Closes the current file, if there is one, and queues it for compression.
    ///
    /// # Errors
    /// Returns an error if the summary at the end of the file cannot be written. All states remain
    /// readable.
    pub fn close(&mut self) -> Result<(), RecordError> {
        let Some(current) = self.current.take() else { return Ok(()) };
        let (unpacked, closed) = current.close_unpacked();
        self.reserve_descriptor();
        if let Some(packer) = &self.packer {
            packer.pack(unpacked);
        }
        closed
    }

    /// Waits up to one second for closed files to be compressed. The remaining files stay
    /// uncompressed.
    pub fn finish(self) {
        if let Some(packer) = self.packer {
            packer.finish();
        }
    }

    fn reserve_descriptor(&mut self) {
        if cfg!(unix) && self.spare.is_none() && self.current.is_none() {
            self.spare = tempfile::tempfile_in(&self.folder).or_else(|_| tempfile::tempfile()).ok();
        }
    }

    fn create(&mut self, info: &Info, maze: &Maze) -> Result<RecordingWriter, RecordError> {
        fs::create_dir_all(&self.folder).map_err(|error| RecordError::new(&self.folder, error))?;
        let time = jiff::Zoned::now().strftime("%Y-%m-%d_%H-%M-%S");
        let name = file_name(&info.maze);
        loop {
            self.number += 1;
            let path = self.folder.join(format!("{time}_{name}_{:04}.mcap", self.number));
            match RecordingWriter::create(&path, info, Some(maze)) {
                // Another server or an earlier process has used the name.
                Err(RecordError { source, .. })
                    if source.kind() == std::io::ErrorKind::AlreadyExists
                        && !self.number.is_multiple_of(MAX_TRIES) => {}
                result => {
                    let configure = |writer: RecordingWriter| {
                        writer.with_messages(self.messages).with_limit(self.limit)
                    };
                    return result.map(configure);
                }
            }
        }
    }
}

/// Shortens a maze name and replaces every character except letters, digits, `-` and `.` with `-`.
fn file_name(maze: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-.".contains(c) { c } else { '-' };
    let mut bytes = 0;
    let fits = |c: &char| {
        bytes += c.len_utf8();
        bytes <= MAX_NAME_BYTES
    };
    maze.chars().map(plain).take_while(fits).collect()
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Cell;
    use mmsim_protocol::Colour;

    use super::*;
    use crate::recording::Recording;
    use crate::recording::reader::Integrity;

    const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";
    const STATES: [&[u8]; 2] = [b"S\x00\x00NC\x01\x00C\x0d\x00", b"S\x01\x00EC\x01\x00C\x0d\x17"];

    fn write(recorder: &mut Recorder, state: &[u8]) -> Result<(), RecordError> {
        let maze: Maze = MAZE.parse().unwrap();
        let info = Info::new("a/b c", maze.size(), maze.start(), maze.goals(), 0);
        recorder.write(&[], state, || (info, &maze))
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let mut files: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
    }

    #[test]
    fn each_simulation_has_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new/folder");
        let mut recorder = Recorder::new(&folder).unwrap();
        recorder.close().unwrap();
        assert!(files(&folder).is_empty(), "a file is created with its first state");
        for state in STATES {
            write(&mut recorder, state).unwrap();
        }
        recorder.close().unwrap();
        assert_eq!(files(&folder).len(), 1);
        write(&mut recorder, STATES[1]).unwrap();
        let files = files(&folder);
        assert_eq!(files.len(), 2);
        for (number, (file, states)) in files.iter().zip([&STATES[..], &STATES[1..]]).enumerate() {
            let name = file.file_name().unwrap().to_str().unwrap();
            assert!(name.ends_with(&format!("_a-b-c_000{}.mcap", number + 1)), "{name}");
            let recording = Recording::open(file).unwrap();
            assert!(recording.history().iter().eq(states.iter().copied()), "{name}");
            assert_eq!(recording.maze().unwrap().to_string(), MAZE);
            assert_eq!(*recording.integrity() == Integrity::Closed, number == 0);
        }
        recorder.close().unwrap();
        assert_eq!(*Recording::open(&files[1]).unwrap().integrity(), Integrity::Closed);
    }

    #[test]
    fn annotations_are_in_the_file_before_the_next_state() {
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = Recorder::new(folder.path()).unwrap();
        recorder.write_annotations(b"AL\x05\0first").unwrap();
        assert!(files(folder.path()).is_empty(), "the update of the first state contains them");
        // As if the process had been killed.
        let log = || {
            let recording = Recording::open(&files(folder.path())[0]).unwrap();
            recording.log().into_iter().map(|line| (line.state, line.text)).collect::<Vec<_>>()
        };
        for number in 0..9 {
            write(&mut recorder, STATES[1]).unwrap();
            assert_eq!(log(), []);
            for line in [b"AL\x01\0a", b"AL\x01\0b"] {
                recorder.write_annotations(line).unwrap();
            }
            let expected = ["a", "b"].map(|text| (number + 1, text.to_string()));
            assert_eq!(log(), expected);
        }
        recorder.write_annotations(b"AT\x01\0\x03endC\x01\0gM\x01m").unwrap();
        let unpacked = fs::metadata(&files(folder.path())[0]).unwrap().len();
        recorder.close().unwrap();
        recorder.finish();
        assert!(fs::metadata(&files(folder.path())[0]).unwrap().len() < unpacked, "packed");
        assert_eq!(log(), ["a", "b"].map(|text| (9, text.to_string())));
        let recording = Recording::open(&files(folder.path())[0]).unwrap();
        let (states, cell) =
            (recording.history().block(0).unwrap().unpack().unwrap(), Cell::new(1, 0));
        let texts = [7, 8].map(|index| {
            let context = recording.context(&states, index).unwrap();
            (context.notes().text(cell).to_string(), context.notes().mouse().map(String::from))
        });
        assert_eq!(texts, [(String::new(), None), ("end".into(), Some("m".into()))]);
        assert_eq!(recording.last_context().notes().colour(cell), Some(Colour::Green));
    }

    /// Windows does not remove a folder that contains an open file.
    #[cfg(unix)]
    #[test]
    fn a_removed_folder_refuses_states_until_close() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("lost");
        let mut recorder = Recorder::new(&folder).unwrap();
        write(&mut recorder, STATES[0]).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        for _ in 0..2 {
            let error = write(&mut recorder, STATES[1]).unwrap_err().to_string();
            let expected = ": the file was removed or replaced (reset starts a new recording)";
            assert!(error.ends_with(expected), "{error}");
            let error = recorder.write_annotations(b"At").unwrap_err().to_string();
            assert!(error.ends_with(expected), "{error}");
        }
        recorder.close().unwrap();
        write(&mut recorder, STATES[0]).unwrap();
        let [file] = &files(&folder)[..] else { panic!() };
        assert!(Recording::open(file).unwrap().history().iter().eq([STATES[0]]));
    }

    #[test]
    fn a_folder_that_cannot_be_created_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = Recorder::new(&file.join("folder")).err().unwrap().to_string();
        assert!(error.starts_with("cannot record in "), "{error}");
    }

    #[test]
    fn file_names_are_valid_on_any_file_system() {
        assert_eq!(file_name("01-harbour.x"), "01-harbour.x");
        assert_eq!(file_name("../a:b\\c*?\n東京"), "..-a-b-c---東京");
        assert_eq!(file_name(&"x".repeat(200)).len(), MAX_NAME_BYTES);
        assert_eq!(file_name(&"東".repeat(100)).len(), MAX_NAME_BYTES / 3 * 3);
    }
}
