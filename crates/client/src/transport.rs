//! How requests get to a simulator.

use std::time::Duration;

/// A way to ask a simulator: a request goes out, one reply comes back.
pub trait Transport {
    /// Sends `request` and puts the reply into `reply`, which is emptied first.
    ///
    /// # Errors
    /// No reply came.
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError>;
}

impl<T: Transport> Transport for &mut T {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        (**self).exchange(request, reply)
    }
}

/// Why there is no reply.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// The simulator did not answer in time.
    #[error("expected a reply from {endpoint}, found none within {} s", after.as_secs_f64())]
    NoReply {
        /// Where the simulator should be.
        endpoint: String,
        /// How long we waited.
        after: Duration,
    },
    /// The endpoint is not one of ZeroMQ's, or the socket failed.
    #[error("cannot reach {endpoint}: {reason}")]
    Failed {
        /// Where the simulator should be.
        endpoint: String,
        /// What the transport says.
        reason: String,
    },
}

/// A simulator in the same process: a function from a request to the reply it puts in the buffer.
/// What the function returns is not looked at.
pub struct InMemory<F> {
    answer: F,
}

impl<F: FnMut(&[u8], &mut Vec<u8>) -> R, R> InMemory<F> {
    /// A transport to the simulator that `answer` is.
    pub const fn new(answer: F) -> Self {
        Self { answer }
    }
}

impl<F: FnMut(&[u8], &mut Vec<u8>) -> R, R> Transport for InMemory<F> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        reply.clear();
        (self.answer)(request, reply);
        Ok(())
    }
}
