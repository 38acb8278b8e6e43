//! Signals that are already ignored when the command starts, as under `nohup` or in a script's
//! background jobs.
#![cfg(target_os = "linux")]

mod harness;

use std::fs;
use std::process::Command;

use harness::{Home, SIGNALS, Serving, recorded};

const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

/// The number of the signal SIGHUP.
const HUP: u32 = 1;
/// The number of the signal SIGINT.
const INT: u32 = 2;
/// The number of the signal SIGTERM.
const TERM: u32 = 15;

/// Starts a command with the named signals ignored, and waits until it prints `text`.
fn start(home: &Home, ignored: &str, arguments: &[&str], text: &str) -> Serving {
    let script = format!("trap '' {ignored}; exec \"$0\" \"$@\"");
    let mut shell = Command::new("env");
    shell.arg(format!("--default-signal={SIGNALS}")).args(["sh", "-c", &script]);
    shell.arg(env!("CARGO_BIN_EXE_mmsim")).args(arguments).current_dir(home.path());
    shell.env("HOME", home.path()).env_remove("RUST_LOG");
    Serving::start(shell, text)
}

/// Returns true if a signal is in one of the server's signal masks, such as `SigIgn:`.
fn is_in(server: &Serving, mask: &str, signal: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", server.id())).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix(mask)).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() >> (signal - 1) & 1 == 1
}

/// Asserts that a signal stays ignored, and that SIGTERM stops the command cleanly.
fn check(mut server: Serving, name: &str, number: u32, others: &[u32]) {
    assert!(is_in(&server, "SigIgn:", number) && !is_in(&server, "SigCgt:", number), "{name}");
    for other in others {
        assert!(is_in(&server, "SigCgt:", *other), "{name}: {other}");
    }
    server.signal(name);
    server.signal("TERM");
    let (status, messages) = server.wait();
    assert_eq!(status.code(), Some(0), "{messages}");
}

#[test]
fn signals_ignored_at_the_start_stay_ignored() {
    let home = Home::new();
    home.write("small.txt", MAZE);
    let once = home.run(&["demo", "small.txt", "--once", "--port", "0", "--record", "records"]);
    assert_eq!(once.code, Some(0), "{once:?}");
    let record = recorded(&home.path().join("records"));
    let record = record.to_str().unwrap();
    let (serving, own) = (["--port", "0", "--no-viewer"], "still serving");
    for (arguments, text) in [
        ([&["small.txt"], &serving[..]].concat(), "serving"),
        ([&["demo", "small.txt"], &serving[..]].concat(), own),
        ([&["trial", "small.txt", "--serve"], &serving[..]].concat(), own),
        ([&["run", "--maze", "small.txt", "--stay"], &serving[..], &["--", "true"]].concat(), own),
        (vec!["replay", record, "--serve", "--viewer-port", "0"], "watch at"),
    ] {
        check(start(&home, "HUP", &arguments, text), "HUP", HUP, &[INT, TERM]);
        check(start(&home, "INT", &arguments, text), "INT", INT, &[HUP, TERM]);
    }
}

#[test]
fn a_server_that_ignores_every_signal_keeps_serving() {
    let home = Home::new();
    home.write("small.txt", MAZE);
    let arguments = ["small.txt", "--port", "0", "--no-viewer"];
    let server = start(&home, "HUP INT TERM", &arguments, "tcp://");
    for signal in ["HUP", "INT", "TERM"] {
        server.signal(signal);
    }
    let solve = ["solve", "flood-fill", "--goal", "server", "--timeout", "300"];
    for _ in 0..3 {
        let ended = home.run(&[&solve[..], &["--connect", &server.address]].concat());
        assert_eq!(ended.code, Some(0), "{ended:?}");
    }
}
