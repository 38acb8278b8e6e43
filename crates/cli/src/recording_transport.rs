//! Client-side recording of a search.

use std::path::Path;

use mmsim_client::{Transport, TransportError};
use mmsim_protocol::{Info, Reply};
use mmsim_recording::{RecordError, RecordingWriter};

/// A transport that records each state that the simulator acknowledges with `ok`. A recording error
/// does not stop the search.
pub(crate) struct RecordingTransport<T> {
    transport: T,
    writer: Result<Option<RecordingWriter>, RecordError>,
}

impl<T> RecordingTransport<T> {
    /// Creates the recording if `file` is given.
    pub(crate) fn new(transport: T, file: Option<&Path>, info: &Info) -> Result<Self, RecordError> {
        // The client does not know the true maze.
        let writer = file.map(|file| RecordingWriter::create(file, info, None)).transpose()?;
        Ok(Self { transport, writer: Ok(writer) })
    }

    /// Closes the recording.
    pub(crate) fn close(self) -> Result<(), RecordError> {
        self.writer?.map_or(Ok(()), RecordingWriter::close)
    }
}

impl<T: Transport> Transport for RecordingTransport<T> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        self.transport.exchange(request, reply)?;
        if request.starts_with(b"S")
            && Reply::decode(reply) == Ok(Reply::Ok)
            && let Ok(Some(writer)) = &mut self.writer
            && let Err(error) = writer.write(request)
        {
            self.writer = Err(error);
        }
        Ok(())
    }
}
