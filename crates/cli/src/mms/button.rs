//! The reset button of a mouse.

use std::io::{self, IsTerminal, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crate::output::say;

/// The reset button: each line on stdin presses it.
pub(super) struct Button(Arc<AtomicBool>);

impl Button {
    pub(super) fn from_stdin() -> Self {
        let pressed = Arc::new(AtomicBool::new(false));
        let button = Arc::clone(&pressed);
        if is_ours() && io::stdin().is_terminal() {
            say("Enter presses the mouse's reset button");
        }
        thread::spawn(move || {
            let (mut stdin, mut typed) = (io::stdin().lock(), [0; 256]);
            while wait_for_line()
                && let Ok(length @ 1..) = stdin.read(&mut typed)
            {
                if typed[..length].contains(&b'\n') {
                    button.store(true, Ordering::Relaxed);
                }
            }
        });
        Self(pressed)
    }

    /// Whether it was pressed since the last time.
    pub(super) fn was_pressed(&self) -> bool {
        self.0.load(Ordering::Relaxed) && self.0.swap(false, Ordering::Relaxed)
    }
}

/// Whether what is typed is for this program: a terminal stops one in the background that reads.
#[cfg(unix)]
fn is_ours() -> bool {
    let of_terminal = rustix::termios::tcgetpgrp(rustix::stdio::stdin());
    of_terminal.is_ok_and(|group| group == rustix::process::getpgrp())
}

#[cfg(not(unix))]
const fn is_ours() -> bool {
    true
}

/// Waits until there is something to read for us; `false` if that will never be.
#[cfg(unix)]
fn wait_for_line() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    if !io::stdin().is_terminal() {
        return true;
    }
    let stdin = rustix::stdio::stdin();
    let glance = Timespec { tv_sec: 0, tv_nsec: 200_000_000 };
    loop {
        let mut ready = [PollFd::new(&stdin, PollFlags::IN)];
        match poll(&mut ready, Some(&glance)) {
            Ok(_) if ready[0].revents().intersects(PollFlags::ERR | PollFlags::NVAL) => {
                return false;
            }
            Ok(1..) if is_ours() => return true,
            // Somebody else's line, which stays ready: no hurry.
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
