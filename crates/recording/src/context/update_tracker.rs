//! Collects what a client does between two states.

use mmsim_maze::{Heading, MazeSize, Pose};

use mmsim_protocol::Annotations;

use crate::context::update::{AnnotationList, Readings, Update};

/// The number of poses in the largest maze.
const POSES: usize = MazeSize::MAX_AREA * Heading::ALL.len();

/// The maximum total length of the annotations that precede a state, in bytes, without the letters
/// of their requests. In the largest maze, the longest texts, colours and walls of all cells fit.
pub(crate) const MAX_PENDING_BYTES: usize = 64 << 10;

/// Collects what a client does between two states, as an [`Update`].
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
#[derive(Clone, Debug)]
pub struct UpdateTracker {
    /// One bit for each pose at which the client has read walls.
    read: [u64; POSES / u64::BITS as usize],
    /// The poses that the client has read since the previous state, for the first time.
    poses: Vec<Pose>,
    /// The entries of the annotations since the previous state.
    annotations: Vec<u8>,
    /// True if `poses` and `annotations` belong to the newest state.
    is_reported: bool,
    /// True if the client has read walls.
    has_read: bool,
}

/// The error for too many annotations before a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "cannot store more annotations before the next state: limit of {} KiB reached (send S or reset)",
    MAX_PENDING_BYTES >> 10
)]
pub struct TooManyAnnotations;

impl Default for UpdateTracker {
    fn default() -> Self {
        Self {
            read: [0; POSES / u64::BITS as usize],
            poses: Vec::new(),
            annotations: Vec::new(),
            is_reported: false,
            has_read: false,
        }
    }
}

impl UpdateTracker {
    /// Adds a reading. Later readings at the same pose have no effect.
    #[inline]
    pub fn read(&mut self, pose: Pose) {
        let Pose { cell, heading } = pose;
        let side = usize::from(MazeSize::MAX_SIDE);
        let cell = usize::from(cell.y) % side * side + usize::from(cell.x) % side;
        let index = cell * Heading::ALL.len() + heading as usize;
        let (word, bit) = (&mut self.read[index / 64], 1 << (index % 64));
        if *word & bit == 0 {
            *word |= bit;
            self.add(pose);
        }
    }

    #[cold]
    fn add(&mut self, pose: Pose) {
        self.forget_reported();
        self.has_read = true;
        self.poses.push(pose);
    }

    /// Adds annotations.
    ///
    /// # Errors
    /// Returns an error if there are too many annotations since the previous state.
    pub fn annotate(&mut self, annotations: Annotations<'_>) -> Result<(), TooManyAnnotations> {
        self.forget_reported();
        let entries = annotations.entries();
        if self.annotations.len() + entries.len() > MAX_PENDING_BYTES {
            return Err(TooManyAnnotations);
        }
        self.annotations.extend_from_slice(entries);
        Ok(())
    }

    /// Returns the readings and annotations since the previous state.
    pub fn update(&mut self) -> Update<'_> {
        self.forget_reported();
        let Self { poses, annotations, has_read, .. } = self;
        let readings = if *has_read { Readings::Poses(poses) } else { Readings::Untracked };
        Update { readings, annotations: AnnotationList::from_entries(annotations) }
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
            self.is_reported = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::WallState;
    use mmsim_protocol::{
        Annotation, AnnotationWriter, Colour, MAX_ANNOTATIONS_BYTES, MAX_TEXT_CHARS,
    };

    use super::*;

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
        let requests = MAX_PENDING_BYTES / 4095;
        for _ in 0..requests {
            updates.annotate(annotations(&request)).unwrap();
        }
        let rest = &request[..=MAX_PENDING_BYTES - requests * 4095];
        updates.annotate(annotations(rest)).unwrap();
        let error = updates.annotate(annotations(b"At")).unwrap_err();
        insta::assert_snapshot!(error, @"cannot store more annotations before the next state: limit of 64 KiB reached (send S or reset)");
        assert_eq!(updates.update().annotations.iter().count(), MAX_PENDING_BYTES);
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
