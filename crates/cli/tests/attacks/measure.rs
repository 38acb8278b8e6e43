//! The resources of a process, as reported by Linux.

use std::fs;

use mmsim_tests::wait_for;

/// The maximum growth of memory after an attack, in KiB.
const MORE_MEMORY: u64 = 32 * 1024;

/// The maximum growth of peak memory during the attacks, in KiB.
const MORE_AT_ITS_PEAK: u64 = 64 * 1024;

/// The resources of a process at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Memory in KiB.
    pub(crate) memory: u64,
    /// Peak memory in KiB.
    peak: u64,
    threads: u64,
    descriptors: usize,
}

impl Held {
    /// Returns the resources of a process, `None` on other systems.
    pub(crate) fn by(process: u32) -> Option<Self> {
        let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        let number = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name))?;
            line.trim().trim_end_matches(" kB").parse().ok()
        };
        Some(Self {
            memory: number("VmRSS:")?,
            peak: number("VmHWM:")?,
            threads: number("Threads:")?,
            descriptors: fs::read_dir(format!("/proc/{process}/fd")).ok()?.count(),
        })
    }

    /// Waits until the process uses no more than at this moment.
    pub(crate) fn wait_until_back(&self, process: u32) {
        let what = format!("the server to hold no more than {self:?}");
        wait_for(&what, || {
            let now = Self::by(process).expect("the server has ended");
            assert!(now.peak <= self.memory + MORE_AT_ITS_PEAK, "from {self:?} to {now:?}");
            let back = now.memory <= self.memory + MORE_MEMORY
                && now.threads == self.threads
                && now.descriptors == self.descriptors;
            back.then(|| println!("  before {self:?}\n  after  {now:?}"))
        });
    }
}
