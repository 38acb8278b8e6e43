//! Recordings: files that were cut off, damaged, or never were recordings.

use std::io::{self, Read};

use mmsim_protocol::Request;
use mmsim_recording::{Integrity, ReadError, Recording};

/// What a file begins with, before its records.
const MAGIC_BYTES: usize = mcap::MAGIC.len();

/// Reads the content as that of a file and checks what the recording says of itself, that it is the
/// same however the bytes come in, and, unless it is packed in chunks, whatever follows after the
/// last whole record. Of a damaged chunk the states before the damage are there.
pub fn run(content: &[u8]) {
    let whole = Recording::read(content);
    let piecewise = Recording::read(Trickle(content));
    check(&whole, content.len());
    check(&piecewise, content.len());
    match (whole, piecewise) {
        (Ok(recording), Ok(piecewise)) => {
            check_alike(&recording, &piecewise);
            assert_eq!(recording.integrity(), piecewise.integrity());
            if has_chunks(content) {
                return;
            }
            if let &Integrity::Truncated { intact, .. } | &Integrity::Damaged { intact, .. } = recording.integrity()
            {
                let rest = usize::try_from(intact).ok().and_then(|end| content.get(..end));
                let shorter = Recording::read(rest.expect("an end inside of the file"));
                check_alike(&recording, &shorter.expect("a recording without what follows"));
            }
        }
        (Err(error), Err(piecewise)) => assert_eq!(error.to_string(), piecewise.to_string()),
        (one, other) => panic!("{one:?}, but in pieces {other:?}"),
    }
}

/// Whether one of the records is a chunk, as other tools write them: each record is a byte that says
/// what it is, a length of eight bytes, and as many bytes.
fn has_chunks(content: &[u8]) -> bool {
    let mut rest = content.get(MAGIC_BYTES..).unwrap_or_default();
    while let Some((&[kind], behind)) = rest.split_first_chunk() {
        if kind == mcap::records::op::CHUNK {
            return true;
        }
        let Some((&length, body)) = behind.split_first_chunk() else { break };
        let length = usize::try_from(u64::from_le_bytes(length)).ok();
        rest = length.and_then(|length| body.get(length..)).unwrap_or_default();
    }
    false
}

/// Its parts fit together, and each state is one of its maze; or the error takes one line.
fn check(result: &Result<Recording, ReadError>, length: usize) {
    let recording = match result {
        Ok(recording) => recording,
        Err(error) => {
            let error = error.to_string();
            assert!(!error.contains(char::is_control), "in one line: {error:?}");
            return;
        }
    };
    let (size, states) = (recording.size(), recording.history().len());
    assert_eq!(recording.info().states, states);
    assert!(!recording.info().name.contains(char::is_control), "in one line");
    assert_eq!(recording.info().size(), Some(size));
    assert_eq!(recording.times().len(), states);
    assert!(recording.maze().is_none_or(|maze| maze.size() == size));
    assert_eq!(recording.history().iter().count(), states);
    for state in recording.history().iter() {
        assert!(matches!(Request::decode(&state, size), Ok(Request::State(_))));
    }
    match recording.integrity() {
        Integrity::Closed => {}
        &Integrity::Truncated { intact, length: found } => {
            assert!(intact <= found && found == length as u64);
        }
        Integrity::Damaged { intact, reason } => {
            assert!(*intact <= length as u64);
            assert!(!reason.contains(char::is_control), "in one line: {reason:?}");
        }
    }
}

/// The same recording, but for how it ends.
fn check_alike(recording: &Recording, other: &Recording) {
    assert_eq!(recording.info(), other.info());
    assert_eq!(recording.maze(), other.maze());
    assert!(recording.times().iter().eq(other.times().iter()));
    assert!(recording.history().iter().eq(other.history().iter()));
}

/// Gives its bytes seven at a time.
struct Trickle<'a>(&'a [u8]);

impl Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(7);
        self.0.read(&mut buffer[..most])
    }
}
