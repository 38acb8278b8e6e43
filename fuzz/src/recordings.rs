//! Recordings: files that were cut off, damaged, or never were recordings.

use std::io::{self, Read};
use std::mem::discriminant;

use mmsim_protocol::Request;
use mmsim_server::{Ending, Recording};

/// Reads the content as that of a file and checks what the recording says of itself, and that it
/// is the same however the bytes come in and whatever follows after the last whole record.
pub fn run(content: &[u8]) {
    let whole = Recording::read(content);
    let piecewise = Recording::read(Trickle(content));
    match (whole, piecewise) {
        (Ok(recording), Ok(piecewise)) => {
            check(&recording, content.len());
            check_alike(&recording, &piecewise);
            check_endings(recording.ending(), piecewise.ending());
            if let &Ending::Cut { whole, .. } | &Ending::Damaged { whole, .. } = recording.ending()
            {
                let rest = usize::try_from(whole).ok().and_then(|end| content.get(..end));
                let shorter = Recording::read(rest.expect("an end inside of the file"));
                check_alike(&recording, &shorter.expect("a recording without what follows"));
            }
        }
        (Err(error), Err(piecewise)) => {
            assert_eq!(discriminant(&error), discriminant(&piecewise));
            let error = error.to_string();
            assert!(!error.contains(char::is_control), "in one line: {error:?}");
        }
        (one, other) => panic!("{one:?}, but in pieces {other:?}"),
    }
}

/// Its parts fit together, and each state is one of its maze.
fn check(recording: &Recording, length: usize) {
    let (size, states) = (recording.size(), recording.history().len());
    assert_eq!(recording.info().states, states);
    assert_eq!(recording.info().size(), Some(size));
    assert_eq!(recording.times().len(), states);
    assert!(recording.maze().is_none_or(|maze| maze.size() == size));
    assert_eq!(recording.history().iter().count(), states);
    for state in recording.history().iter() {
        assert!(matches!(Request::decode(&state, size), Ok(Request::State(_))));
    }
    match recording.ending() {
        Ending::Closed => {}
        &Ending::Cut { whole, length: found } => {
            assert!(whole <= found && found == length as u64);
        }
        Ending::Damaged { whole, reason } => {
            assert!(*whole <= length as u64);
            assert!(!reason.contains(char::is_control), "in one line: {reason:?}");
        }
    }
}

/// The same but for where it ends: in a chunk, as other tools pack them, that depends on how much
/// of the chunk came in at once.
fn check_endings(ending: &Ending, other: &Ending) {
    match (ending, other) {
        (Ending::Cut { length, .. }, Ending::Cut { length: other, .. }) => {
            assert_eq!(length, other);
        }
        (Ending::Damaged { reason, .. }, Ending::Damaged { reason: other, .. }) => {
            assert_eq!(reason, other);
        }
        _ => assert_eq!(ending, other),
    }
}

/// The same recording, but for how it ends.
fn check_alike(recording: &Recording, other: &Recording) {
    assert_eq!(recording.info(), other.info());
    assert_eq!(recording.maze(), other.maze());
    assert_eq!(recording.times(), other.times());
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
