//! `mmsim check-server`: check that a server follows the protocol.

pub(crate) mod args;
mod malformed;
mod readings;

use std::io;

use mmsim_client::TransportError;
use mmsim_maze::{Cell, Escaped, Heading, MazeSize, Pose, counted};
use mmsim_protocol::{Info, MAX_STATE_BYTES, Matrix, Order, Reply, Request, State};
use serde::Serialize;

use crate::args::CommandResult;
use crate::connection::connect;
use crate::output::{own_command, print, print_json, warn};
use args::CheckServerArgs;
use malformed::malformed_requests;
use readings::Readings;

pub(crate) fn run(args: &CheckServerArgs) -> CommandResult {
    let endpoint = args.endpoint();
    let mut transport = connect(&endpoint, Some(args.timeout), false)?;
    let exchange = |frames: &[&[u8]], reply: &mut _| transport.exchange_frames(frames, reply);
    let mut checker = Checker::new(exchange, args.size, args.json);
    checker.check_all(args.malformed)?;
    let Checker { checks, stopped, .. } = checker;
    let faults = checks.iter().filter(|check| check.fault.is_some()).count();
    if args.json {
        print_json(&checks)?;
    } else {
        let number = counted(checks.len(), "check");
        print(&format!("{number}, {}\n", counted(faults, "fault")))?;
    }
    if stopped {
        warn(why_stopped(&endpoint, &checks));
    }
    Ok(faults == 0)
}

/// Explains why no further checks were made.
fn why_stopped(endpoint: &str, checks: &[Check]) -> String {
    if checks.iter().any(|check| check.reply.is_some()) {
        return format!("stopped, because {endpoint} no longer replies (restart the server)");
    }
    format!("no reply from {endpoint} (start a simulator with {})", own_command(""))
}

/// A request, its reply, and what is wrong with the reply.
#[derive(Serialize)]
struct Check {
    request: String,
    reply: Option<String>,
    ok: bool,
    fault: Option<String>,
}

/// The combinations of the orders of weights and walls.
const ORDERS: [[Order; 2]; 4] =
    [[Order::C, Order::C], [Order::C, Order::F], [Order::F, Order::C], [Order::F, Order::F]];

/// The verdict on a reply. An error says what is wrong.
type Verdict = Result<(), String>;

/// The results of the checks of a server. `exchange` sends the frames of a request and receives the
/// reply.
struct Checker<E> {
    exchange: E,
    size: MazeSize,
    json: bool,
    checks: Vec<Check>,
    /// True if the server no longer replies to `ping`. Then no further requests are sent.
    stopped: bool,
}

impl<E: FnMut(&[&[u8]], &mut Vec<u8>) -> Result<(), TransportError>> Checker<E> {
    fn new(exchange: E, size: MazeSize, json: bool) -> Self {
        Self { exchange, size, json, checks: Vec::new(), stopped: false }
    }

    fn check_all(&mut self, malformed: bool) -> io::Result<()> {
        self.ping()?;
        self.reset()?;
        self.walls()?;
        self.states()?;
        if malformed {
            self.info()?;
            self.malformed()?;
        }
        self.reset()
    }

    fn ping(&mut self) -> io::Result<()> {
        self.check("ping", &[&encoded(&Request::Ping)], |reply| expect(Reply::Pong, reply))
    }

    fn reset(&mut self) -> io::Result<()> {
        self.check("reset", &[&encoded(&Request::Reset)], |reply| expect(Reply::Ok, reply))
    }

    /// Reads the walls of several cells in all headings. All replies must agree with each other.
    fn walls(&mut self) -> io::Result<()> {
        let (mut readings, mut contradicts) = (Readings::new(self.size), false);
        for cell in cells(self.size) {
            for heading in Heading::ALL {
                let pose = Pose::new(cell, heading);
                let request = encoded(&Request::Walls(pose));
                self.check(&format!("W at {pose}"), &[&request], |reply| {
                    let Ok(Reply::Walls(around)) = Reply::decode(reply) else {
                        return wrong("3 bytes, each 0 or 1", &shown(reply));
                    };
                    readings.add(pose, around).inspect_err(|_| contradicts = true)
                })?;
            }
        }
        match readings.mistake().filter(|_| contradicts) {
            Some(mistake) => self.report(Check {
                request: "all W requests".into(),
                reply: None,
                ok: false,
                fault: Some(format!("the replies agree with each other only if {mistake}")),
            }),
            None => Ok(()),
        }
    }

    /// Sends states with each combination of the two orders.
    fn states(&mut self) -> io::Result<()> {
        let matrices: [(&str, &dyn Fn(usize) -> u8); 3] = [
            ("0", &|_| 0),
            ("0 to 255", &|index: usize| index.to_le_bytes()[0]),
            ("255", &|_| u8::MAX),
        ];
        let headings = Heading::ALL.into_iter().cycle();
        let mut poses = cells(self.size).into_iter().cycle().zip(headings);
        for (name, byte) in matrices {
            for orders in ORDERS {
                let Some((cell, heading)) = poses.next() else { break };
                let pose = Pose::new(cell, heading);
                let request = state(self.size, pose, orders, byte);
                let [weights, walls] = orders;
                let name = format!("S at {pose}, orders {weights:?} and {walls:?}, weights {name}");
                self.check(&name, &[&request], |reply| expect(Reply::Ok, reply))?;
            }
        }
        Ok(())
    }

    /// Sends `info`, which servers may support or refuse.
    fn info(&mut self) -> io::Result<()> {
        let size = self.size;
        self.check("info", &[&encoded(&Request::Info)], |reply| match Reply::decode(reply) {
            Ok(Reply::Error(_)) => Ok(()),
            Ok(Reply::Info(json)) => match serde_json::from_str::<Info>(json) {
                Ok(info) if info.size() == Some(size) => Ok(()),
                Ok(Info { width, height, .. }) => {
                    wrong(&format!("a maze of {size} cells"), &format!("{width}x{height}"))
                }
                Err(error) => {
                    wrong("a description of the maze", &format!("{} ({error})", shown(reply)))
                }
            },
            _ => wrong("a JSON object or an error", &shown(reply)),
        })
    }

    /// Sends malformed requests. The server must refuse each one and serve the next request.
    fn malformed(&mut self) -> io::Result<()> {
        let start = Pose::new(Cell::new(0, 0), Heading::North);
        let walls = encoded(&Request::Walls(start));
        let state = state(self.size, start, [Order::C, Order::F], &|_| 0);
        for (name, frames) in malformed_requests(self.size, &walls, &state) {
            let frames: Vec<&[u8]> = frames.iter().map(Vec::as_slice).collect();
            self.check(&name, &frames, |reply| match Reply::decode(reply) {
                Ok(Reply::Error(reason)) if !reason.contains('\n') => Ok(()),
                _ => wrong("\"error: \" and a reason on one line", &shown(reply)),
            })?;
            self.check_serving()?;
        }
        Ok(())
    }

    /// Sends a request and reports the verdict on the reply. Without a reply, finds out whether the
    /// server still serves other requests.
    fn check(
        &mut self,
        request: &str,
        frames: &[&[u8]],
        verdict: impl FnOnce(&[u8]) -> Verdict,
    ) -> io::Result<()> {
        if self.stopped {
            return Ok(());
        }
        let check = self.ask(request, frames, verdict);
        let answered = check.reply.is_some();
        self.stopped = !answered && request == "ping";
        self.report(check)?;
        if answered { Ok(()) } else { self.check_serving() }
    }

    /// Sends `ping`, and reports only a fault.
    fn check_serving(&mut self) -> io::Result<()> {
        if self.stopped {
            return Ok(());
        }
        let check =
            self.ask("ping", &[&encoded(&Request::Ping)], |reply| expect(Reply::Pong, reply));
        self.stopped = check.reply.is_none();
        if check.ok { Ok(()) } else { self.report(check) }
    }

    /// Sends a request and checks the reply.
    fn ask(
        &mut self,
        request: &str,
        frames: &[&[u8]],
        verdict: impl FnOnce(&[u8]) -> Verdict,
    ) -> Check {
        let mut reply = Vec::new();
        let (reply, verdict) = match (self.exchange)(frames, &mut reply) {
            Ok(()) => (Some(shown(&reply)), verdict(&reply)),
            Err(TransportError::Frames { found, .. }) => {
                let found = counted(found, "frame").to_string();
                (Some(found.clone()), wrong("a reply of one frame", &found))
            }
            Err(TransportError::NoReply { after, .. }) => {
                (None, Err(format!("no reply to {request} within {} s", after.as_secs_f64())))
            }
            Err(error) => (None, Err(error.to_string())),
        };
        Check { request: request.into(), reply, ok: verdict.is_ok(), fault: verdict.err() }
    }

    /// Stores the result of a check and prints it, unless JSON is printed at the end.
    fn report(&mut self, check: Check) -> io::Result<()> {
        let Check { request, reply, fault, .. } = &check;
        let line = match fault {
            None => format!("ok     {request}: {}", reply.as_deref().unwrap_or_default()),
            Some(fault) => format!("wrong  {request}: {fault}"),
        };
        self.checks.push(check);
        if self.json { Ok(()) } else { print(&format!("{}\n", Escaped(line))) }
    }
}

/// Returns cells in all corners and in the centre, some of them neighbours.
fn cells(size: MazeSize) -> Vec<Cell> {
    let (right, top) = (size.width() - 1, size.height() - 1);
    let mut cells = Vec::new();
    let mut add = |x, y| {
        let cell = Cell::new(x, y);
        if size.contains(cell) && !cells.contains(&cell) {
            cells.push(cell);
        }
    };
    for (x, y) in [(0, 0), (right / 2, top / 2), (right.saturating_sub(1), top.saturating_sub(1))] {
        for (east, north) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            add(x + east, y + north);
        }
    }
    add(0, top);
    add(right, 0);
    cells
}

/// Returns an `S` request. `byte` returns the byte of each cell; only the lowest five bits of the
/// bytes for walls are used.
fn state(
    size: MazeSize,
    pose: Pose,
    [weights_order, walls_order]: [Order; 2],
    byte: &dyn Fn(usize) -> u8,
) -> Vec<u8> {
    let weights: Vec<u8> = (0..size.area()).map(byte).collect();
    let walls: Vec<u8> = weights.iter().map(|byte| byte % 32).collect();
    let matrices =
        Matrix::new(weights_order, size, &weights).zip(Matrix::new(walls_order, size, &walls));
    let state = matrices.and_then(|(weights, walls)| State::new(pose, weights, walls));
    state.map_or_else(Vec::new, |state| encoded(&Request::State(state)))
}

/// Returns the bytes of a request.
fn encoded(request: &Request<'_>) -> Vec<u8> {
    let mut bytes = vec![0; MAX_STATE_BYTES];
    let length = request.encode(&mut bytes).unwrap_or_default();
    bytes.truncate(length);
    bytes
}

/// Checks that a reply is the expected one, which is `pong` or `ok`.
fn expect(expected: Reply<'_>, reply: &[u8]) -> Verdict {
    if Reply::decode(reply) == Ok(expected) {
        return Ok(());
    }
    let mut bytes = vec![0; expected.len()];
    let _ = expected.encode(&mut bytes);
    wrong(&shown(&bytes), &shown(reply))
}

fn wrong(expected: &str, found: &str) -> Verdict {
    Err(format!("expected {expected}, found {found}"))
}

/// Formats a reply: text in quotes, other bytes in hex. Long replies are truncated.
fn shown(reply: &[u8]) -> String {
    const MAX_CHARS: usize = 200;
    let text = str::from_utf8(reply).ok().filter(|text| !text.starts_with(char::is_control));
    let hex = || reply.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ");
    let shown = text.map_or_else(hex, |text| format!("\"{}\"", Escaped(text)));
    match shown.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("{}… of {} bytes", &shown[..end], reply.len()),
        None => shown,
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use mmsim_server::Simulation;

    use super::*;

    /// Checks a server that does not reply to some of the requests.
    fn check_silent(
        mut is_silent: impl FnMut(&[u8]) -> bool,
        malformed: bool,
    ) -> (Vec<Check>, bool) {
        let mut simulation = Simulation::new("harbour", mmsim_mazes::HARBOUR.parse().unwrap());
        let exchange = |frames: &[&[u8]], reply: &mut Vec<u8>| {
            if is_silent(frames[0]) {
                let after = Duration::from_secs(10);
                return Err(TransportError::NoReply {
                    endpoint: "tcp://127.0.0.1:1".into(),
                    after,
                });
            }
            simulation.handle(frames[0], reply);
            Ok(())
        };
        let mut checker = Checker::new(exchange, MazeSize::CLASSIC, true);
        checker.check_all(malformed).unwrap();
        (checker.checks, checker.stopped)
    }

    #[test]
    fn a_missing_reply_is_a_fault() {
        let faults = |checks: &[Check]| -> Vec<String> {
            checks.iter().filter_map(|check| check.fault.clone()).collect()
        };
        let fault = |request: &str| format!("no reply to {request} within 10 s");
        let (checks, stopped) = check_silent(|_| true, false);
        assert_eq!((faults(&checks), checks.len(), stopped), (vec![fault("ping")], 1, true));
        assert!(why_stopped("tcp://a:1", &checks).starts_with("no reply from tcp://a:1 (start"));
        // The server serves the other requests.
        let (checks, stopped) = check_silent(|request| request == b"W\x01\x00E", false);
        let expected = vec![fault("W at (1, 0) heading east")];
        assert_eq!((faults(&checks), checks.len(), stopped), (expected, 71, false));
        // Like the reference server, which replies neither to an unknown request nor afterwards.
        let mut is_stuck = false;
        let silent = |request: &[u8]| {
            is_stuck |= request == b"info";
            is_stuck
        };
        let (checks, stopped) = check_silent(silent, true);
        let expected = vec![fault("info"), fault("ping")];
        assert_eq!((faults(&checks), checks.len(), stopped), (expected, 72, true));
        assert!(why_stopped("tcp://a:1", &checks).contains("tcp://a:1 no longer replies"));
    }

    #[test]
    fn cells_are_distinct_cells_of_the_maze() {
        for (width, height, count) in
            [(1, 1, 1), (1, 2, 2), (2, 2, 4), (3, 3, 9), (16, 16, 14), (32, 5, 14)]
        {
            let size = MazeSize::new(width, height).unwrap();
            let cells = cells(size);
            assert_eq!(cells.len(), count, "{size}: {cells:?}");
            assert!(cells.iter().all(|&cell| size.contains(cell)));
        }
    }

    #[test]
    fn replies_are_shown_as_text_or_hex() {
        for (reply, expected) in [
            (&b"ok"[..], "\"ok\""),
            (b"", "\"\""),
            (&[1, 0, 1], "01 00 01"),
            (b"error: \"a\n", "\"error: \"a\\n\""),
            (&[b'x', 0xff], "78 ff"),
        ] {
            assert_eq!(shown(reply), expected);
        }
        assert_eq!(shown(&[b'x'; 201]), format!("\"{}… of 201 bytes", "x".repeat(199)));
    }
}
