//! A non-blocking stream with an input and an output buffer.

use std::io::{ErrorKind, Read, Write};

use crate::connection::DisconnectReason;

/// The maximum number of bytes in one read from a stream.
pub(crate) const READ_BYTES: usize = 4 * 1024;

/// A non-blocking stream and its buffers.
#[derive(Debug)]
pub(crate) struct BufferedStream<S> {
    pub(crate) stream: S,
    /// Received bytes, of which the first `consumed` have been decoded.
    pub(crate) input: Vec<u8>,
    pub(crate) consumed: usize,
    /// Bytes to send.
    pub(crate) output: Vec<u8>,
    /// True if the stream may have bytes to read.
    pub(crate) is_readable: bool,
    /// True if the stream may accept more bytes.
    pub(crate) is_writable: bool,
}

impl<S: Read + Write> BufferedStream<S> {
    /// Creates the buffers for a newly connected stream. The first bytes to send are `output`.
    pub(crate) fn new(stream: S, output: &[u8]) -> Self {
        Self {
            stream,
            input: Vec::new(),
            consumed: 0,
            output: output.to_vec(),
            is_readable: true,
            is_writable: true,
        }
    }

    /// Records that the stream may be readable or writable again.
    pub(crate) const fn set_ready(&mut self, is_readable: bool, is_writable: bool) {
        self.is_readable |= is_readable;
        self.is_writable |= is_writable;
    }

    /// Returns true if received bytes have not been decoded yet.
    pub(crate) const fn has_input(&self) -> bool {
        self.consumed < self.input.len()
    }

    /// Returns true if bytes are waiting to be sent.
    pub(crate) const fn has_output(&self) -> bool {
        !self.output.is_empty()
    }

    /// Reads available bytes from the stream. Returns false if the stream has no bytes to read.
    pub(crate) fn receive(&mut self) -> Result<bool, DisconnectReason> {
        if !self.is_readable {
            return Ok(false);
        }
        self.input.drain(..self.consumed);
        self.consumed = 0;
        let start = self.input.len();
        self.input.resize(start + READ_BYTES, 0);
        let result = self.stream.read(&mut self.input[start..]);
        self.input.truncate(start + result.as_ref().map_or(0, |&count| count));
        match result {
            Ok(0) => Err(DisconnectReason::Closed),
            Ok(_) => Ok(true),
            Err(error) if error.kind() == ErrorKind::Interrupted => Ok(true),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                self.is_readable = false;
                // An idle connection needs only a small buffer.
                self.input.shrink_to(READ_BYTES);
                Ok(false)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Sends as much output as the stream accepts now.
    pub(crate) fn send(&mut self) -> Result<(), DisconnectReason> {
        while self.is_writable && self.has_output() {
            match self.stream.write(&self.output) {
                Ok(0) => return Err(DisconnectReason::Closed),
                Ok(count) => drop(self.output.drain(..count)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => self.is_writable = false,
                Err(error) => return Err(error.into()),
            }
        }
        if !self.has_output() {
            self.output.shrink_to(READ_BYTES);
        }
        Ok(())
    }
}
