//! Clients that think before each request, as real mice do: what a request costs them, and what it
//! costs the server in processor time, beside a bare REP socket of libzmq in the same run.
//!
//! Each pair of rows is measured in alternating rounds; a row has the median and the worst round.
//! `taskset -c 0` before the command measures it on one processor of Linux.

use std::process::{Child, Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mmsim_benches::{bundled_maze, median};
use mmsim_server::{Server, Simulation, StopHandle};
use rustix::time::{ClockId, clock_gettime};

/// Thinking times before each request, in microseconds.
const THINKING_US: [u64; 6] = [0, 5, 20, 60, 100, 200];

/// Rounds of each row, and requests in each round.
const ROUNDS: usize = 5;
const REQUESTS: u32 = 1000;

const REQUEST: &[u8] = b"W\0\0N";
const REPLY: &[u8] = &[1, 0, 1];

/// The same loop as [`libzmq_client`] in Python; prints the microseconds of a request.
const PYTHON: &str = r#"
import sys, time, zmq
address, requests, thinking_us = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
socket = zmq.Context().socket(zmq.REQ)
socket.connect(address)
def ask():
    socket.send(b"W\0\0N")
    assert socket.recv() == b"\1\0\1"
ask()
begin = time.perf_counter_ns()
for _ in range(requests):
    end = time.perf_counter_ns() + 1000 * thinking_us
    while time.perf_counter_ns() < end:
        pass
    ask()
print((time.perf_counter_ns() - begin) / requests / 1000 - thinking_us)
"#;

/// Something that answers [`REQUEST`] on a thread of its own, which returns its processor time.
struct Peer {
    address: String,
    stop: Option<StopHandle>,
    thread: JoinHandle<Duration>,
}

impl Peer {
    fn mmsim() -> Self {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let (address, stop) = (server.address().to_string(), Some(server.stop_handle()));
        let thread = thread::spawn(|| {
            server.run(&mut Simulation::new("served", bundled_maze("01-harbour"))).unwrap();
            processor_time(ClockId::ThreadCPUTime)
        });
        Self { address, stop, thread }
    }

    /// A bare REP socket, until it receives an empty message. libzmq does its input and output on a
    /// thread of its own, whose processor time is not counted.
    fn libzmq() -> Self {
        let socket = zmq::Context::new().socket(zmq::REP).unwrap();
        socket.bind("tcp://127.0.0.1:*").unwrap();
        let address = socket.get_last_endpoint().unwrap().unwrap();
        let thread = thread::spawn(move || {
            while !socket.recv_bytes(0).unwrap().is_empty() {
                socket.send(REPLY, 0).unwrap();
            }
            socket.send(REPLY, 0).unwrap();
            processor_time(ClockId::ThreadCPUTime)
        });
        Self { address, stop: None, thread }
    }

    /// Stops it; returns its processor time.
    fn stop(self) -> Duration {
        match self.stop {
            Some(stop) => stop.stop(),
            None => ask(&connect(&self.address), b""),
        }
        self.thread.join().unwrap()
    }
}

fn processor_time(clock: ClockId) -> Duration {
    clock_gettime(clock).try_into().unwrap()
}

fn connect(address: &str) -> zmq::Socket {
    let socket = zmq::Context::new().socket(zmq::REQ).unwrap();
    socket.connect(address).unwrap();
    socket
}

fn ask(socket: &zmq::Socket, request: &[u8]) {
    socket.send(request, 0).unwrap();
    assert_eq!(socket.recv_bytes(0).unwrap(), REPLY);
}

/// The microseconds of a request to a client in compiled code, which calls libzmq as one in C does.
fn libzmq_client(address: &str, thinking: Duration) -> f64 {
    let socket = connect(address);
    ask(&socket, REQUEST);
    let begin = Instant::now();
    for _ in 0..REQUESTS {
        let end = Instant::now() + thinking;
        while Instant::now() < end {}
        ask(&socket, REQUEST);
    }
    (begin.elapsed() / REQUESTS).saturating_sub(thinking).as_secs_f64() * 1e6
}

fn python_client(address: &str, thinking: Duration) -> f64 {
    let arguments = [address, &REQUESTS.to_string(), &thinking.as_micros().to_string()];
    let output = Command::new("python3").args(["-c", PYTHON]).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().trim().parse().unwrap()
}

/// Processes that are always busy, one for each processor, until dropped.
struct Neighbours(Vec<Child>);

impl Neighbours {
    fn start() -> Self {
        let busy = |_| Command::new("sh").args(["-c", "while :; do :; done"]).spawn().unwrap();
        Self((0..processors()).map(busy).collect())
    }
}

impl Drop for Neighbours {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn processors() -> usize {
    thread::available_parallelism().unwrap().get()
}

fn has_python() -> bool {
    let mut import = Command::new("python3");
    import.args(["-c", "import zmq"]).stdout(Stdio::null()).stderr(Stdio::null());
    import.status().is_ok_and(|status| status.success())
}

type Client = fn(&str, Duration) -> f64;

fn main() {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let mut clients: Vec<(&str, Client)> = vec![("libzmq", libzmq_client)];
    if has_python() {
        clients.push(("Python", python_client));
    } else {
        println!("thinking: no Python with pyzmq, its rows are skipped");
    }
    let (thinking, rounds) =
        if is_test { (&THINKING_US[..1], 1) } else { (&THINKING_US[..], ROUNDS) };
    println!(
        "microseconds of a request beside the time the client thinks (worst round), processor time \
         of the server's thread a request in microseconds; {} processors",
        processors()
    );
    for busy in [false, true] {
        let _neighbours = busy.then(Neighbours::start);
        let neighbours = if busy { "busy neighbours" } else { "idle machine" };
        for (name, client) in &clients {
            for &thinking_us in thinking {
                let mut ours = Vec::new();
                let mut bare = Vec::new();
                for _ in 0..rounds {
                    ours.push(round(Peer::mmsim(), *client, thinking_us));
                    bare.push(round(Peer::libzmq(), *client, thinking_us));
                }
                let server: Vec<f64> = ours.iter().map(|(_, spent)| *spent).collect();
                println!(
                    "thinking/{name:<6} {thinking_us:>3} us, {neighbours:<15}: mmsim {}, bare REP {}, \
                     server {:4.1}",
                    summary(&ours),
                    summary(&bare),
                    median(&server)
                );
            }
        }
    }
}

/// The microseconds of a request for the client and for the server's thread.
fn round(peer: Peer, client: Client, thinking_us: u64) -> (f64, f64) {
    let time = client(&peer.address, Duration::from_micros(thinking_us));
    (time, peer.stop().as_secs_f64() * 1e6 / f64::from(REQUESTS))
}

/// The median and the worst round, as the client saw them.
fn summary(rounds: &[(f64, f64)]) -> String {
    let times: Vec<f64> = rounds.iter().map(|(time, _)| *time).collect();
    let worst = times.iter().copied().fold(0.0, f64::max);
    format!("{:6.1} ({worst:7.1})", median(&times))
}
