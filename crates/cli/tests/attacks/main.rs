//! Attacks on the command while it works. In most of them, a correct client searches the served maze,
//! and every search must succeed. After each attack, the server must have as many threads and
//! descriptors as before, and its memory may grow only slightly. Other attacks have servers of their
//! own, or none: random streams, kills, trees of mice, mutated recordings and hostile servers.
//!
//! `MMSIM_ATTACK_FORCE=20 cargo test -p mmsim --test attacks -- --nocapture` makes most attacks 20
//! times as long and prints measurements. Random streams and kills print `MMSIM_ATTACK_SEED`, which
//! repeats their random numbers.
#![cfg(unix)]

#[path = "../harness/mod.rs"]
mod harness;

mod connections;
#[cfg(target_os = "linux")]
mod descendants;
mod kills;
mod measure;
mod model;
mod raw;
mod recordings;
mod requests;
mod routes;
mod searcher;
mod servers;
mod streams;

use std::env;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::thread;
use std::time::Duration;

use harness::{Home, Serving};
use measure::Resources;
use mmsim_maze::{Cell, Heading, Pose};
use mmsim_protocol::Reply;
use mmsim_tests::{TIMEOUT_MS, malformed_requests, wait_for};
use searcher::while_searching;

/// Returns `MMSIM_ATTACK_FORCE`, a multiplier for the length of most attacks. The default is 1.
fn force() -> usize {
    static FORCE: OnceLock<usize> = OnceLock::new();
    *FORCE.get_or_init(|| env::var("MMSIM_ATTACK_FORCE").map_or(1, |force| force.parse().unwrap()))
}

/// A server under attack.
struct Target(Serving);

impl Target {
    fn start() -> Self {
        Self(Home::new().serve(&["--port", "0", searcher::MAZE]))
    }

    fn address(&self) -> &str {
        &self.0.address
    }

    /// Runs an attack, and checks that the server continues to work.
    fn run_attack(&self, name: &str, attack: impl FnOnce(&str)) {
        println!("{name}");
        while_searching(self.address(), || {
            let before = Resources::from_process(self.0.id());
            attack(self.address());
            if let Some(before) = before {
                before.wait_until_back(self.0.id());
            }
        });
    }
}

/// Connects a ZeroMQ socket with a long timeout.
fn socket(context: &zmq::Context, kind: zmq::SocketType, address: &str) -> zmq::Socket {
    let socket = context.socket(kind).unwrap();
    socket.set_linger(0).unwrap();
    socket.set_rcvtimeo(TIMEOUT_MS).unwrap();
    socket.set_sndtimeo(TIMEOUT_MS).unwrap();
    socket.connect(address).unwrap();
    socket
}

fn assert_refused(reply: &[u8], request: &[u8]) {
    let start = request.get(..8).unwrap_or(request).escape_ascii();
    let shown = reply.escape_ascii();
    assert!(reply.starts_with(b"error: expected "), "{shown} to {start}, {}", request.len());
}

fn assert_served(socket: &zmq::Socket) {
    socket.send("ping", 0).unwrap();
    assert_eq!(socket.recv_multipart(0).unwrap(), [b"pong"]);
}

#[test]
fn wrong_requests() {
    let target = Target::start();
    target.run_attack("malformed requests", |address| {
        let client = socket(&zmq::Context::new(), zmq::REQ, address);
        for request in (0..force()).flat_map(|_| malformed_requests()) {
            client.send(&request, 0).unwrap();
            assert_refused(&client.recv_bytes(0).unwrap(), &request);
            assert_served(&client);
        }
    });
    target.run_attack("every length with every first byte", |address| {
        let dealer = socket(&zmq::Context::new(), zmq::DEALER, address);
        for first in 0..=u8::MAX {
            // Zeros are never a valid request: no heading and no order is zero.
            let requests = (0..=600).map(|length| {
                let mut request = vec![0; length];
                request[..length.min(1)].fill(first);
                request
            });
            for request in requests.clone() {
                dealer.send_multipart([vec![], request], 0).unwrap();
            }
            for request in requests {
                let reply = dealer.recv_multipart(0).unwrap();
                assert_eq!((reply.len(), reply[0].len()), (2, 0));
                assert_refused(&reply[1], &request);
            }
        }
        dealer.send_multipart(["", "ping"], 0).unwrap();
        assert_eq!(dealer.recv_multipart(0).unwrap()[1], b"pong", "exactly one reply to each");
    });
    target.run_attack("requests of several frames", |address| {
        let client = socket(&zmq::Context::new(), zmq::REQ, address);
        let many = vec!["x"; 10_000];
        let several: [&[&str]; 8] = [
            &["ping", "x"],
            &["foo", "ping"],
            &["", "ping"],
            &["ping", ""],
            &["ping", "ping"],
            &["W\0\0N", "S\0\0N"],
            &["W\0\0", "N"],
            &many,
        ];
        for frames in several.repeat(force()) {
            client.send_multipart(frames, 0).unwrap();
            let reply = client.recv_multipart(0).unwrap();
            assert_eq!(reply.len(), 1);
            assert_refused(&reply[0], b"");
            assert_served(&client);
        }
        let mut peer = raw::greet(address);
        for _ in 0..force() {
            peer.write_all(&raw::frame(1, b"").repeat(1_000_000)).unwrap();
            peer.write_all(&raw::frame(0, b"ping")).unwrap();
            let expected = "error: expected one frame, found 1000000";
            let mut reply = vec![0; 2 + 2 + expected.len()];
            peer.read_exact(&mut reply).unwrap();
            assert_eq!(reply[4..].escape_ascii().to_string(), expected);
        }
        // An endless message of valid large frames must not use memory either.
        peer.write_all(&raw::frame(1, b"")).unwrap();
        peer.write_all(&raw::frame(1, &vec![7; 60_000]).repeat(1000)).unwrap();
        raw::reset(peer);
    });
}

#[test]
fn dealers() {
    let target = Target::start();
    target.run_attack("dealers without the empty frame", |address| {
        for _ in 0..20 * force() {
            let dealer = socket(&zmq::Context::new(), zmq::DEALER, address);
            // Without the empty frame, these messages are not requests, so the reset has no effect.
            for request in ["ping", "info", "reset"] {
                dealer.send(request, 0).unwrap();
                dealer.send_multipart([request, request], 0).unwrap();
            }
            dealer.send_multipart(["", "ping"], 0).unwrap();
            assert_eq!(dealer.recv_multipart(0).unwrap(), [&b""[..], b"pong"]);
            // Peers disconnect while their requests are pending, first after a delay and then
            // immediately.
            let mut peer = raw::greet(address);
            peer.write_all(&raw::frame(0, b"ping").repeat(100)).unwrap();
            raw::reset(peer);
        }
    });
    target.run_attack("dealers that never read", |address| {
        let context = zmq::Context::new();
        let dealers = (0..4).map(|_| {
            let dealer = socket(&context, zmq::DEALER, address);
            dealer.set_rcvhwm(1).unwrap();
            dealer.set_sndtimeo(10).unwrap();
            for _ in 0..1000 * force() {
                if dealer.send_multipart(["", "info"], 0).is_err() {
                    break; // the server has stopped reading
                }
            }
            dealer
        });
        let dealers: Vec<_> = dealers.collect();
        // The replies to these malformed requests must not go to another client.
        for dealer in &dealers {
            let _ = dealer.send("ping", 0);
        }
        assert_served(&socket(&context, zmq::REQ, address));
    });
    target.run_attack("a peer that sends endlessly and never reads", |address| {
        let mut peer = raw::greet(address);
        peer.set_write_timeout(Some(Duration::from_millis(500))).unwrap();
        let requests = raw::request(b"info").repeat(1 << 13);
        let is_full = || peer.write_all(&requests).is_err().then_some(());
        wait_for("the server to stop reading", is_full);
        assert_served(&socket(&zmq::Context::new(), zmq::REQ, address));
        // No reply is lost when the peer starts to read.
        for _ in 0..1000 {
            let mut head = [0; 4];
            peer.read_exact(&mut head).unwrap();
            assert_eq!(head[..3], [1, 0, 0]);
            let mut reply = vec![0; head[3].into()];
            peer.read_exact(&mut reply).unwrap();
            assert!(reply.starts_with(b"{") && reply.ends_with(b"}"));
        }
    });
}

#[test]
fn other_protocols() {
    let target = Target::start();
    target.run_attack("no greeting", |address| {
        for _ in 0..20 * force() {
            for garbage in [&b"GET / HTTP/1.1\r\n\r\n"[..], b"\0", &[0xff; 500], &[7; 9]] {
                let mut peer = raw::connect(address);
                raw::send(&mut peer, garbage);
                raw::wait_until_cut_off(peer);
            }
        }
        let mut zeros = raw::connect(address);
        for _ in 0..64 {
            raw::send(&mut zeros, &vec![0; 1 << 20]);
        }
        raw::wait_until_cut_off(zeros);
    });
    target.run_attack("other greetings and handshakes", |address| {
        let changed = |index: usize, bytes: &[u8]| {
            let mut greeting = raw::greeting();
            greeting[index..index + bytes.len()].copy_from_slice(bytes);
            [greeting, raw::ready("REQ", 0)].concat()
        };
        let after = |handshake: Vec<u8>| [raw::greeting(), handshake].concat();
        let wrong = [
            b"\x01\0\0\x04ping".to_vec(),
            b"\xff\0\0\0\0\0\0\0\x01\x7f\x01\x08\0\0".to_vec(),
            changed(12, b"PLAIN"),
            changed(12, b"CURVE"),
            changed(16, b"x"),
            after(raw::ready("PUB", 0)),
            after(raw::ready("SUB", 0)),
            after(raw::ready("PUSH", 0)),
            after(raw::ready("REP", 0)),
            after(raw::ready("", 0)),
            after(raw::ready("REQ", 60_000)),
            after(raw::request(b"ping")),
            after(raw::command("ERROR", b"\x03no!")),
            after(raw::command("READY", b"\x0bSocket-Type\xff\xff\xff\xffREQ")),
            after(raw::command("HELLO", &[7; 200])),
            after(vec![4, 0]),
        ];
        for wrong in wrong.iter().cycle().take(wrong.len() * force()) {
            let mut peer = raw::connect(address);
            raw::send(&mut peer, wrong);
            raw::wait_until_cut_off(peer);
        }
        // A ZMTP 2.0 peer is accepted.
        let mut old = raw::connect(address);
        raw::send(&mut old, b"\xff\0\0\0\0\0\0\0\x01\x7f\x01\x03\0\0\x01\0\0\x04ping");
        let mut reply = [0; 22];
        old.read_exact(&mut reply).unwrap();
        assert!(reply.starts_with(b"\xff") && reply.ends_with(b"\x03\x04\0\0\x01\0\0\x04pong"));
        let context = zmq::Context::new();
        let others = [zmq::PUB, zmq::SUB, zmq::PUSH, zmq::PULL, zmq::ROUTER, zmq::PAIR];
        let _others = others.map(|kind| socket(&context, kind, address));
        assert_served(&socket(&context, zmq::REQ, address));
    });
}

#[test]
fn wrong_frames_and_commands() {
    let target = Target::start();
    target.run_attack("malformed frames and commands", |address| {
        let exbibytes = |first: u8| [&[2, first][..], &[0xff; 7]].concat();
        let wrong = [
            exbibytes(0x7f),
            exbibytes(0xff),
            [raw::frame(1, b""), exbibytes(0x7f)].concat(),
            [&[6][..], &(1_u64 << 62).to_be_bytes()].concat(),
            raw::request(&vec![b'x'; 1 << 20]),
            raw::frame(1, &[7; 255]).repeat(100),
            vec![0xff; 100],
            vec![5, 0],
            vec![4, 0],
            raw::frame(4, b"\xffPING"),
            raw::command("PING", b""),
            raw::command("ERROR", b""),
            raw::command("NO-SUCH", &vec![7; 60_000]),
        ];
        for wrong in wrong.iter().cycle().take(wrong.len() * force()) {
            let mut peer = raw::greet(address);
            raw::send(&mut peer, wrong);
            raw::wait_until_cut_off(peer);
        }
        let mut peer = raw::greet(address);
        peer.write_all(&vec![0; 4 << 20]).unwrap();
        peer.write_all(&raw::command("SUBSCRIBE", b"W")).unwrap();
        peer.write_all(&raw::command("NO-SUCH", &[7; 3000])).unwrap();
        raw::ping(&mut peer);
    });
    target.run_attack("endless pings", |address| {
        let mut peer = raw::greet(address);
        peer.set_write_timeout(Some(Duration::from_millis(200))).unwrap();
        let pings = raw::command("PING", b"\0\x010123456789abcdef").repeat(1 << 14);
        for _ in 0..8 * force() {
            if peer.write_all(&pings).is_err() {
                break; // the server has stopped reading
            }
        }
        raw::reset(peer);
        // These bytes terminate servers that are based on libzmq.
        for _ in 0..300 * force() {
            let mut peer = raw::greet(address);
            let burst = [raw::request(b"").repeat(1900), raw::command("PING", b"\0\0").repeat(50)];
            raw::send(&mut peer, &burst.concat());
            raw::reset(peer);
        }
    });
}

/// A reset must release the memory of a long history, even if more clients have just
/// connected.
#[test]
fn a_reset_releases_memory() {
    let target = Target::start();
    let context = zmq::Context::new();
    let client = socket(&context, zmq::DEALER, target.address());
    let Some(before) = Resources::from_process(target.0.id()) else { return };
    for _ in 0..2 {
        for block in 0..400 {
            for number in 0..100 {
                client.send_multipart([vec![], noise(100 * block + number)], 0).unwrap();
            }
            for _ in 0..100 {
                assert_eq!(client.recv_multipart(0).unwrap()[1], b"ok");
            }
        }
        let late: Vec<_> = (0..3).map(|_| socket(&context, zmq::REQ, target.address())).collect();
        late.iter().for_each(assert_served);
        let full = Resources::from_process(target.0.id()).unwrap();
        assert!(full.memory > before.memory + 18 * 1024, "from {before:?} to {full:?}");
        client.send_multipart(["", "reset"], 0).unwrap();
        assert_eq!(client.recv_multipart(0).unwrap()[1], b"ok");
        let after = Resources::from_process(target.0.id()).unwrap();
        assert!(after.memory < before.memory + 4 * 1024, "from {full:?} to {after:?}");
    }
}

/// Returns an incompressible state.
fn noise(seed: u32) -> Vec<u8> {
    let mut noise = u64::from(seed) << 32 | 1;
    let mut state = vec![0; 518];
    state.fill_with(|| {
        noise ^= noise << 13;
        noise ^= noise >> 7;
        noise ^= noise << 17;
        noise.to_be_bytes()[0]
    });
    state[..5].copy_from_slice(b"S\0\0NC");
    state[261] = b'F';
    state
}

#[test]
fn many_simultaneous_clients() {
    let target = Target::start();
    target.run_attack("32 clients, each with its own replies", |address| {
        let maze = searcher::maze();
        thread::scope(|scope| {
            for first in 0..32 {
                let maze = &maze;
                scope.spawn(move || {
                    let client = socket(&zmq::Context::new(), zmq::REQ, address);
                    for number in (first * 37..).take(300 * force()) {
                        let byte = |divisor| u8::try_from(number / divisor % 16).unwrap();
                        let (cell, side) = (Cell::new(byte(1), byte(16)), number % 4);
                        let pose = Pose::new(cell, Heading::ALL[side]);
                        let (around, letter) = (maze.walls().around(pose), b"NESW"[side]);
                        client.send(&[b'W', cell.x, cell.y, letter][..], 0).unwrap();
                        let reply = client.recv_multipart(0).unwrap();
                        assert_eq!(reply.len(), 1);
                        assert_eq!(Reply::decode(&reply[0]), Ok(Reply::Walls(around)), "{cell}");
                    }
                });
            }
        });
    });
    target.run_attack("many clients with the same identity, some with heartbeats", |address| {
        let context = zmq::Context::new();
        let named = (0..100 * force().min(5)).map(|number| {
            let client = context.socket(zmq::REQ).unwrap();
            client.set_identity(b"mouse").unwrap();
            if number % 2 == 0 {
                client.set_heartbeat_ivl(20).unwrap();
                client.set_heartbeat_timeout(60_000).unwrap();
            }
            client.set_linger(0).unwrap();
            client.set_rcvtimeo(TIMEOUT_MS).unwrap();
            client.connect(address).unwrap();
            client
        });
        let named: Vec<_> = named.collect();
        for _ in 0..5 {
            for client in &named {
                client.send("ping", 0).unwrap();
            }
            for client in &named {
                assert_eq!(client.recv_multipart(0).unwrap(), [b"pong"]);
            }
        }
    });
}
