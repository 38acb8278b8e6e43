//! What happened between two consecutive states, and its bytes.
//!
//! ```text
//! update    readings
//! readings  nothing   the walls around the pose of the state were read; in a run without readings,
//!                     none were read
//!           U         the run has no readings
//!           N R…      exactly the walls around the poses R were read
//!           R R…      the walls around the pose of the state and around the poses R were read
//! R         the letter R, x, y, heading (N, E, S or W)
//! ```

use mmsim_maze::{MazeSize, Pose};
use mmsim_protocol::Request;

/// What happened between the previous state and a state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update<'a> {
    /// The walls that the client has read.
    pub readings: Readings<'a>,
}

/// The walls that a client has read between the previous state and a state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Readings<'a> {
    /// Unless the run is [`Untracked`](Self::Untracked), the client has read the walls around the
    /// pose of the state, as most clients do. Recordings made by earlier versions of mmsim contain
    /// only such readings.
    #[default]
    Usual,
    /// The client has not read any walls since the reset. It knows walls from another source, so
    /// all walls that it claims to know count as known.
    Untracked,
    /// The client has read exactly the walls around these poses.
    Poses(&'a [Pose]),
}

impl Update<'_> {
    /// Returns the maximum length of the encoded update in bytes.
    pub(crate) const fn max_bytes(&self) -> usize {
        match self.readings {
            Readings::Usual | Readings::Untracked => 1,
            Readings::Poses(poses) => 1 + (1 + poses.len()) * READING_BYTES,
        }
    }
}

/// The letters at the beginning of the entries of an update.
const UNTRACKED: u8 = b'U';
const NOT_OWN: u8 = b'N';
const READING: u8 = b'R';

/// The length of an entry `R` in bytes.
const READING_BYTES: usize = 4;

/// The maximum length of an update in bytes.
pub(crate) const MAX_UPDATE_BYTES: usize = 1 + 4 * MazeSize::MAX_AREA * READING_BYTES;

/// An update whose bytes have been checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StoredUpdate<'a> {
    pub(crate) readings: StoredReadings<'a>,
}

/// The readings of a [`StoredUpdate`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StoredReadings<'a> {
    Usual,
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
        if bytes.len() > MAX_UPDATE_BYTES {
            return Err(format!(
                "expected at most {MAX_UPDATE_BYTES} bytes before a state, found {}",
                bytes.len()
            ));
        }
        let (readings, own) = match bytes {
            [] => return Ok(Self { readings: StoredReadings::Usual }),
            [UNTRACKED] => return Ok(Self { readings: StoredReadings::Untracked }),
            [NOT_OWN, rest @ ..] => (rest, false),
            _ => (bytes, true),
        };
        let (entries, rest) = readings.as_chunks();
        let others = OtherPoses { entries, size };
        if let Some(entry) = entries.iter().find(|&&entry| others.decode(entry).is_none()) {
            let entry = entry.escape_ascii();
            return Err(format!("expected R, x, y and heading, found \"{entry}\""));
        }
        if !rest.is_empty() {
            let rest = rest.escape_ascii();
            return Err(format!("expected R, x, y and heading (4 bytes), found \"{rest}\""));
        }
        Ok(Self { readings: StoredReadings::Poses { own, others } })
    }

    /// Converts the stored update to an update before a state with the pose `own`. `poses` becomes
    /// the buffer of the poses.
    pub(crate) fn to_update(self, own: Option<Pose>, poses: &mut Vec<Pose>) -> Update<'_> {
        let readings = match self.readings {
            StoredReadings::Usual => Readings::Usual,
            StoredReadings::Untracked => Readings::Untracked,
            StoredReadings::Poses { own: has_own, others } => {
                poses.clear();
                poses.extend(own.filter(|_| has_own).into_iter().chain(others.iter()));
                Readings::Poses(poses)
            }
        };
        Update { readings }
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

    use super::*;

    #[test]
    fn updates_are_decoded() {
        let size = MazeSize::new(3, 2).unwrap();
        let own = Pose::new(Cell::new(1, 0), Heading::West);
        let other = Pose::new(Cell::new(2, 1), Heading::East);
        let mut poses = vec![own; 3];
        for (bytes, readings) in [
            (&b""[..], Readings::Usual),
            (b"U", Readings::Untracked),
            (b"N", Readings::Poses(&[])),
            (b"NR\x02\x01E", Readings::Poses(&[other])),
            (b"R\x02\x01E", Readings::Poses(&[own, other])),
            (b"R\x02\x01ER\x01\0W", Readings::Poses(&[own, other, own])),
        ] {
            let update = StoredUpdate::decode(bytes, size).unwrap();
            assert_eq!(update.to_update(Some(own), &mut poses), Update { readings });
        }
        let update = StoredUpdate::decode(b"R\x02\x01E", size).unwrap();
        let readings = Readings::Poses(&[other]);
        assert_eq!(update.to_update(None, &mut poses), Update { readings });
    }

    #[test]
    fn malformed_updates_are_errors() {
        let error =
            |bytes: &[u8]| StoredUpdate::decode(bytes, MazeSize::new(3, 2).unwrap()).unwrap_err();
        insta::assert_snapshot!(error(b"X"), @r#"expected R, x, y and heading (4 bytes), found "X""#);
        insta::assert_snapshot!(error(b"UU"), @r#"expected R, x, y and heading (4 bytes), found "UU""#);
        insta::assert_snapshot!(error(b"NR\x03\0E"), @r#"expected R, x, y and heading, found "R\x03\x00E""#);
        insta::assert_snapshot!(error(b"R\0\0eR\0\0E"), @r#"expected R, x, y and heading, found "R\x00\x00e""#);
        insta::assert_snapshot!(error(b"R\0\0ER\0\0"), @r#"expected R, x, y and heading (4 bytes), found "R\x00\x00""#);
        insta::assert_snapshot!(error(&vec![b'R'; MAX_UPDATE_BYTES + 1]), @"expected at most 16385 bytes before a state, found 16386");
    }
}
