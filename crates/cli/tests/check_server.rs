//! `mmsim check-server` against the server and against servers that make mistakes.

#![cfg(not(all(windows, target_env = "gnu")))] // needs a server of libzmq

mod harness;

use harness::wrong_server::{Change, WrongServer};
use harness::{Home, Output};
use mmsim_maze::{Cell, Heading, MazeSize};
use mmsim_protocol::Request;

/// Returns the lines about faults.
fn faults(ended: &Output) -> Vec<&str> {
    ended.stdout.lines().filter(|line| line.starts_with("wrong ")).collect()
}

/// Checks a server that makes a mistake.
fn check(
    change: impl FnMut(&[u8], Vec<u8>) -> Vec<Vec<u8>> + Send + 'static,
    options: &[&str],
) -> Output {
    let server = WrongServer::start(change);
    Home::new().run(&[&["check-server", &server.endpoint], options].concat())
}

#[test]
fn the_server_has_no_faults() {
    let home = Home::new();
    for (maze, size) in [("harbour", "16x16"), ("first steps", "8x8"), ("old quarter", "32x32")] {
        let server = home.serve(&["--port", "0", maze]);
        let command = ["check-server", &server.address, "--size", size, "--timeout", "300"];
        let ended = home.run(&command);
        assert_eq!((ended.code, &*ended.stderr), (Some(0), ""), "{ended:?}");
        assert_eq!(faults(&ended), [""; 0]);
        assert_eq!(ended.stdout.lines().last(), Some("71 checks, 0 faults"), "{maze}");
        assert!(!ended.stdout.contains("info"), "{}", ended.stdout);

        let malformed = home.run(&[&command[..], &["--malformed", "--json"]].concat());
        assert_eq!((malformed.code, &*malformed.stderr), (Some(0), ""), "{malformed:?}");
        let report = malformed.json();
        let checks = report.as_array().unwrap();
        assert!(checks.len() > 100 && checks.iter().all(|check| check["ok"] == true), "{report}");
        assert_eq!(checks[0]["request"], "ping");
        assert_eq!(checks[0]["reply"], "\"pong\"");
        assert!(checks[0]["fault"].is_null());
        for request in ["info", "malformed \"foo\"", "malformed frames \"ping\", \"\""] {
            assert!(checks.iter().any(|check| check["request"] == request), "{request}: {report}");
        }
    }
}

#[test]
fn the_endpoint_may_be_in_the_environment() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "harbour"]);
    let mut command = home.command(&["check-server"]);
    let ended = mmsim_tests::output(command.env("MMSIM_ENDPOINT", &server.address));
    assert!(ended.status.success(), "{ended:?}");
}

#[test]
fn each_fault_is_named() {
    let cases: [(Change, usize, &str); 10] = [
        (
            |request, reply| vec![if request == b"ping" { b"PONG".into() } else { reply }],
            1,
            "ping: expected \"pong\", found \"PONG\"",
        ),
        (
            |request, reply| vec![if request == b"reset" { b"OK".into() } else { reply }],
            2,
            "reset: expected \"ok\", found \"OK\"",
        ),
        (
            |_, reply| vec![if reply.len() == 3 { reply[..2].into() } else { reply }],
            56,
            "W at (0, 0) heading north: expected 3 bytes, each 0 or 1, found 01 00",
        ),
        (
            |_, reply| vec![if reply.len() == 3 { [&reply[..], b"\0"].concat() } else { reply }],
            56,
            "W at (0, 0) heading north: expected 3 bytes, each 0 or 1, found 01 00 01 00",
        ),
        (
            |request, mut reply| {
                if request == b"W\x01\x00E" {
                    reply[1] = 2;
                }
                vec![reply]
            },
            1,
            "W at (1, 0) heading east: expected 3 bytes, each 0 or 1, found ",
        ),
        (
            |_, mut reply| {
                if reply.len() == 3 {
                    reply.reverse();
                }
                vec![reply]
            },
            0,
            "all W requests: the replies agree with each other only if left and right are swapped",
        ),
        (
            // The wall to the east of the start is missing if it is read from the other side.
            |request, mut reply| {
                if let Ok(Request::Walls(pose)) = Request::decode(request, MazeSize::CLASSIC)
                    && pose.cell == Cell::new(1, 0)
                    && let sides = [pose.heading.left(), pose.heading, pose.heading.right()]
                    && let Some(at) = sides.iter().position(|&side| side == Heading::West)
                {
                    reply[at] ^= 1;
                }
                vec![reply]
            },
            3,
            "W at (1, 0) heading north: expected a wall on the west side of (1, 0) as in the reply \
             to W at (0, 0) heading north, found no wall",
        ),
        (
            |request, mut reply| {
                if request == b"W\x0f\x00E" {
                    reply[1] = 0;
                }
                vec![reply]
            },
            1,
            "W at (15, 0) heading east: expected the outer wall on the east side of (15, 0), found \
             no wall",
        ),
        (
            |request, reply| {
                let is_f = request.starts_with(b"S") && request[4] == b'F';
                vec![if is_f { b"error: expected order C".into() } else { reply }]
            },
            6,
            "S at (0, 1) heading south, orders F and C, weights 0: expected \"ok\", found \
             \"error: expected order C\"",
        ),
        (
            |request, reply| {
                if request == b"reset" { vec![reply, b"extra".into()] } else { vec![reply] }
            },
            2,
            "reset: expected a reply of one frame, found 2 frames",
        ),
    ];
    for (change, count, fault) in cases {
        let ended = check(change, &["--timeout", "300"]);
        assert_eq!((ended.code, &*ended.stderr), (Some(1), ""), "{ended:?}");
        let faults = faults(&ended);
        let is_named = |line: &&str| line.strip_prefix("wrong  ").unwrap().starts_with(fault);
        assert!(faults.iter().any(is_named), "{fault}: {faults:#?}");
        assert!(count == 0 || faults.len() == count, "{fault}: {faults:#?}");
        let summary = format!(" checks, {} fault", faults.len());
        assert!(ended.stdout.lines().last().unwrap().contains(&summary), "{}", ended.stdout);
    }
}

#[test]
fn a_missing_reply_is_a_fault() {
    let ended = check(|_, _| Vec::new(), &["--timeout", "0.2"]);
    assert_eq!(ended.code, Some(1));
    assert_eq!(ended.stdout, "wrong  ping: no reply to ping within 0.2 s\n1 check, 1 fault\n");
    assert!(ended.stderr.contains("no reply from tcp://"), "{ended:?}");
}

#[test]
fn malformed_requests_must_be_refused() {
    // Serves only the last frame of a request.
    let ended = check(|_, reply| vec![reply], &["--malformed", "--timeout", "300"]);
    let faults = faults(&ended);
    assert!(faults.len() == 4 && faults.iter().all(|line| line.contains("frames")), "{faults:#?}");
    let fault = "wrong  malformed frames \"ping\", \"ping\": expected \"error: \" and a reason on \
                 one line, found \"pong\"";
    assert!(faults.contains(&fault), "{faults:#?}");
}

#[test]
fn a_maze_of_another_size_is_a_fault() {
    let home = Home::new();
    let server = home.serve(&["--port", "0", "first steps"]);
    let ended = home.run(&["check-server", &server.address, "--timeout", "300"]);
    assert_eq!(ended.code, Some(1));
    let fault = "expected \"ok\", found \"error: expected a state of 134 bytes for a maze of 8x8 \
                 cells, found 518 bytes\"";
    assert!(faults(&ended).iter().any(|line| line.ends_with(fault)), "{ended:?}");
}

#[test]
fn invalid_arguments_are_usage_errors() {
    for arguments in [&["--size", "33x1"][..], &["--timeout", "0"], &["a", "b"]] {
        let ended = Home::new().run(&[&["check-server"], arguments].concat());
        assert_eq!((ended.code, &*ended.stdout), (Some(2), ""), "{ended:?}");
    }
}
