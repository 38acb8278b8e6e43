//! REQ and DEALER sockets over TCP.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::fmt;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use mmsim_zmtp::codec::{Event, GREETING, REQ_READY, ReplyDecoder, push_request};

pub use SocketType::{DEALER, REQ};

/// Makes [`Socket::poll`] wait for a message to receive.
pub const POLLIN: i16 = 1;

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
        let (link, received) = (RefCell::default(), RefCell::default());
        Ok(Socket { kind, link, received, timeout: Cell::new(Duration::MAX) })
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
    link: RefCell<Option<(TcpStream, Receiver<Vec<u8>>)>>,
    /// Replies that [`poll`](Self::poll) has found.
    received: RefCell<VecDeque<Vec<u8>>>,
    timeout: Cell<Duration>,
}

impl Socket {
    /// Connects to a running server. If there is none, receives nothing.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn connect(&self, address: &str) -> Result<()> {
        *self.link.borrow_mut() = open(address.trim_start_matches("tcp://")).ok();
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

    /// Sends a message of one or more frames. The first frame of a DEALER socket is empty.
    ///
    /// # Errors
    /// Never returns an error.
    pub fn send_multipart<F: AsRef<[u8]>>(
        &self,
        frames: impl IntoIterator<Item = F>,
        _flags: i32,
    ) -> Result<()> {
        let frames: Vec<F> = frames.into_iter().collect();
        let body = frames.iter().skip((self.kind == DEALER).into()).map(AsRef::as_ref);
        let mut bytes = Vec::new();
        push_request(&mut bytes, &body.collect::<Vec<_>>());
        if let Some((stream, _)) = self.link.borrow_mut().as_mut() {
            // A socket of libzmq keeps messages until the server comes back.
            let _ = stream.write_all(&bytes);
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
        let reply = self.received.borrow_mut().pop_front().ok_or(Error::EAGAIN)?;
        Ok(if self.kind == DEALER { vec![Vec::new(), reply] } else { vec![reply] })
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
        if received.is_empty() {
            let link = self.link.borrow();
            match link.as_ref().map(|(_, replies)| replies.recv_timeout(timeout)) {
                Some(Ok(reply)) => received.push_back(reply),
                Some(Err(RecvTimeoutError::Timeout)) => {}
                // Like a socket of libzmq, which waits for the server to come back.
                Some(Err(RecvTimeoutError::Disconnected)) | None => thread::sleep(timeout),
            }
        }
        !received.is_empty()
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        if let Some((stream, _)) = self.link.get_mut() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

/// Connects to a server, and reads its replies on another thread.
fn open(address: &str) -> io::Result<(TcpStream, Receiver<Vec<u8>>)> {
    let mut stream = TcpStream::connect(address)?;
    stream.write_all(&[&GREETING[..], REQ_READY].concat())?;
    let (sender, replies) = mpsc::channel();
    let mut incoming = stream.try_clone()?;
    thread::spawn(move || {
        let (mut decoder, mut input, mut buffer) = (ReplyDecoder::default(), Vec::new(), [0; 4096]);
        while let Ok(count @ 1..) = incoming.read(&mut buffer) {
            input.extend_from_slice(&buffer[..count]);
            while let Ok((consumed @ 1.., event)) = decoder.decode(&input) {
                if let Event::Message { last, .. } = event
                    && sender.send(last.into_owned()).is_err()
                {
                    return;
                }
                input.drain(..consumed);
            }
        }
    });
    Ok((stream, replies))
}

/// Returns a timeout, where a negative number means no timeout.
fn timeout(milliseconds: i64) -> Duration {
    u64::try_from(milliseconds).map_or(Duration::MAX, Duration::from_millis)
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
