//! What is kept of simulations: how much, and where.

use mmsim_server::{RecordError, Recorder, Simulation};
use sysinfo::{MemoryRefreshKind, System};

use crate::args::KeepArgs;
use crate::output::say;
use crate::selection::Selected;

const MIB: u64 = 1 << 20;

/// A simulation of the selected maze, its history limited as told.
pub(crate) fn simulation(selected: Selected, args: &KeepArgs) -> Simulation {
    let limit = args.history_limit.unwrap_or_else(half_of_free_memory).saturating_mul(MIB);
    Simulation::new(&selected.name, selected.maze)
        .with_history_limit(usize::try_from(limit).unwrap_or(usize::MAX))
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

/// Half of the memory that is free for this process, in mebibytes, and at least one.
fn half_of_free_memory() -> u64 {
    let mut system = System::new();
    system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    // A container may have less than its machine.
    let free = system
        .cgroup_limits()
        .map_or(u64::MAX, |limits| limits.free_memory)
        .min(system.available_memory());
    (free / 2 / MIB).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_free_memory_is_less_than_the_machine_has() {
        let mut system = System::new();
        system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        assert!((1..=system.total_memory() / 2 / MIB).contains(&half_of_free_memory()));
    }
}
