//! Records simulations into a folder, each into a file of its own.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use tracing::debug;

use super::pack::{Packer, remove_unfinished};
use super::{RecordError, RecordingWriter};
use crate::{Change, Simulation};

/// How many names are tried for a file before it is given up.
const NAMES: u32 = 10_000;

/// The longest name of a maze in the name of a file, in bytes; file systems end at 255.
const MAX_NAME_BYTES: usize = 100;

/// Records simulations into a folder: each, from reset to reset, is a file of its own, begun with
/// its first state. Once it is closed it is packed in the background.
///
/// A file is named after the local time of its first state, the maze, and a number that counts the
/// files of this recorder, such as `2026-11-21_18-19-49_harbour_0001.mcap`.
pub struct Recorder {
    folder: PathBuf,
    /// The number of the newest file.
    number: u32,
    current: Option<RecordingWriter>,
    /// Holds the place of the next file among those that the system lets a process open, else
    /// connections could take all of them.
    spare: Option<File>,
    /// `None` until a recording is closed.
    packer: Option<Packer>,
}

impl Recorder {
    /// Records into this folder, which is created if it is not there.
    ///
    /// # Errors
    /// The folder cannot be created, or no file in it.
    pub fn new(folder: &Path) -> Result<Self, RecordError> {
        let failed = |error| RecordError::new(folder, error);
        fs::create_dir_all(folder).map_err(failed)?;
        if let Err(error) = remove_unfinished(folder) {
            debug!("{}: cannot be cleaned up: {error}", folder.display());
        }
        let spare = tempfile::tempfile_in(folder).map_err(failed)?;
        Ok(Self {
            folder: folder.into(),
            number: 0,
            current: None,
            spare: Some(spare),
            packer: None,
        })
    }

    /// Records what a request has changed in a simulation: the newest state of its history, or that
    /// there are none any more.
    ///
    /// # Errors
    /// The state cannot be recorded. After a reset, the file that ends there cannot be closed; all
    /// its states can be read nevertheless.
    pub fn follow(
        &mut self,
        change: Change,
        request: &[u8],
        simulation: &Simulation,
    ) -> Result<(), RecordError> {
        match (change, &mut self.current) {
            (Change::Nothing, _) => Ok(()),
            (Change::Reset, _) => self.close(),
            (Change::State, Some(current)) => current.write(request),
            (Change::State, None) => {
                self.spare = None;
                let written = match self.begin(simulation) {
                    Ok(new) => self.current.insert(new).write(request),
                    Err(error) => Err(error),
                };
                self.hold_place();
                written
            }
        }
    }

    /// Closes the file that is being written, if there is one, and has it packed.
    ///
    /// # Errors
    /// What closes it cannot be written. All its states can be read nevertheless.
    pub fn close(&mut self) -> Result<(), RecordError> {
        let Some(current) = self.current.take() else { return Ok(()) };
        let (unpacked, closed) = current.close_unpacked();
        self.hold_place();
        if self.packer.is_none() {
            self.packer = Packer::start().ok();
        }
        if let Some(packer) = &self.packer {
            packer.pack(unpacked);
        }
        closed
    }

    /// Waits until the files that are closed are packed, for a second. Those that are not by then
    /// stay as they are: whole, but larger.
    pub fn finish(self) {
        if let Some(packer) = self.packer {
            packer.finish();
        }
    }

    fn hold_place(&mut self) {
        if self.spare.is_none() && self.current.is_none() {
            self.spare = tempfile::tempfile_in(&self.folder).or_else(|_| tempfile::tempfile()).ok();
        }
    }

    fn begin(&mut self, simulation: &Simulation) -> Result<RecordingWriter, RecordError> {
        fs::create_dir_all(&self.folder).map_err(|error| RecordError::new(&self.folder, error))?;
        let time = jiff::Zoned::now().strftime("%Y-%m-%d_%H-%M-%S");
        let maze = file_name(simulation.name());
        loop {
            self.number += 1;
            let path = self.folder.join(format!("{time}_{maze}_{:04}.mcap", self.number));
            match RecordingWriter::create(&path, &simulation.info(), Some(simulation.maze())) {
                // That of another server, or of one that ran a moment ago.
                Err(RecordError { source, .. })
                    if source.kind() == std::io::ErrorKind::AlreadyExists
                        && !self.number.is_multiple_of(NAMES) => {}
                result => return result,
            }
        }
    }
}

/// The name of a maze as part of the name of a file, on any system.
fn file_name(maze: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-.".contains(c) { c } else { '-' };
    let mut room = MAX_NAME_BYTES;
    let fits = |c: &char| {
        room = room.saturating_sub(c.len_utf8());
        room > 0
    };
    maze.chars().map(plain).take_while(fits).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ending, Recording, ReplyBuffer};

    const STATES: [&[u8]; 2] = [b"S\x00\x00NC\x01\x00C\x0d\x00", b"S\x01\x00EC\x01\x00C\x0d\x17"];

    fn simulation() -> Simulation {
        Simulation::new("a/b c", "o---o---o\n| S   G |\no---o---o\n".parse().unwrap())
    }

    fn follow(recorder: &mut Recorder, simulation: &mut Simulation, request: &[u8]) {
        let change = simulation.handle(request, &mut ReplyBuffer::new());
        recorder.follow(change, request, simulation).unwrap();
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let mut files: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
    }

    #[test]
    fn each_simulation_is_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new/folder");
        let (mut recorder, mut simulation) = (Recorder::new(&folder).unwrap(), simulation());
        for request in
            [b"reset", b"reset", STATES[0], b"ping", STATES[1], b"S", b"reset", b"W\0\0N"]
        {
            follow(&mut recorder, &mut simulation, request);
        }
        assert_eq!(files(&folder).len(), 1, "a file begins with its first state");
        follow(&mut recorder, &mut simulation, STATES[1]);
        let files = files(&folder);
        assert_eq!(files.len(), 2);
        for (number, (file, states)) in files.iter().zip([&STATES[..], &STATES[1..]]).enumerate() {
            let name = file.file_name().unwrap().to_str().unwrap();
            assert!(name.ends_with(&format!("_a-b-c_000{}.mcap", number + 1)), "{name}");
            let recording = Recording::open(file).unwrap();
            assert!(recording.history().iter().eq(states.iter().copied()), "{name}");
            assert_eq!(recording.maze(), Some(simulation.maze()));
            assert_eq!(*recording.ending() == Ending::Closed, number == 0);
        }
        recorder.close().unwrap();
        assert_eq!(*Recording::open(&files[1]).unwrap().ending(), Ending::Closed);
    }

    /// Windows does not let a folder go in which a file is open.
    #[cfg(unix)]
    #[test]
    fn a_folder_that_has_gone_refuses_states_until_reset() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("lost");
        let (mut recorder, mut simulation) = (Recorder::new(&folder).unwrap(), simulation());
        follow(&mut recorder, &mut simulation, STATES[0]);
        fs::remove_dir_all(&folder).unwrap();
        let change = simulation.handle(STATES[1], &mut ReplyBuffer::new());
        for _ in 0..2 {
            let error = recorder.follow(change, STATES[1], &simulation).unwrap_err().to_string();
            assert!(error.ends_with(": the file has gone; reset begins a new one"), "{error}");
        }
        follow(&mut recorder, &mut simulation, b"reset");
        follow(&mut recorder, &mut simulation, STATES[0]);
        let [file] = &files(&folder)[..] else { panic!() };
        assert!(Recording::open(file).unwrap().history().iter().eq([STATES[0]]));
    }

    #[test]
    fn a_folder_that_cannot_be_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = Recorder::new(&file.join("folder")).err().unwrap().to_string();
        assert!(error.starts_with("cannot record in "), "{error}");
    }

    #[test]
    fn names_are_fit_for_any_file_system() {
        assert_eq!(file_name("01-harbour.x"), "01-harbour.x");
        assert_eq!(file_name("../a:b\\c*?\n東京"), "..-a-b-c---東京");
        assert!(file_name(&"東".repeat(100)).len() <= MAX_NAME_BYTES);
    }
}
