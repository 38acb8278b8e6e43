//! What it costs to be watched, without a browser: a follower that asks as a page does, sixty times
//! a second, and pages that each wait for a GIF. Then a history of a million states: how long any of
//! them takes to come, and all that a page needs to open it.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_benches::{Noise, Searches, bundled_maze, classic_mazes};
use mmsim_maze::{KnownMaze, Maze, MazeSize};
use mmsim_protocol::{MapState, Order, state_bytes};
use mmsim_server::{Server, Simulation};
use mmsim_viewer::{Viewer, ViewerConfig};
use serde_json::Value;

/// Rounds of a comparison and round trips in each; the two sides take turns.
const ROUNDS: usize = 61;
const TRIPS: usize = 2_000;

/// How often a page draws.
const FRAME: Duration = Duration::from_micros(16_667);

/// A connection as a browser keeps it.
struct Page(BufReader<TcpStream>, String);

impl Page {
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

    /// What a page asks for to draw a state; gives the state's message.
    fn draw(&mut self, run: u32, at: usize) -> Vec<u8> {
        let moment = self.get(&format!("/api/sources/live/moment?run={run}&at={at}"));
        let mut moment: Value = serde_json::from_slice(&moment).unwrap();
        assert_eq!(moment["at"], at);
        serde_json::from_value(moment["state"].take()).unwrap()
    }
}

/// Watches the newest state until told to stop; gives how many it has drawn.
fn follow(address: &str, watch: &mmsim_server::Monitor, stop: &AtomicBool) -> usize {
    let (mut page, mut drawn) = (Page::open(address), 0);
    while !stop.load(Ordering::Relaxed) {
        let (begun, status) = (Instant::now(), watch.status());
        if let Some(newest) = status.states.checked_sub(1) {
            assert_eq!(page.draw(status.run, newest)[0], b'S');
            drawn += 1;
        }
        thread::sleep(FRAME.saturating_sub(begun.elapsed()));
    }
    drawn
}

/// Connections that ask for a GIF at the same time.
const GIFS: usize = 2;

/// Asks for GIFs of the run until told to stop; returns the number of requests.
fn ask_for_gifs(address: &str, watch: &mmsim_server::Monitor, stop: &AtomicBool) -> usize {
    let (host, run) = (address.strip_prefix("http://").unwrap(), watch.status().run);
    let path = format!("/api/sources/live/animation.gif?run={run}");
    let request = format!("GET {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n");
    let ask = || {
        let mut asked = 0;
        while !stop.load(Ordering::Relaxed) {
            let mut stream = TcpStream::connect(host).unwrap();
            stream.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            asked += 1;
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
        asked
    };
    thread::scope(|scope| {
        let asking = [ask; GIFS].map(|ask| scope.spawn(ask));
        asking.into_iter().map(|asking| asking.join().unwrap()).sum()
    })
}

/// Does something beside a client until told to stop; returns how often it did.
type Beside = fn(&str, &mmsim_server::Monitor, &AtomicBool) -> usize;

fn median(mut values: Vec<f64>) -> (f64, f64, f64) {
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values[0], values[values.len() - 1])
}

/// The rate of `S` beside something as a part of that without it.
fn compare(trips: usize, rounds: usize, beside: Beside) -> (f64, f64, f64) {
    let maze = bundled_maze("01-harbour");
    let (map, start) = (KnownMaze::unexplored(&maze), maze.start());
    let mut state = vec![0; state_bytes(MazeSize::CLASSIC)];
    MapState::new(start, &map, |cell| cell.x.into(), Order::F).encode(&mut state).unwrap();
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let (watch, show) =
        (server.monitor(), ViewerConfig::default().with_live(&server, "01-harbour.txt".as_ref()));
    let server = server.spawn(Simulation::new("served", maze));
    let viewer = Viewer::bind("127.0.0.1", 0).unwrap().spawn(show).unwrap();
    let client = zmq::Context::new().socket(zmq::REQ).unwrap();
    client.set_linger(0).unwrap();
    client.set_rcvtimeo(60_000).unwrap();
    client.connect(server.address()).unwrap();
    let (mut reply, mut number) = (zmq::Message::new(), 0_u32);
    let mut time = || {
        let begun = Instant::now();
        for _ in 0..trips {
            number = number.wrapping_add(1);
            state[5..9].copy_from_slice(&number.to_le_bytes());
            client.send(&state, 0).unwrap();
            client.recv(&mut reply, 0).unwrap();
            assert_eq!(&*reply, b"ok");
        }
        begun.elapsed().as_secs_f64()
    };
    let ratios = (0..rounds).map(|_| {
        let alone = time();
        let stop = AtomicBool::new(false);
        thread::scope(|scope| {
            let doing = scope.spawn(|| beside(viewer.address(), &watch, &stop));
            let watched = time();
            stop.store(true, Ordering::Relaxed);
            assert!(doing.join().unwrap() > 0);
            alone / watched
        })
    });
    let ratios = median(ratios.collect());
    viewer.stop();
    assert_eq!(server.stop().unwrap().history().len(), 2 * trips * rounds);
    ratios
}

/// A simulation with so many states of real searches.
fn searched(mazes: &[Maze], count: usize) -> Simulation {
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

/// Milliseconds to open a page on a long history, and to draw any of its states.
fn scrub(mazes: &[Maze], count: usize) {
    let simulation = searched(mazes, count);
    let mut noise = Noise::new(2);
    let indices: Vec<_> = (0..200).map(|_| noise.below(count)).collect();
    let expected: Vec<_> = indices.iter().map(|&index| simulation.history().get(index)).collect();
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let show = ViewerConfig::default().with_live(&server, "searched.txt".as_ref());
    let server = server.spawn(simulation);
    let viewer = Viewer::bind("127.0.0.1", 0).unwrap().spawn(show).unwrap();
    let begun = Instant::now();
    let mut page = Page::open(viewer.address());
    for path in ["", "/drawing.svg?run=1", "/costs?run=1"] {
        assert!(!page.get(&format!("/api/sources/live{path}")).is_empty());
    }
    page.draw(1, count - 1);
    println!("watched/open: {:.1} ms for {count} states", begun.elapsed().as_secs_f64() * 1e3);
    let times = indices.iter().zip(expected).map(|(&index, expected)| {
        let begun = Instant::now();
        assert_eq!(Some(page.draw(1, index)), expected);
        begun.elapsed().as_secs_f64() * 1e3
    });
    let (middle, least, most) = median(times.collect());
    println!("watched/scrub: {middle:.2} ms to any state (median; {least:.2} to {most:.2})");
    viewer.stop();
    server.stop().unwrap();
}

fn main() {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let (trips, rounds, count) = if is_test { (500, 1, 5000) } else { (TRIPS, ROUNDS, 1_000_000) };
    let wanted = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let is_wanted = |row: &str| wanted.as_ref().is_none_or(|wanted| row.contains(wanted));
    for (row, beside) in [("S", follow as Beside), ("S while GIFs are drawn", ask_for_gifs)] {
        if !is_wanted(row) {
            continue;
        }
        let (middle, least, most) = compare(trips, rounds, beside);
        if !is_test {
            println!(
                "watched/{row}: {middle:.3} of the rate with nobody watching \
                 (median of {rounds} rounds, {least:.3} to {most:.3}; at least 0.9)"
            );
        }
    }
    if is_wanted("open scrub") {
        scrub(&classic_mazes(), count);
    }
}
