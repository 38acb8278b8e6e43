//! What strangers send. Each attack returns how far it got.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_zmtp::codec::{GREETING, READY, REQ_READY};
use socket2::SockRef;

use crate::Target;

type Attack = fn(&mut Target) -> String;

pub const ATTACKS: [(&str, Attack); 4] = [
    ("a frame that claims 2^62 bytes: 102 bytes", huge_frame),
    ("8 KB of requests and PINGs, then a reset: 1,000 times", requests_and_reset),
    ("3,000 malformed streams", malformed_streams),
    ("50 clients that never read, for 10 s", clients_that_never_read),
];

/// Opens a connection and sends the handshake of a REQ socket.
fn greet(target: &Target) -> Option<TcpStream> {
    let mut stream = TcpStream::connect(target.address).ok()?;
    stream.set_read_timeout(Some(Duration::from_millis(500))).ok()?;
    stream.write_all(&[&GREETING[..], REQ_READY].concat()).ok()?;
    Some(stream)
}

/// Waits for the handshake of the server, which may have a longer READY command than ours.
fn read_handshake(stream: &mut TcpStream) -> Option<()> {
    stream.read_exact(&mut [0; GREETING.len() + READY.len()]).ok()
}

fn huge_frame(target: &mut Target) -> String {
    if let Some(mut stream) = greet(target) {
        let _ = read_handshake(&mut stream);
        let _ = stream.write_all(b"\x01\0\x02\x40\0\0\0\0\0\0\0");
        thread::sleep(Duration::from_millis(500));
    }
    "after 1 connection".into()
}

/// Fills the receive queue with requests, sends PINGs, and resets the connection.
fn requests_and_reset(target: &mut Target) -> String {
    let burst = [b"\x01\0\0\0".repeat(1900), b"\x04\x07\x04PING\0\0".repeat(50)].concat();
    let mut count = 0;
    while count < 1000 && target.is_running() {
        count += 1;
        if let Some(mut stream) = greet(target) {
            let _ = read_handshake(&mut stream);
            let _ = stream.write_all(&burst);
            // A connection without linger is reset when it is closed.
            let _ = SockRef::from(&stream).set_linger(Some(Duration::ZERO));
        }
    }
    format!("after {count} connections")
}

/// Sends valid handshakes and then frames with random flags, lengths and bodies.
fn malformed_streams(target: &mut Target) -> String {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut count = 0;
    while count < 3000 && target.is_running() {
        count += 1;
        let Some(mut stream) = greet(target) else { continue };
        let mut bytes = Vec::new();
        for _ in 0..=random.below(8) {
            match random.below(6) {
                0 => bytes.extend(b"\x01\0\0\x04good"),
                1 => {
                    let length = random.next() >> random.below(64);
                    bytes.push(2 | random.byte() & 7);
                    bytes.extend(length.to_be_bytes());
                }
                2 => bytes.extend([4, random.byte(), random.byte() & 7]),
                _ => bytes.extend([random.byte() & 7, random.byte() & 31]),
            }
            bytes.extend((0..random.below(40)).map(|_| random.byte()));
        }
        let _ = stream.write_all(&bytes);
        if random.below(2) == 0 {
            let _ = SockRef::from(&stream).set_linger(Some(Duration::ZERO));
        }
    }
    format!("after {count} connections")
}

/// Compares the rates of the replies to a good client before and while others send requests and read
/// nothing.
fn clients_that_never_read(target: &mut Target) -> String {
    let alone = replies_per_second(target, Duration::from_secs(5));
    let is_over = AtomicBool::new(false);
    let streams: Vec<_> = (0..50).filter_map(|_| greet(target)).collect();
    let among_others = thread::scope(|scope| {
        scope.spawn(|| {
            let requests = b"\x01\0\0\x04more".repeat(1000);
            for stream in &streams {
                let _ = stream.set_nonblocking(true);
            }
            while !is_over.load(Ordering::Relaxed) {
                // A stream is full, or the server has closed it.
                for mut stream in &streams {
                    let _ = stream.write(&requests);
                }
                thread::sleep(Duration::from_millis(1));
            }
        });
        let rate = replies_per_second(target, Duration::from_secs(10));
        is_over.store(true, Ordering::Relaxed);
        rate
    });
    format!("{among_others:.0} instead of {alone:.0} replies per second to another client")
}

/// Returns the rate at which a client that waits for each reply gets replies.
fn replies_per_second(target: &mut Target, time: Duration) -> f64 {
    let (end, mut replies) = (Instant::now() + time, 0_u32);
    let Ok(mut client) = target.client() else { return 0.0 };
    let mut reply = Vec::new();
    client.send(&[b"good"]);
    while Instant::now() < end && target.is_running() {
        match client.receive(&mut reply, Duration::from_millis(100)) {
            Ok(None) => continue,
            Ok(Some(_)) => replies += 1,
            Err(_) => {}
        }
        client.send(&[b"good"]);
    }
    f64::from(replies) / time.as_secs_f64()
}

/// A generator of random numbers (xorshift64), so that every server gets the same bytes.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn byte(&mut self) -> u8 {
        self.next().to_be_bytes()[0]
    }
}
