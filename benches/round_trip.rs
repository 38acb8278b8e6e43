//! Measures the time of `W` and `S` requests to mmsim over ZeroMQ on loopback, with and without
//! recording. For comparison, a bare REP socket sends replies of the same sizes without parsing the
//! requests. The client is libzmq, and for another comparison that of mmsim.

use std::hint::black_box;
use std::thread;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};
use mmsim_benches::{harbour, is_measuring, print_row};
use mmsim_maze::KnownMaze;
use mmsim_protocol::{MapState, Order};
use mmsim_recording::{NewMessages, Recorder};
use mmsim_server::{Server, Simulation};
use mmsim_zmtp::ReqClient;

/// The number of rounds. Each round measures mmsim, then the implementation it is compared with.
const ROUNDS: usize = 15;
/// The number of round trips to each server in a round.
const TRIPS: u32 = 1500;

/// A request and the expected reply.
struct SampleExchange {
    name: &'static str,
    request: Vec<u8>,
    reply: &'static [u8],
}

fn exchanges() -> [SampleExchange; 2] {
    let maze = harbour();
    let map = KnownMaze::unexplored(&maze);
    let mut state = vec![0; 518];
    MapState::new(maze.start(), &map, |cell| cell.x.into(), Order::F).encode(&mut state).unwrap();
    [
        SampleExchange { name: "W", request: b"W\0\0N".to_vec(), reply: &[1, 0, 1] },
        SampleExchange { name: "S", request: state, reply: b"ok" },
    ]
}

/// A REQ socket.
trait Client {
    /// Sends a request and returns the reply.
    fn ask(&mut self, request: &[u8]) -> &[u8];
}

struct LibzmqClient {
    /// The socket keeps its ZeroMQ context alive.
    socket: zmq::Socket,
    reply: zmq::Message,
}

impl Client for LibzmqClient {
    fn ask(&mut self, request: &[u8]) -> &[u8] {
        self.socket.send(request, 0).unwrap();
        self.socket.recv(&mut self.reply, 0).unwrap();
        &self.reply
    }
}

struct OwnClient {
    client: ReqClient,
    reply: Vec<u8>,
}

impl Client for OwnClient {
    fn ask(&mut self, request: &[u8]) -> &[u8] {
        self.client.send(&[request]);
        let frames = self.client.receive(&mut self.reply, Duration::from_secs(60)).unwrap();
        assert_eq!(frames, Some(1));
        &self.reply
    }
}

/// Returns a connected client of libzmq.
fn connect(address: &str) -> LibzmqClient {
    let socket = zmq::Context::new().socket(zmq::REQ).unwrap();
    socket.set_linger(0).unwrap();
    socket.set_rcvtimeo(60_000).unwrap();
    socket.connect(address).unwrap();
    LibzmqClient { socket, reply: zmq::Message::new() }
}

/// Starts a thread with a bare REP socket that sends `reply` to every request. The thread exits
/// after it has replied to an empty request. Returns a client that is connected to the REP
/// socket.
fn connect_to_bare_rep(reply: &'static [u8]) -> LibzmqClient {
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

/// Deletes the history and measures the total time of `trips` round trips.
fn time(client: &mut dyn Client, exchange: &SampleExchange, trips: u64) -> Duration {
    client.ask(b"reset");
    assert_eq!(client.ask(&exchange.request), exchange.reply);
    let start = Instant::now();
    for _ in 0..trips {
        client.ask(black_box(&exchange.request));
    }
    start.elapsed()
}

/// Returns the request rate of `ours` relative to that of `peer`: the median, the minimum and the
/// maximum of several rounds. They are measured alternately, so that changes in the machine's speed
/// affect both equally.
fn relative_rate(
    exchange: &SampleExchange,
    ours: &mut dyn Client,
    peer: &mut dyn Client,
) -> [f64; 3] {
    let mut ratios: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let ours = time(ours, exchange, TRIPS.into());
            time(peer, exchange, TRIPS.into()).as_secs_f64() / ours.as_secs_f64()
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    [ratios[ROUNDS / 2], ratios[0], ratios[ROUNDS - 1]]
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let folder = tempfile::tempdir().unwrap();
    let recorder = |name: &str, messages: Option<NewMessages>| {
        Some(Recorder::new(&folder.path().join(name)).unwrap().with_messages(messages))
    };
    let server = |recorder: Option<Recorder>| {
        let server = Server::bind("127.0.0.1", 0).unwrap().with_recorder(recorder);
        server.spawn(Simulation::new("served", harbour()))
    };
    let servers = [
        ("mmsim", server(None)),
        ("mmsim --record", server(recorder("json", Some(mmsim_run::messages)))),
        ("mmsim --record --states-only", server(recorder("states", None))),
    ];
    for exchange in exchanges() {
        let mut bare = connect_to_bare_rep(exchange.reply);
        let mut ours: Vec<_> =
            servers.iter().map(|(name, server)| (*name, connect(server.address()))).collect();
        let client = ReqClient::new(servers[0].1.address().parse().unwrap()).unwrap();
        let mut own = OwnClient { client, reply: Vec::new() };
        let mut group = criterion.benchmark_group(format!("round_trip/{}", exchange.name));
        group.throughput(Throughput::Elements(1));
        let libzmq = ours.iter_mut().map(|(name, client)| (*name, client as &mut dyn Client));
        let others: [(&str, &mut dyn Client); 2] =
            [("bare REP", &mut bare), ("mmsim, client of mmsim", &mut own)];
        for (side, client) in libzmq.chain(others) {
            group.bench_function(side, |b| b.iter_custom(|trips| time(client, &exchange, trips)));
        }
        group.finish();
        if is_measuring() {
            let print = |row: &str, peer: &str, [median, min, max]: [f64; 3], goal: f64| {
                let result = format!(
                    "{median:.2} of the rate of {peer} ({min:.2} to {max:.2}; goal: {goal})"
                );
                print_row(&format!("round_trip/{}", exchange.name), row, &result);
            };
            // Only states are recorded.
            let compared = if exchange.name == "S" { ours.len() } else { 1 };
            for (name, client) in &mut ours[..compared] {
                let goal = if name.contains("--record") { 0.85 } else { 0.95 };
                let rate = relative_rate(&exchange, client, &mut bare);
                print(name, "a bare REP socket", rate, goal);
            }
            let rate = relative_rate(&exchange, &mut own, &mut ours[0].1);
            print("client of mmsim", "a libzmq client", rate, 1.0);
        }
        bare.ask(b"");
    }
    for (_, server) in servers {
        server.stop().unwrap();
    }
    criterion.final_summary();
}
