//! The reset button of a mouse.

use std::io::{self, IsTerminal, Read};
use std::sync::Arc;
use std::thread;

use mmsim_mouse::MouseControl;

use crate::output::note;

/// Makes each line on stdin press the reset button of the mouse.
pub(super) fn press_on_input(control: Arc<MouseControl>) {
    if is_in_foreground() && io::stdin().is_terminal() {
        note("press Enter to press the mouse's reset button");
    }
    thread::spawn(move || {
        let (mut stdin, mut typed) = (io::stdin().lock(), [0; 256]);
        while wait_for_line()
            && let Ok(length @ 1..) = stdin.read(&mut typed)
        {
            if typed[..length].contains(&b'\n') {
                control.press_reset();
            }
        }
    });
}

/// Returns true if this process may read from the terminal. The system stops background processes
/// that read from a terminal.
#[cfg(unix)]
fn is_in_foreground() -> bool {
    let foreground = rustix::termios::tcgetpgrp(rustix::stdio::stdin());
    foreground.is_ok_and(|group| group == rustix::process::getpgrp())
}

#[cfg(not(unix))]
const fn is_in_foreground() -> bool {
    true
}

/// Waits until there is input for this process. Returns false if no input can arrive.
#[cfg(unix)]
fn wait_for_line() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    if !io::stdin().is_terminal() {
        return true;
    }
    let stdin = rustix::stdio::stdin();
    let timeout = Timespec { tv_sec: 0, tv_nsec: 200_000_000 };
    loop {
        let mut ready = [PollFd::new(&stdin, PollFlags::IN)];
        match poll(&mut ready, Some(&timeout)) {
            Ok(_) if ready[0].revents().intersects(PollFlags::ERR | PollFlags::NVAL) => {
                return false;
            }
            Ok(1..) if is_in_foreground() => return true,
            // Input for another process stays ready, so do not spin.
            Ok(1..) => thread::sleep(std::time::Duration::from_millis(200)),
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(_) => return false,
        }
    }
}

#[cfg(not(unix))]
const fn wait_for_line() -> bool {
    true
}
