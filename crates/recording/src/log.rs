//! Reads log lines from the newest to the oldest.

use std::convert::Infallible;

use mmsim_maze::MazeSize;
use mmsim_protocol::Annotation;

use crate::block::Block;
use crate::changes::Change;
use crate::context_block::UpdateData;
use crate::history::History;
use crate::update::StoredUpdate;

/// A log line of a mouse.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// The index of the state that follows the line.
    pub state: usize,
    /// The line.
    pub text: String,
}

/// A copy of the log lines in one [`Block`] of a history.
#[derive(Clone, Debug)]
pub struct LogBlock {
    pub(crate) block: usize,
    pub(crate) updates: UpdateData,
    pub(crate) size: MazeSize,
}

impl LogBlock {
    /// Returns the lines in order, or `None` if memory runs out.
    fn lines(self) -> Option<Vec<LogLine>> {
        let updates = self.updates.unpack().ok()?;
        let mut lines = Vec::new();
        for (index, update) in updates.iter() {
            let Ok(update) = StoredUpdate::decode(update, self.size) else { continue };
            lines.extend(update.changes.iter().filter_map(|change| match change {
                Change::Other(Annotation::Log(text)) => {
                    Some(LogLine { state: self.block * Block::STATES + index, text: text.into() })
                }
                _ => None,
            }));
        }
        Some(lines)
    }
}

/// Returns the last `max` log lines that match a filter, up to the state with the index `last`, in
/// order. Lines of a block are skipped if memory runs out.
///
/// `read` returns the last block with log lines up to a block index, as
/// [`History::log_block`] does.
///
/// # Errors
/// Returns the first error from `read`.
pub fn read_log<E>(
    last: usize,
    max: usize,
    filter: impl Fn(&str) -> bool,
    mut read: impl FnMut(usize) -> Result<Option<LogBlock>, E>,
) -> Result<Vec<LogLine>, E> {
    let (mut found, mut next) = (Vec::new(), Some(last / Block::STATES));
    while let Some(block) = next.filter(|_| found.len() < max).map(&mut read).transpose()?.flatten()
    {
        next = block.block.checked_sub(1);
        let lines = block.lines().unwrap_or_default().into_iter().rev();
        let matching = lines.filter(|line| line.state <= last && filter(&line.text));
        found.extend(matching.take(max - found.len()));
    }
    found.reverse();
    Ok(found)
}

impl History {
    /// Returns the last `max` log lines that match a filter, up to the state with the index `last`,
    /// in order.
    pub fn log(&self, last: usize, max: usize, filter: impl Fn(&str) -> bool) -> Vec<LogLine> {
        let read = |block| Ok::<_, Infallible>(self.log_block(block));
        read_log(last, max, filter, read).unwrap_or_else(|never| match never {})
    }
}
