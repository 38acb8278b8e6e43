//! Client-side recording of a search.

use std::io;
use std::path::Path;

use mmsim_client::{Transport, TransportError};
use mmsim_protocol::{Info, MazeSize, Reply, Request};
use mmsim_recording::{ReadingTracker, RecordError, RecordingWriter, Update, UpdateEncoder};

/// A transport that records each state that the simulator acknowledges with `ok`. A recording error
/// does not stop the search.
pub(crate) struct RecordingTransport<T> {
    transport: T,
    recording: Result<Option<ClientRecording>, RecordError>,
}

struct ClientRecording {
    writer: RecordingWriter,
    size: MazeSize,
    readings: ReadingTracker,
    updates: UpdateEncoder,
}

impl<T> RecordingTransport<T> {
    /// Creates the recording if `file` is given.
    pub(crate) fn new(transport: T, file: Option<&Path>, info: &Info) -> Result<Self, RecordError> {
        let recording = file.map(|file| ClientRecording::create(file, info)).transpose()?;
        Ok(Self { transport, recording: Ok(recording) })
    }

    /// Closes the recording.
    pub(crate) fn close(self) -> Result<(), RecordError> {
        self.recording?.map_or(Ok(()), |recording| recording.writer.close())
    }
}

impl<T: Transport> Transport for RecordingTransport<T> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        self.transport.exchange(request, reply)?;
        if let Ok(Some(recording)) = &mut self.recording
            && let Err(error) = recording.add(request, reply)
        {
            self.recording = Err(error);
        }
        Ok(())
    }
}

impl ClientRecording {
    fn create(file: &Path, info: &Info) -> Result<Self, RecordError> {
        let invalid = || RecordError {
            path: file.into(),
            source: io::Error::other("the size of the maze is invalid"),
        };
        let size = info.size().ok_or_else(invalid)?;
        // The client does not know the true maze.
        let writer = RecordingWriter::create(file, info, None)?;
        let (readings, updates) = (ReadingTracker::default(), UpdateEncoder::new(size));
        Ok(Self { writer, size, readings, updates })
    }

    fn add(&mut self, request: &[u8], reply: &[u8]) -> Result<(), RecordError> {
        match (Request::decode(request, self.size), Reply::decode(reply)) {
            (Ok(Request::Reset), Ok(Reply::Ok)) => self.readings.clear(),
            (Ok(Request::Walls(pose)), Ok(Reply::Walls(_))) => self.readings.read(pose),
            (Ok(Request::State(_)), Ok(Reply::Ok)) => {
                let update = Update { readings: self.readings.readings() };
                self.writer.write_after(self.updates.encode(update, request), request)?;
                self.readings.report();
            }
            _ => {}
        }
        Ok(())
    }
}
