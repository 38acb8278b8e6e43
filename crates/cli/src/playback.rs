//! Errors and warnings about recordings.

use std::path::Path;

use mmsim_recording::{Integrity, Recording};

use crate::output::warn;

/// Formats the error for an `--at` index beyond the last state of the recording.
pub(crate) fn no_state(file: &Path, recording: &Recording, index: usize) -> String {
    let file = file.display();
    match recording.history().len().checked_sub(1) {
        Some(last) => format!("{file}: no state {index} (--at takes 0 to {last})"),
        None => format!("{file}: no state {index}: the recording has no states"),
    }
}

/// Returns true if the recording is undamaged. Otherwise, prints a warning and returns false.
pub(crate) fn is_undamaged(file: &Path, recording: &Recording) -> bool {
    let Integrity::Damaged { intact, reason } = recording.integrity() else { return true };
    warn(format_args!("{}: damaged after byte {intact}: {reason}", file.display()));
    false
}
