//! The memory available to this process.

pub(crate) use system::free;

/// Restarts this program with one arena of glibc for all threads if its address space is limited. By
/// default, glibc reserves at least 64 MiB of address space for each thread that allocates, and a
/// thread cannot use the reserve of another.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn share_arena() {
    use std::env;
    use std::os::unix::process::CommandExt as _;
    use std::process::Command;

    use mmsim_mouse::ONE_ARENA;
    use rustix::process::{Resource, getrlimit};

    let is_limited = getrlimit(Resource::As).current.is_some();
    if is_limited
        && ONE_ARENA.iter().all(|name| env::var_os(name).is_none())
        && let Ok(program) = env::current_exe()
    {
        let mut arguments = env::args_os();
        let name = arguments.next().unwrap_or_default();
        // If this fails, fewer states fit.
        let _ = Command::new(program)
            .arg0(name)
            .args(arguments)
            .envs(ONE_ARENA.map(|name| (name, "1")))
            .exec();
    }
}

#[cfg(target_os = "linux")]
mod system {
    use std::fs;
    use std::path::{Path, PathBuf};

    use mmsim_recording::free_within_limits;

    /// Linux control groups, versions 2 and 1. Each entry holds the mount point, the names of the
    /// limit file and the usage file, and the key in `memory.stat` for reclaimable file pages.
    const GROUPS: [[&str; 4]; 2] = [
        ["sys/fs/cgroup", "memory.max", "memory.current", "inactive_file "],
        [
            "sys/fs/cgroup/memory",
            "memory.limit_in_bytes",
            "memory.usage_in_bytes",
            "total_inactive_file ",
        ],
    ];

    /// Returns the free memory in bytes, or `None` if the system does not report it. Respects the
    /// limits of this process and of its control groups.
    pub(crate) fn free() -> Option<u64> {
        let root = Path::new("/");
        [free_within_limits(), machine(root), groups(root)].into_iter().flatten().min()
    }

    /// Returns the free memory of the machine.
    pub(super) fn machine(root: &Path) -> Option<u64> {
        after(&read(root.join("proc/meminfo"))?, "MemAvailable:")?.checked_mul(1024)
    }

    /// Returns the memory left under the limits of this process's control groups and their
    /// ancestors.
    pub(super) fn groups(root: &Path) -> Option<u64> {
        let groups = read(root.join("proc/self/cgroup"))?;
        let own =
            |line: &str| Some(line.splitn(3, ':').nth(2)?.trim_start_matches('/').to_string());
        let paths: Vec<String> = groups.lines().filter_map(own).collect();
        let with_parents = || paths.iter().flat_map(|path| Path::new(path).ancestors());
        let free = GROUPS.iter().flat_map(|[folder, files @ ..]| {
            let folder = root.join(folder);
            with_parents().filter_map(move |path| group(&folder.join(path), files))
        });
        free.min()
    }

    /// Returns the memory left under the limit of one control group.
    fn group(folder: &Path, [limit, used, reclaimable]: &[&str; 3]) -> Option<u64> {
        let number = |name| read(folder.join(name))?.trim().parse().ok();
        // Without a limit, the file holds `max`.
        let (limit, used): (u64, u64) = (number(limit)?, number(used)?);
        let statistics = read(folder.join("memory.stat")).unwrap_or_default();
        let reclaimable = after(&statistics, reclaimable).unwrap_or_default();
        Some(limit.saturating_sub(used.saturating_sub(reclaimable)))
    }

    pub(super) fn read(path: PathBuf) -> Option<String> {
        fs::read_to_string(path).ok()
    }

    /// Returns the number that follows `key` in the line that starts with `key`.
    pub(super) fn after(text: &str, key: &str) -> Option<u64> {
        text.lines()
            .find_map(|line| line.strip_prefix(key)?.split_whitespace().next()?.parse().ok())
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use sysinfo::{MemoryRefreshKind, System};

    /// Returns the free memory in bytes, or `None` if the system does not report it.
    pub(crate) fn free() -> Option<u64> {
        let mut system = System::new();
        system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        Some(system.available_memory()).filter(|&free| free > 0)
    }
}

#[cfg(target_os = "linux")]
#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::system::*;

    /// Creates a temporary folder that holds `files`.
    fn root(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (path, content) in files {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
        }
        root
    }

    #[test]
    fn the_minimum_of_a_group_and_its_ancestors_counts() {
        let new = root(&[
            ("proc/self/cgroup", "0::/user/mouse\n"),
            ("sys/fs/cgroup/user/mouse/memory.max", "max\n"),
            ("sys/fs/cgroup/user/mouse/memory.current", "100\n"),
            ("sys/fs/cgroup/user/memory.max", "1000\n"),
            ("sys/fs/cgroup/user/memory.current", "700\n"),
            ("sys/fs/cgroup/user/memory.stat", "anon 400\ninactive_file 250\n"),
            ("sys/fs/cgroup/memory.max", "5000\n"),
            ("sys/fs/cgroup/memory.current", "100\n"),
        ]);
        assert_eq!(groups(new.path()), Some(550));
        let old = root(&[
            ("proc/self/cgroup", "9:name=systemd:/\n4:memory:/mouse/run\n0::/\n"),
            ("sys/fs/cgroup/memory/mouse/run/memory.limit_in_bytes", "900\n"),
            ("sys/fs/cgroup/memory/mouse/run/memory.usage_in_bytes", "500\n"),
            ("sys/fs/cgroup/memory/mouse/run/memory.stat", "total_inactive_file 50\n"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "2000\n"),
        ]);
        assert_eq!(groups(old.path()), Some(450));
        // In a container, the path may be that of the host.
        let container = root(&[
            ("proc/self/cgroup", "0::/docker/0123\n"),
            ("sys/fs/cgroup/memory.max", "300\n"),
            ("sys/fs/cgroup/memory.current", "400\n"),
        ]);
        assert_eq!(groups(container.path()), Some(0));
        assert_eq!(groups(root(&[("proc/self/cgroup", "0::/\n")]).path()), None);
        assert_eq!(groups(root(&[]).path()), None);
    }

    #[test]
    fn reads_the_free_memory() {
        let root = root(&[("proc/meminfo", "MemTotal: 90 kB\nMemAvailable:   70 kB\n")]);
        assert_eq!(machine(root.path()), Some(70 * 1024));
        assert_eq!(machine(Path::new("/no such folder")), None);
        let all = after(&read("/proc/meminfo".into()).unwrap(), "MemTotal:").unwrap();
        assert!((1..=all * 1024).contains(&free().unwrap()));
    }
}
