//! Checks that a server follows the protocol.

mod malformed;
mod wall_readings;

use mmsim_maze::{Cell, Escaped, Heading, MazeSize, Pose, counted};
use mmsim_protocol::{Info, MAX_STATE_BYTES, Matrix, Order, Reply, Request, State};

use crate::transport::TransportError;
use malformed::malformed_requests;
use wall_readings::WallReadings;

/// A request to a server, its reply, and what is wrong with the reply.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerCheck {
    /// The request in words.
    pub request: String,
    /// The reply as text in quotes or as bytes in hex. `None` if there is no reply, and for a fault of
    /// several replies.
    pub reply: Option<String>,
    /// What is wrong with the reply, or `None` if the reply is right.
    pub fault: Option<String>,
}

/// Sends each request of the protocol to a server with a maze of this size, and checks the replies.
/// The requests include `reset`, which deletes the states that the server has stored.
///
/// `exchange` sends the frames of a request and receives the reply, such as
/// [`Zmq::exchange_frames`](crate::Zmq::exchange_frames). `report` is called with each check. If
/// `with_malformed` is true, also sends `info` and malformed requests, after which some servers stop
/// replying.
///
/// Returns false if the server no longer replies to `ping`. Then no further requests are sent.
///
/// ```
/// use mmsim_client::check_server;
/// use mmsim_maze::{Maze, MazeSize};
/// use mmsim_server::Simulation;
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let (size, mut simulation) = (maze.size(), Simulation::new("small", maze));
/// let exchange = |frames: &[&[u8]], reply: &mut Vec<u8>| {
///     simulation.handle(frames[0], reply);
///     Ok(())
/// };
/// assert!(check_server(exchange, size, false, |check| assert_eq!(check.fault, None)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn check_server(
    exchange: impl FnMut(&[&[u8]], &mut Vec<u8>) -> Result<(), TransportError>,
    size: MazeSize,
    with_malformed: bool,
    report: impl FnMut(ServerCheck),
) -> bool {
    let mut checker = Checker { exchange, report, size, is_replying: true };
    checker.ping();
    checker.reset();
    checker.walls();
    checker.states();
    if with_malformed {
        checker.info();
        checker.malformed();
    }
    checker.reset();
    checker.is_replying
}

/// The combinations of the orders of weights and walls.
const ORDERS: [[Order; 2]; 4] =
    [[Order::C, Order::C], [Order::C, Order::F], [Order::F, Order::C], [Order::F, Order::F]];

struct Checker<X, R> {
    exchange: X,
    report: R,
    size: MazeSize,
    /// False if the server no longer replies to `ping`.
    is_replying: bool,
}

impl<X, R> Checker<X, R>
where
    X: FnMut(&[&[u8]], &mut Vec<u8>) -> Result<(), TransportError>,
    R: FnMut(ServerCheck),
{
    fn ping(&mut self) {
        self.check("ping", &[&encoded(&Request::Ping)], |reply| expect(Reply::Pong, reply));
    }

    fn reset(&mut self) {
        self.check("reset", &[&encoded(&Request::Reset)], |reply| expect(Reply::Ok, reply));
    }

    /// Reads the walls of several cells in all headings. All replies must agree with each other.
    fn walls(&mut self) {
        let (mut readings, mut contradicts) = (WallReadings::new(self.size), false);
        for cell in cells(self.size) {
            for heading in Heading::ALL {
                let pose = Pose::new(cell, heading);
                let request = encoded(&Request::Walls(pose));
                self.check(&format!("W at {pose}"), &[&request], |reply| {
                    let Ok(Reply::Walls(around)) = Reply::decode(reply) else {
                        return wrong("3 bytes, each 0 or 1", &shown(reply));
                    };
                    readings.add(pose, around).inspect_err(|_| contradicts = true)
                });
            }
        }
        if let Some(mistake) = readings.mistake().filter(|_| contradicts) {
            (self.report)(ServerCheck {
                request: "all W requests".into(),
                reply: None,
                fault: Some(format!("the replies agree with each other only if {mistake}")),
            });
        }
    }

    /// Sends states with each combination of the two orders.
    fn states(&mut self) {
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
                self.check(&name, &[&request], |reply| expect(Reply::Ok, reply));
            }
        }
    }

    /// Sends `info`, which servers may support or refuse.
    fn info(&mut self) {
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
        });
    }

    /// Sends malformed requests. The server must refuse each one and serve the next request.
    fn malformed(&mut self) {
        let start = Pose::new(Cell::new(0, 0), Heading::North);
        let walls = encoded(&Request::Walls(start));
        let state = state(self.size, start, [Order::C, Order::F], &|_| 0);
        for (name, frames) in malformed_requests(self.size, &walls, &state) {
            let frames: Vec<&[u8]> = frames.iter().map(Vec::as_slice).collect();
            self.check(&name, &frames, |reply| match Reply::decode(reply) {
                Ok(Reply::Error(reason)) if !reason.contains('\n') => Ok(()),
                _ => wrong("\"error: \" and a reason on one line", &shown(reply)),
            });
            self.check_serving();
        }
    }

    /// Sends a request and reports the verdict on the reply. Without a reply, finds out whether the
    /// server still serves other requests.
    fn check(
        &mut self,
        request: &str,
        frames: &[&[u8]],
        verdict: impl FnOnce(&[u8]) -> Result<(), String>,
    ) {
        if self.is_replying {
            let check = self.ask(request, frames, verdict);
            let is_answered = check.reply.is_some();
            self.is_replying = is_answered || request != "ping";
            (self.report)(check);
            if !is_answered {
                self.check_serving();
            }
        }
    }

    /// Sends `ping`, and reports only a fault.
    fn check_serving(&mut self) {
        if self.is_replying {
            let ping = encoded(&Request::Ping);
            let check = self.ask("ping", &[&ping], |reply| expect(Reply::Pong, reply));
            self.is_replying = check.reply.is_some();
            if check.fault.is_some() {
                (self.report)(check);
            }
        }
    }

    /// Sends a request and checks the reply.
    fn ask(
        &mut self,
        request: &str,
        frames: &[&[u8]],
        verdict: impl FnOnce(&[u8]) -> Result<(), String>,
    ) -> ServerCheck {
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
        ServerCheck { request: request.into(), reply, fault: verdict.err() }
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
fn expect(expected: Reply<'_>, reply: &[u8]) -> Result<(), String> {
    if Reply::decode(reply) == Ok(expected) {
        return Ok(());
    }
    let mut bytes = vec![0; expected.len()];
    let _ = expected.encode(&mut bytes);
    wrong(&shown(&bytes), &shown(reply))
}

fn wrong(expected: &str, found: &str) -> Result<(), String> {
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

    use mmsim_maze::{CellSet, Maze, Walls};
    use mmsim_server::Simulation;

    use super::*;

    /// Checks a server that does not reply to some of the requests. Returns the number of checks, the
    /// faults, and whether the server still replies.
    fn check_silent(
        mut is_silent: impl FnMut(&[u8]) -> bool,
        with_malformed: bool,
    ) -> (usize, Vec<String>, bool) {
        let walls = Walls::open(MazeSize::CLASSIC);
        let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
        let mut simulation = Simulation::new("open", maze);
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
        let (mut checks, mut faults) = (0, Vec::new());
        let is_replying = check_server(exchange, MazeSize::CLASSIC, with_malformed, |check| {
            checks += 1;
            faults.extend(check.fault);
        });
        (checks, faults, is_replying)
    }

    #[test]
    fn a_missing_reply_is_a_fault() {
        let fault = |request: &str| format!("no reply to {request} within 10 s");
        assert_eq!(check_silent(|_| true, false), (1, vec![fault("ping")], false));
        // The server serves the other requests.
        let expected = vec![fault("W at (1, 0) heading east")];
        assert_eq!(check_silent(|request| request == b"W\x01\x00E", false), (71, expected, true));
        // Like the reference server, which replies neither to an unknown request nor afterwards.
        let mut is_stuck = false;
        let silent = |request: &[u8]| {
            is_stuck |= request == b"info";
            is_stuck
        };
        assert_eq!(check_silent(silent, true), (72, vec![fault("info"), fault("ping")], false));
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
