//! A child process together with its own child processes.

use std::io;
use std::process::{Child, Command};

/// A process and its child processes, which are killed together.
pub(crate) struct ProcessGroup(system::Group);

impl ProcessGroup {
    /// Starts a process in a new group.
    pub(crate) fn spawn(command: &mut Command) -> io::Result<(Child, Self)> {
        system::spawn(command).map(|(child, group)| (child, Self(group)))
    }

    /// Kills all processes of the group. May be called again after the process has exited.
    pub(crate) fn kill(&mut self) {
        system::kill(&mut self.0);
    }
}

#[cfg(unix)]
mod system {
    use std::io;
    use std::os::unix::process::CommandExt;
    use std::process::{Child, Command};

    use rustix::process::{Pid, Signal, kill_process_group};

    pub(super) type Group = Pid;

    pub(super) fn spawn(command: &mut Command) -> io::Result<(Child, Group)> {
        let child = command.process_group(0).spawn()?;
        let group = Pid::from_child(&child);
        Ok((child, group))
    }

    pub(super) fn kill(group: &mut Group) {
        let _ = kill_process_group(*group, Signal::KILL);
    }
}

#[cfg(windows)]
mod system {
    use std::io;
    use std::os::windows::io::AsRawHandle;
    use std::process::{Child, Command};

    use win32job::{ExtendedLimitInfo, Job};

    /// A job object. Windows kills its processes when its last handle is closed, also if this process
    /// is killed.
    pub(super) type Group = Option<Job>;

    pub(super) fn spawn(command: &mut Command) -> io::Result<(Child, Group)> {
        let mut limits = ExtendedLimitInfo::new();
        let job = Job::create_with_limit_info(limits.limit_kill_on_job_close());
        let child = command.spawn()?;
        // Without a job object, only the process itself can be killed. A job object contains only
        // processes that are started after its first process has been added.
        let job = job.ok().filter(|job| job.assign_process(child.as_raw_handle() as isize).is_ok());
        Ok((child, job))
    }

    pub(super) fn kill(group: &mut Group) {
        drop(group.take());
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;
    use std::sync::mpsc;
    use std::thread;
    use std::time::Duration;

    use super::*;

    /// The child process keeps the pipe open, so the pipe ends only if it is killed too.
    #[test]
    fn child_processes_are_killed() {
        let mut command = if cfg!(windows) {
            let mut command = Command::new("cmd");
            command.args(["/c", "echo started& cmd /c pause"]);
            command
        } else {
            let mut command = Command::new("sh");
            command.args(["-c", "echo started; sleep 1000; exit"]);
            command
        };
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let (mut child, mut group) = ProcessGroup::spawn(command).unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let (sender, end) = mpsc::channel();
        thread::spawn(move || {
            let mut line = String::new();
            output.read_line(&mut line).unwrap();
            assert_eq!(line.trim_end(), "started");
            group.kill();
            while output.read_line(&mut line).unwrap() > 0 {}
            sender.send(()).unwrap();
        });
        end.recv_timeout(Duration::from_secs(300)).expect("the end of the output");
        child.wait().unwrap();
    }
}
