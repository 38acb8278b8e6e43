//! Measures latency and throughput with several simultaneous clients. For comparison, also measures
//! a plain event loop that sends replies of the same sizes without parsing the requests.
//!
//! To keep their overhead small, the clients speak ZMTP over plain TCP sockets. Like a mouse, each
//! client waits for the reply before it sends the next request.

use std::collections::HashMap;
use std::io::{ErrorKind, Read, Write};
use std::net::SocketAddr;
use std::time::Instant;
use std::{net, thread};

use mio::net::{TcpListener, TcpStream};
use mio::{Events, Interest, Poll, Token};
use mmsim_benches::{harbour, is_measuring, median, median_ratio, print_row, serve};

/// The number of simultaneous clients in each measurement.
const CLIENTS: [usize; 3] = [1, 2, 10];

/// The number of rounds. Each round measures mmsim, then the plain event loop.
const ROUNDS: usize = 15;
/// The total number of requests that the clients send to each server in a round.
const REQUESTS: usize = 6000;

/// The ZMTP 3.1 greeting without the trailing zeros.
const GREETING: &[u8] = b"\xff\0\0\0\0\0\0\0\0\x7f\x03\x01NULL";
/// The length of the greeting in bytes, including the trailing zeros.
const GREETING_BYTES: usize = 64;

/// The READY command of a REQ socket.
const READY: &[u8] = b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\x03REQ";

/// A `W` request from the start cell, as bytes on the wire.
const REQUEST: &[u8] = b"\x01\0\0\x04W\0\0N";
/// The reply to [`REQUEST`], as bytes on the wire.
const REPLY: &[u8] = b"\x01\0\0\x03\x01\0\x01";

/// Accepts connections and replies to each [`REQUEST`] immediately, without limits or fair
/// queueing.
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

/// Connects to an mmsim server and completes the handshake.
fn connect_zmtp(address: &str) -> TcpStream {
    let mut stream = net::TcpStream::connect(address.trim_start_matches("tcp://")).unwrap();
    let zeros = [0; GREETING_BYTES - GREETING.len()];
    stream.write_all(&[GREETING, &zeros, READY].concat()).unwrap();
    let (mut greeting, mut header) = ([0; GREETING_BYTES], [0; 2]);
    stream.read_exact(&mut greeting).unwrap();
    stream.read_exact(&mut header).unwrap();
    stream.read_exact(&mut vec![0; header[1].into()]).unwrap();
    into_mio(stream)
}

/// Converts a blocking connection to a non-blocking one that works with [`Poll`].
fn into_mio(stream: net::TcpStream) -> TcpStream {
    stream.set_nodelay(true).unwrap();
    stream.set_nonblocking(true).unwrap();
    TcpStream::from_std(stream)
}

#[derive(Clone, Copy)]
struct RoundStats {
    /// The median latency in microseconds.
    p50: f64,
    /// The 99th percentile of the latency in microseconds.
    p99: f64,
    /// The number of requests per second, summed over all clients.
    rate: f64,
}

/// Sends `requests` requests, distributed over the clients. All clients run on one thread to keep
/// the scheduler from affecting the result.
fn round(clients: &mut [TcpStream], requests: usize) -> RoundStats {
    let (mut poll, mut events) = (Poll::new().unwrap(), Events::with_capacity(clients.len()));
    let (mut times, mut reply) = (Vec::with_capacity(requests), [0; REPLY.len()]);
    let start = Instant::now();
    let mut sent = vec![start; clients.len()];
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
            times.push(sent[index].elapsed().as_secs_f64() * 1e6);
            if times.len() + waiting > requests {
                waiting -= 1;
                continue;
            }
            sent[index] = Instant::now();
            client.write_all(REQUEST).unwrap();
        }
    }
    let rate = f64::from(u32::try_from(times.len()).unwrap()) / start.elapsed().as_secs_f64();
    for client in clients {
        poll.registry().deregister(client).unwrap();
    }
    times.sort_by(f64::total_cmp);
    RoundStats { p50: times[times.len() / 2], p99: times[times.len() * 99 / 100], rate }
}

fn main() {
    let (rounds, requests) = if is_measuring() { (ROUNDS, REQUESTS) } else { (1, 100) };
    let server = serve(harbour());
    let listener = TcpListener::bind(SocketAddr::from(([127, 0, 0, 1], 0))).unwrap();
    let plain = listener.local_addr().unwrap().to_string();
    thread::spawn(|| plain_loop(listener));
    for count in CLIENTS {
        let mut ours: Vec<_> = (0..count).map(|_| connect_zmtp(server.address())).collect();
        let mut plain_clients: Vec<_> =
            (0..count).map(|_| into_mio(net::TcpStream::connect(&plain).unwrap())).collect();
        let rounds: Vec<_> = (0..rounds)
            .map(|_| (round(&mut ours, requests), round(&mut plain_clients, requests)))
            .collect();
        if !is_measuring() {
            continue;
        }
        // The median, and the median of the ratios to the plain event loop.
        let medians = |figure: fn(&RoundStats) -> f64| {
            let (ours, plain): (Vec<_>, Vec<_>) =
                rounds.iter().map(|(ours, plain)| (figure(ours), figure(plain))).unzip();
            (median(&ours), median_ratio(&ours, &plain))
        };
        let (p50, p50_ratio) = medians(|round| round.p50);
        let (p99, p99_ratio) = medians(|round| round.p99);
        let (rate, rate_ratio) = medians(|round| round.rate);
        print_row(
            "clients",
            &format!("clients at the same time: {count}"),
            &format!(
                "{p50_ratio:.2}, {p99_ratio:.2} and {rate_ratio:.2} times a plain event loop (median \
                 {p50:.0} µs, 99th percentile {p99:.0} µs, {rate:.0} requests/s)"
            ),
        );
    }
    server.stop().unwrap();
}
