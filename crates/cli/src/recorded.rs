//! Records on the client's side: the states that a simulator has acknowledged.

use std::path::Path;

use mmsim_client::{Transport, TransportError};
use mmsim_protocol::{Info, Reply};
use mmsim_recording::{RecordError, RecordingWriter};

/// A transport that records each state which gets its `ok`. If that fails, the search goes on.
pub(crate) struct Recorded<T> {
    transport: T,
    writer: Option<RecordingWriter>,
    failed: Option<RecordError>,
}

impl<T> Recorded<T> {
    /// Records into this file, if there is one.
    pub(crate) fn new(transport: T, file: Option<&Path>, info: &Info) -> Result<Self, RecordError> {
        // The true maze is the simulator's secret.
        let writer = file.map(|file| RecordingWriter::create(file, info, None)).transpose()?;
        Ok(Self { transport, writer, failed: None })
    }

    /// Closes the recording.
    pub(crate) fn close(self) -> Result<(), RecordError> {
        self.failed.map_or(Ok(()), Err)?;
        self.writer.map_or(Ok(()), RecordingWriter::close)
    }
}

impl<T: Transport> Transport for Recorded<T> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        self.transport.exchange(request, reply)?;
        if request.starts_with(b"S")
            && Reply::decode(reply) == Ok(Reply::Ok)
            && self.failed.is_none()
            && let Some(writer) = &mut self.writer
        {
            self.failed = writer.write(request).err();
        }
        Ok(())
    }
}
