//! Client-side recording of a search.

use std::path::Path;

use mmsim_client::{Transport, TransportError};
use mmsim_protocol::{Info, MazeSize, Reply, Request};
use mmsim_recording::{RecordError, RecordingWriter, UpdateEncoder, UpdateTracker};

use crate::args::RecordingArgs;

/// A transport that records each state that the simulator acknowledges with `ok`. A recording error
/// ends the recording, but does not stop the search.
pub(crate) struct RecordingTransport<T> {
    transport: T,
    recording: Option<ClientRecording>,
    error: Option<RecordError>,
}

struct ClientRecording {
    writer: RecordingWriter,
    size: MazeSize,
    updates: UpdateTracker,
    encoder: UpdateEncoder,
}

impl<T> RecordingTransport<T> {
    /// Creates the recording if `file` is given. `info` describes a maze of this size.
    pub(crate) fn new(
        transport: T,
        file: Option<&Path>,
        options: RecordingArgs,
        (info, size): (&Info, MazeSize),
    ) -> Result<Self, RecordError> {
        let create = |file| -> Result<_, RecordError> {
            // The client does not know the true maze.
            let writer = RecordingWriter::create(file, info, None)?;
            let writer = writer.with_messages(options.messages()).with_limit(options.limit());
            let (updates, encoder) = (UpdateTracker::default(), UpdateEncoder::new(size));
            Ok(ClientRecording { writer, size, updates, encoder })
        };
        Ok(Self { transport, recording: file.map(create).transpose()?, error: None })
    }

    /// Closes the recording, and returns its first error.
    pub(crate) fn close(self) -> Result<(), RecordError> {
        let closed = self.recording.map_or(Ok(()), |recording| recording.writer.close());
        self.error.map_or(closed, Err)
    }
}

impl<T: Transport> Transport for RecordingTransport<T> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        self.transport.exchange(request, reply)?;
        if self.error.is_none()
            && let Some(recording) = &mut self.recording
        {
            self.error = recording.add(request, reply).err();
        }
        Ok(())
    }
}

impl ClientRecording {
    fn add(&mut self, request: &[u8], reply: &[u8]) -> Result<(), RecordError> {
        match (Request::decode(request, self.size), Reply::decode(reply)) {
            (Ok(Request::Reset), Ok(Reply::Ok)) => self.updates.clear(),
            (Ok(Request::Walls(pose)), Ok(Reply::Walls(_))) => self.updates.read(pose),
            (Ok(Request::Annotations(annotations)), Ok(Reply::Ok)) => {
                // A simulator with a higher limit may accept annotations that are not recorded.
                let is_recorded = self.updates.annotate(annotations).is_ok();
                return if is_recorded { self.writer.write_annotations(request) } else { Ok(()) };
            }
            (Ok(Request::State(_)), Ok(Reply::Ok)) => {
                let update = self.encoder.encode(self.updates.update(), request);
                self.writer.write_with_update(update, request)?;
                self.updates.report();
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use mmsim_client::{InMemory, Named, search_run};
    use mmsim_maze::{KnownMaze, Maze};
    use mmsim_recording::Recording;
    use mmsim_server::Simulation;
    use mmsim_solvers::{FloodFill, Mouse};

    use super::*;

    #[test]
    fn the_recording_equals_the_history_of_the_simulator() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        // The mouse also reads the wall behind the start.
        let maze: Maze = "o---o---o\n|   | S |\no   o   o\n| G     |\no---o---o\n".parse().unwrap();
        let mut simulation = Simulation::new("small", maze.clone());
        let info = simulation.info();
        let transport = InMemory::new(|request, reply| simulation.handle(request, reply));
        let recording = RecordingTransport::new(
            transport,
            Some(&path),
            RecordingArgs::default(),
            (&info, maze.size()),
        );
        let recording = recording.unwrap();
        let mut transport = Named::new(recording, "Theseus", "flood-fill").unwrap();
        let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(&maze), maze.start());
        let observe = |_: &Mouse<_>, _: &_| ControlFlow::Continue(());
        search_run(&mut transport, &mut mouse, 1000, observe).unwrap();
        drop(transport);

        let recording = Recording::open(&path).unwrap();
        let history = simulation.history();
        assert!(history.len() > 1 && recording.history().iter().eq(history.iter()));
        for index in 0..history.len() {
            assert_eq!(recording.history().context(index), history.context(index));
        }
        let context = recording.history().newest_context();
        assert_eq!(context.notes().mouse(), Some("Theseus"));
        assert!(
            context
                .walls_read()
                .is_some_and(|read| { read.has(maze.start().cell, mmsim_maze::Heading::South) })
        );
    }
}
