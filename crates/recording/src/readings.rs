//! Collects the poses at which a client reads walls.

use mmsim_maze::{Heading, MazeSize, Pose};

use crate::update::Readings;

/// The number of poses in the largest maze.
const POSES: usize = MazeSize::MAX_AREA * Heading::ALL.len();

/// The poses at which a client has read walls since its last reset.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Pose};
/// use mmsim_recording::{ReadingTracker, Readings};
/// let pose = |y| Pose::new(Cell::new(0, y), Heading::North);
/// let mut tracker = ReadingTracker::default();
/// assert_eq!(tracker.readings(), Readings::Untracked);
/// tracker.read(pose(0));
/// tracker.read(pose(1));
/// assert_eq!(tracker.readings(), Readings::Poses(&[pose(0), pose(1)]));
/// tracker.report();
/// tracker.read(pose(1));
/// assert_eq!(tracker.readings(), Readings::Poses(&[]));
/// ```
#[derive(Clone, Debug)]
pub struct ReadingTracker {
    /// One bit for each pose at which the client has read walls.
    read: [u64; POSES / u64::BITS as usize],
    /// The poses that the client has read since the previous state, for the first time.
    poses: Vec<Pose>,
    /// True if `poses` belongs to the newest state.
    is_reported: bool,
    /// True if the client has read walls.
    has_read: bool,
}

impl Default for ReadingTracker {
    fn default() -> Self {
        Self {
            read: [0; POSES / u64::BITS as usize],
            poses: Vec::new(),
            is_reported: false,
            has_read: false,
        }
    }
}

impl ReadingTracker {
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

    /// Returns the readings since the previous state.
    pub fn readings(&mut self) -> Readings<'_> {
        self.forget_reported();
        if self.has_read { Readings::Poses(&self.poses) } else { Readings::Untracked }
    }

    /// Marks the readings as part of a state. Later readings belong to the next state.
    pub const fn report(&mut self) {
        self.is_reported = true;
    }

    /// Cancels the last [`report`](Self::report), because its state was not stored. Call this
    /// method before the next reading.
    pub const fn undo_report(&mut self) {
        self.is_reported = false;
    }

    /// Removes all readings.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    fn forget_reported(&mut self) {
        if self.is_reported {
            self.poses.clear();
            self.is_reported = false;
        }
    }
}
