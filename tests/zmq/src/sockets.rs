//! REQ and DEALER sockets over TCP, with the names of the crate `zmq`.
//!
//! That crate needs libzmq, whose sources do not compile with `MinGW`. On Windows, tests that only
//! need a client use these sockets instead. On other systems, they use libzmq.
#![forbid(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::fmt;
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

pub use SocketType::{DEALER, REQ};

/// Makes [`Socket::poll`] wait for a message to receive.
pub const POLLIN: i16 = 1;

/// The greeting of ZMTP 3.0 with the security mechanism NULL.
const GREETING: [u8; 64] = {
    let mut greeting = [0; 64];
    (greeting[0], greeting[9], greeting[10]) = (0xff, 0x7f, 3);
    let (mut at, name) = (0, b"NULL");
    while at < name.len() {
        greeting[12 + at] = name[at];
        at += 1;
    }
    greeting
};

/// The bits of the first byte of a frame.
const MORE: u8 = 1;
const LONG: u8 = 2;
const COMMAND: u8 = 4;

/// Creates sockets.
#[derive(Default)]
pub struct Context;

impl Context {
    /// Creates a context.
    pub const fn new() -> Self {
        Self
    }

    /// Creates a socket.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn socket(&self, kind: SocketType) -> Result<Socket> {
        Ok(Socket {
            kind,
            identity: RefCell::default(),
            link: RefCell::default(),
            received: RefCell::default(),
            timeout: Cell::new(Duration::MAX),
        })
    }
}

/// The kind of a socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SocketType {
    /// Sends a request and then receives its reply.
    REQ,
    /// Sends and receives in any order, including the empty frame before a request.
    DEALER,
}

/// A message of one or more frames.
type Message = Vec<Vec<u8>>;

/// A socket that connects to one server.
pub struct Socket {
    kind: SocketType,
    identity: RefCell<Vec<u8>>,
    link: RefCell<Option<(TcpStream, Receiver<Message>)>>,
    /// Messages that [`poll`](Self::poll) has found.
    received: RefCell<VecDeque<Message>>,
    timeout: Cell<Duration>,
}

impl Socket {
    /// Connects to a running server. If there is none, receives nothing.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn connect(&self, address: &str) -> Result<()> {
        *self.link.borrow_mut() = self.link_to(address.trim_start_matches("tcp://")).ok();
        Ok(())
    }

    fn link_to(&self, address: &str) -> io::Result<(TcpStream, Receiver<Message>)> {
        let mut stream = TcpStream::connect(address)?;
        let kind: &[u8] = if self.kind == REQ { b"REQ" } else { b"DEALER" };
        let mut ready = b"\x05READY".to_vec();
        for (name, value) in [("Socket-Type", kind), ("Identity", &self.identity.borrow())] {
            ready.extend(frame(0, name.as_bytes()).split_off(1));
            ready.extend([&[0, 0, 0], &frame(0, value)[1..]].concat());
        }
        stream.write_all(&[&GREETING[..], &frame(COMMAND, &ready)].concat())?;
        let (send, messages) = mpsc::channel();
        let mut input = stream.try_clone()?;
        thread::spawn(move || -> io::Result<()> {
            input.read_exact(&mut [0; 64])?;
            while let Ok(message) = read_message(&mut input) {
                if send.send(message).is_err() {
                    break;
                }
            }
            Ok(())
        });
        Ok((stream, messages))
    }

    /// Sets the identity that the socket sends when it connects.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn set_identity(&self, identity: &[u8]) -> Result<()> {
        *self.identity.borrow_mut() = identity.into();
        Ok(())
    }

    /// Does nothing, because closing a socket never waits.
    ///
    /// # Errors
    /// Never returns an error.
    pub const fn set_linger(&self, _milliseconds: i32) -> Result<()> {
        Ok(())
    }

    /// Does nothing, because servers receive all messages of the tests.
    ///
    /// # Errors
    /// Never returns an error.
    pub const fn set_sndtimeo(&self, _milliseconds: i32) -> Result<()> {
        Ok(())
    }

    /// Sets the maximum time to wait for a message.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn set_rcvtimeo(&self, milliseconds: i32) -> Result<()> {
        self.timeout.set(timeout(milliseconds.into()));
        Ok(())
    }

    /// Sends a message of one frame.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn send(&self, message: impl AsRef<[u8]>, flags: i32) -> Result<()> {
        self.send_multipart([message], flags)
    }

    /// Sends a message of one or more frames.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn send_multipart<F: AsRef<[u8]>>(
        &self,
        frames: impl IntoIterator<Item = F>,
        _flags: i32,
    ) -> Result<()> {
        let mut frames: Message = frames.into_iter().map(|frame| frame.as_ref().into()).collect();
        if self.kind == REQ {
            frames.insert(0, Vec::new());
        }
        let last = frames.len() - 1;
        let flags = |at| if at < last { MORE } else { 0 };
        let bytes = frames.iter().enumerate().map(|(at, body)| frame(flags(at), body));
        let mut link = self.link.borrow_mut();
        if let Some((stream, _)) = link.as_mut() {
            // A socket of libzmq keeps messages until the server comes back.
            let _ = stream.write_all(&bytes.collect::<Vec<_>>().concat());
        }
        Ok(())
    }

    /// Receives a message of one frame.
    ///
    /// # Errors
    /// Returns an error if no message arrives in time.
    pub fn recv_bytes(&self, flags: i32) -> Result<Vec<u8>> {
        Ok(self.recv_multipart(flags)?.swap_remove(0))
    }

    /// Receives all frames of a message.
    ///
    /// # Errors
    /// Returns an error if no message arrives in time.
    pub fn recv_multipart(&self, _flags: i32) -> Result<Message> {
        if !self.wait(self.timeout.get()) {
            return Err(Error::EAGAIN);
        }
        self.received.borrow_mut().pop_front().ok_or(Error::EAGAIN)
    }

    /// Waits for a message, and returns the number of sockets that have one.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn poll(&self, _events: i16, milliseconds: i64) -> Result<i32> {
        Ok(self.wait(timeout(milliseconds)).into())
    }

    /// Waits for a message. Returns false after a timeout.
    fn wait(&self, timeout: Duration) -> bool {
        let mut received = self.received.borrow_mut();
        let link = self.link.borrow();
        if !received.is_empty() {
            return true;
        }
        match link.as_ref().map(|(_, messages)| messages.recv_timeout(timeout)) {
            Some(Ok(mut message)) => {
                if self.kind == REQ {
                    message.remove(0);
                }
                received.push_back(message);
            }
            Some(Err(RecvTimeoutError::Timeout)) => {}
            // Like a socket of libzmq, which waits for the server to come back.
            Some(Err(RecvTimeoutError::Disconnected)) | None => thread::sleep(timeout),
        }
        !received.is_empty()
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        if let Some((stream, _)) = self.link.get_mut() {
            let _ = stream.shutdown(std::net::Shutdown::Both);
        }
    }
}

/// Returns a timeout, where a negative number means no timeout.
fn timeout(milliseconds: i64) -> Duration {
    u64::try_from(milliseconds).map_or(Duration::MAX, Duration::from_millis)
}

fn frame(flags: u8, body: &[u8]) -> Vec<u8> {
    match u8::try_from(body.len()) {
        Ok(length) => [&[flags, length], body].concat(),
        Err(_) => [&[flags | LONG], &(body.len() as u64).to_be_bytes()[..], body].concat(),
    }
}

/// Reads the next message. Skips commands.
fn read_message(input: &mut impl Read) -> io::Result<Message> {
    let mut frames = Message::new();
    loop {
        let mut head = [0; 9];
        input.read_exact(&mut head[..2])?;
        let mut length = u64::from(head[1]);
        if head[0] & LONG != 0 {
            input.read_exact(&mut head[2..])?;
            length = head[1..].iter().fold(0, |length, &byte| length << 8 | u64::from(byte));
        }
        let mut body = vec![0; usize::try_from(length).map_err(io::Error::other)?];
        input.read_exact(&mut body)?;
        if head[0] & COMMAND == 0 {
            frames.push(body);
            if head[0] & MORE == 0 {
                return Ok(frames);
            }
        }
    }
}

/// The result of an operation on a socket.
pub type Result<T> = std::result::Result<T, Error>;

/// An error with its name in `zmq`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// No message arrived in time.
    EAGAIN,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no message in time")
    }
}

impl std::error::Error for Error {}
