//! Transports for requests to a simulator.

use std::time::Duration;

use mmsim_protocol::{Annotation, AnnotationError, AnnotationWriter};

/// A connection to a simulator. Each request gets one reply.
pub trait Transport {
    /// Sends `request` and replaces the contents of `reply` with the reply.
    ///
    /// # Errors
    /// Returns an error if there is no reply.
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError>;
}

impl<T: Transport + ?Sized> Transport for &mut T {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        (**self).exchange(request, reply)
    }
}

/// The reason why a request received no reply.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TransportError {
    /// The simulator did not reply in time.
    #[error("no reply from {endpoint} within {} s", after.as_secs_f64())]
    NoReply {
        /// The endpoint of the simulator.
        endpoint: String,
        /// The timeout.
        after: Duration,
    },
    /// The reply has several frames.
    #[error("expected a reply of one frame from {endpoint}, found {found}")]
    Frames {
        /// The endpoint of the simulator.
        endpoint: String,
        /// The number of frames.
        found: usize,
    },
    /// The connection ended before the reply arrived, or the simulator does not use the protocol of
    /// ZeroMQ. The simulator may have received the request.
    #[error("no reply from {endpoint}: {reason}")]
    Disconnected {
        /// The endpoint of the simulator.
        endpoint: String,
        /// The reason why the connection ended.
        reason: String,
    },
    /// The endpoint is invalid, or no socket can be opened.
    #[error("cannot reach {endpoint}: {reason}")]
    Failed {
        /// The endpoint of the simulator.
        endpoint: String,
        /// The transport's error message.
        reason: String,
    },
}

/// A simulator in the same process: a function that handles a request and writes the reply to a
/// buffer. The function's return value is ignored.
pub struct InMemory<F> {
    handle: F,
}

impl<F: FnMut(&[u8], &mut Vec<u8>) -> R, R> InMemory<F> {
    /// Creates a transport that passes requests to `handle`.
    pub const fn new(handle: F) -> Self {
        Self { handle }
    }
}

impl<F: FnMut(&[u8], &mut Vec<u8>) -> R, R> Transport for InMemory<F> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        reply.clear();
        (self.handle)(request, reply);
        Ok(())
    }
}

/// The name of the bundled mice, each of which runs a bundled strategy.
pub const BUNDLED_MOUSE_NAME: &str = "mmsim";

/// A transport that names the mouse and its strategy after each `reset`, so that viewers and
/// recordings show the names. Requires a simulator that accepts
/// [annotations](mmsim_protocol::Annotations).
///
/// ```
/// use mmsim_client::{Exchange, InMemory, Named};
/// let mut requests = Vec::new();
/// let transport = InMemory::new(|request, reply| {
///     requests.push(request.to_vec());
///     reply.extend_from_slice(b"ok");
/// });
/// Exchange::new(Named::new(transport, "Theseus", "flood-fill")?).reset()?;
/// assert_eq!(requests, [&b"reset"[..], b"AM\x07TheseusS\x0aflood-fill"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Named<T> {
    transport: T,
    names: Vec<u8>,
}

impl<T> Named<T> {
    /// Adds the names to a transport.
    ///
    /// # Errors
    /// Returns an error if a name is too long or contains characters that are not printable.
    pub fn new(transport: T, mouse: &str, strategy: &str) -> Result<Self, AnnotationError> {
        let mut buffer = [0; 256];
        let mut writer = AnnotationWriter::new(&mut buffer);
        writer.push(Annotation::Mouse(mouse))?;
        writer.push(Annotation::Strategy(strategy))?;
        let names = writer.finish().unwrap_or_default().to_vec();
        Ok(Self { transport, names })
    }
}

impl<T: Transport> Transport for Named<T> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        self.transport.exchange(request, reply)?;
        if request == b"reset" && reply == b"ok" {
            // A simulator that refuses the names does not stop the search.
            self.transport.exchange(&self.names, &mut Vec::new())?;
        }
        Ok(())
    }
}
