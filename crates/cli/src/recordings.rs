//! The memory limits of histories and recordings, and messages about them.

use std::error::Error;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use mmsim_compare::NamedMaze;
use mmsim_maze::{Maze, Unknown, counted};
use mmsim_protocol::State;
use mmsim_recording::{IgnoredRecords, Integrity, MemoryBudget, NewMessages, ReadError, Recording};
use mmsim_run::messages;
use mmsim_server::Simulation;
use tracing::info;

use crate::args::{ReadingArgs, RetentionArgs};
use crate::memory;
use crate::output::{note, own_command, warn};
use crate::selection::Selection;

const MIB: u64 = 1 << 20;

/// The amount of free memory to assume if the system does not report it, in bytes.
const ASSUMED_FREE_BYTES: u64 = 1 << 30;

/// The memory limits of a server.
pub(crate) struct MemoryLimits {
    /// The limit of the live history, in bytes.
    pub(crate) history: usize,
    /// The memory budget for recordings that are open in the viewer.
    pub(crate) recordings: Arc<MemoryBudget>,
}

impl MemoryLimits {
    /// Returns the limits set by the arguments. By default, the history may use half of the free
    /// memory and recordings may use a quarter. Call this before the server opens sockets, because
    /// measuring free memory needs a file descriptor.
    pub(crate) fn new(args: &RetentionArgs) -> Self {
        let free = memory::free().unwrap_or(ASSUMED_FREE_BYTES);
        let limit = |part| bytes(args.history_limit, free / part);
        let recordings = Arc::new(MemoryBudget::new(limit(4)));
        Self { history: limit(2), recordings }
    }
}

/// Returns the messages for other tools, unless a recording must contain only the states.
pub(crate) fn messages_unless(states_only: bool) -> Option<NewMessages> {
    let new: NewMessages = messages;
    (!states_only).then_some(new)
}

/// Returns the memory budget of a command that only reads recordings, by default half of the free
/// memory.
pub(crate) fn recording_budget(args: &ReadingArgs) -> Arc<MemoryBudget> {
    let free = memory::free().unwrap_or(ASSUMED_FREE_BYTES);
    Arc::new(MemoryBudget::new(bytes(args.history_limit, free / 2)))
}

/// Opens a recording.
pub(crate) fn open(file: &Path, budget: &Arc<MemoryBudget>) -> Result<Recording, Box<dyn Error>> {
    Recording::open_within(file, budget).map_err(|error| match &error.source {
        ReadError::NotMcap | ReadError::Io(_) if is_maze(file) => {
            let file = file.display();
            let show = own_command(&format!("mazes show {file}"));
            format!("{file} is a maze, not a recording (show it with {show})").into()
        }
        ReadError::Io(_) if file.is_dir() => {
            format!("{} is a folder (name a recording in it)", file.display()).into()
        }
        ReadError::Io(source) if source.kind() == ErrorKind::NotFound => {
            format!("no such file: {}", file.display()).into()
        }
        _ => error.into(),
    })
}

/// Returns the walls that the mouse of a recording knows in its last state, as a maze in which each
/// unknown wall is present, and whether the recording is undamaged.
pub(crate) fn known_walls(
    file: &Path,
    budget: &Arc<MemoryBudget>,
) -> Result<(NamedMaze, bool), Box<dyn Error>> {
    let recording = open(file, budget)?;
    let is_undamaged = is_undamaged(file, &recording);
    let known = || {
        let last = recording.history().len().checked_sub(1)?;
        let state = recording.history().get(last)?;
        let state = State::decode(&state, recording.size()).ok()?;
        let unexplored = recording.info().known_maze()?;
        Some(recording.last_context().known_maze(&state, &unexplored, recording.maze()))
    };
    let no_state = || format!("{}: the recording has no state with known walls", file.display());
    let known = known().ok_or_else(no_state)?;
    let walls = known.walls(Unknown::Closed).clone();
    let maze = Maze::new(walls, known.start().cell, *known.goals())?;
    let name = recording.info().maze.clone();
    Ok((NamedMaze { path: file.into(), name, maze }, is_undamaged))
}

fn is_maze(file: &Path) -> bool {
    Selection::read(file.as_os_str()).is_ok_and(|selection| selection.first().is_ok())
}

/// Converts mebibytes to bytes. For `None`, returns `default` bytes, but at least one mebibyte.
fn bytes(mebibytes: Option<u64>, default: u64) -> usize {
    let bytes = mebibytes.map_or(default.max(MIB), |mebibytes| mebibytes.saturating_mul(MIB));
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// Prints the folder for recordings, if any, and logs the limit of the history.
pub(crate) fn report(args: &RetentionArgs, simulation: &Simulation) {
    let mib = simulation.history().limit() as u64 / MIB;
    let default = ", half of the free memory (change with --history-limit)";
    let part = if args.history_limit.is_none() { default } else { "" };
    info!("keeping up to {mib} MiB of states{part}");
    if let Some(folder) = &args.record {
        note(format_args!("recording to {}", folder.display()));
    }
}

/// Formats the error for an `--at` index beyond the last state of the recording.
pub(crate) fn no_state(file: &Path, recording: &Recording, index: usize) -> String {
    let file = file.display();
    match recording.history().len().checked_sub(1) {
        Some(last) => format!("{file}: no state {index} (--at takes 0 to {last})"),
        None => format!("{file}: no state {index}: the recording has no states"),
    }
}

/// Returns true if the recording is undamaged. Otherwise, prints a warning and returns false. Prints
/// a note if the file has other records than those of the recording.
pub(crate) fn is_undamaged(file: &Path, recording: &Recording) -> bool {
    let IgnoredRecords { messages, attachments } = recording.ignored();
    if messages > 0 || attachments > 0 {
        let [messages, attachments] =
            [(messages, "message"), (attachments, "attachment")].map(|(n, of)| counted(n, of));
        let file = file.display();
        note(format_args!("{file}: ignored {messages} and {attachments} of other programs"));
    }
    let Integrity::Damaged { intact, reason } = recording.integrity() else { return true };
    warn(format_args!("{}: damaged after byte {intact}: {reason}", file.display()));
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_default_to_parts_of_the_free_memory() {
        assert_eq!(bytes(Some(7), 0), 7 << 20);
        assert_eq!(bytes(Some(u64::MAX), 0), usize::MAX);
        assert_eq!((bytes(None, 1), bytes(None, 5 << 20)), (1 << 20, 5 << 20));
        let MemoryLimits { history, recordings } = MemoryLimits::new(&RetentionArgs::default());
        assert!(recordings.limit() <= history && history / 2 <= recordings.limit());
    }
}
