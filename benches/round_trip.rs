//! Measures the time of `W` and `S` requests to mmsim over ZeroMQ on loopback, with and without
//! recording. For comparison, a bare REP socket sends replies of the same sizes without parsing the
//! requests.

use std::hint::black_box;
use std::thread;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};
use mmsim_benches::bundled_maze;
use mmsim_maze::KnownMaze;
use mmsim_protocol::{MapState, Order};
use mmsim_recording::Recorder;
use mmsim_server::{Server, Simulation};

/// The number of rounds. Each round measures mmsim, then the bare REP socket.
const ROUNDS: usize = 15;
/// The number of round trips to each server in a round.
const TRIPS: u32 = 4000;

/// A request and the expected reply.
struct SampleExchange {
    name: &'static str,
    request: Vec<u8>,
    reply: &'static [u8],
}

fn exchanges() -> [SampleExchange; 2] {
    let maze = bundled_maze("01-harbour");
    let map = KnownMaze::unexplored(&maze);
    let mut state = vec![0; 518];
    MapState::new(maze.start(), &map, |cell| cell.x.into(), Order::F).encode(&mut state).unwrap();
    [
        SampleExchange { name: "W", request: b"W\0\0N".to_vec(), reply: &[1, 0, 1] },
        SampleExchange { name: "S", request: state, reply: b"ok" },
    ]
}

/// Returns a connected REQ socket. The socket keeps its ZeroMQ context alive.
fn connect(address: &str) -> zmq::Socket {
    let socket = zmq::Context::new().socket(zmq::REQ).unwrap();
    socket.set_linger(0).unwrap();
    socket.set_rcvtimeo(60_000).unwrap();
    socket.connect(address).unwrap();
    socket
}

/// Starts a thread with a bare REP socket that sends `reply` to every request. The thread exits
/// after it has replied to an empty request. Returns a REQ socket that is connected to the REP
/// socket.
fn connect_to_bare_rep(reply: &'static [u8]) -> zmq::Socket {
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

fn round_trip(socket: &zmq::Socket, request: &[u8], reply: &mut zmq::Message) {
    socket.send(request, 0).unwrap();
    socket.recv(reply, 0).unwrap();
}

/// Deletes the history and measures the total time of `trips` round trips.
fn time(socket: &zmq::Socket, exchange: &SampleExchange, trips: u64) -> Duration {
    let mut reply = zmq::Message::new();
    round_trip(socket, b"reset", &mut reply);
    round_trip(socket, &exchange.request, &mut reply);
    assert_eq!(*reply, *exchange.reply);
    let start = Instant::now();
    for _ in 0..trips {
        round_trip(socket, black_box(&exchange.request), &mut reply);
    }
    start.elapsed()
}

/// Prints the request rate of mmsim relative to that of the bare socket. The servers are measured
/// alternately, so that changes in the machine's speed affect both servers equally.
fn compare(name: &str, exchange: &SampleExchange, ours: &zmq::Socket, bare: &zmq::Socket) {
    let mut ratios: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let ours = time(ours, exchange, TRIPS.into());
            time(bare, exchange, TRIPS.into()).as_secs_f64() / ours.as_secs_f64()
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let expected = if name.contains("--record") { 0.85 } else { 0.95 };
    let (median, min, max) = (ratios[ROUNDS / 2], ratios[0], ratios[ROUNDS - 1]);
    println!(
        "round_trip/{}/{name}: {median:.3} of the rate of a bare REP socket \
         (median of {ROUNDS} rounds, {min:.3} to {max:.3}; at least {expected})",
        exchange.name
    );
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let is_test = std::env::args().any(|argument| argument == "--test");
    let folder = tempfile::tempdir().unwrap();
    let recorder = |name: &str, has_json| {
        Some(Recorder::new(&folder.path().join(name)).unwrap().with_json(has_json))
    };
    let server = |recorder: Option<Recorder>| {
        let server = Server::bind("127.0.0.1", 0).unwrap().with_recorder(recorder);
        server.spawn(Simulation::new("served", bundled_maze("01-harbour")))
    };
    let servers = [
        ("mmsim", server(None)),
        ("mmsim --record", server(recorder("json", true))),
        ("mmsim --record --states-only", server(recorder("states", false))),
    ];
    for exchange in exchanges() {
        let bare = connect_to_bare_rep(exchange.reply);
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
        round_trip(&bare, b"", &mut zmq::Message::new());
    }
    for (_, server) in servers {
        server.stop().unwrap();
    }
    criterion.final_summary();
}
