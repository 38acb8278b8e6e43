//! What is kept of simulations and recordings: how much, and where.

use std::sync::Arc;

use mmsim_recording::{MemoryBudget, RecordError, Recorder};
use mmsim_server::Simulation;

use crate::args::{KeepArgs, ReadingArgs};
use crate::memory;
use crate::output::say;
use crate::selection::Selected;

const MIB: u64 = 1 << 20;

/// The free memory that is assumed where the system does not tell.
const UNKNOWN: u64 = 1 << 30;

/// How much memory a server may take for states.
pub(crate) struct Limits {
    /// That of the live history, in bytes.
    history: usize,
    /// That of the recordings which are open on the page.
    pub(crate) recordings: Arc<MemoryBudget>,
}

impl Limits {
    /// As much as the arguments say of each, by default half of the free memory for the history and
    /// half of the rest for recordings. To be asked for before sockets take all descriptors.
    pub(crate) fn new(args: &KeepArgs) -> Self {
        let free = memory::free().unwrap_or(UNKNOWN);
        let limit = |part| limit(args.history_limit, free / part);
        let recordings = Arc::new(MemoryBudget::new(limit(4)));
        Self { history: limit(2), recordings }
    }

    /// A simulation of the selected maze.
    pub(crate) fn simulation(&self, selected: Selected) -> Simulation {
        Simulation::new(&selected.name, selected.maze).with_history_limit(self.history)
    }
}

/// The memory for recordings where nothing is served, by default half of the free one.
pub(crate) fn budget(args: &ReadingArgs) -> Arc<MemoryBudget> {
    let free = memory::free().unwrap_or(UNKNOWN);
    Arc::new(MemoryBudget::new(limit(args.history_limit, free / 2)))
}

/// So many mebibytes in bytes, or by default this many bytes, at least a mebibyte.
fn limit(mebibytes: Option<u64>, default: u64) -> usize {
    let bytes = mebibytes.map_or(default.max(MIB), |mebibytes| mebibytes.saturating_mul(MIB));
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// What records the simulations, if that is asked for.
pub(crate) fn recorder(args: &KeepArgs) -> Result<Option<Recorder>, RecordError> {
    args.record.as_deref().map(Recorder::new).transpose()
}

/// Says what is kept and where.
pub(crate) fn announce(args: &KeepArgs, simulation: &Simulation) {
    let mib = simulation.history().limit() as u64 / MIB;
    match args.history_limit {
        None => say(format_args!(
            "keeping up to {mib} MiB of states, half of the free memory; --history-limit changes that"
        )),
        Some(_) => say(format_args!("keeping up to {mib} MiB of states")),
    }
    if let Some(folder) = &args.record {
        say(format_args!("recording to {}", folder.display()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_told_or_parts_of_the_free_memory() {
        assert_eq!(limit(Some(7), 0), 7 << 20);
        assert_eq!(limit(Some(u64::MAX), 0), usize::MAX);
        assert_eq!((limit(None, 1), limit(None, 5 << 20)), (1 << 20, 5 << 20));
        let Limits { history, recordings } = Limits::new(&KeepArgs::default());
        assert!(recordings.limit() <= history && history / 2 <= recordings.limit());
    }
}
