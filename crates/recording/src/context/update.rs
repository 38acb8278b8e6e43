//! What happened between two consecutive states, and its bytes.
//!
//! ```text
//! update    readings, then changes of annotations (see `changes.rs`)
//! readings  nothing   the walls around the pose of the state were read; in a run without readings,
//!                     none were read
//!           U         the run has no readings
//!           N R…      exactly the walls around the poses R were read
//!           R R…      the walls around the pose of the state and around the poses R were read
//! R         the letter R, x, y, heading (N, E, S or W)
//! ```

use mmsim_maze::{MazeSize, Pose};
use mmsim_protocol::{Annotation, Annotations, Request};

use crate::context::changes::Changes;
use crate::context::update_tracker::MAX_PENDING_BYTES;

/// What happened between the previous state and this state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update<'a> {
    /// The walls that the client has read.
    pub readings: Readings<'a>,
    /// The annotations that the client has sent.
    pub annotations: AnnotationList<'a>,
}

/// The walls that a client has read between the previous state and this state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Readings<'a> {
    /// Unless the run is [`Untracked`](Self::Untracked), the client has read the walls around the
    /// pose of the state, as most clients do.
    #[default]
    AtPose,
    /// The client has not read any walls since the reset. It knows walls from another source, so
    /// all walls that it claims to know count as known.
    Untracked,
    /// The client has read exactly the walls around these poses.
    Poses(&'a [Pose]),
}

/// The annotations of any number of requests (`A`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AnnotationList<'a>(&'a [u8]);

/// The parts of an update that do not change the context.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Events {
    /// True if the mouse was put back at its start.
    pub(crate) has_restart: bool,
    /// The number of log lines.
    pub(crate) lines: usize,
}

impl<'a> AnnotationList<'a> {
    /// Returns true if there are no annotations.
    pub const fn is_empty(self) -> bool {
        self.0.is_empty()
    }

    /// Returns the length of the annotations in bytes.
    pub(crate) const fn len(self) -> usize {
        self.0.len()
    }

    /// Iterates over the annotations.
    pub fn iter(self) -> impl Iterator<Item = Annotation<'a>> {
        Annotations::iter_entries(self.0)
    }

    /// Creates a list from the [`entries`](Annotations::entries) of valid requests.
    pub(crate) const fn from_entries(entries: &'a [u8]) -> Self {
        Self(entries)
    }
}

impl Update<'_> {
    /// Returns the maximum length of the encoded update in bytes. Encoded annotations can be longer
    /// than the annotations that the client has sent, because they may clear many cells one by one.
    pub(crate) const fn max_bytes(&self) -> usize {
        let readings = match self.readings {
            Readings::AtPose | Readings::Untracked => 1,
            Readings::Poses(poses) => 1 + (1 + poses.len()) * READING_BYTES,
        };
        readings + if self.annotations.is_empty() { 0 } else { 64 + 2 * self.annotations.len() }
    }
}

/// The letters at the beginning of the entries of an update.
const UNTRACKED: u8 = b'U';
const NOT_OWN: u8 = b'N';
const READING: u8 = b'R';

/// The length of an entry `R` in bytes.
const READING_BYTES: usize = 4;

/// The maximum length of an update in bytes, see [`Update::max_bytes`].
pub(crate) const MAX_UPDATE_BYTES: usize =
    1 + 4 * MazeSize::MAX_AREA * READING_BYTES + 64 + 2 * MAX_PENDING_BYTES;

/// An update whose bytes have been checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StoredUpdate<'a> {
    pub(crate) readings: StoredReadings<'a>,
    pub(crate) changes: Changes<'a>,
}

/// The readings of a [`StoredUpdate`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StoredReadings<'a> {
    AtPose,
    Untracked,
    /// The readings around the pose of the state, if `own` is true, and around other poses.
    Poses {
        own: bool,
        others: OtherPoses<'a>,
    },
}

/// Valid entries `R`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OtherPoses<'a> {
    entries: &'a [[u8; READING_BYTES]],
    size: MazeSize,
}

impl<'a> StoredUpdate<'a> {
    /// Checks the bytes of an update. The error states what was expected and found.
    pub(crate) fn decode(bytes: &'a [u8], size: MazeSize) -> Result<Self, String> {
        // Most updates are empty.
        if bytes.is_empty() {
            return Ok(Self { readings: StoredReadings::AtPose, changes: Changes::none(size) });
        }
        if bytes.len() > MAX_UPDATE_BYTES {
            return Err(format!(
                "expected at most {MAX_UPDATE_BYTES} bytes before a state, found {}",
                bytes.len()
            ));
        }
        let (own, others) = match bytes {
            [UNTRACKED | NOT_OWN, rest @ ..] => (false, rest),
            _ => (true, bytes),
        };
        let readings = others.chunks_exact(READING_BYTES).take_while(|entry| entry[0] == READING);
        let (others, rest) = others.split_at(readings.count() * READING_BYTES);
        let (entries, _) = others.as_chunks();
        let others = OtherPoses { entries, size };
        if let Some(entry) = entries.iter().find(|&&entry| others.decode(entry).is_none()) {
            let entry = entry.escape_ascii();
            return Err(format!("expected R, x, y and heading, found \"{entry}\""));
        }
        let changes = Changes::decode(rest, size)?;
        let readings = match (bytes, entries) {
            ([UNTRACKED, ..], []) => StoredReadings::Untracked,
            ([UNTRACKED, ..], _) => return Err("expected no readings after U, found R".into()),
            ([NOT_OWN, ..], _) | (_, [_, ..]) => StoredReadings::Poses { own, others },
            (_, []) => StoredReadings::AtPose,
        };
        Ok(Self { readings, changes })
    }
}

impl Events {
    /// Returns the events in the valid bytes of an update.
    pub(crate) fn from_update(update: &[u8], size: MazeSize) -> Self {
        let decoded = StoredUpdate::decode(update, size);
        decoded.map(|update| update.changes.events()).unwrap_or_default()
    }
}

impl OtherPoses<'_> {
    pub(crate) fn iter(&self) -> impl Iterator<Item = Pose> {
        self.entries.iter().filter_map(|&entry| self.decode(entry))
    }

    fn decode(&self, [letter, x, y, heading]: [u8; READING_BYTES]) -> Option<Pose> {
        match Request::decode(&[b'W', x, y, heading], self.size) {
            Ok(Request::Walls(pose)) if letter == READING => Some(pose),
            _ => None,
        }
    }
}

/// Appends the entry that means that the run has no readings.
pub(crate) fn put_untracked(bytes: &mut Vec<u8>) {
    bytes.push(UNTRACKED);
}

/// Appends the entry that means that the walls around the pose of the state were not read.
pub(crate) fn put_not_own(bytes: &mut Vec<u8>) {
    bytes.push(NOT_OWN);
}

/// Appends a reading of the walls around a pose.
pub(crate) fn put_reading(bytes: &mut Vec<u8>, Pose { cell, heading }: Pose) {
    bytes.extend([READING, cell.x, cell.y, heading.letter() as u8]);
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading};
    use mmsim_protocol::Annotation;

    use super::*;
    use crate::context::changes::Change;

    #[test]
    fn updates_are_decoded() {
        let size = MazeSize::new(3, 2).unwrap();
        let other = Pose::new(Cell::new(2, 1), Heading::East);
        for (bytes, own, expected) in [
            (&b"N"[..], false, &[][..]),
            (b"NR\x02\x01E", false, &[other]),
            (b"R\x02\x01E", true, &[other]),
            (b"R\x02\x01ER\x02\x01E", true, &[other, other]),
        ] {
            for changes in [&b""[..], b"c"] {
                let bytes = [bytes, changes].concat();
                let update = StoredUpdate::decode(&bytes, size).unwrap();
                let StoredReadings::Poses { own: found, others } = update.readings else {
                    panic!("{update:?}")
                };
                assert_eq!((found, others.iter().collect::<Vec<_>>()), (own, expected.into()));
                assert_eq!(update.changes.iter().count(), changes.len());
            }
        }
        for (bytes, expected) in [
            (&b""[..], StoredReadings::AtPose),
            (b"c", StoredReadings::AtPose),
            (b"U", StoredReadings::Untracked),
            (b"Uc", StoredReadings::Untracked),
        ] {
            let update = StoredUpdate::decode(bytes, size).unwrap();
            assert_eq!(update.readings, expected);
            let colours = Change::Other(Annotation::ClearColours);
            assert!(update.changes.iter().eq(bytes.ends_with(b"c").then_some(colours)));
        }
    }

    #[test]
    fn malformed_updates_are_errors() {
        let error =
            |bytes: &[u8]| StoredUpdate::decode(bytes, MazeSize::new(3, 2).unwrap()).unwrap_err();
        insta::assert_snapshot!(error(b"X"), @r#"expected a change of annotations, found "X""#);
        insta::assert_snapshot!(error(b"UU"), @r#"expected a change of annotations, found "U""#);
        insta::assert_snapshot!(error(b"UR\0\0E"), @"expected no readings after U, found R");
        insta::assert_snapshot!(error(b"NR\x03\0E"), @r#"expected R, x, y and heading, found "R\x03\x00E""#);
        insta::assert_snapshot!(error(b"R\0\0eR\0\0E"), @r#"expected R, x, y and heading, found "R\x00\x00e""#);
        insta::assert_snapshot!(error(b"R\0\0ER\0\0"), @r#"expected a change of annotations, found "R\x00\x00""#);
        insta::assert_snapshot!(error(&vec![b'c'; MAX_UPDATE_BYTES + 1]), @"expected at most 147521 bytes before a state, found 147522");
    }
}
