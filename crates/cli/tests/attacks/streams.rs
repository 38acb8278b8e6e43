//! Random streams of requests over real sockets. A [`Model`] predicts the replies and recordings.

use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};
use std::io::{self, BufReader};

use harness::{read_on, recordings};
use mmsim_maze::WyRand;

use crate::kills::Client;
use crate::model::{Model, SIZES};
use crate::requests::Requests;
use crate::*;

/// The number of messages in a stream.
const MESSAGES: usize = 3000;

/// Returns a home folder with the file `maze.txt`, the model of its simulator, and random numbers
/// for a stream. They depend on `MMSIM_ATTACK_SEED`, by default a random number, which is printed.
pub(crate) fn random_maze(size: (u8, u8), stream: u64) -> (Home, Model, WyRand) {
    static SEED: OnceLock<u64> = OnceLock::new();
    let seed = SEED.get_or_init(|| match env::var("MMSIM_ATTACK_SEED") {
        Ok(seed) => seed.parse().unwrap(),
        Err(_) => RandomState::new().hash_one(0),
    });
    println!("MMSIM_ATTACK_SEED={seed}, stream {stream}");
    let (home, mut rng) = (Home::new(), WyRand::new(seed.wrapping_add(stream)));
    let model = Model::random("maze", size, &mut rng);
    home.write("maze.txt", model.maze.to_string());
    (home, model, rng)
}

/// The versions of ZMTP that the server supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Zmtp2,
    Zmtp30,
    Zmtp31,
}

impl Version {
    const ALL: [Self; 3] = [Self::Zmtp2, Self::Zmtp30, Self::Zmtp31];

    /// Returns the handshake of a DEALER socket.
    fn handshake(self) -> Vec<u8> {
        let mut greeting = raw::greeting();
        match self {
            Self::Zmtp2 => return b"\xff\0\0\0\0\0\0\0\x01\x7f\x01\x05\0\x03abc".into(),
            Self::Zmtp30 => greeting[11] = 0,
            Self::Zmtp31 => {}
        }
        [greeting, raw::ready("DEALER", 0)].concat()
    }

    /// Reads the handshake of the server.
    fn read_handshake(self, stream: &mut impl Read) {
        let mut signature = [0; 11];
        stream.read_exact(&mut signature).unwrap();
        assert_eq!(signature, *b"\xff\0\0\0\0\0\0\0\x01\x7f\x03");
        if self == Self::Zmtp2 {
            let mut rest = [0; 3];
            stream.read_exact(&mut rest).unwrap();
            assert_eq!(rest, *b"\x04\0\0");
        } else {
            stream.read_exact(&mut [0; 53]).unwrap();
            let (flags, ready) = read_frame(stream).unwrap();
            assert!(flags == 4 && ready.starts_with(b"\x05READY"), "{}", ready.escape_ascii());
        }
    }
}

/// Reads a frame: its flags without that of a long frame, and its body.
pub(crate) fn read_frame(stream: &mut impl Read) -> io::Result<(u8, Vec<u8>)> {
    let (mut flags, mut length) = ([0], [0; 8]);
    stream.read_exact(&mut flags)?;
    let is_long = flags[0] & 2 != 0;
    stream.read_exact(&mut length[if is_long { 0 } else { 7 }..])?;
    let mut body = vec![0; usize::try_from(u64::from_be_bytes(length)).unwrap()];
    stream.read_exact(&mut body)?;
    Ok((flags[0] & !2, body))
}

/// Something that a peer sends.
struct Message {
    wire: Vec<u8>,
    frames: Vec<Vec<u8>>,
    /// The number of heartbeats before frames of the message.
    pings: usize,
}

impl Message {
    /// Puts a request into the usual frames or, sometimes, into others.
    fn new(request: Vec<u8>, is_usual: bool, rng: &mut WyRand) -> Self {
        let [before, kind] = [(); 2].map(|()| if is_usual { u32::MAX } else { rng.below(10) });
        let envelope = [&b""[..], b"a", b"envelope", &[7; 300]];
        let mut frames: Vec<Vec<u8>> = match before {
            0 => (0..rng.below(3)).map(|_| envelope[rng.index(4)].into()).collect(),
            1 => (0..rng.below(3)).map(|_| envelope[1 + rng.index(3)].into()).collect(),
            _ => vec![],
        };
        match kind {
            0 => frames.extend([vec![], request.clone(), request]),
            1 => frames.push(request),
            2 => frames.push(vec![]),
            _ => frames.extend([vec![], request]),
        }
        let (last, mut pings, mut wire) = (frames.len() - 1, 0, Vec::new());
        for (index, body) in frames.iter().enumerate() {
            if rng.below(30) == 0 {
                pings += 1;
                wire.extend(raw::command("PING", b"\0\x01context"));
            }
            let more = u8::from(index < last);
            if rng.below(10) == 0 {
                let length = (body.len() as u64).to_be_bytes();
                wire.extend([&[more | 2][..], &length, body].concat());
            } else {
                wire.extend(raw::frame(more, body));
            }
        }
        Self { wire, frames, pings }
    }
}

/// A client that sends messages in parts.
struct Peer {
    stream: BufReader<TcpStream>,
    /// The number of its connection, unless it is a stranger.
    mouse: Option<usize>,
    /// The messages that have not been sent completely.
    queue: VecDeque<Message>,
    /// The number of bytes of the first message that have been sent.
    sent: usize,
}

impl Peer {
    fn connect(address: &str, mouse: Option<usize>, rng: &mut WyRand) -> Self {
        let version = Version::ALL[rng.index(3)];
        let mut stream = BufReader::new(raw::connect(address));
        stream.get_mut().write_all(&version.handshake()).unwrap();
        version.read_handshake(&mut stream);
        Self { stream, mouse, queue: VecDeque::new(), sent: 0 }
    }

    /// Sends a part of the queue, and checks the replies to all messages that are complete.
    fn send(&mut self, model: &mut Model, rng: &mut WyRand) -> usize {
        let wire: Vec<_> = self.queue.iter().flat_map(|message| &message.wire).copied().collect();
        let rest = &wire[self.sent..];
        let count = match rng.below(3) {
            0 => rest.len(),
            1 => 1 + rng.index(rest.len().min(20)),
            _ => 1 + rng.index(rest.len()),
        };
        self.stream.get_mut().write_all(&rest[..count]).unwrap();
        self.sent += count;
        let mut complete = 0;
        while self.queue.front().is_some_and(|next| next.wire.len() <= self.sent) {
            let message = self.queue.pop_front().unwrap();
            self.sent -= message.wire.len();
            complete += 1;
            for _ in 0..message.pings {
                let pong = read_frame(&mut self.stream).unwrap();
                assert_eq!(pong, (4, b"\x04PONGcontext".into()));
            }
            check_reply(&mut self.stream, &message.frames, model, self.mouse);
        }
        complete
    }
}

/// Checks the reply to a message, if there must be one.
#[track_caller]
fn check_reply(
    stream: &mut impl Read,
    frames: &[Vec<u8>],
    model: &mut Model,
    mouse: Option<usize>,
) {
    let Some((envelope, expected)) = model.answer(frames, mouse) else { return };
    for frame in envelope {
        assert_eq!(read_frame(stream).unwrap(), (1, frame));
    }
    let (flags, body) = read_frame(stream).unwrap();
    assert_eq!(flags, 0);
    expected.check(&body, &frames[frames.len() - 1]);
}

/// Sends random messages from peers that take turns, and may vanish in the middle of a message. The
/// first peer is the mouse, and the others are strangers if they have another address. Returns the
/// number of messages.
fn exchange(addresses: [&str; 2], requests: &mut Requests, model: &mut Model) -> usize {
    let mut numbers = 0..;
    let mut connect = |index: usize, rng: &mut WyRand| {
        let is_mouse = index == 0 || addresses[0] == addresses[1];
        Peer::connect(addresses[index.min(1)], numbers.next().filter(|_| is_mouse), rng)
    };
    let rng = &mut requests.rng;
    let mut peers: Vec<_> = (0..4).map(|index| connect(index, rng)).collect();
    let mut messages = 0;
    while messages < MESSAGES {
        let index = requests.rng.index(peers.len());
        let peer = &mut peers[index];
        if peer.queue.is_empty() {
            let batch = requests.batch(0.4);
            let (is_usual, rng) = (requests.rng.flip(), &mut requests.rng);
            let batch = batch.into_iter().map(|request| Message::new(request, is_usual, rng));
            peer.queue.extend(batch);
        }
        let rng = &mut requests.rng;
        messages += peer.send(model, rng);
        if index > 0 && rng.below(100) == 0 {
            let gone = std::mem::replace(peer, connect(index, rng));
            if rng.flip() {
                raw::reset(gone.stream.into_inner());
            }
        }
    }
    for peer in &mut peers {
        let (wire, frames) = (raw::request(b"info"), vec![vec![], b"info".into()]);
        peer.queue.push_back(Message { wire, frames, pings: 0 });
        while !peer.queue.is_empty() {
            messages += peer.send(model, &mut requests.rng);
        }
    }
    messages
}

/// Checks that a folder contains exactly the recordings of the simulator.
#[track_caller]
fn check_recordings(home: &Home, model: &Model) {
    let found = recordings(&home.path().join("r"));
    model.check(found.iter().map(|(_, recording)| recording));
}

#[test]
fn each_reply_is_the_expected_one() {
    let (mut messages, mut states) = (0, 0);
    for (number, size) in (0..).zip(SIZES.iter().cycle().take(SIZES.len() * force())) {
        let (home, mut model, rng) = random_maze(*size, number);
        let mut server = home.serve(&["maze.txt", "--port", "0", "--record", "r"]);
        let mut requests = Requests::new(rng, model.maze.size());
        messages += exchange([&server.address; 2], &mut requests, &mut model);
        states += model.states();
        match requests.rng.below(3) {
            0 => server.kill(),
            1 => server.signal("TERM"),
            _ => server.signal("INT"),
        }
        server.wait();
        check_recordings(&home, &model);
    }
    println!("{messages} messages, {states} states in {} streams", SIZES.len() * force());
}

#[test]
fn strangers_do_not_disturb_the_mouse_of_a_run() {
    let (mut messages, mut errors) = (0, 0);
    for (number, size) in (0..).zip(SIZES.iter().cycle().take(2 * force())) {
        let (home, mut model, rng) = random_maze(*size, number);
        let mouse = ["sh", "-c", "echo mouse at $MMSIM_ENDPOINT >&2; exec sleep 600"];
        model = model.with_mouse(&mouse.join(" "));
        let options =
            ["run", "--maze", "maze.txt", "--port", "0", "--no-viewer", "--record", "r", "--"];
        let command = home.command(&[&options[..], &mouse].concat());
        let (mut server, stderr) = Serving::start_reading(command, "tcp://");
        server.has_mouse = true;
        let (stderr, rest) = read_on(stderr, "mouse at ");
        let own = rest.lines().find_map(|line| line.strip_prefix("mouse at ")).unwrap();
        let mut requests = Requests::new(rng, model.maze.size());
        raw::ping(&mut raw::greet(own));
        messages += exchange([own, &server.address], &mut requests, &mut model);
        errors += model.errors[1];
        server.signal("TERM");
        let (_, end) = read_on(stderr, "mouse stopped by ");
        let expected = format!(", {} requests refused", model.errors[0]);
        assert!(end.contains(&expected), "expected {expected}, found {end}");
        check_recordings(&home, &model);
    }
    println!("{messages} messages, {errors} errors for strangers");
}

/// The bytes of a connection arrive in two parts, which end at each position in turn.
#[test]
fn bytes_may_be_split_anywhere() {
    let (home, mut model, _) = random_maze((5, 3), 0);
    let server = home.serve(&["maze.txt", "--port", "0", "--record", "r"]);
    let mut other = raw::greet(&server.address);
    let state = [&b"S\x04\x02WC"[..], &[7; 15], b"F", &[13; 15]].concat();
    let long = [&b"AL\x2c\x01"[..], &[b'x'; 300]].concat();
    let sent = [&b"ping"[..], b"W\0\0N", b"AT\x01\x01\x011R", &long, &state, b"info", b"S", b""];
    let messages = sent.map(|request| vec![vec![], request.to_vec()]);
    let wire: Vec<_> = sent.iter().flat_map(|request| raw::request(request)).collect();
    let mut cuts = 0;
    for version in Version::ALL.into_iter().cycle().take(3 * force().min(5)) {
        let wire = [version.handshake(), wire.clone()].concat();
        for cut in 0..=wire.len() {
            let mut stream = BufReader::new(raw::connect(&server.address));
            stream.get_mut().write_all(&wire[..cut]).unwrap();
            // The server handles all peers before it waits for further bytes.
            raw::ping(&mut other);
            stream.get_mut().write_all(&wire[cut..]).unwrap();
            version.read_handshake(&mut stream);
            for frames in &messages {
                check_reply(&mut stream, frames, &mut model, Some(cuts));
            }
            cuts += 1;
        }
    }
    drop(server);
    check_recordings(&home, &model);
    println!("{cuts} connections");
}

#[test]
fn simultaneous_clients_lose_nothing() {
    const CLIENTS: u8 = 4;
    let (home, model, _) = random_maze((CLIENTS, 1), 0);
    let mut server = home.serve(&["maze.txt", "--port", "0", "--record", "r"]);
    let state = |client: u8, number: u32| {
        let number = number.to_le_bytes();
        [&[b'S', client, 0, b'N', b'C'][..], &number, b"F", &[1; 4]].concat()
    };
    let line = |client: u8, number: u32| format!("{client} {number:07}");
    let numbers = 0..500 * u32::try_from(force()).unwrap();
    thread::scope(|scope| {
        for client in 0..CLIENTS {
            let requests = numbers.clone().flat_map(|number| {
                let line = ["AL\x09\0", &line(client, number)].concat();
                [line.into(), state(client, number)]
            });
            let mut client = Client::new(&server.address, 30, requests.collect());
            let mut model = model.clone();
            scope.spawn(move || client.send_until(client.requests.len(), &mut model));
        }
    });
    server.kill();
    server.wait();
    let [(_, recording)] = &recordings(&home.path().join("r"))[..] else { panic!() };
    let (states, lines): (Vec<_>, _) = (recording.history().iter().collect(), recording.log());
    for client in 0..CLIENTS {
        let own = states.iter().filter(|state| state[1] == client);
        assert!(own.eq(&numbers.clone().map(|number| state(client, number)).collect::<Vec<_>>()));
        let own = lines
            .iter()
            .map(|line| &line.text)
            .filter(|text| text.starts_with(&client.to_string()));
        assert!(own.eq(&numbers.clone().map(|number| line(client, number)).collect::<Vec<_>>()));
    }
    assert_eq!(states.len(), numbers.len() * usize::from(CLIENTS));
    println!("{} states of {CLIENTS} simultaneous clients", states.len());
}
