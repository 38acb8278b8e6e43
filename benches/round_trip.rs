//! Round trips over ZeroMQ on loopback: `W` and `S` to our server, with and without a recording,
//! beside a bare REP socket that answers messages of the same sizes without looking at them.

use std::hint::black_box;
use std::thread;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};
use mmsim_benches::bundled_maze;
use mmsim_maze::KnownMaze;
use mmsim_protocol::{MapState, Order};
use mmsim_recording::Recorder;
use mmsim_server::{Server, Simulation};

/// Rounds of the comparison and round trips in each; the two sides take turns.
const ROUNDS: usize = 15;
const TRIPS: u32 = 4000;

/// A request, the length of its reply, and the name of both.
struct Exchange {
    name: &'static str,
    request: Vec<u8>,
    reply: &'static [u8],
}

fn exchanges() -> [Exchange; 2] {
    let maze = bundled_maze("01-harbour");
    let map = KnownMaze::unexplored(&maze);
    let mut state = vec![0; 518];
    MapState::new(maze.start(), &map, |cell| cell.x.into(), Order::F).encode(&mut state).unwrap();
    [
        Exchange { name: "W", request: b"W\0\0N".to_vec(), reply: &[1, 0, 1] },
        Exchange { name: "S", request: state, reply: b"ok" },
    ]
}

/// A connected REQ socket. The context lives as long as the socket.
fn connect(address: &str) -> zmq::Socket {
    let socket = zmq::Context::new().socket(zmq::REQ).unwrap();
    socket.set_linger(0).unwrap();
    socket.set_rcvtimeo(60_000).unwrap();
    socket.connect(address).unwrap();
    socket
}

/// A bare REP socket: whatever comes, the reply is the same. It ends with a message of no byte.
fn echo(reply: &'static [u8]) -> zmq::Socket {
    let socket = zmq::Context::new().socket(zmq::REP).unwrap();
    socket.bind("tcp://127.0.0.1:*").unwrap();
    let address = socket.get_last_endpoint().unwrap().unwrap();
    thread::spawn(move || {
        let mut request = zmq::Message::new();
        loop {
            socket.recv(&mut request, 0).unwrap();
            socket.send(reply, 0).unwrap();
            if request.is_empty() {
                break;
            }
        }
    });
    connect(&address)
}

fn trip(socket: &zmq::Socket, request: &[u8], reply: &mut zmq::Message) {
    socket.send(request, 0).unwrap();
    socket.recv(reply, 0).unwrap();
}

/// How long `trips` round trips take, from an empty history.
fn time(socket: &zmq::Socket, exchange: &Exchange, trips: u64) -> Duration {
    let mut reply = zmq::Message::new();
    trip(socket, b"reset", &mut reply);
    trip(socket, &exchange.request, &mut reply);
    assert_eq!(*reply, *exchange.reply);
    let begun = Instant::now();
    for _ in 0..trips {
        trip(socket, black_box(&exchange.request), &mut reply);
    }
    begun.elapsed()
}

/// The rate of our server as a part of the bare socket's: the median of rounds in which both take
/// turns, so that a change in the machine's speed hits both.
fn compare(name: &str, exchange: &Exchange, ours: &zmq::Socket, bare: &zmq::Socket) {
    let mut ratios: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let ours = time(ours, exchange, TRIPS.into());
            time(bare, exchange, TRIPS.into()).as_secs_f64() / ours.as_secs_f64()
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let expected = if name.ends_with("--record") { 0.85 } else { 0.95 };
    let (median, least, most) = (ratios[ROUNDS / 2], ratios[0], ratios[ROUNDS - 1]);
    println!(
        "round_trip/{}/{name}: {median:.3} of the rate of a bare REP socket \
         (median of {ROUNDS} rounds, {least:.3} to {most:.3}; at least {expected})",
        exchange.name
    );
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let is_test = std::env::args().any(|argument| argument == "--test");
    let folder = tempfile::tempdir().unwrap();
    let server = |recorder: Option<Recorder>| {
        let server = Server::bind("127.0.0.1", 0).unwrap().with_recorder(recorder);
        server.spawn(Simulation::new("served", bundled_maze("01-harbour")))
    };
    let servers = [
        ("mmsim", server(None)),
        ("mmsim --record", server(Some(Recorder::new(folder.path()).unwrap()))),
    ];
    for exchange in exchanges() {
        let bare = echo(exchange.reply);
        let ours: Vec<_> =
            servers.iter().map(|(name, server)| (*name, connect(server.address()))).collect();
        let mut group = criterion.benchmark_group(format!("round_trip/{}", exchange.name));
        group.throughput(Throughput::Elements(1));
        for (side, socket) in
            ours.iter().map(|(name, ours)| (*name, ours)).chain([("bare REP", &bare)])
        {
            group.bench_function(side, |b| b.iter_custom(|trips| time(socket, &exchange, trips)));
        }
        group.finish();
        for (name, ours) in ours.iter().filter(|_| !is_test) {
            compare(name, &exchange, ours, &bare);
        }
        trip(&bare, b"", &mut zmq::Message::new());
    }
    for (_, server) in servers {
        server.stop().unwrap();
    }
    criterion.final_summary();
}
