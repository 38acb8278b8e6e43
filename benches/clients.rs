//! Several clients at once: how long requests take, beside a plain event loop in the same run that
//! answers messages of the same sizes without looking at them.
//!
//! The clients speak ZMTP on bare sockets, so that their own cost is small. Each waits for its reply
//! before it sends the next request, as a mouse does.

use std::collections::HashMap;
use std::io::{ErrorKind, Read, Write};
use std::net::SocketAddr;
use std::time::Instant;
use std::{net, thread};

use mio::net::{TcpListener, TcpStream};
use mio::{Events, Interest, Poll, Token};
use mmsim_benches::{bundled_maze, median, serve};

/// Clients at the same time.
const CLIENTS: [usize; 3] = [1, 2, 10];

/// Rounds in which both sides alternate, and requests of all clients in each.
const ROUNDS: usize = 15;
const REQUESTS: usize = 6000;

/// The greeting of ZMTP 3.1 without the zeros at its end, and its length with them.
const GREETING: &[u8] = b"\xff\0\0\0\0\0\0\0\0\x7f\x03\x01NULL";
const GREETING_BYTES: usize = 64;

/// The command READY of a REQ socket.
const READY: &[u8] = b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\x03REQ";

/// `W` at the start, and its reply, as they are on the wire.
const REQUEST: &[u8] = b"\x01\0\0\x04W\0\0N";
const REPLY: &[u8] = b"\x01\0\0\x03\x01\0\x01";

/// Accepts connections and answers each [`REQUEST`] as soon as it has come, without a limit or a turn.
fn plain_loop(mut listener: TcpListener) {
    const LISTENER: Token = Token(usize::MAX);
    let mut poll = Poll::new().unwrap();
    poll.registry().register(&mut listener, LISTENER, Interest::READABLE).unwrap();
    let (mut events, mut peers) = (Events::with_capacity(256), HashMap::new());
    let mut buffer = [0; 4096];
    loop {
        poll.poll(&mut events, None).unwrap();
        for event in &events {
            if event.token() == LISTENER {
                while let Ok((mut peer, _)) = listener.accept() {
                    peer.set_nodelay(true).unwrap();
                    let token = Token(peers.len());
                    poll.registry().register(&mut peer, token, Interest::READABLE).unwrap();
                    peers.insert(token, peer);
                }
                continue;
            }
            let Some(peer) = peers.get_mut(&event.token()) else { continue };
            loop {
                match peer.read(&mut buffer) {
                    Ok(0) => break,
                    Ok(count) => peer.write_all(&REPLY.repeat(count / REQUEST.len())).unwrap(),
                    Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                    Err(error) => panic!("{error}"),
                }
            }
        }
    }
}

/// A connection to our server after its handshake.
fn greet(address: &str) -> TcpStream {
    let mut stream = net::TcpStream::connect(address.trim_start_matches("tcp://")).unwrap();
    let zeros = [0; GREETING_BYTES - GREETING.len()];
    stream.write_all(&[GREETING, &zeros, READY].concat()).unwrap();
    let (mut theirs, mut head) = ([0; GREETING_BYTES], [0; 2]);
    stream.read_exact(&mut theirs).unwrap();
    stream.read_exact(&mut head).unwrap();
    stream.read_exact(&mut vec![0; head[1].into()]).unwrap();
    polled(stream)
}

/// The same connection for a [`Poll`].
fn polled(stream: net::TcpStream) -> TcpStream {
    stream.set_nodelay(true).unwrap();
    stream.set_nonblocking(true).unwrap();
    TcpStream::from_std(stream)
}

/// What the clients of a round saw.
#[derive(Clone, Copy)]
struct Round {
    /// Microseconds of half of all requests at most, and of 99 in 100.
    p50: f64,
    p99: f64,
    /// Requests a second, of all clients together.
    rate: f64,
}

/// Lets all clients ask until there were so many requests. One thread does this for all of them:
/// threads would measure how the system schedules them.
fn round(clients: &mut [TcpStream], requests: usize) -> Round {
    let (mut poll, mut events) = (Poll::new().unwrap(), Events::with_capacity(clients.len()));
    let (mut times, mut reply) = (Vec::with_capacity(requests), [0; REPLY.len()]);
    let begin = Instant::now();
    let mut asked = vec![begin; clients.len()];
    for (index, client) in clients.iter_mut().enumerate() {
        poll.registry().register(client, Token(index), Interest::READABLE).unwrap();
        client.write_all(REQUEST).unwrap();
    }
    let mut waiting = clients.len();
    while waiting > 0 {
        poll.poll(&mut events, None).unwrap();
        for event in &events {
            let Token(index) = event.token();
            let client = &mut clients[index];
            client.read_exact(&mut reply).unwrap();
            assert_eq!(reply, REPLY);
            times.push(asked[index].elapsed().as_secs_f64() * 1e6);
            if times.len() + waiting > requests {
                waiting -= 1;
                continue;
            }
            asked[index] = Instant::now();
            client.write_all(REQUEST).unwrap();
        }
    }
    let rate = f64::from(u32::try_from(times.len()).unwrap()) / begin.elapsed().as_secs_f64();
    for client in clients {
        poll.registry().deregister(client).unwrap();
    }
    times.sort_by(f64::total_cmp);
    Round { p50: times[times.len() / 2], p99: times[times.len() * 99 / 100], rate }
}

fn main() {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let (rounds, requests) = if is_test { (1, 100) } else { (ROUNDS, REQUESTS) };
    let server = serve(bundled_maze("01-harbour"));
    let listener = TcpListener::bind(SocketAddr::from(([127, 0, 0, 1], 0))).unwrap();
    let plain = listener.local_addr().unwrap().to_string();
    thread::spawn(|| plain_loop(listener));
    println!("clients: medians of {rounds} rounds; mmsim, plain loop, median ratio");
    for count in CLIENTS {
        let mut ours: Vec<_> = (0..count).map(|_| greet(server.address())).collect();
        let mut others: Vec<_> =
            (0..count).map(|_| polled(net::TcpStream::connect(&plain).unwrap())).collect();
        let rounds: Vec<_> = (0..rounds)
            .map(|_| (round(&mut ours, requests), round(&mut others, requests)))
            .collect();
        let row = |name: &str, figure: fn(&Round) -> f64| {
            let side = |figures: Vec<f64>| median(&figures);
            println!(
                "clients/{count:>2} {name}: {:>9.1} {:>9.1} {:>6.3}",
                side(rounds.iter().map(|(ours, _)| figure(ours)).collect()),
                side(rounds.iter().map(|(_, plain)| figure(plain)).collect()),
                side(rounds.iter().map(|(ours, plain)| figure(ours) / figure(plain)).collect()),
            );
        };
        row("p50 in us     ", |round| round.p50);
        row("p99 in us     ", |round| round.p99);
        row("requests per s", |round| round.rate);
    }
    server.stop().unwrap();
}
