//! One connection: what has come in and not been looked at, and what waits to go out.

use std::io::{self, ErrorKind, Read, Write};

use crate::ReplyBuffer;
use crate::limits::MAX_WAITING_REPLY_BYTES;
use crate::simulation::refuse;
use crate::zmtp::{self, Decoder, Step, Violation};

/// What is read at once, in bytes.
const READ_BYTES: usize = 4 * 1024;

/// Frames of one peer that are looked at before it is the next one's turn.
const TURN_FRAMES: usize = 64;

/// A peer of a server.
#[derive(Debug)]
pub(crate) struct Peer<S> {
    stream: S,
    decoder: Decoder,
    /// What has been received; the first `taken` bytes have been looked at.
    input: Vec<u8>,
    taken: usize,
    /// What waits to be sent; the first `sent` bytes are gone.
    output: Vec<u8>,
    sent: usize,
    /// Whether the stream may have bytes for us.
    pub(crate) readable: bool,
    /// Whether the stream may take bytes of us.
    pub(crate) writable: bool,
}

/// Why a connection ends.
#[derive(Debug, thiserror::Error)]
pub(crate) enum End {
    #[error("the peer has left")]
    Left,
    #[error("another peer takes its place")]
    Evicted,
    #[error("no handshake, or no request after a frame over the limit, in time")]
    Late,
    #[error(transparent)]
    Violation(#[from] Violation),
    #[error(transparent)]
    Stream(#[from] io::Error),
}

/// Whether a peer has something more to do without anything happening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// It waits for its stream.
    Idle,
    /// Others are to have their turn before it.
    Again,
}

impl<S: Read + Write> Peer<S> {
    /// A peer that has just connected, to be greeted in its first turn.
    pub(crate) fn new(stream: S) -> Self {
        Self {
            stream,
            decoder: Decoder::default(),
            input: Vec::new(),
            taken: 0,
            output: zmtp::SIGNATURE.to_vec(),
            sent: 0,
            readable: true,
            writable: true,
        }
    }

    pub(crate) const fn stream_mut(&mut self) -> &mut S {
        &mut self.stream
    }

    /// Whether the handshake is done, and no frame over the limit has come since the last request.
    pub(crate) fn is_ready(&self) -> bool {
        self.decoder.is_ready()
    }

    /// Whether something waits to be sent.
    pub(crate) const fn has_output(&self) -> bool {
        self.sent < self.output.len()
    }

    /// Receives, answers at most `in_a_row` requests, and sends the replies. `answer` gets a request,
    /// or the last frame of one, with the number of its frames.
    pub(crate) fn turn(
        &mut self,
        in_a_row: usize,
        mut answer: impl FnMut(&[u8], usize, &mut ReplyBuffer),
        reply: &mut ReplyBuffer,
    ) -> Result<Turn, End> {
        let turn = self.take_turn(in_a_row, &mut answer, reply);
        // What was right before something wrong is answered all the same.
        let sent = self.send();
        let turn = turn?;
        sent?;
        Ok(turn)
    }

    fn take_turn(
        &mut self,
        mut requests_left: usize,
        answer: &mut impl FnMut(&[u8], usize, &mut ReplyBuffer),
        reply: &mut ReplyBuffer,
    ) -> Result<Turn, End> {
        for _ in 0..TURN_FRAMES {
            if self.output.len() - self.sent >= MAX_WAITING_REPLY_BYTES {
                self.send()?;
                if !self.writable {
                    return Ok(Turn::Idle);
                }
            }
            let (taken, step) = self.decoder.step(&self.input[self.taken..])?;
            match step {
                Step::More => {
                    // A reply need not wait for what comes after its request.
                    self.send()?;
                    if !self.receive()? {
                        return Ok(Turn::Idle);
                    }
                }
                Step::Nothing | Step::Ready => {}
                Step::Say(bytes) => self.output.extend_from_slice(bytes),
                Step::Ping { context } => zmtp::push_pong(&mut self.output, context),
                Step::Request { last, frames } => {
                    answer(last, frames, reply);
                    self.push_reply(reply);
                    requests_left -= 1;
                }
                Step::LongRequest { last, frames } => {
                    answer(&last, frames, reply);
                    self.push_reply(reply);
                    requests_left -= 1;
                }
                Step::TooLong(violation) => {
                    refuse(reply, violation);
                    self.push_reply(reply);
                }
            }
            self.taken += taken;
            if requests_left == 0 {
                self.send()?;
                let has_input = self.taken < self.input.len() || self.receive()?;
                return Ok(if has_input { Turn::Again } else { Turn::Idle });
            }
        }
        Ok(Turn::Again)
    }

    fn push_reply(&mut self, reply: &[u8]) {
        self.output.extend_from_slice(self.decoder.envelope());
        zmtp::push_last_frame(&mut self.output, reply);
    }

    /// Receives what there is; `false` if that is nothing at present.
    fn receive(&mut self) -> Result<bool, End> {
        if !self.readable {
            return Ok(false);
        }
        self.input.drain(..self.taken);
        self.taken = 0;
        let begun = self.input.len();
        self.input.resize(begun + READ_BYTES, 0);
        let result = loop {
            match self.stream.read(&mut self.input[begun..]) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                result => break result,
            }
        };
        self.input.truncate(begun + result.as_ref().map_or(0, |&count| count));
        match result {
            Ok(0) => Err(End::Left),
            Ok(_) => Ok(true),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                self.readable = false;
                // Who waits needs no memory beyond that of a usual request.
                self.input.shrink_to(READ_BYTES);
                Ok(false)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Sends what the stream takes at present.
    pub(crate) fn send(&mut self) -> Result<(), End> {
        while self.writable && self.has_output() {
            match self.stream.write(&self.output[self.sent..]) {
                Ok(0) => return Err(End::Left),
                Ok(count) => self.sent += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => self.writable = false,
                Err(error) => return Err(error.into()),
            }
        }
        if !self.has_output() {
            self.output.clear();
            self.output.shrink_to(READ_BYTES);
            self.sent = 0;
        } else if self.sent >= READ_BYTES {
            self.output.drain(..self.sent);
            self.sent = 0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;
    use crate::limits::MAX_REQUEST_BYTES;

    const REQ: &[u8] = b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\x03REQ";

    /// A stream in memory, of which the other end is this test.
    #[derive(Default)]
    struct Wire {
        incoming: VecDeque<u8>,
        outgoing: Vec<u8>,
        /// How much it takes before it would block.
        room: usize,
        closed: bool,
    }

    impl Read for Wire {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            if self.incoming.is_empty() && !self.closed {
                return Err(ErrorKind::WouldBlock.into());
            }
            self.incoming.read(buffer)
        }
    }

    impl Write for Wire {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let count = bytes.len().min(self.room);
            if count == 0 {
                return Err(ErrorKind::WouldBlock.into());
            }
            self.room -= count;
            self.outgoing.extend_from_slice(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// A peer that has said this after its handshake.
    fn peer(said: &[u8]) -> Peer<Wire> {
        let incoming = [&zmtp::GREETING[..], REQ, said].concat().into();
        Peer::new(Wire { incoming, room: usize::MAX, ..Wire::default() })
    }

    fn echo(request: &[u8], _frames: usize, reply: &mut ReplyBuffer) {
        reply.clear();
        reply.extend_from_slice(request);
    }

    /// Turns until the peer waits for its stream.
    fn until_idle(peer: &mut Peer<Wire>) -> Result<(), End> {
        while peer.turn(8, echo, &mut Vec::new())? == Turn::Again {}
        Ok(())
    }

    fn replies(peer: &Peer<Wire>) -> &[u8] {
        let hello = [&zmtp::GREETING[..], zmtp::READY].concat();
        peer.stream.outgoing.strip_prefix(&hello[..]).unwrap()
    }

    #[test]
    fn requests_are_answered_in_order_a_few_in_a_turn() {
        let said = |from: u8, to: u8| (from..to).flat_map(|n| [1, 0, 0, 1, n]).collect::<Vec<_>>();
        let mut peer = peer(&said(0, 100));
        assert_eq!(peer.turn(8, echo, &mut Vec::new()).unwrap(), Turn::Again);
        assert_eq!(replies(&peer), said(0, 8));
        until_idle(&mut peer).unwrap();
        assert_eq!(replies(&peer), said(0, 100));
        assert!(peer.is_ready() && !peer.has_output() && !peer.readable);
        peer.stream.incoming.extend(said(100, 101));
        until_idle(&mut peer).unwrap();
        assert_eq!(replies(&peer), said(0, 100), "nothing says that it is readable");
        peer.readable = true;
        until_idle(&mut peer).unwrap();
        assert_eq!(replies(&peer), said(0, 101));
    }

    #[test]
    fn who_does_not_read_is_not_read() {
        let request = [&b"\x01\0\x02\0\0\0\0\0\0\x04\0"[..], &[7; 1024]].concat();
        let mut peer = peer(&request.repeat(1000));
        peer.stream.room = 200;
        until_idle(&mut peer).unwrap();
        assert!(!peer.stream.incoming.is_empty() && !peer.writable);
        assert!(peer.output.len() < MAX_WAITING_REPLY_BYTES + 2 * request.len());
        // Nothing is lost: once it reads, it gets them all.
        while !peer.writable {
            (peer.stream.room, peer.writable) = (5000, true);
            until_idle(&mut peer).unwrap();
        }
        assert_eq!(replies(&peer), request.repeat(1000));
    }

    #[test]
    fn memory_is_bounded_and_given_back() {
        let frame = [&b"\x01\0\x02\0\0\0\0\0\x01\0\0"[..], &vec![7; MAX_REQUEST_BYTES]].concat();
        let mut peer = peer(&frame[..frame.len() - 1]);
        until_idle(&mut peer).unwrap();
        assert!(peer.input.capacity() <= 4 * READ_BYTES, "no frame as long as that is right");
        peer.stream.incoming.push_back(7);
        peer.readable = true;
        until_idle(&mut peer).unwrap();
        assert_eq!(replies(&peer).len(), frame.len());
        assert!(peer.input.capacity() <= READ_BYTES && peer.output.capacity() <= READ_BYTES);
    }

    #[test]
    fn what_is_right_before_something_wrong_is_answered() {
        let mut peer = peer(b"\x01\0\0\x01a\xff");
        assert!(matches!(until_idle(&mut peer), Err(End::Violation(Violation::Flags(0xff)))));
        assert_eq!(replies(&peer), b"\x01\0\0\x01a");
    }

    #[test]
    fn who_leaves_is_noticed() {
        let mut peer = peer(b"\x01\0\0\x01a");
        peer.stream.closed = true;
        assert!(matches!(until_idle(&mut peer), Err(End::Left)));
        assert_eq!(replies(&peer), b"\x01\0\0\x01a");
    }
}
