//! The protocol tester in Python.

use std::thread;

use mmsim_tests::output;

use crate::client;
use crate::harness::wrong_server::{Change, WrongServer};

/// Returns the exit code, the last line and the first fault, if Python is available.
fn check(change: Change) -> Option<(Option<i32>, String, String)> {
    let server = WrongServer::start(change);
    let output = output(client::python()?.args(["protocol_tester.py", &server.endpoint]));
    let stdout = String::from_utf8(output.stdout).unwrap();
    let fault = stdout.lines().find_map(|line| line.strip_prefix("wrong  "));
    let last = stdout.lines().last().unwrap_or_default();
    Some((output.status.code(), last.into(), fault.unwrap_or_default().into()))
}

#[test]
fn the_python_tester_finds_each_fault() {
    let cases: [(Change, i32, &str, &str); 7] = [
        (|_, reply| vec![reply], 0, "67 checks, 0 wrong", ""),
        (
            |request, reply| vec![if request == b"reset" { b"OK".into() } else { reply }],
            1,
            "67 checks, 2 wrong",
            "reset: expected [b'ok'], found [b'OK']",
        ),
        (
            |request, reply| vec![if request == b"W\0\0N" { vec![1, 0] } else { reply }],
            1,
            "67 checks, 1 wrong",
            "W at (0, 0) heading N: expected 3 bytes, each 0 or 1, found [b'\\x01\\x00']",
        ),
        (
            |request, reply| vec![if request == b"W\0\0W" { vec![1, 1, 1] } else { reply }],
            1,
            "67 checks, 1 wrong",
            "W at (0, 0) heading W: expected 0 as in the reply to W at (0, 0) heading N on the \
             north side, found 1",
        ),
        (
            |request, reply| vec![if request == b"W\0\0W" { vec![1, 0, 0] } else { reply }],
            1,
            "67 checks, 1 wrong",
            "W at (0, 0) heading W: expected 1 for the outer wall on the west side, found 0",
        ),
        (
            |request, reply| match request {
                [b'S', _, _, _, b'F', ..] => vec![b"error: expected C".into()],
                _ => vec![reply],
            },
            1,
            "67 checks, 6 wrong",
            "S at (0, 15) heading S, orders F and C: expected [b'ok'], found [b'error: expected C']",
        ),
        (
            |request, reply| match request {
                b"ping" => Vec::new(),
                _ => vec![reply],
            },
            1,
            "wrong  ping: no reply within 5 s",
            "ping: no reply within 5 s",
        ),
    ];
    // The last case waits for a timeout.
    thread::scope(|scope| {
        for (change, code, last, fault) in cases {
            scope.spawn(move || {
                let Some(found) = check(change) else { return };
                assert_eq!(found, (Some(code), last.into(), fault.into()));
            });
        }
    });
}
