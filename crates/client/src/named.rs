//! Names the mouse and its strategy.

use mmsim_protocol::{Annotation, AnnotationError, AnnotationWriter};

use crate::transport::{Transport, TransportError};

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
