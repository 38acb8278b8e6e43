//! The requests that a client sends to a simulator.

use mmsim_maze::{Excerpt, MazeSize, Pose};

use crate::annotations::Annotations;
use crate::error::RequestError;
use crate::layout::{BufferTooSmall, write_bytes};
use crate::message::{decode_pose, heading_byte};
use crate::state::State;

/// The version of the protocol, which is part of the reply to `info`.
pub const PROTOCOL_VERSION: u32 = 1;

/// The default TCP port of a simulator.
pub const DEFAULT_PORT: u16 = 6574;

const PING: &[u8] = b"ping";
const RESET: &[u8] = b"reset";
const INFO: &[u8] = b"info";

/// A request that borrows the bytes of its message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Request<'a> {
    /// Checks the connection.
    Ping,
    /// Deletes all states and starts a new search.
    Reset,
    /// Asks for the walls around a mouse in this pose.
    Walls(Pose),
    /// Reports the mouse's belief at one moment of its search.
    State(State<'a>),
    /// Asks for a description of the maze. Only this project's server supports `info`; the
    /// reference server (mmsim 0.1.7, written in Python) never replies to it.
    Info,
    /// Adds texts, colours, walls and log lines to the next state. Only servers whose reply to
    /// `info` lists the extension `annotations` support this request.
    Annotations(Annotations<'a>),
}

impl<'a> Request<'a> {
    /// Decodes a request. `size` is the size of the simulator's maze.
    ///
    /// # Errors
    /// Returns an error if the bytes are not a request, or if a cell is outside the maze.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, Heading, MazeSize, Pose, Request};
    /// let request = Request::decode(b"W\x03\x04E", MazeSize::CLASSIC)?;
    /// assert_eq!(request, Request::Walls(Pose::new(Cell::new(3, 4), Heading::East)));
    /// let error = Request::decode(b"W\x03", MazeSize::CLASSIC).unwrap_err();
    /// assert_eq!(error.to_string(), "expected W, x, y and heading (4 bytes), found 2 bytes");
    /// # Ok::<(), mmsim_protocol::RequestError>(())
    /// ```
    pub fn decode(message: &'a [u8], size: MazeSize) -> Result<Self, RequestError> {
        match message {
            PING => Ok(Self::Ping),
            RESET => Ok(Self::Reset),
            INFO => Ok(Self::Info),
            &[b'W', x, y, heading] => decode_pose(x, y, heading, size).map(Self::Walls),
            [b'W', ..] => Err(RequestError::WallsLength { found: message.len() }),
            [b'S', ..] => State::decode(message, size).map(Self::State),
            [b'A', ..] => Annotations::decode(message, size).map(Self::Annotations),
            _ => Err(RequestError::Unknown(Excerpt::new(message))),
        }
    }

    /// Returns true if the request changes what a simulator stores: `reset`, `S` and `A`. The others
    /// only read.
    pub const fn is_write(self) -> bool {
        matches!(self, Self::Reset | Self::State(_) | Self::Annotations(_))
    }

    /// Writes the request to the start of `buffer` and returns the number of bytes written.
    ///
    /// # Errors
    /// Returns an error if the buffer is shorter than the request. A buffer of
    /// [`MAX_ANNOTATIONS_BYTES`](crate::MAX_ANNOTATIONS_BYTES) bytes is long enough for any
    /// request, and one of [`MAX_STATE_BYTES`](crate::MAX_STATE_BYTES) bytes for any other than
    /// annotations.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, Heading, Pose, Request};
    /// let mut buffer = [0; 16];
    /// let length = Request::Walls(Pose::new(Cell::new(3, 4), Heading::East)).encode(&mut buffer)?;
    /// assert_eq!(&buffer[..length], b"W\x03\x04E");
    /// # Ok::<(), mmsim_protocol::BufferTooSmall>(())
    /// ```
    pub fn encode(&self, buffer: &mut [u8]) -> Result<usize, BufferTooSmall> {
        match self {
            Self::Ping => write_bytes(buffer, PING),
            Self::Reset => write_bytes(buffer, RESET),
            Self::Info => write_bytes(buffer, INFO),
            Self::Walls(Pose { cell, heading }) => {
                write_bytes(buffer, &[b'W', cell.x, cell.y, heading_byte(*heading)])
            }
            Self::State(state) => state.encode(buffer),
            Self::Annotations(annotations) => write_bytes(buffer, annotations.as_bytes()),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use mmsim_maze::{Cell, Heading};

    use super::*;
    use crate::layout::{MAX_ANNOTATIONS_BYTES, WALLS_REQUEST_BYTES};

    fn error(message: &[u8]) -> String {
        Request::decode(message, MazeSize::CLASSIC).unwrap_err().to_string()
    }

    #[test]
    fn requests_are_encoded_and_decoded() {
        let pose = Pose::new(Cell::new(0x0a, 0x0b), Heading::West);
        for (request, bytes) in [
            (Request::Ping, &b"ping"[..]),
            (Request::Reset, b"reset"),
            (Request::Info, b"info"),
            (Request::Walls(pose), b"W\x0a\x0bW"),
        ] {
            let mut buffer = [0xa5; 8];
            assert_eq!(request.encode(&mut buffer), Ok(bytes.len()));
            assert_eq!(&buffer[..bytes.len()], bytes);
            assert!(buffer[bytes.len()..].iter().all(|&byte| byte == 0xa5));
            assert_eq!(Request::decode(bytes, MazeSize::CLASSIC), Ok(request));
            let too_small = BufferTooSmall { expected: bytes.len(), found: bytes.len() - 1 };
            assert_eq!(request.encode(&mut buffer[..bytes.len() - 1]), Err(too_small));
        }
    }

    #[test]
    fn errors_say_expected_and_found() {
        insta::assert_snapshot!(error(b""), @"expected ping, reset, info, W, S or A, found an empty message");
        insta::assert_snapshot!(error(b"foo"), @r#"expected ping, reset, info, W, S or A, found "foo""#);
        insta::assert_snapshot!(error(b"ping\n"), @r#"expected ping, reset, info, W, S or A, found "ping\n""#);
        insta::assert_snapshot!(error(&[b'x'; 1 << 12]), @r#"expected ping, reset, info, W, S or A, found "xxxxxxxxxxxxxxxx"… of 4096 bytes"#);
        insta::assert_snapshot!(error(b"W\x00\x00"), @"expected W, x, y and heading (4 bytes), found 3 bytes");
        insta::assert_snapshot!(error(b"WW\x00\x00N"), @"expected W, x, y and heading (4 bytes), found 5 bytes");
        insta::assert_snapshot!(error(b"W\x00\x00n"), @r#"expected N, E, S or W as the heading, found "n""#);
        insta::assert_snapshot!(error(b"W\x00\x00\xff"), @r#"expected N, E, S or W as the heading, found "\xff""#);
        insta::assert_snapshot!(error(b"W\x10\x00N"), @"expected a cell in a maze of 16x16 cells, found (16, 0)");
        insta::assert_snapshot!(error(b"W\x00\xffN"), @"expected a cell in a maze of 16x16 cells, found (0, 255)");
        insta::assert_snapshot!(error(b"S"), @"expected a state of 518 bytes for a maze of 16x16 cells, found 1 bytes");
        insta::assert_snapshot!(RequestError::Frames { found: 2 }, @"expected one frame, found 2");
    }

    #[test]
    fn cells_are_checked_against_the_served_maze() {
        let size = MazeSize::new(5, 32).unwrap();
        for x in 0..=255 {
            for y in 0..=255 {
                let decoded = Request::decode(&[b'W', x, y, b'S'], size).is_ok();
                assert_eq!(decoded, x < 5 && y < 32, "({x}, {y})");
            }
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_request_or_an_error(
            message in prop::collection::vec(any::<u8>(), 0..2100),
            (width, height) in (1usize..=32, 1usize..=32),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            match Request::decode(&message, size) {
                Ok(request) => {
                    let mut buffer = [0xa5; MAX_ANNOTATIONS_BYTES];
                    let length = request.encode(&mut buffer).unwrap();
                    prop_assert_eq!(&buffer[..length], &message[..]);
                }
                Err(error) => {
                    let text = error.to_string();
                    prop_assert!(text.starts_with("expected ") && text.contains(", found "));
                    prop_assert!(!text.contains('\n') && text.len() < 200);
                }
            }
        }

        #[test]
        fn a_walls_request_survives_a_round_trip(x in 0u8..32, y in 0u8..32, heading in 0usize..4) {
            let request = Request::Walls(Pose::new(Cell::new(x, y), Heading::ALL[heading]));
            let mut buffer = [0xa5; WALLS_REQUEST_BYTES];
            prop_assert_eq!(request.encode(&mut buffer), Ok(WALLS_REQUEST_BYTES));
            prop_assert_eq!(Request::decode(&buffer, MazeSize::HALF_SIZE), Ok(request));
        }
    }
}
