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

use std::collections::BTreeMap;
use std::iter;

use mmsim_maze::{CellSet, MazeSize, Pose};
use mmsim_protocol::{Annotation, Annotations, Request};

use crate::context::changes::Changes;
use crate::history::log::LogLine;

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

/// The annotations of any number of requests (`A`): the [`entries`](Annotations::entries) of valid
/// requests.
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

    /// Iterates over the annotations.
    pub fn iter(self) -> impl Iterator<Item = Annotation<'a>> {
        Annotations::iter_entries(self.0)
    }
}

/// The annotations after the newest state of a run. They belong to the next state, or to the end of
/// the run if there is none.
///
/// ```
/// use mmsim_maze::MazeSize;
/// use mmsim_protocol::Annotations;
/// use mmsim_recording::UpdateTracker;
/// let mut updates = UpdateTracker::default();
/// updates.annotate(Annotations::decode(b"AL\x06\0RESULT", MazeSize::CLASSIC)?)?;
/// let trailing = updates.trailing();
/// assert!(trailing.log_lines(9).all(|line| (line.state, &*line.text) == (9, "RESULT")));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TrailingAnnotations(Vec<u8>);

impl TrailingAnnotations {
    /// Returns true if there are no annotations.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the annotations.
    pub fn list(&self) -> AnnotationList<'_> {
        AnnotationList(&self.0)
    }

    /// Returns the log lines of a run with this number of states, which is the index of their state.
    pub fn log_lines(&self, states: usize) -> impl Iterator<Item = LogLine> {
        self.list().iter().filter_map(move |annotation| match annotation {
            Annotation::Log(text) => Some(LogLine { state: states, text: text.into() }),
            _ => None,
        })
    }

    /// Appends annotations. On error, nothing changes.
    pub(crate) fn add(&mut self, annotations: Annotations<'_>) -> Result<(), TooManyAnnotations> {
        let entries = annotations.entries();
        if self.0.len() + entries.len() > MAX_PENDING_BYTES {
            return Err(TooManyAnnotations::OfAll);
        }
        self.0.extend_from_slice(entries);
        Ok(())
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Iterates over the annotations as requests (`A`), each with one annotation.
    pub(crate) fn requests(&self) -> impl Iterator<Item = Vec<u8>> {
        let mut rest = &*self.0;
        iter::from_fn(move || {
            let before = rest;
            Annotation::take_first(&mut rest).ok()??;
            Some([b"A", &before[..before.len() - rest.len()]].concat())
        })
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
        readings + if self.annotations.is_empty() { 0 } else { 64 + 2 * self.annotations.0.len() }
    }
}

/// The entry that means that the run has no readings.
pub(crate) const UNTRACKED: u8 = b'U';

/// The entry that means that the walls around the pose of the state were not read.
pub(crate) const NOT_OWN: u8 = b'N';

/// The letter of a reading of the walls around a pose.
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

/// Appends a reading of the walls around a pose.
pub(crate) fn put_reading(bytes: &mut Vec<u8>, Pose { cell, heading }: Pose) {
    bytes.extend([READING, cell.x, cell.y, heading.letter() as u8]);
}

/// The maximum total length of the annotations that precede a state, in bytes, without the letters
/// of their requests. A reader unpacks 256 states at once, so up to 132 MiB.
pub(crate) const MAX_PENDING_BYTES: usize = 256 << 10;

/// The maximum part of one connection. In the largest maze, the longest texts, colours and walls of all
/// cells fit.
const MAX_CLIENT_BYTES: usize = 64 << 10;

/// Collects what clients do between two states, as an [`Update`].
///
/// ```
/// use mmsim_maze::{Cell, Heading, Pose};
/// use mmsim_recording::{Readings, UpdateTracker};
/// let pose = |y| Pose::new(Cell::new(0, y), Heading::North);
/// let mut updates = UpdateTracker::default();
/// assert_eq!(updates.update().readings, Readings::Untracked);
/// updates.read(pose(0));
/// updates.read(pose(1));
/// assert_eq!(updates.update().readings, Readings::Poses(&[pose(0), pose(1)]));
/// updates.report();
/// updates.read(pose(1));
/// assert_eq!(updates.update().readings, Readings::Poses(&[]));
/// ```
#[derive(Clone, Debug, Default)]
pub struct UpdateTracker {
    /// The cells in which the client has read walls, for each heading.
    read: [CellSet; 4],
    /// The poses that the client has read since the previous state, for the first time.
    poses: Vec<Pose>,
    /// The annotations since the previous state.
    annotations: TrailingAnnotations,
    /// The lengths of the annotations of each connection, in bytes.
    clients: BTreeMap<Option<u64>, usize>,
    /// True if `poses` and `annotations` belong to the newest state.
    is_reported: bool,
    /// True if the client has read walls.
    has_read: bool,
}

/// The error for too many annotations before a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot store more annotations before the next state: {} reached (send S or reset)", self.limit())]
pub enum TooManyAnnotations {
    /// The connection of the client has sent too many annotations.
    OfClient,
    /// All clients together have sent too many annotations.
    OfAll,
}

impl TooManyAnnotations {
    fn limit(self) -> String {
        match self {
            Self::OfClient => format!("limit of {} KiB per connection", MAX_CLIENT_BYTES >> 10),
            Self::OfAll => format!("limit of {} KiB for all connections", MAX_PENDING_BYTES >> 10),
        }
    }
}

impl UpdateTracker {
    /// Adds a reading. Later readings at the same pose have no effect.
    #[inline]
    pub fn read(&mut self, pose: Pose) {
        if self.read[pose.heading as usize].insert(pose.cell) {
            self.add(pose);
        }
    }

    #[cold]
    fn add(&mut self, pose: Pose) {
        self.forget_reported();
        self.has_read = true;
        self.poses.push(pose);
    }

    /// Adds annotations of the only client.
    ///
    /// # Errors
    /// See [`annotate_from`](Self::annotate_from).
    pub fn annotate(&mut self, annotations: Annotations<'_>) -> Result<(), TooManyAnnotations> {
        self.annotate_from(None, annotations)
    }

    /// Adds annotations of the connection with this number.
    ///
    /// # Errors
    /// Returns an error, and adds nothing, if there are too many annotations since the previous state.
    pub fn annotate_from(
        &mut self,
        client: Option<u64>,
        annotations: Annotations<'_>,
    ) -> Result<(), TooManyAnnotations> {
        self.forget_reported();
        let earlier = self.clients.get(&client).copied().unwrap_or_default();
        let bytes = earlier + annotations.entries().len();
        if bytes > MAX_CLIENT_BYTES {
            return Err(TooManyAnnotations::OfClient);
        }
        self.annotations.add(annotations)?;
        if bytes > earlier {
            self.clients.insert(client, bytes);
        }
        Ok(())
    }

    /// Cancels the last [`annotate_from`](Self::annotate_from) with these arguments, because the
    /// annotations were not recorded. Call this method before a client continues.
    pub fn undo_annotate_from(&mut self, client: Option<u64>, annotations: Annotations<'_>) {
        let length = annotations.entries().len();
        self.annotations.0.truncate(self.annotations.0.len().saturating_sub(length));
        if let Some(bytes) = self.clients.get_mut(&client) {
            *bytes = bytes.saturating_sub(length);
        }
    }

    /// Returns the annotations since the previous state.
    pub fn trailing(&self) -> TrailingAnnotations {
        if self.is_reported { TrailingAnnotations::default() } else { self.annotations.clone() }
    }

    /// Returns the readings and annotations since the previous state.
    pub fn update(&mut self) -> Update<'_> {
        self.forget_reported();
        let Self { poses, annotations, has_read, .. } = self;
        let readings = if *has_read { Readings::Poses(poses) } else { Readings::Untracked };
        Update { readings, annotations: annotations.list() }
    }

    /// Marks the readings and annotations as part of a state. Later ones belong to the next state.
    pub const fn report(&mut self) {
        self.is_reported = true;
    }

    /// Cancels the last [`report`](Self::report), because its state was not stored. Call this
    /// method before the client continues.
    pub const fn undo_report(&mut self) {
        self.is_reported = false;
    }

    /// Removes all readings and annotations.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    fn forget_reported(&mut self) {
        if self.is_reported {
            self.poses.clear();
            self.annotations.clear();
            self.clients.clear();
            self.is_reported = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, WallState};
    use mmsim_protocol::{
        Annotation, AnnotationWriter, Colour, MAX_ANNOTATIONS_BYTES, MAX_TEXT_CHARS,
    };

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
        insta::assert_snapshot!(error(&vec![b'c'; MAX_UPDATE_BYTES + 1]), @"expected at most 540737 bytes before a state, found 540738");
    }

    fn annotations(request: &[u8]) -> Annotations<'_> {
        Annotations::decode(request, MazeSize::HALF_SIZE).unwrap()
    }

    #[test]
    fn the_annotations_of_all_requests_precede_the_state() {
        let requests = [&b"AcdL\x01\0x"[..], b"AT\x1f\x1f\x011", b"At"].map(annotations);
        let mut updates = UpdateTracker::default();
        assert!(updates.update().annotations.is_empty());
        for request in requests {
            updates.annotate(request).unwrap();
        }
        let list = updates.update().annotations;
        assert!(list.iter().eq(requests.iter().flat_map(Annotations::iter)));
        assert_eq!(list.iter().count(), 5);
    }

    #[test]
    fn annotations_are_accepted_up_to_the_limit() {
        let mut updates = UpdateTracker::default();
        // The letter of a request does not count.
        let request = [&b"A"[..], &[b't'; 4095]].concat();
        let requests = MAX_CLIENT_BYTES / 4095;
        let rest = &request[..=MAX_CLIENT_BYTES - requests * 4095];
        let one = annotations(b"At");
        for round in 0..2 {
            for client in [None, Some(0), Some(1), Some(u64::MAX)] {
                assert_eq!(updates.trailing().is_empty(), client.is_none(), "round {round}");
                for _ in 0..requests {
                    updates.annotate_from(client, annotations(&request)).unwrap();
                }
                updates.annotate_from(client, annotations(rest)).unwrap();
                assert_eq!(updates.annotate_from(client, one), Err(TooManyAnnotations::OfClient));
                updates.undo_annotate_from(client, annotations(rest));
                updates.annotate_from(client, annotations(rest)).unwrap();
            }
            assert_eq!(updates.annotate_from(Some(2), one), Err(TooManyAnnotations::OfAll));
            assert_eq!(updates.update().annotations.iter().count(), MAX_PENDING_BYTES);
            if round == 0 { updates.report() } else { updates.clear() }
        }
        updates.annotate(one).unwrap();
        let [client, all] = [TooManyAnnotations::OfClient, TooManyAnnotations::OfAll];
        insta::assert_snapshot!(client, @"cannot store more annotations before the next state: limit of 64 KiB per connection reached (send S or reset)");
        insta::assert_snapshot!(all, @"cannot store more annotations before the next state: limit of 256 KiB for all connections reached (send S or reset)");
    }

    #[test]
    fn a_repaint_of_the_largest_maze_fits() {
        let (mut updates, text) = (UpdateTracker::default(), "\u{10ffff}".repeat(MAX_TEXT_CHARS));
        for cell in MazeSize::HALF_SIZE.cells() {
            let mut buffer = [0; MAX_ANNOTATIONS_BYTES];
            let mut writer = AnnotationWriter::new(&mut buffer);
            writer.push(Annotation::Text { cell, text: &text }).unwrap();
            writer.push(Annotation::Colour { cell, colour: Some(Colour::Red) }).unwrap();
            for heading in [Heading::North, Heading::East] {
                let state = Some(WallState::Unknown);
                writer.push(Annotation::Wall { cell, heading, state }).unwrap();
            }
            updates.annotate(annotations(writer.finish().unwrap())).unwrap();
        }
    }
}
