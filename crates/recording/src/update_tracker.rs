//! Collects what a client does between two states.

use mmsim_maze::{Heading, MazeSize, Pose};

use mmsim_protocol::Annotations;

use crate::annotation_list::{AnnotationList, put_request};
use crate::update::{Readings, Update};

/// The number of poses in the largest maze.
const POSES: usize = MazeSize::MAX_AREA * Heading::ALL.len();

/// The maximum total length of the annotations that precede a state, in bytes.
pub(crate) const MAX_PENDING_BYTES: usize = 256 << 10;

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
    /// The annotations since the previous state.
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
        if self.annotations.len() + annotations.as_bytes().len() > MAX_PENDING_BYTES {
            return Err(TooManyAnnotations);
        }
        put_request(&mut self.annotations, annotations);
        Ok(())
    }

    /// Returns the readings and annotations since the previous state.
    pub fn update(&mut self) -> Update<'_> {
        self.forget_reported();
        let Self { poses, annotations, has_read, .. } = self;
        let readings = if *has_read { Readings::Poses(poses) } else { Readings::Untracked };
        Update { readings, annotations: AnnotationList::from_requests(annotations) }
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
