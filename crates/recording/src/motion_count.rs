//! Counts the steps and turns between states.

use mmsim_maze::Pose;

/// The steps and turns from the first state of a history to another state.
///
/// ```
/// use mmsim_recording::{History, MotionCount};
/// let mut history = History::new(mmsim_maze::MazeSize::new(2, 1)?);
/// history.push(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// history.push(b"S\x01\x00EC\x01\x00C\x0d\x17")?;
/// let states = history.block(0).and_then(|block| block.unpack()).expect("a block");
/// assert_eq!(states.motion_count(1), Some(MotionCount { steps: 1, turns: 1 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionCount {
    /// The number of steps: the sum of the Manhattan distances between consecutive cells.
    pub steps: u64,
    /// The number of quarter turns. A U-turn counts as two.
    pub turns: u64,
}

impl MotionCount {
    /// Adds the motion between the poses of two consecutive states.
    pub(crate) fn add(&mut self, from: Pose, to: Pose) {
        let (dx, dy) = (from.cell.x.abs_diff(to.cell.x), from.cell.y.abs_diff(to.cell.y));
        self.steps += u64::from(dx) + u64::from(dy);
        self.turns += match to.heading {
            heading if heading == from.heading => 0,
            heading if heading == from.heading.back() => 2,
            _ => 1,
        };
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Heading::{East, North, West};
    use mmsim_maze::{Cell, Heading};

    use super::*;

    #[test]
    fn steps_are_manhattan_distances_and_turns_are_quarters() {
        let motion = |from: (u8, u8, Heading), to: (u8, u8, Heading)| {
            let [from, to] = [from, to].map(|(x, y, heading)| Pose::new(Cell::new(x, y), heading));
            let mut motion = MotionCount { steps: 10, turns: 20 };
            motion.add(from, to);
            (motion.steps - 10, motion.turns - 20)
        };
        assert_eq!(motion((0, 0, North), (0, 1, North)), (1, 0));
        assert_eq!(motion((3, 5, North), (1, 9, West)), (6, 1));
        assert_eq!(motion((3, 5, East), (3, 5, West)), (0, 2));
        assert_eq!(motion((3, 5, West), (3, 5, North)), (0, 1));
    }
}
