//! How much of simulations and recordings is kept, and where.

use std::sync::Arc;

use mmsim_recording::MemoryBudget;
use mmsim_server::Simulation;

use crate::args::{ReadingArgs, RetentionArgs};
use crate::memory;
use crate::output::note;

const MIB: u64 = 1 << 20;

/// The free memory to assume where the system does not report it.
const ASSUMED_FREE_BYTES: u64 = 1 << 30;

/// How much memory a server may use for states.
pub(crate) struct MemoryLimits {
    /// For the live history, in bytes.
    pub(crate) history: usize,
    /// For the recordings that are open in the viewer.
    pub(crate) recordings: Arc<MemoryBudget>,
}

impl MemoryLimits {
    /// Returns the limits from the arguments. By default, the history may use half of the free memory
    /// and recordings a quarter. Call this before sockets use up the file descriptors.
    pub(crate) fn new(args: &RetentionArgs) -> Self {
        let free = memory::free().unwrap_or(ASSUMED_FREE_BYTES);
        let limit = |part| bytes(args.history_limit, free / part);
        let recordings = Arc::new(MemoryBudget::new(limit(4)));
        Self { history: limit(2), recordings }
    }
}

/// Returns the memory for recordings where nothing is served, by default half of the free memory.
pub(crate) fn recording_budget(args: &ReadingArgs) -> Arc<MemoryBudget> {
    let free = memory::free().unwrap_or(ASSUMED_FREE_BYTES);
    Arc::new(MemoryBudget::new(bytes(args.history_limit, free / 2)))
}

/// Converts mebibytes to bytes. Without a number, returns `default`, but at least one mebibyte.
fn bytes(mebibytes: Option<u64>, default: u64) -> usize {
    let bytes = mebibytes.map_or(default.max(MIB), |mebibytes| mebibytes.saturating_mul(MIB));
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// Reports the limit of the history and the folder of recordings.
pub(crate) fn report(args: &RetentionArgs, simulation: &Simulation) {
    let mib = simulation.history().limit() as u64 / MIB;
    match args.history_limit {
        None => note(format_args!(
            "keeping up to {mib} MiB of states, half of the free memory (change with --history-limit)"
        )),
        Some(_) => note(format_args!("keeping up to {mib} MiB of states")),
    }
    if let Some(folder) = &args.record {
        note(format_args!("recording to {}", folder.display()));
    }
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
