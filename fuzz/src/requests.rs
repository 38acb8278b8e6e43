//! Requests to one simulation, one after the other.
//!
//! An input is a byte that chooses the size of the maze ([`SIZES`]) and whether the history is
//! limited, then pieces, each ended by [`CUT`] and a count:
//!
//! ```text
//! maze  piece CUT count  piece CUT count  …
//! ```
//!
//! A count of 0 gives the piece to the simulation as it is. Pieces are told apart by a mark rather
//! than by their lengths, so that a byte more or less spoils this request only, by a byte.
//!
//! Any other count stands for as many states, each unlike the one before it: a piece that begins
//! with `S` and has at least six bytes is stretched to the length of a state (see `stretched`). So
//! six bytes are a whole state of any maze, and a short input fills the history beyond a block.

use std::collections::VecDeque;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, Walls, WallsAround};
use mmsim_protocol::{Info, Reply, Request, state_bytes};
use mmsim_server::{Change, ReplyBuffer, Simulation};

/// What ends a piece, before its count.
pub const CUT: [u8; 2] = [0xa5, 0x5a];

/// The sizes of maze, width and height in cells. The first byte is the index of one; the history
/// is limited with as many added to it.
pub const SIZES: [(u8, u8); 6] = [(16, 16), (1, 1), (2, 1), (21, 21), (32, 32), (5, 32)];

/// What a limited history may hold, in bytes: from one state of the largest maze to several blocks
/// of the smallest.
const LIMIT: usize = 4096;

/// The most requests that one input makes: several blocks of the history, at most 2 MiB of states.
const MAX_REQUESTS: usize = 1 << 10;

/// Bytes of a state before its weights: `S` x y heading order.
const HEAD_BYTES: usize = 5;

/// After how many requests their number is told.
const TOLD_EVERY: u64 = 1_000_000;

/// Requests so far, over all inputs.
static REQUESTS: AtomicU64 = AtomicU64::new(0);

/// A maze of each size. Whether a wall stands is as good as random, so that each of the eight
/// replies to a walls request comes up.
static MAZES: LazyLock<[Maze; SIZES.len()]> = LazyLock::new(|| {
    SIZES.map(|(width, height)| {
        let size = MazeSize::new(width.into(), height.into()).expect("1 to 32 cells each way");
        let mut walls = Walls::open(size);
        let mut random = 1_u32;
        for cell in size.cells() {
            for heading in [Heading::North, Heading::East] {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                walls.set(cell, heading, random >> 31 == 1);
            }
        }
        Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).expect("a start inside the maze")
    })
});

/// Gives the requests of an input to a new simulation and checks each reply and the history.
pub fn run(input: &[u8]) {
    let Some((&first, mut pieces)) = input.split_first() else { return };
    let (choice, first) = (usize::from(first) / SIZES.len(), usize::from(first) % SIZES.len());
    let maze = &MAZES[first];
    let mut observed = Observed::new(maze, (choice % 2 == 1).then_some(LIMIT));
    let mut left = MAX_REQUESTS;
    while !pieces.is_empty() && left > 0 {
        let (piece, count, rest) = cut(pieces);
        pieces = rest;
        let state = if count > 0 { stretched(piece, maze.size()) } else { None };
        let Some(mut state) = state else {
            observed.ask(piece);
            left -= 1;
            continue;
        };
        for _ in 0..count.min(left) {
            observed.ask(&state);
            state[HEAD_BYTES] = state[HEAD_BYTES].wrapping_add(1);
        }
        left -= count.min(left);
    }
    check_history(&observed.simulation, &observed.states);
    count_requests(MAX_REQUESTS - left);
}

/// The first piece, its count, and what follows. The last piece may lack its end.
fn cut(pieces: &[u8]) -> (&[u8], usize, &[u8]) {
    let end = pieces.windows(CUT.len()).position(|bytes| bytes == CUT);
    let Some(end) = end else { return (pieces, 0, &[]) };
    match pieces[end + CUT.len()..].split_first() {
        Some((&count, rest)) => (&pieces[..end], count.into(), rest),
        None => (&pieces[..end], 0, &[]),
    }
}

/// A message as long as a state of this size: the head as it stands in the piece, the piece's last
/// byte as the order of the walls, what is between the two repeated in both matrices. `None` for
/// what begins otherwise or has fewer bytes than a head and an order.
///
/// ```text
/// S x y N C  7 9  F     stretched for a maze of 2x2 cells:     S x y N C  7 9 7 9  F  7 9 7 9
/// ```
fn stretched(piece: &[u8], size: MazeSize) -> Option<Vec<u8>> {
    let (head, rest) = piece.split_at_checked(HEAD_BYTES).filter(|(head, _)| head[0] == b'S')?;
    let (&walls_order, pattern) = rest.split_last()?;
    let pattern = if pattern.is_empty() { &[0] } else { pattern };
    let matrix: Vec<u8> = pattern.iter().copied().cycle().take(size.area()).collect();
    let message = [head, &matrix, &[walls_order], &matrix].concat();
    assert_eq!(message.len(), state_bytes(size));
    Some(message)
}

/// The input of this first byte and these requests; `None` if one of them has a [`CUT`] in it.
pub fn input<'a>(first: u8, requests: impl IntoIterator<Item = &'a [u8]>) -> Option<Vec<u8>> {
    let mut input = vec![first];
    let mut expected = VecDeque::new();
    for request in requests {
        input.extend_from_slice(request);
        input.extend_from_slice(&CUT);
        input.push(0);
        expected.push_back(request);
    }
    let mut pieces = &input[1..];
    while !pieces.is_empty() {
        let (piece, _, rest) = cut(pieces);
        pieces = rest;
        if expected.pop_front() != Some(piece) {
            return None;
        }
    }
    expected.is_empty().then_some(input)
}

/// A simulation and what it must know by now.
struct Observed<'a> {
    maze: &'a Maze,
    simulation: Simulation,
    limit: Option<usize>,
    reply: ReplyBuffer,
    /// Every state since the last reset.
    states: Vec<Vec<u8>>,
}

impl<'a> Observed<'a> {
    fn new(maze: &'a Maze, limit: Option<usize>) -> Self {
        let unlimited = Simulation::new("fuzz", maze.clone());
        let simulation = match limit {
            Some(bytes) => unlimited.with_history_limit(bytes),
            None => unlimited,
        };
        Self { maze, simulation, limit, reply: ReplyBuffer::new(), states: Vec::new() }
    }

    /// Asks and holds the reply against the laws: there is one, it is the one that is due, and the
    /// history changes by it and by nothing else.
    fn ask(&mut self, request: &[u8]) {
        let Self { maze, simulation, limit, reply, states } = self;
        let decoded = Request::decode(request, maze.size());
        if decoded == Ok(Request::Reset) {
            check_history(simulation, states);
        }
        reply.clear();
        reply.extend_from_slice(b"left of an earlier reply");
        let change = simulation.handle(request, reply);
        let mut due = Change::Nothing;
        let reply = Reply::decode(reply).expect("a reply of the protocol");
        match decoded {
            Ok(Request::Ping) => assert_eq!(reply, Reply::Pong),
            Ok(Request::Reset) => {
                assert_eq!(reply, Reply::Ok);
                states.clear();
                due = Change::Reset;
            }
            Ok(Request::Walls(pose)) => {
                let wall = |heading| maze.walls().has(pose.cell, heading);
                let (left, front, right) =
                    (pose.heading.left(), pose.heading, pose.heading.right());
                let (left, front, right) = (wall(left), wall(front), wall(right));
                assert_eq!(reply, Reply::Walls(WallsAround { left, front, right }));
            }
            Ok(Request::State(_)) if matches!(reply, Reply::Error(_)) => {
                let room = limit.expect("no limit") - simulation.history().bytes();
                assert!(room < request.len(), "{reply:?} with room for {room} bytes");
            }
            Ok(Request::State(_)) => {
                assert_eq!(reply, Reply::Ok);
                states.push(request.to_vec());
                due = Change::State;
            }
            Ok(Request::Info) => {
                let Reply::Info(json) = reply else { panic!("info answered by {reply:?}") };
                let info: Info = serde_json::from_str(json).expect("info as JSON");
                let name = simulation.name();
                let told = Info::new(name, maze.size(), maze.start(), maze.goals(), states.len());
                assert_eq!(info, told);
            }
            Ok(other) => panic!("unexpected request {other:?}"),
            Err(error) => {
                let reason = error.to_string();
                assert!(!reason.contains(char::is_control), "in one line: {reason:?}");
                assert_eq!(reply, Reply::Error(&reason));
            }
        }
        if let Ok(decoded) = decoded {
            let mut buffer = vec![0xa5; request.len()];
            assert_eq!(decoded.encode(&mut buffer), Ok(request.len()));
            assert_eq!(buffer, request, "decoded and encoded again");
        }
        assert_eq!(change, due);
        assert_eq!(simulation.history().len(), states.len());
        assert_eq!(simulation.history().is_empty(), states.is_empty());
        if let Some(last) = states.len().checked_sub(1) {
            check_state(simulation, states, last);
        }
    }
}

/// Every state reads as it came, in order as well as picked out, and there is none after them.
fn check_history(simulation: &Simulation, states: &[Vec<u8>]) {
    let mut kept = simulation.history().iter();
    for (index, state) in states.iter().enumerate() {
        assert_eq!(kept.next().as_deref(), Some(&state[..]), "state {index}");
    }
    assert!(kept.next().is_none());
    for index in (0..=states.len()).step_by(61).chain([states.len(), usize::MAX]) {
        check_state(simulation, states, index);
    }
}

fn check_state(simulation: &Simulation, states: &[Vec<u8>], index: usize) {
    let kept = simulation.history().get(index);
    assert_eq!(kept.as_deref(), states.get(index).map(Vec::as_slice), "state {index}");
}

/// Counts them, and tells the number each time that it is past another million.
fn count_requests(count: usize) {
    let before = REQUESTS.fetch_add(count as u64, Ordering::Relaxed);
    let after = before + count as u64;
    if before / TOLD_EVERY < after / TOLD_EVERY {
        eprintln!("requests: {after}");
    }
}
