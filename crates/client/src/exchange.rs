//! Single requests to a simulator and their replies.

use mmsim_maze::{Cell, Escaped, KnownMaze, Pose, WallsAround};
use mmsim_protocol::{
    Annotation, AnnotationError, AnnotationWriter, CRASH_PREFIX, Excerpt, Info,
    MAX_ANNOTATIONS_BYTES, MapState, Order, Reply, Request,
};

use crate::run::RunError;
use crate::transport::Transport;

/// Sends requests, counts them, and decodes their replies. Clients with their own search loop can
/// use `Exchange` instead of [`search_run`].
///
/// ```
/// use mmsim_client::{Exchange, InMemory};
/// use mmsim_maze::{KnownMaze, Maze};
/// use mmsim_server::Simulation;
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let (start, mut map) = (maze.start(), KnownMaze::unexplored(&maze));
/// let mut simulation = Simulation::new("small", maze);
/// let mut simulator =
///     Exchange::new(InMemory::new(|request, reply| simulation.handle(request, reply)));
/// simulator.reset()?;
/// map.observe(start, simulator.walls(start)?)?;
/// simulator.state(start, &map, |_| 0)?;
/// assert_eq!(simulator.requests(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// [`search_run`]: crate::search_run
pub struct Exchange<T> {
    transport: T,
    requests: u32,
    request: [u8; MAX_ANNOTATIONS_BYTES],
    reply: Vec<u8>,
}

impl<T: Transport> Exchange<T> {
    /// Creates an exchange over this transport.
    pub const fn new(transport: T) -> Self {
        Self { transport, requests: 0, request: [0; MAX_ANNOTATIONS_BYTES], reply: Vec::new() }
    }

    /// Returns the number of requests that were sent.
    pub const fn requests(&self) -> u32 {
        self.requests
    }

    /// Deletes all states in the simulator to begin a new search.
    ///
    /// # Errors
    /// Returns an error if the simulator does not reply or refuses the request.
    pub fn reset(&mut self) -> Result<(), RunError> {
        self.ask("reset", |buffer| Request::Reset.encode(buffer), is_ok)
    }

    /// Requests the walls around a mouse in the given pose.
    ///
    /// # Errors
    /// Returns an error if the simulator does not reply or refuses the request, for example because
    /// the cell is outside the maze.
    pub fn walls(&mut self, pose: Pose) -> Result<WallsAround, RunError> {
        self.ask(
            "W",
            |buffer| Request::Walls(pose).encode(buffer),
            |reply| match reply {
                Reply::Walls(around) => Some(around),
                _ => None,
            },
        )
    }

    /// Requests the walls around a mouse that has moved to the given pose. Returns `None` if a wall has
    /// blocked it, which a simulator that lets mice misread walls reports.
    ///
    /// # Errors
    /// Returns the same errors as [`walls`](Self::walls).
    pub fn walls_unless_blocked(&mut self, pose: Pose) -> Result<Option<WallsAround>, RunError> {
        match self.walls(pose) {
            Err(RunError::Refused { reason, .. }) if reason.starts_with(CRASH_PREFIX) => Ok(None),
            walls => walls.map(Some),
        }
    }

    /// Sends the pose of the mouse, the known walls, and a weight for each cell.
    ///
    /// # Errors
    /// Returns an error if the simulator does not reply or refuses the request, for example because
    /// its maze and `map` differ in size.
    pub fn state(
        &mut self,
        pose: Pose,
        map: &KnownMaze,
        weight: impl Fn(Cell) -> u16,
    ) -> Result<(), RunError> {
        self.ask("S", |buffer| MapState::new(pose, map, weight, Order::F).encode(buffer), is_ok)
    }

    /// Sends annotations, which belong to the next state, in as many requests as needed. Requires a
    /// simulator that supports them ([`Info::has_annotations`]).
    ///
    /// # Errors
    /// Returns an error if an annotation is invalid, or if the simulator does not reply or refuses
    /// a request. The annotations of earlier requests remain.
    pub fn annotate<'a>(
        &mut self,
        annotations: impl IntoIterator<Item = Annotation<'a>>,
    ) -> Result<(), RunError> {
        let mut rest = annotations.into_iter().peekable();
        while rest.peek().is_some() {
            let encode = |buffer: &mut [u8]| {
                let mut writer = AnnotationWriter::new(buffer);
                while let Some(&annotation) = rest.peek() {
                    match writer.push(annotation) {
                        Ok(()) => rest.next(),
                        Err(AnnotationError::BufferTooSmall(_)) => break,
                        Err(AnnotationError::Invalid(error)) => return Err(error.into()),
                    };
                }
                Ok::<_, RunError>(writer.finish().unwrap_or_default().len())
            };
            self.ask("A", encode, is_ok)?;
        }
        Ok(())
    }

    /// Requests a description of the maze. Only mmsim replies to this request; the reference
    /// simulator never replies.
    ///
    /// # Errors
    /// Returns an error if the simulator does not reply or sends an unexpected reply.
    pub fn info(&mut self) -> Result<Info, RunError> {
        let json = self.ask(
            "info",
            |buffer| Request::Info.encode(buffer),
            |reply| match reply {
                Reply::Info(json) => Some(String::from(json)),
                _ => None,
            },
        )?;
        Ok(serde_json::from_str(&json)?)
    }

    fn ask<R, E>(
        &mut self,
        request: &'static str,
        encode: impl FnOnce(&mut [u8]) -> Result<usize, E>,
        expected: impl FnOnce(Reply<'_>) -> Option<R>,
    ) -> Result<R, RunError>
    where
        RunError: From<E>,
    {
        let length = encode(&mut self.request)?;
        self.requests += 1;
        self.transport.exchange(&self.request[..length], &mut self.reply)?;
        decode_reply(request, &self.reply, expected)
    }
}

/// The maximum number of characters of a simulator's reason that an error shows.
const MAX_REASON_CHARS: usize = 500;

/// Decodes the reply to the request with this name. `expected` returns the contents of the expected
/// kind of reply, and `None` for any other kind.
///
/// # Errors
/// Returns an error if the simulator refuses the request or sends an unexpected reply.
pub fn decode_reply<R>(
    request: &'static str,
    reply: &[u8],
    expected: impl FnOnce(Reply<'_>) -> Option<R>,
) -> Result<R, RunError> {
    match Reply::decode(reply)? {
        Reply::Error(reason) => {
            Err(RunError::Refused { request, reason: shorten(Escaped(reason).to_string()) })
        }
        decoded => expected(decoded)
            .ok_or_else(|| RunError::WrongReply { request, found: Excerpt::new(reply) }),
    }
}

/// Cuts a text that nobody would read to its end.
fn shorten(text: String) -> String {
    match text.char_indices().nth(MAX_REASON_CHARS) {
        Some((end, _)) => format!("{}… (of {} bytes)", &text[..end], text.len()),
        None => text,
    }
}

fn is_ok(reply: Reply<'_>) -> Option<()> {
    (reply == Reply::Ok).then_some(())
}

#[cfg(test)]
mod tests {
    use mmsim_protocol::{Annotations, MazeSize};

    use super::*;
    use crate::transport::InMemory;

    #[test]
    fn long_annotations_take_several_requests() {
        let size = MazeSize::HALF_SIZE;
        let texts: Vec<_> = size.cells().map(|cell| (cell, cell.to_string())).collect();
        let annotations = || texts.iter().map(|&(cell, ref text)| Annotation::Text { cell, text });
        let mut received = Vec::new();
        let transport = InMemory::new(|request: &[u8], reply: &mut Vec<u8>| {
            received.push(request.to_vec());
            reply.extend_from_slice(b"ok");
        });
        Exchange::new(transport).annotate(annotations()).unwrap();
        assert_eq!(received.len(), 3);
        let decoded = received.iter().map(|request| Annotations::decode(request, size).unwrap());
        assert!(decoded.flat_map(|request| request.iter()).eq(annotations()));
    }

    #[test]
    fn invalid_annotations_are_not_sent() {
        let transport = InMemory::new(|request: &[u8], _: &mut Vec<u8>| panic!("{request:?}"));
        let mut exchange = Exchange::new(transport);
        exchange.annotate([]).unwrap();
        let error = exchange.annotate([Annotation::Log("a\nb")]).unwrap_err();
        insta::assert_snapshot!(error, @r#"expected a log line of at most 1000 bytes of tabs and printable characters in UTF-8, found "a\nb" at byte 4"#);
    }
}
