//! Attacks with too many connections, idle or slow connections, and connections that close without
//! warning.

use mmsim_server::LIMITS;

use crate::*;

#[test]
fn connections() {
    let target = Target::start();
    rlimit::increase_nofile_limit(4096).unwrap();
    target.run_attack("silence, half a greeting and silence, or byte by byte", |address| {
        let silent: Vec<_> = (0..500).map(|_| raw::connect(address)).collect();
        let half = raw::greeting()[..32].to_vec();
        let mut slow: Vec<_> = (0..50 * force().min(4)).map(|_| raw::connect(address)).collect();
        let half: Vec<_> = slow
            .iter()
            .map(|_| {
                let mut peer = raw::connect(address);
                raw::send(&mut peer, &half);
                peer
            })
            .collect();
        let mut other = raw::greet(address);
        for byte in &raw::greeting()[..40] {
            for peer in &mut slow {
                raw::send(peer, &[*byte]);
            }
            // The server handles all peers before it waits for further bytes.
            raw::ping(&mut other);
        }
        drop(other);
        silent.into_iter().chain(slow).chain(half).for_each(raw::wait_until_cut_off);
    });
    target.run_attack("500 idle connections", |address| {
        let idle: Vec<_> = (0..500).map(|_| raw::greet(address)).collect();
        assert_served(&socket(&zmq::Context::new(), zmq::REQ, address));
        drop(idle);
    });
    target.run_attack("more connections than the limit", |address| {
        // The searcher already has one connection.
        let mut all: Vec<_> = (1..LIMITS.max_connections).map(|_| raw::greet(address)).collect();
        // A connection that has just sent a request is protected.
        for peer in &mut all {
            raw::walls(peer);
        }
        let further = 20 * force().min(20);
        let late: Vec<_> = (0..further).map(|_| raw::connect(address)).collect();
        let client = socket(&zmq::Context::new(), zmq::REQ, address);
        client.send("ping", 0).unwrap();
        // Existing peers are still served; new peers are refused until others leave.
        for peer in &mut all {
            raw::walls(peer);
        }
        all.truncate(all.len() - further - 1);
        late.into_iter().for_each(raw::wait_until_cut_off);
        assert_eq!(client.recv_bytes(0).unwrap(), b"pong");
        drop(all);
        assert_served(&socket(&zmq::Context::new(), zmq::REQ, address));
    });
    target.run_attack("a long incomplete frame from each of many peers", |address| {
        let frame = [raw::frame(1, b""), raw::frame(0, &vec![b'x'; 60_000])].concat();
        let all: Vec<_> = (0..900)
            .map(|_| {
                let mut peer = raw::greet(address);
                raw::send(&mut peer, &frame[..55_000]);
                peer
            })
            .collect();
        assert_served(&socket(&zmq::Context::new(), zmq::REQ, address));
        drop(all);
    });
}

#[test]
fn silent_connections() {
    let target = Target::start();
    rlimit::increase_nofile_limit(4096).unwrap();
    target.run_attack("as many connections as the limit, which never close", |address| {
        let all: Vec<_> = (0..LIMITS.max_connections + 10)
            .map(|_| {
                let mut peer = raw::connect(address);
                raw::send(&mut peer, &[raw::greeting(), raw::ready("REQ", 0)].concat());
                peer
            })
            .collect();
        // A new peer replaces a silent one.
        assert_served(&socket(&zmq::Context::new(), zmq::REQ, address));
        drop(all);
    });
}

#[test]
fn more_connections_than_descriptors() {
    let home = Home::new();
    let mut command = std::process::Command::new("sh");
    command.args(["-c", "ulimit -n 64 && exec \"$0\" --port 0 --viewer-port 0 \"$1\""]);
    command.args([env!("CARGO_BIN_EXE_mmsim"), searcher::MAZE]).env("HOME", home.path());
    let target = Target(Serving::start(command, "tcp://"));
    target.run_attack("more connections than descriptors", |address| {
        let all: Vec<_> = (0..200).map(|_| raw::connect(address)).collect();
        let client = socket(&zmq::Context::new(), zmq::REQ, address);
        client.send("ping", 0).unwrap();
        all.into_iter().for_each(raw::wait_until_cut_off);
        assert_eq!(client.recv_bytes(0).unwrap(), b"pong");
    });
}

#[test]
fn peers_that_vanish() {
    let target = Target::start();
    target.run_attack("peers that vanish between request and reply", |address| {
        let walls = [raw::greeting(), raw::ready("REQ", 0), raw::request(b"W\0\0N")].concat();
        for count in 0..10_000 * force() {
            let mut peer = raw::connect(address);
            raw::send(&mut peer, &walls);
            if count % 2 == 0 {
                // The server receives the request before the end of the stream.
                peer.shutdown(Shutdown::Write).unwrap();
            }
            if count % 4 < 2 {
                let _ = peer.read(&mut [0; 1]);
            }
            raw::reset(peer);
        }
    });
    target.run_attack("resets in the middle of a frame", |address| {
        let whole = raw::request(&[b'S'; 518]);
        for cut in (0..whole.len()).cycle().take(whole.len() * force()) {
            let mut peer: TcpStream = raw::greet(address);
            raw::send(&mut peer, &whole[..cut]);
            raw::reset(peer);
        }
    });
    target.run_attack("sockets of ZeroMQ that are closed before the reply", |address| {
        for _ in 0..force() {
            // A context has at most 1023 sockets, including those being closed.
            let context = zmq::Context::new();
            for _ in 0..500 {
                let client = socket(&context, zmq::REQ, address);
                client.send("W\0\0N", 0).unwrap();
            }
        }
    });
}

/// A client whose heartbeats have no answer closes its connection, and loses its reply.
#[test]
fn a_held_reply_delays_neither_heartbeats_nor_other_clients() {
    const HOUR_MS: &str = "3600000";
    let heartbeat = raw::command("PING", b"\0\x01context");
    let (answer, reply) = (raw::command("PONG", b"context"), raw::request(b"ok"));
    for pace in [HOUR_MS, "20"] {
        let home = Home::new();
        let run = ["run", "--port", "0", "--no-viewer", "--maze", searcher::MAZE, "--pace", pace];
        let mouse = ["--", "sh", "-c", "echo started >&2; exec sleep 600"];
        let mut server = Serving::start(home.command(&[&run[..], &mouse].concat()), "started");
        server.has_mouse = true;
        let mut client = raw::greet(&server.address);
        client.write_all(&raw::request(&noise(0))).unwrap();
        let mut read = |length| {
            client.write_all(&heartbeat).unwrap();
            let mut bytes = vec![0; length];
            client.read_exact(&mut bytes).unwrap();
            bytes
        };
        if pace == HOUR_MS {
            for _ in 0..100 {
                assert_eq!(read(answer.len()), answer);
                raw::ping(&mut raw::greet(&server.address));
            }
        } else {
            let found = read(answer.len() + reply.len());
            let orders = [[&answer[..], &reply], [&reply[..], &answer]];
            assert!(orders.iter().any(|order| order.concat() == found), "{found:?}");
        }
        server.signal("TERM");
        assert_eq!(server.wait().0.code(), Some(130));
    }
}
