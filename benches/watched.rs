//! Measures how much viewing slows down a search. Plain HTTP clients take the place of a browser.
//! In the first measurement, a client follows the search at sixty frames per second; in the second,
//! two clients request GIFs. Another benchmark measures the time to open a page that shows a
//! million states, and the time to fetch a randomly chosen state.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_benches::{Searches, classic_mazes, harbour, is_measuring, print_row};
use mmsim_maze::{KnownMaze, Maze, MazeSize, WyRand};
use mmsim_protocol::{MapState, Order, state_bytes};
use mmsim_server::{Server, Simulation};
use mmsim_viewer::{Viewer, ViewerConfig};
use serde_json::Value;

/// The number of rounds. Each round measures the request rate first without and then with load on
/// the viewer.
const ROUNDS: usize = 31;
/// The number of round trips in each measurement.
const TRIPS: usize = 2_000;

/// The time between two frames of the viewer page.
const FRAME: Duration = Duration::from_micros(16_667);

/// A page's persistent HTTP connection, and the value of the `host` header in its requests.
struct PageClient(BufReader<TcpStream>, String);

impl PageClient {
    fn open(address: &str) -> Self {
        let host = address.strip_prefix("http://").unwrap().to_string();
        let stream = TcpStream::connect(&host).unwrap();
        stream.set_nodelay(true).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        Self(BufReader::new(stream), host)
    }

    fn get(&mut self, path: &str) -> Vec<u8> {
        let Self(stream, host) = self;
        let request = format!("GET {path} HTTP/1.1\r\nhost: {host}\r\n\r\n");
        stream.get_mut().write_all(request.as_bytes()).unwrap();
        let (mut line, mut length) = (String::new(), 0);
        stream.read_line(&mut line).unwrap();
        assert!(line.contains(" 200 "), "{path}: {line}");
        while line != "\r\n" {
            line.clear();
            stream.read_line(&mut line).unwrap();
            if let Some(value) = line.strip_prefix("content-length: ") {
                length = value.trim().parse().unwrap();
            }
        }
        let mut body = vec![0; length];
        stream.read_exact(&mut body).unwrap();
        body
    }

    /// Requests the data that a page needs to draw a state. Returns the state as an `S` message.
    fn draw(&mut self, run: u32, at: usize) -> Vec<u8> {
        let view = self.get(&format!("/api/sources/live/moment?run={run}&at={at}"));
        let mut view: Value = serde_json::from_slice(&view).unwrap();
        assert_eq!(view["at"], at);
        serde_json::from_value(view["state"].take()).unwrap()
    }
}

/// Requests the newest state for every frame until `stop` is set. Returns the number of requested
/// states.
fn follow(address: &str, monitor: &mmsim_server::Monitor, stop: &AtomicBool) -> usize {
    let (mut page, mut drawn) = (PageClient::open(address), 0);
    while !stop.load(Ordering::Relaxed) {
        let (start, status) = (Instant::now(), monitor.status());
        if let Some(newest) = status.states.checked_sub(1) {
            assert_eq!(page.draw(status.run, newest)[0], b'S');
            drawn += 1;
        }
        thread::sleep(FRAME.saturating_sub(start.elapsed()));
    }
    drawn
}

/// The number of simultaneous connections that request GIFs.
const GIFS: usize = 2;

/// Requests GIFs of the run until `stop` is set. Returns the number of requests.
fn request_gifs(address: &str, monitor: &mmsim_server::Monitor, stop: &AtomicBool) -> usize {
    let (host, run) = (address.strip_prefix("http://").unwrap(), monitor.status().run);
    let path = format!("/api/sources/live/animation.gif?run={run}");
    let request = format!("GET {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n");
    let send_requests = || {
        let mut requests = 0;
        while !stop.load(Ordering::Relaxed) {
            let mut stream = TcpStream::connect(host).unwrap();
            stream.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            requests += 1;
            let mut buffer = [0; 1 << 12];
            while !stop.load(Ordering::Relaxed) {
                match stream.read(&mut buffer) {
                    Ok(0) => break,
                    Ok(_) => {}
                    Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                    Err(error) => panic!("{error}"),
                }
            }
        }
        requests
    };
    thread::scope(|scope| {
        let threads = [send_requests; GIFS].map(|send_requests| scope.spawn(send_requests));
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    })
}

/// A function that requests states or GIFs from the viewer until the [`AtomicBool`] is set, and
/// returns the number of requests.
type Load = fn(&str, &mmsim_server::Monitor, &AtomicBool) -> usize;

/// Returns the median, the minimum and the maximum.
fn summarize(mut values: Vec<f64>) -> (f64, f64, f64) {
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values[0], values[values.len() - 1])
}

/// Measures the rate of `S` requests under load, relative to the rate without load. Returns the
/// median, the minimum and the maximum of the relative rates over all rounds.
fn compare(trips: usize, rounds: usize, load: Load) -> (f64, f64, f64) {
    let maze = harbour();
    let (map, start) = (KnownMaze::unexplored(&maze), maze.start());
    let mut state = vec![0; state_bytes(MazeSize::CLASSIC)];
    MapState::new(start, &map, |cell| cell.x.into(), Order::F).encode(&mut state).unwrap();
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let (monitor, config) =
        (server.monitor(), ViewerConfig::default().with_live(&server, "01-harbour.txt".as_ref()));
    let server = server.spawn(Simulation::new("served", maze));
    let viewer = Viewer::bind("127.0.0.1", 0).unwrap().spawn(config).unwrap();
    let client = zmq::Context::new().socket(zmq::REQ).unwrap();
    client.set_linger(0).unwrap();
    client.set_rcvtimeo(60_000).unwrap();
    client.connect(server.address()).unwrap();
    let (mut reply, mut number) = (zmq::Message::new(), 0_u32);
    let mut time = || {
        let start = Instant::now();
        for _ in 0..trips {
            number = number.wrapping_add(1);
            state[5..9].copy_from_slice(&number.to_le_bytes());
            client.send(&state, 0).unwrap();
            client.recv(&mut reply, 0).unwrap();
            assert_eq!(&*reply, b"ok");
        }
        start.elapsed().as_secs_f64()
    };
    let ratios = (0..rounds).map(|_| {
        let alone = time();
        let stop = AtomicBool::new(false);
        thread::scope(|scope| {
            let thread = scope.spawn(|| load(viewer.address(), &monitor, &stop));
            let loaded = time();
            stop.store(true, Ordering::Relaxed);
            assert!(thread.join().unwrap() > 0);
            alone / loaded
        })
    });
    let ratios = summarize(ratios.collect());
    viewer.stop();
    assert_eq!(server.stop().unwrap().history().len(), 2 * trips * rounds);
    ratios
}

/// Returns a simulation with `count` states from real searches.
fn simulation_of_searches(mazes: &[Maze], count: usize) -> Simulation {
    let (mut simulation, mut searches) =
        (Simulation::new("searched", mazes[0].clone()), Searches::new(mazes));
    let mut reply = Vec::new();
    while simulation.history().len() < count {
        searches.next(|state| {
            if simulation.history().len() < count {
                simulation.handle(state, &mut reply);
                assert_eq!(reply, b"ok");
            }
        });
    }
    simulation
}

/// Measures the time to open a page that shows a history of `count` states, and the time to fetch a
/// random state.
fn scrub(mazes: &[Maze], count: usize) {
    let simulation = simulation_of_searches(mazes, count);
    let mut rng = WyRand::new(2);
    let indices: Vec<_> = (0..200).map(|_| rng.index(count)).collect();
    let expected: Vec<_> = indices.iter().map(|&index| simulation.history().get(index)).collect();
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let config = ViewerConfig::default().with_live(&server, "searched.txt".as_ref());
    let server = server.spawn(simulation);
    let viewer = Viewer::bind("127.0.0.1", 0).unwrap().spawn(config).unwrap();
    let start = Instant::now();
    let mut page = PageClient::open(viewer.address());
    for path in ["", "/drawing.svg?run=1", "/costs?run=1"] {
        assert!(!page.get(&format!("/api/sources/live{path}")).is_empty());
    }
    page.draw(1, count - 1);
    let open = start.elapsed().as_secs_f64() * 1e3;
    let times = indices.iter().zip(expected).map(|(&index, expected)| {
        let start = Instant::now();
        assert_eq!(Some(page.draw(1, index)), expected);
        start.elapsed().as_secs_f64() * 1e3
    });
    let (median, min, max) = summarize(times.collect());
    if is_measuring() {
        print_row(
            "watched/open",
            &format!("page with {count} states"),
            &format!(
                "{:.1} times the time to fetch any state ({open:.1} ms; {median:.2} ms, {min:.2} \
                 to {max:.2})",
                open / median
            ),
        );
    }
    viewer.stop();
    server.stop().unwrap();
}

fn main() {
    let (trips, rounds, count) =
        if is_measuring() { (TRIPS, ROUNDS, 1_000_000) } else { (500, 1, 5000) };
    for (row, load) in
        [("page that follows the search", follow as Load), ("two GIFs", request_gifs)]
    {
        let (median, min, max) = compare(trips, rounds, load);
        if is_measuring() {
            let result =
                format!("{median:.2} of the rate without it ({min:.2} to {max:.2}; goal: 0.9)");
            print_row("watched/S", row, &result);
        }
    }
    scrub(&classic_mazes(), count);
}
