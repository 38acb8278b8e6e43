//! Reads log lines from the newest to the oldest or vice versa.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use mmsim_maze::MazeSize;
use mmsim_protocol::Annotation;
use serde::Serialize;

use crate::context::changes::Change;
use crate::context::update::StoredUpdate;
use crate::history::block::{Block, UpdateData};

/// A log line of a mouse. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LogLine {
    /// The index of the state that follows the line, which is the number of states if there is none.
    pub state: usize,
    /// The line.
    pub text: String,
}

/// The end of a log at which reading begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogEnd {
    /// Reads the first lines.
    First,
    /// Reads the last lines.
    Last,
}

/// A copy of the log lines in one [`Block`] of a history.
#[derive(Clone, Debug)]
pub struct LogBlock {
    pub(crate) block: usize,
    pub(crate) updates: UpdateData,
    pub(crate) size: MazeSize,
}

impl LogBlock {
    /// Returns the first or last `max` lines that match a filter and belong to a range of states, in
    /// order. Returns `None` if memory runs out.
    fn lines(
        self,
        states: &RangeInclusive<usize>,
        end: LogEnd,
        max: usize,
        filter: impl Fn(&str) -> bool,
    ) -> Option<Vec<LogLine>> {
        let updates = self.updates.unpack().ok()?;
        let first = self.block * Block::STATES;
        let matching = updates
            .iter()
            .map(|(index, update)| (first + index, update))
            .filter(|(state, _)| states.contains(state))
            .filter_map(|(state, update)| {
                Some((state, StoredUpdate::decode(update, self.size).ok()?.changes))
            })
            .flat_map(|(state, changes)| changes.iter().map(move |change| (state, change)))
            .filter_map(|(state, change)| match change {
                Change::Other(Annotation::Log(text)) if filter(text) => Some((state, text)),
                _ => None,
            });
        let mut kept = VecDeque::new();
        match end {
            LogEnd::First => kept.extend(matching.take(max)),
            LogEnd::Last => {
                for line in matching {
                    if kept.len() == max {
                        kept.pop_front();
                    }
                    kept.push_back(line);
                }
            }
        }
        let line = |(state, text): (usize, &str)| LogLine { state, text: text.into() };
        Some(kept.into_iter().map(line).collect())
    }
}

/// Returns the first or last `max` log lines that match a filter and belong to a range of states, in
/// order. Reads no more blocks than necessary, one at a time, and skips the lines of a block if
/// memory runs out.
///
/// `read` returns the first or last block with log lines in a range of blocks, as
/// [`History::log_block`](crate::History::log_block) does.
///
/// # Errors
/// Returns the first error from `read`.
pub fn read_log<E>(
    states: &RangeInclusive<usize>,
    end: LogEnd,
    max: usize,
    filter: impl Fn(&str) -> bool,
    mut read: impl FnMut(RangeInclusive<usize>, LogEnd) -> Result<Option<LogBlock>, E>,
) -> Result<Vec<LogLine>, E> {
    let (mut first, mut last) = (states.start() / Block::STATES, states.end() / Block::STATES);
    let mut found = VecDeque::new();
    while !states.is_empty()
        && first <= last
        && found.len() < max
        && let Some(block) = read(first..=last, end)?
    {
        let index = block.block;
        let lines = block.lines(states, end, max - found.len(), &filter).unwrap_or_default();
        match end {
            LogEnd::First => {
                found.extend(lines);
                first = index + 1;
            }
            LogEnd::Last => {
                lines.into_iter().rev().for_each(|line| found.push_front(line));
                let Some(before) = index.checked_sub(1) else { break };
                last = before;
            }
        }
    }
    Ok(found.into())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::convert::Infallible;

    use mmsim_protocol::Annotations;

    use super::*;
    use crate::context::update::UpdateTracker;
    use crate::history::{History, PushError};

    const STATE: &[u8] = b"S\0\0NC\0C\0";

    fn size() -> MazeSize {
        MazeSize::new(1, 1).unwrap()
    }

    /// Appends states. Those whose indices are in `logged` have two lines each.
    fn history(states: usize, logged: &[usize]) -> History {
        let (mut history, mut updates) = (History::new(size()), UpdateTracker::default());
        for index in 0..states {
            if logged.contains(&index) {
                updates
                    .annotate(Annotations::decode(b"AL\x01\0aL\x01\0b", size()).unwrap())
                    .unwrap();
            }
            history.push_with_update(updates.update(), STATE).unwrap();
            updates.report();
        }
        history
    }

    #[test]
    fn only_blocks_with_lines_in_the_range_are_read() {
        let logged = [3, 256 * 4 + 1, 256 * 4 + 2, 256 * 9];
        let history = history(256 * 9 + 5, &logged);
        let all: Vec<_> = logged
            .iter()
            .flat_map(|&state| ["a", "b"].map(|text| LogLine { state, text: text.into() }))
            .collect();
        let blocks = RefCell::new(Vec::new());
        let read = |states, end, max, filter: &str| {
            blocks.borrow_mut().clear();
            read_log(
                &states,
                end,
                max,
                |text| text.contains(filter),
                |range, end| {
                    let block = history.log_block(range, end);
                    blocks.borrow_mut().extend(block.as_ref().map(|block| block.block));
                    Ok::<_, Infallible>(block)
                },
            )
            .unwrap()
        };
        for (states, end, max, expected, expected_blocks) in [
            (0..=usize::MAX, LogEnd::First, usize::MAX, &all[..], &[0, 4, 9][..]),
            (0..=usize::MAX, LogEnd::Last, usize::MAX, &all, &[9, 4, 0]),
            (0..=5000, LogEnd::First, 3, &all[..3], &[0, 4]),
            (0..=5000, LogEnd::Last, 3, &all[5..], &[9, 4]),
            (0..=5000, LogEnd::First, 0, &[], &[]),
            (4..=1025, LogEnd::Last, 9, &all[2..4], &[4, 0]),
            (1026..=2303, LogEnd::First, 9, &all[4..6], &[4]),
            (256..=1000, LogEnd::Last, 9, &[], &[]),
            (1280..=2303, LogEnd::First, 9, &[], &[]),
            (2305..=2306, LogEnd::Last, 9, &[], &[9]),
            (RangeInclusive::new(1025, 1024), LogEnd::Last, 9, &[], &[]),
        ] {
            assert_eq!(read(states.clone(), end, max, ""), expected, "{states:?} {end:?}");
            assert_eq!(*blocks.borrow(), expected_blocks, "{states:?} {end:?}");
        }
        assert_eq!(read(0..=5000, LogEnd::Last, 1, "a"), &all[6..7]);
    }

    #[test]
    fn empty_lines_count_toward_the_limit() {
        let limit = 4 << 20;
        let (mut history, mut updates) =
            (History::with_limit(size(), limit), UpdateTracker::default());
        let request = [&b"A"[..], &b"L\0\0".repeat(1365)].concat();
        let request = Annotations::decode(&request, size()).unwrap();
        let error = loop {
            while updates.annotate(request).is_ok() {}
            let before = history.bytes();
            if let Err(error) = history.push_with_update(updates.update(), STATE) {
                assert_eq!(history.bytes(), before);
                break error;
            }
            updates.report();
        };
        assert_eq!(error, PushError::Full { limit, states: history.len() });
        let lines = history.log(usize::MAX, usize::MAX, |_| true);
        assert!(lines.len() * size_of::<LogLine>() <= limit, "{} lines", lines.len());
        history.clear();
        assert_eq!(history.bytes(), 0);
        history.push_with_update(updates.update(), STATE).unwrap();
        assert!(history.bytes() > 20_000 * size_of::<LogLine>());
        history.undo_push();
        assert_eq!(history.bytes(), 0);
    }
}
