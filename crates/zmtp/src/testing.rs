//! Streams and services for tests.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::rc::Rc;

use crate::codec::decoder::Decoder;
use crate::codec::event::{Event, ProtocolError};
use crate::codec::handshake::{GREETING, REQ_READY};
use crate::service::{ClientId, Service};

/// An in-memory stream that never blocks. The test provides the input and checks the output.
#[derive(Clone, Default)]
pub(crate) struct Wire(Rc<RefCell<Ends>>);

#[derive(Default)]
struct Ends {
    incoming: VecDeque<u8>,
    outgoing: Vec<u8>,
    /// The number of bytes that can be written before a write returns [`ErrorKind::WouldBlock`].
    capacity: usize,
    is_closed: bool,
    /// The errors for the next reads and writes, one for each call.
    errors: VecDeque<ErrorKind>,
}

impl Wire {
    /// Creates a stream from which a handshake and then `incoming` can be read.
    pub(crate) fn new(incoming: &[u8]) -> Self {
        let wire = Self::silent();
        wire.push_handshake();
        wire.push(incoming);
        wire
    }

    /// Creates a stream from which no bytes can be read yet.
    pub(crate) fn silent() -> Self {
        let wire = Self::default();
        wire.set_capacity(usize::MAX);
        wire
    }

    pub(crate) fn push_handshake(&self) {
        self.push(&[&GREETING[..], REQ_READY].concat());
    }

    pub(crate) fn push(&self, incoming: &[u8]) {
        self.0.borrow_mut().incoming.extend(incoming);
    }

    pub(crate) fn close(&self) {
        self.0.borrow_mut().is_closed = true;
    }

    /// Makes the next reads and writes fail with these errors, one for each call.
    pub(crate) fn fail(&self, errors: impl IntoIterator<Item = ErrorKind>) {
        self.0.borrow_mut().errors.extend(errors);
    }

    pub(crate) fn set_capacity(&self, bytes: usize) {
        self.0.borrow_mut().capacity = bytes;
    }

    pub(crate) fn has_incoming(&self) -> bool {
        !self.0.borrow().incoming.is_empty()
    }

    /// Returns all bytes that have been written to the stream.
    pub(crate) fn sent(&self) -> Vec<u8> {
        self.0.borrow().outgoing.clone()
    }
}

impl Read for Wire {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut ends = self.0.borrow_mut();
        if let Some(error) = ends.errors.pop_front() {
            return Err(error.into());
        }
        if ends.incoming.is_empty() && !ends.is_closed {
            return Err(ErrorKind::WouldBlock.into());
        }
        ends.incoming.read(buffer)
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut ends = self.0.borrow_mut();
        match ends.errors.pop_front() {
            Some(ErrorKind::WriteZero) => return Ok(0),
            Some(error) => return Err(error.into()),
            None => {}
        }
        let count = bytes.len().min(ends.capacity);
        if count == 0 {
            return Err(ErrorKind::WouldBlock.into());
        }
        ends.capacity -= count;
        ends.outgoing.extend_from_slice(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A service that replies with the bytes of the request. The request `ping` does not count as
/// activity.
#[derive(Default)]
pub(crate) struct Echo {
    /// The number of calls to `after_round`.
    pub(crate) rounds: usize,
}

impl Service for Echo {
    fn answer(&mut self, _: ClientId, request: &[u8], _frames: usize, reply: &mut Vec<u8>) -> bool {
        reply.clear();
        reply.extend_from_slice(request);
        request != b"ping"
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = format!("error: {reason}").into();
    }

    fn after_round(&mut self) {
        self.rounds += 1;
    }
}

/// Decodes `input`. Returns the events as text. If decoding fails, the last element is the
/// error.
pub(crate) fn events(decoder: &mut Decoder, mut input: &[u8]) -> Vec<String> {
    let mut events = Vec::new();
    loop {
        match decoder.decode(input) {
            Ok((_, Event::Incomplete)) => return events,
            Ok((consumed, event)) => {
                assert!(consumed > 0, "{event:?}");
                events.push(format!("{event:?}"));
                input = &input[consumed..];
            }
            Err(error) => {
                events.push(error.to_string());
                return events;
            }
        }
    }
}
