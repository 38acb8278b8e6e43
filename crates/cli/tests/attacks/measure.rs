//! Measuring the resources of a process on Linux.

use std::fs;

use mmsim_tests::wait_for;

/// The maximum memory growth after an attack, in KiB.
const MAX_GROWTH_KIB: u64 = 32 * 1024;

/// The maximum growth in peak memory during the attacks, in KiB.
const MAX_PEAK_GROWTH_KIB: u64 = 64 * 1024;

/// The resource usage of a process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Resources {
    /// Memory in KiB.
    pub(crate) memory: u64,
    /// Peak memory in KiB.
    peak: u64,
    threads: u64,
    descriptors: usize,
}

impl Resources {
    /// Returns the resource usage of a process, or `None` on systems other than Linux.
    pub(crate) fn from_process(process: u32) -> Option<Self> {
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

    /// Waits until the process uses no more resources than recorded in `self`, apart from permitted
    /// memory growth.
    pub(crate) fn wait_until_back(&self, process: u32) {
        let what = format!("the server to use no more than {self:?}");
        wait_for(&what, || {
            let now = Self::from_process(process).expect("the server is still running");
            assert!(now.peak <= self.memory + MAX_PEAK_GROWTH_KIB, "from {self:?} to {now:?}");
            let back = now.memory <= self.memory + MAX_GROWTH_KIB
                && now.threads == self.threads
                && now.descriptors == self.descriptors;
            back.then(|| println!("  before {self:?}\n  after  {now:?}"))
        });
    }
}
