//! What a process holds, as Linux tells it.

use std::fs;

use mmsim_tests::wait_for;

/// After an attack no more memory may be held than this beyond what was held before, in KiB.
const MORE_MEMORY: u64 = 32 * 1024;

/// Nor may there have been more than this at any time while the attacks went on, in KiB.
const MORE_AT_ITS_PEAK: u64 = 64 * 1024;

/// What a process holds at a moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Memory in KiB …
    pub(crate) memory: u64,
    /// … and the most there has been.
    peak: u64,
    threads: u64,
    descriptors: usize,
}

impl Held {
    /// What the process with this id holds; nothing on systems that do not say.
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

    /// Waits until the process holds no more than it did at this moment.
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
