//! Steps and turns of a mouse from state to state.

use std::ops::AddAssign;

/// Steps and turns from the first state of a history to one of its states.
///
/// ```
/// use mmsim_server::{History, MotionCount};
/// let mut history = History::new(mmsim_maze::MazeSize::new(2, 1)?);
/// history.push(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// history.push(b"S\x01\x00EC\x01\x00C\x0d\x17")?;
/// assert_eq!(history.tally(1), Some(MotionCount { steps: 1, turns: 1 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionCount {
    /// Steps of one cell. Two states that are further apart count by rows and columns.
    pub steps: u64,
    /// Quarter turns. A U-turn counts as two.
    pub turns: u64,
}

impl AddAssign for MotionCount {
    fn add_assign(&mut self, other: Self) {
        self.steps += other.steps;
        self.turns += other.turns;
    }
}

impl MotionCount {
    /// Counts the steps and turns between the poses of two successive states.
    pub(crate) fn between([x, y, heading]: [u8; 3], [to_x, to_y, to_heading]: [u8; 3]) -> Self {
        let steps = u64::from(x.abs_diff(to_x)) + u64::from(y.abs_diff(to_y));
        let turns = match (quarter(heading), quarter(to_heading)) {
            (Some(from), Some(to)) => [0, 1, 2, 1][(4 + to - from) % 4],
            _ => 0,
        };
        Self { steps, turns }
    }
}

/// Returns the bytes of the pose: x, y and the letter of the heading.
pub(crate) fn pose(state: &[u8]) -> Option<[u8; 3]> {
    state.get(1..)?.first_chunk().copied()
}

fn quarter(letter: u8) -> Option<usize> {
    b"NESW".iter().position(|&heading| heading == letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_count_rows_and_columns_and_turns_count_quarters() {
        let tally = |before: &[u8], after: &[u8]| {
            let MotionCount { steps, turns } =
                MotionCount::between(pose(before).unwrap(), pose(after).unwrap());
            (steps, turns)
        };
        assert_eq!(tally(b"S\x00\x00N", b"S\x00\x01N"), (1, 0));
        assert_eq!(tally(b"S\x03\x05N", b"S\x01\x09W"), (6, 1));
        assert_eq!(tally(b"S\x03\x05E", b"S\x03\x05W"), (0, 2));
        assert_eq!(tally(b"S\x03\x05W", b"S\x03\x05N"), (0, 1));
        assert_eq!(pose(b"S\x00\x00"), None);
        assert_eq!(tally(b"S\x00\x00?", b"S\x00\x02N"), (2, 0));
    }
}
