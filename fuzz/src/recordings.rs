//! The fuzz target for recordings, including truncated and damaged ones.

use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;

use mmsim_protocol::Request;
use mmsim_recording::{Block, Integrity, ReadError, Recording};

/// The number of magic bytes before the first record.
const MAGIC_BYTES: usize = mcap::MAGIC.len();

/// Reads the content as a recording. Checks that the recording is consistent, and that reading the
/// same bytes in small pieces gives the same recording.
///
/// Also checks that bytes after the last intact record do not change the contents. This check does
/// not apply to files with chunks: the reader returns the states at the start of a damaged chunk
/// but does not count the chunk as intact.
pub fn run(content: &[u8]) {
    let at_once = Recording::read(content);
    let piecewise = Recording::read_within(Trickle(Cursor::new(content)), &Arc::default());
    check(&at_once, content.len());
    check(&piecewise, content.len());
    match (at_once, piecewise) {
        (Ok(recording), Ok(piecewise)) => {
            check_alike(&recording, &piecewise);
            assert_eq!(recording.integrity(), piecewise.integrity());
            if has_chunks(content) {
                return;
            }
            if let &Integrity::Truncated { intact, .. } | &Integrity::Damaged { intact, .. } =
                recording.integrity()
            {
                let rest = usize::try_from(intact).ok().and_then(|end| content.get(..end));
                let shorter = Recording::read(rest.expect("the intact part is inside the file"));
                match shorter {
                    Ok(shorter) => check_alike(&recording, &shorter),
                    // The description may follow the damage.
                    Err(ReadError::MissingDescription { .. }) => {}
                    Err(error) => panic!("the intact part is not a recording: {error}"),
                }
            }
        }
        (Err(error), Err(piecewise)) => assert_eq!(error.to_string(), piecewise.to_string()),
        (one, other) => panic!("{one:?} from the whole file, but {other:?} from small pieces"),
    }
}

/// Returns true if the recording contains a chunk, which is a record that contains other records. A
/// record consists of one byte for the kind, eight bytes for the length, and the body.
fn has_chunks(content: &[u8]) -> bool {
    let mut rest = content.get(MAGIC_BYTES..).unwrap_or_default();
    while let Some((&[kind], after_kind)) = rest.split_first_chunk() {
        if kind == mcap::records::op::CHUNK {
            return true;
        }
        let Some((&length, body)) = after_kind.split_first_chunk() else { break };
        let length = usize::try_from(u64::from_le_bytes(length)).ok();
        rest = length.and_then(|length| body.get(length..)).unwrap_or_default();
    }
    false
}

/// Checks that the recording is consistent and that all its states are valid. If reading failed,
/// checks that the error message is a single line.
fn check(result: &Result<Recording, ReadError>, length: usize) {
    let recording = match result {
        Ok(recording) => recording,
        Err(error) => {
            let error = error.to_string();
            assert!(!error.contains(char::is_control), "not a single line: {error:?}");
            return;
        }
    };
    let (size, states) = (recording.size(), recording.history().len());
    assert_eq!(recording.info().states, states);
    assert!(!recording.info().maze.contains(char::is_control), "the name is not a single line");
    assert_eq!(recording.info().size(), Some(size));
    assert_eq!(recording.times().len(), states);
    assert!(recording.maze().is_none_or(|maze| maze.size() == size));
    assert_eq!(recording.history().iter().count(), states);
    for state in recording.history().iter() {
        assert!(matches!(Request::decode(&state, size), Ok(Request::State(_))));
    }
    for block in 0..states.div_ceil(Block::STATES) {
        let newest = states.min((block + 1) * Block::STATES) - 1;
        let block = recording.history().block(block).and_then(Block::unpack);
        assert!(block.is_some_and(|block| block.context(newest).is_some()), "state {newest}");
    }
    match recording.integrity() {
        Integrity::Closed => {}
        &Integrity::Truncated { intact, length: found } => {
            assert!(intact <= found && found == length as u64);
        }
        Integrity::Damaged { intact, reason } => {
            assert!(*intact <= length as u64);
            assert!(!reason.contains(char::is_control), "not a single line: {reason:?}");
        }
    }
}

/// Checks that two recordings have the same contents. The [`Integrity`] of the recordings may
/// differ.
fn check_alike(recording: &Recording, other: &Recording) {
    assert_eq!(recording.info(), other.info());
    assert_eq!(recording.maze(), other.maze());
    assert!(recording.times().iter().eq(other.times().iter()));
    assert!(recording.history().iter().eq(other.history().iter()));
    let newest = |recording: &Recording| {
        recording
            .history()
            .len()
            .checked_sub(1)
            .and_then(|index| recording.history().context(index))
    };
    assert_eq!(newest(recording), newest(other));
}

/// A reader that returns at most seven bytes per read.
struct Trickle<'a>(Cursor<&'a [u8]>);

impl Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let max = buffer.len().min(7);
        self.0.read(&mut buffer[..max])
    }
}

impl Seek for Trickle<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}
