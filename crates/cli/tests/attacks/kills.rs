//! Servers that are killed while they record, compress or start. Everything that they have
//! acknowledged must be in their recordings.

use std::fs;
use std::hint;
use std::io::{BufReader, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use harness::{noise, recordings};
use mmsim_maze::WyRand;
use mmsim_recording::{Integrity, Recording};

use crate::model::{Model, SIZES};
use crate::requests::Requests;
use crate::streams::{random_maze, read_frame};
use crate::*;

/// The maximum number of rounds of [`pause`], as a power of two.
const MAX_PAUSE: u32 = 22;

/// The number of states of a recording that is compressed.
const PACKED_STATES: u64 = 800;

/// A folder into which several servers record, one after the other.
struct Folder {
    home: Home,
    rng: WyRand,
    /// A simulator that has received nothing.
    model: Model,
    /// The servers that have ended, each with its recordings.
    ended: Vec<(Model, Vec<PathBuf>)>,
}

impl Folder {
    fn new(size: (u8, u8), number: u64) -> Self {
        let (home, model, rng) = random_maze(size, number);
        Self { home, rng, model, ended: Vec::new() }
    }

    fn path(&self) -> PathBuf {
        self.home.path().join("r")
    }

    /// Starts a server and waits until it prints `text`.
    fn serve_until(&self, text: &str) -> Serving {
        self.home.serve_until(&["maze.txt", "--port", "0", "--record", "r"], text)
    }

    /// Returns the recordings of the running server.
    fn new_recordings(&self) -> (Vec<PathBuf>, Vec<Recording>) {
        let is_new = |path: &PathBuf| !self.ended.iter().any(|(_, paths)| paths.contains(path));
        recordings(&self.path()).into_iter().filter(|(path, _)| is_new(path)).unzip()
    }

    /// Checks the recordings of a server that has ended. If `is_closed`, the server had the time to
    /// close them. `unanswered` are the requests to which the server has not replied. Returns the
    /// number of states that were recorded without a reply.
    fn end(&mut self, mut model: Model, unanswered: &[Vec<u8>], is_closed: bool) -> usize {
        let (paths, new) = self.new_recordings();
        let found: usize = new.iter().map(|it| it.history().len() + it.log().len()).sum();
        let (mut unanswered, acknowledged) = (unanswered.iter(), model.states());
        while model.items() < found
            && let Some(request) = unanswered.next()
        {
            model.reply(request, Some(0));
        }
        model.check(new.iter().filter(|recording| is_closed || has_state(recording)));
        let is_intact = |integrity: &Integrity| match integrity {
            Integrity::Closed => true,
            Integrity::Truncated { .. } => !is_closed,
            Integrity::Damaged { .. } => false,
        };
        assert!(new.iter().all(|recording| is_intact(recording.integrity())));
        let unacknowledged = model.states() - acknowledged;
        self.ended.push((model, paths));
        unacknowledged
    }

    /// Starts and stops a server. It must remove temporary files, and preserve all recordings.
    fn check(mut self) {
        let mut server = self.serve_until("tcp://");
        assert_eq!(packing_files(&self.path()).len(), 0, "temporary files");
        raw::ping(&mut raw::greet(&server.address));
        server.signal("TERM");
        assert_eq!(server.wait().0.code(), Some(0));
        self.end(self.model.clone(), &[], true);
        for (model, paths) in &self.ended {
            let mut all = recordings(&self.path());
            all.retain(|(path, recording)| paths.contains(path) && has_state(recording));
            model.check(all.iter().map(|(_, recording)| recording));
        }
    }
}

/// Returns true if the recording has a state. A server may be killed after it has created a file and
/// before it has written the first state.
fn has_state(recording: &Recording) -> bool {
    !recording.history().is_empty()
}

/// Returns the temporary files in which recordings are being compressed.
fn packing_files(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.extension().is_some_and(|ending| ending == "packing")).collect()
}

/// Lets another process work for a random time, most often a short one.
fn pause(rng: &mut WyRand) {
    let max = 1 << rng.below(MAX_PAUSE + 1);
    (0..rng.below(max)).for_each(|_| hint::spin_loop());
}

/// A client that sends up to `ahead` requests before it reads a reply.
pub(crate) struct Client {
    stream: BufReader<TcpStream>,
    ahead: usize,
    pub(crate) requests: Vec<Vec<u8>>,
    sent: usize,
    answered: usize,
}

impl Client {
    pub(crate) fn new(address: &str, ahead: usize, requests: Vec<Vec<u8>>) -> Self {
        let stream = BufReader::new(raw::greet(address));
        Self { stream, ahead, requests, sent: 0, answered: 0 }
    }

    fn send(&mut self) {
        let to = (self.answered + self.ahead).min(self.requests.len());
        let wire = self.requests[self.sent..to].iter().flat_map(|request| raw::request(request));
        raw::send(self.stream.get_mut(), &wire.collect::<Vec<_>>());
        self.sent = to;
    }

    /// Receives a reply. Returns false if the server has ended instead.
    fn receive(&mut self, model: &mut Model) -> bool {
        let frames = read_frame(&mut self.stream).and_then(|_| read_frame(&mut self.stream));
        let reply = match frames {
            Ok((_, reply)) => reply,
            Err(error) if error.kind() == ErrorKind::WouldBlock => panic!("no reply: {error}"),
            Err(_) => return false,
        };
        let request = &self.requests[self.answered];
        model.reply(request, Some(0)).check(&reply, request);
        self.answered += 1;
        true
    }

    /// Sends requests until this number of them are answered.
    pub(crate) fn send_until(&mut self, answered: usize, model: &mut Model) {
        while self.answered < answered {
            self.send();
            assert!(self.receive(model), "the server has ended");
        }
    }

    /// Receives the replies of a server that has been killed. Returns the requests without a reply.
    fn receive_rest(&mut self, model: &mut Model) -> &[Vec<u8>] {
        while self.answered < self.sent && self.receive(model) {}
        &self.requests[self.answered..self.sent]
    }
}

/// Returns random requests. Each request `A` ends with a log line, so that recordings show how many
/// requests were handled.
fn random_requests(folder: &mut Folder) -> Vec<Vec<u8>> {
    let count = 50 + folder.rng.index(2000);
    let mut requests = Requests::new(folder.rng.clone(), folder.model.maze.size());
    folder.rng.next_u64();
    let mut all: Vec<_> =
        std::iter::repeat_with(|| requests.batch(0.05)).flatten().take(count).collect();
    for (number, request) in all.iter_mut().enumerate().filter(|(_, it)| it.starts_with(b"A")) {
        request.extend_from_slice(format!("L\x06\0{number:06}").as_bytes());
    }
    all
}

#[test]
fn kills_while_states_arrive() {
    let (mut ends, mut kills, mut acknowledged, mut unacknowledged) = (0, 0, 0, 0);
    for (number, size) in (0..).zip(SIZES.iter().cycle().take(2 * SIZES.len() * force())) {
        let mut folder = Folder::new(*size, number);
        for _ in 0..=folder.rng.below(3) {
            let mut server = folder.serve_until("tcp://");
            let (mut model, requests) = (folder.model.clone(), random_requests(&mut folder));
            let rng = &mut folder.rng;
            let (ahead, answered) = ([1, 1, 20, 100][rng.index(4)], rng.index(requests.len()));
            let mut client = Client::new(&server.address, ahead, requests);
            client.send_until(answered, &mut model);
            client.send();
            pause(rng);
            let signal = ["KILL", "KILL", "KILL", "TERM", "INT"][rng.index(5)];
            let is_kill = signal == "KILL";
            if is_kill {
                server.kill();
            } else {
                server.signal(signal);
            }
            let unanswered = client.receive_rest(&mut model);
            let status = server.wait().0.code();
            assert_eq!(status, (!is_kill).then_some(0));
            assert!(is_kill || packing_files(&folder.path()).is_empty(), "temporary files");
            acknowledged += model.states();
            let more = folder.end(model, unanswered, !is_kill);
            assert!(more <= ahead, "{more} states without a reply");
            (ends, kills) = (ends + 1, kills + usize::from(is_kill));
            unacknowledged += more;
        }
        folder.check();
    }
    println!("{kills} kills and {} other signals", ends - kills);
    println!("{acknowledged} acknowledged states, {unacknowledged} others recorded");
}

#[test]
fn kills_while_recordings_are_compressed_and_servers_start() {
    let (mut kills, mut packed, mut left, mut starts) = (0, 0, 0, 0);
    for number in 0..5 * force() as u64 {
        let mut folder = Folder::new((16, 16), number);
        for _ in 0..=folder.rng.below(3) {
            let mut server = folder.serve_until("tcp://");
            let (mut model, is_reset) = (folder.model.clone(), folder.rng.flip());
            let requests = (0..PACKED_STATES).flat_map(|number| {
                let line = (number % 10 == 9).then(|| b"AL\x04\0line".into());
                [noise::state(number)].into_iter().chain(line)
            });
            let mut client = Client::new(&server.address, 100, requests.collect());
            let mut rng = WyRand::new(folder.rng.next_u64());
            client.send_until(client.requests.len(), &mut model);
            let [path] = &folder.new_recordings().0[..] else { panic!("expected a recording") };
            let file = fs::metadata(path).unwrap().ino();
            if is_reset {
                client.requests.push(b"reset".into());
                client.send_until(client.requests.len(), &mut model);
            } else {
                server.signal("TERM");
            }
            let is_packed = || fs::metadata(path).unwrap().ino() != file;
            // After a SIGTERM, the server may cancel the compression and exit.
            let is_late = is_reset && rng.below(3) == 0;
            let is_packing = || !is_late && !packing_files(&folder.path()).is_empty();
            let mut is_over = || is_packed() || is_packing() || server.has_exited();
            wait_for("the compression", || is_over().then_some(()));
            pause(&mut rng);
            server.kill();
            server.wait();
            packed += usize::from(is_packed());
            folder.end(model, &[], true);
            kills += 1;
            left += packing_files(&folder.path()).len();
            for _ in 0..folder.rng.below(3) {
                let text = ["", "tcp://", "recording to"][folder.rng.index(3)];
                let mut server = folder.serve_until(text);
                pause(&mut folder.rng);
                server.kill();
                server.wait();
                starts += 1;
            }
        }
        folder.check();
    }
    println!(
        "{kills} kills: {packed} after and {left} during compression; {starts} while starting"
    );
}
