//! Measures the time per request and the server's processor time. Before each request, the clients
//! keep the processor busy for a while, like real mice that compute their next step. For
//! comparison, also measures a bare libzmq REP socket.
//!
//! Each round measures mmsim and the bare REP socket alternately. On Linux, run the command with
//! `taskset -c 0` to measure on a single processor.

use std::process::{Child, Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mmsim_benches::{harbour, is_measuring, median, median_ratio, print_row};
use mmsim_server::{Server, Simulation, StopHandle};
use rustix::time::{ClockId, clock_gettime};

/// How long the clients keep the processor busy before each request, in microseconds.
const THINKING_US: [u64; 3] = [0, 60, 200];

const ROUNDS: usize = 5;
/// The number of requests to each server in a round.
const REQUESTS: u32 = 1000;

const REQUEST: &[u8] = b"W\0\0N";
const REPLY: &[u8] = &[1, 0, 1];

/// A Python version of [`libzmq_client`] that prints the mean time per request in microseconds.
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

/// A server that replies to [`REQUEST`] on a separate thread and measures the processor time of
/// that thread.
struct TimedServer {
    address: String,
    stop: Option<StopHandle>,
    thread: JoinHandle<Duration>,
}

impl TimedServer {
    fn mmsim() -> Self {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let (address, stop) = (server.address().to_string(), Some(server.stop_handle()));
        let thread = thread::spawn(|| {
            server.run(&mut Simulation::new("served", harbour())).unwrap();
            processor_time(ClockId::ThreadCPUTime)
        });
        Self { address, stop, thread }
    }

    /// Starts a thread with a bare REP socket. The thread exits after it has replied to an empty
    /// request. The measured processor time excludes libzmq's I/O thread.
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

    /// Stops the server and returns the processor time of its thread.
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

/// Runs a client that uses libzmq and returns the mean time per request in microseconds.
fn libzmq_client(address: &str, thinking: Duration) -> f64 {
    let socket = connect(address);
    ask(&socket, REQUEST);
    let start = Instant::now();
    for _ in 0..REQUESTS {
        let end = Instant::now() + thinking;
        while Instant::now() < end {}
        ask(&socket, REQUEST);
    }
    (start.elapsed() / REQUESTS).saturating_sub(thinking).as_secs_f64() * 1e6
}

fn python_client(address: &str, thinking: Duration) -> f64 {
    let arguments = [address, &REQUESTS.to_string(), &thinking.as_micros().to_string()];
    let output = Command::new("python3").args(["-c", PYTHON]).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().trim().parse().unwrap()
}

/// Processes that keep all processors busy. They are killed on drop.
struct BusyProcesses(Vec<Child>);

impl BusyProcesses {
    fn start() -> Self {
        let busy = |_| Command::new("sh").args(["-c", "while :; do :; done"]).spawn().unwrap();
        Self((0..processors()).map(busy).collect())
    }
}

impl Drop for BusyProcesses {
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
    let mut clients: Vec<(&str, Client)> = vec![("libzmq", libzmq_client)];
    if has_python() {
        clients.push(("Python", python_client));
    } else {
        println!("thinking: Python with pyzmq not found, skipping its rows");
    }
    let (thinking, rounds) =
        if is_measuring() { (&THINKING_US[..], ROUNDS) } else { (&THINKING_US[..1], 1) };
    for is_busy in [false, true] {
        let _processes = is_busy.then(BusyProcesses::start);
        let load = if is_busy { "busy machine" } else { "idle machine" };
        for (name, client) in &clients {
            let mut results = Vec::new();
            for &thinking_us in thinking {
                let (mut ours, mut bare, mut server) = (Vec::new(), Vec::new(), Vec::new());
                for _ in 0..rounds {
                    let (time, processor_time) = round(TimedServer::mmsim(), *client, thinking_us);
                    ours.push(time);
                    server.push(processor_time);
                    bare.push(round(TimedServer::libzmq(), *client, thinking_us).0);
                }
                results.push(format!(
                    "{thinking_us} µs: {:.2} times a bare REP socket ({:.0} µs; server {:.0} µs)",
                    median_ratio(&ours, &bare),
                    median(&ours),
                    median(&server)
                ));
            }
            if is_measuring() {
                print_row(&format!("thinking/{load}"), name, &results.join("; "));
            }
        }
    }
}

/// Runs a client and stops the server. Returns two mean times per request in microseconds: the
/// round-trip time that the client measured and the processor time of the server's thread.
fn round(server: TimedServer, client: Client, thinking_us: u64) -> (f64, f64) {
    let time = client(&server.address, Duration::from_micros(thinking_us));
    (time, server.stop().as_secs_f64() * 1e6 / f64::from(REQUESTS))
}
