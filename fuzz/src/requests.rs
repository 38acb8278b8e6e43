//! The fuzz target for sequences of requests to a simulation.
//!
//! The first byte of an input selects the size of the maze ([`SIZES`]) and whether the history is
//! limited. The rest of the input consists of pieces, each followed by [`CUT`] and a count:
//!
//! ```text
//! maze  piece CUT count  piece CUT count  …
//! ```
//!
//! If the count after a piece is 0, the piece is sent as one request. A separator ends each piece.
//! With length prefixes instead, one inserted or deleted byte would change all later requests.
//!
//! If the count is n > 0, and the piece begins with `S` and has at least six bytes, n different
//! states are sent. The piece is stretched to the length of a state (see `stretched`), so a short
//! input can fill several compressed blocks of the history.

use std::collections::HashMap;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, WallState, Walls, WallsAround, WyRand};
use mmsim_protocol::{
    Annotation, AnnotationWriter, Annotations, Colour, Info, Reply, Request, state_bytes,
};
use mmsim_recording::{LogLine, Notes};
use mmsim_server::{Change, ReplyBuffer, Simulation};

/// The bytes that separate a piece of an input from its count.
pub const CUT: [u8; 2] = [0xa5, 0x5a];

/// The widths and heights of the mazes in cells. The first byte of an input is an index into this
/// array, plus the length of the array if the history is limited.
pub const SIZES: [(u8, u8); 6] = [(16, 16), (1, 1), (2, 1), (21, 21), (32, 32), (5, 32)];

/// The size in bytes of a limited history. This size is enough for one state of the largest maze or
/// for several blocks of states of the smallest maze.
const LIMIT: usize = 4096;

/// The maximum number of requests in one input. This many states fill several compressed blocks of
/// the history, and take at most about 2 MiB.
const MAX_REQUESTS: usize = 1 << 10;

/// The number of bytes of an update and of a context that a limited history may need in addition to
/// a state if no walls were read and nothing was annotated.
const MAX_CONTEXT_BYTES: usize = 512;

/// The number of bytes of an update for each reading of walls.
const READ_BYTES: usize = 4;

/// Notes are compared at each state whose index is a multiple of this number.
const STRIDE: usize = 61;

/// The number of bytes before the weights in a state message: `S`, x, y, the heading and the order
/// of the weights.
const HEAD_BYTES: usize = 5;

/// The number of bytes of annotations that the server accepts before a state, without the letter of
/// each request.
const MAX_PENDING_BYTES: usize = 64 << 10;

/// The number of bytes of a limited history that a log line needs in addition to its update.
const LINE_BYTES: usize = size_of::<LogLine>() + size_of::<usize>();

/// Totals are printed once per this number of requests.
const PRINT_INTERVAL: u64 = 1_000_000;

/// The total number of requests sent so far.
static REQUESTS: AtomicU64 = AtomicU64::new(0);

/// One maze for each size. The walls are pseudorandom, so that all eight possible replies to a `W`
/// request occur.
static MAZES: LazyLock<[Maze; SIZES.len()]> = LazyLock::new(|| {
    SIZES.map(|(width, height)| {
        let size = MazeSize::new(width.into(), height.into()).expect("each side has 1 to 32 cells");
        let mut walls = Walls::open(size);
        let mut rng = WyRand::new(1);
        for wall in size.walls() {
            walls.set(wall.cell, wall.heading, rng.flip());
        }
        Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).expect("the start is inside the maze")
    })
});

/// Sends the requests of an input to a new simulation. Checks each reply and the stored states.
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
    observed.check_history();
    count_requests(MAX_REQUESTS - left);
}

/// Returns the first piece of an input, its count, and the remaining bytes. If the separator or the
/// count is missing at the end of the input, the count is 0.
fn cut(pieces: &[u8]) -> (&[u8], usize, &[u8]) {
    let end = pieces.windows(CUT.len()).position(|bytes| bytes == CUT);
    let Some(end) = end else { return (pieces, 0, &[]) };
    match pieces[end + CUT.len()..].split_first() {
        Some((&count, rest)) => (&pieces[..end], count.into(), rest),
        None => (&pieces[..end], 0, &[]),
    }
}

/// Returns a state message made from a piece of an input, or `None` if the piece does not begin
/// with `S` or has fewer than six bytes. The message begins with the first five bytes of the piece.
/// The last byte of the piece selects the order of the walls. The other bytes of the piece are
/// repeated to fill the matrices of weights and walls.
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

/// Returns the input that consists of this first byte and these pieces, each with its count, or
/// `None` if a piece contains [`CUT`].
pub fn input<'a>(first: u8, pieces: impl IntoIterator<Item = (&'a [u8], u8)>) -> Option<Vec<u8>> {
    let mut input = vec![first];
    for (piece, count) in pieces {
        if piece.windows(CUT.len()).any(|bytes| bytes == CUT) {
            return None;
        }
        input.extend_from_slice(piece);
        input.extend_from_slice(&CUT);
        input.push(count);
    }
    Some(input)
}

/// A simulation and the states that it is expected to store.
struct Observed<'a> {
    maze: &'a Maze,
    simulation: Simulation,
    limit: Option<usize>,
    reply: ReplyBuffer,
    /// All states since the last reset.
    states: Vec<Vec<u8>>,
    /// The annotations that belong to the next state.
    pending: Vec<Vec<u8>>,
    notes: TwinNotes,
    /// The notes at each state whose index is a multiple of [`STRIDE`].
    snapshots: Vec<TwinNotes>,
    /// The log lines, each with the index of its state.
    lines: Vec<LogLine>,
    /// The number of walls read since the last state.
    reads: usize,
}

/// A naive version of [`Notes`].
#[derive(Clone, Default)]
struct TwinNotes {
    texts: HashMap<Cell, String>,
    colours: HashMap<Cell, Colour>,
    walls: HashMap<(Cell, Heading), WallState>,
    mouse: String,
    strategy: String,
    /// True if there was a text, a colour or a declared wall since the last reset.
    has_texts: bool,
    has_colours: bool,
    has_walls: bool,
}

impl TwinNotes {
    fn apply(&mut self, annotation: Annotation<'_>, size: MazeSize) {
        self.has_texts |= matches!(annotation, Annotation::Text { .. });
        self.has_colours |= matches!(annotation, Annotation::Colour { .. });
        self.has_walls |= matches!(annotation, Annotation::Wall { .. });
        match annotation {
            Annotation::Text { cell, text } => drop(self.texts.insert(cell, text.into())),
            Annotation::Colour { cell, colour: Some(colour) } => {
                self.colours.insert(cell, colour);
            }
            Annotation::Colour { cell, colour: None } => drop(self.colours.remove(&cell)),
            Annotation::Wall { cell, heading, state } => {
                let Some(neighbour) = size.neighbour(cell, heading) else { return };
                for side in [(cell, heading), (neighbour, heading.back())] {
                    match state {
                        Some(state) => drop(self.walls.insert(side, state)),
                        None => drop(self.walls.remove(&side)),
                    }
                }
            }
            Annotation::Log(_) | Annotation::Restart => {}
            Annotation::Mouse(name) => self.mouse = name.into(),
            Annotation::Strategy(name) => self.strategy = name.into(),
            Annotation::ClearTexts => self.texts.clear(),
            Annotation::ClearColours => self.colours.clear(),
            Annotation::ClearWalls => self.walls.clear(),
        }
    }

    /// Returns the number of bytes that a simulation may need to store these notes. It may keep
    /// space for values that have been cleared.
    fn max_bytes(&self, size: MazeSize) -> usize {
        let texts = self.texts.values().map(String::len).sum::<usize>();
        let each = [(self.has_texts, 7), (self.has_colours, 3), (self.has_walls, 6)];
        let each = each.map(|(is_set, bytes)| if is_set { bytes } else { 0 });
        texts + self.mouse.len() + self.strategy.len() + each.iter().sum::<usize>() * size.area()
    }

    fn check(&self, notes: &Notes, size: MazeSize) {
        for cell in size.cells() {
            assert_eq!(notes.text(cell), self.texts.get(&cell).map_or("", String::as_str));
            assert_eq!(notes.colour(cell), self.colours.get(&cell).copied());
            for heading in Heading::ALL {
                let declared = self.walls.get(&(cell, heading)).copied();
                assert_eq!(notes.declared_wall(cell, heading), declared, "{cell} {heading}");
            }
        }
        assert_eq!(notes.mouse().unwrap_or_default(), self.mouse);
        assert_eq!(notes.strategy().unwrap_or_default(), self.strategy);
    }
}

/// Checks that a decoded request is encoded as it was received.
fn check_encoding(decoded: Request<'_>, request: &[u8]) {
    let mut buffer = vec![0xa5; request.len()];
    assert_eq!(decoded.encode(&mut buffer), Ok(request.len()));
    assert_eq!(buffer, request, "the request changes when it is decoded and re-encoded");
}

impl<'a> Observed<'a> {
    fn new(maze: &'a Maze, limit: Option<usize>) -> Self {
        let unlimited = Simulation::new("fuzz", maze.clone());
        let simulation = match limit {
            Some(bytes) => unlimited.with_history_limit(bytes),
            None => unlimited,
        };
        Self {
            maze,
            simulation,
            limit,
            reply: ReplyBuffer::new(),
            states: Vec::new(),
            pending: Vec::new(),
            notes: TwinNotes::default(),
            snapshots: Vec::new(),
            lines: Vec::new(),
            reads: 0,
        }
    }

    /// Sends a request. Checks the reply, the reported change and the history.
    fn ask(&mut self, request: &[u8]) {
        let decoded = Request::decode(request, self.maze.size());
        if decoded == Ok(Request::Reset) {
            self.check_history();
        }
        let Self { maze, simulation, limit, reply, states, pending, .. } = self;
        let Self { notes, snapshots, lines, reads, .. } = self;
        reply.clear();
        reply.extend_from_slice(b"an earlier reply");
        let change = simulation.handle(request, reply);
        let mut expected = Change::Nothing;
        let reply = Reply::decode(reply).expect("the reply follows the protocol");
        match decoded {
            Ok(Request::Ping) => assert_eq!(reply, Reply::Pong),
            Ok(Request::Reset) => {
                assert_eq!(reply, Reply::Ok);
                states.clear();
                pending.clear();
                snapshots.clear();
                lines.clear();
                (*notes, *reads) = (TwinNotes::default(), 0);
                expected = Change::Reset;
            }
            Ok(Request::Walls(pose)) => {
                let (cell, heading) = (pose.cell, pose.heading);
                let wall = |heading| maze.walls().has(cell, heading);
                let [left, front, right] = [heading.left(), heading, heading.right()].map(wall);
                assert_eq!(reply, Reply::Walls(WallsAround { left, front, right }));
                *reads += 1;
            }
            Ok(Request::State(_)) if matches!(reply, Reply::Error(_)) => {
                let room = limit.expect("the history is limited") - simulation.history().bytes();
                let annotated = pending.iter().map(Vec::len).sum::<usize>();
                let update =
                    READ_BYTES * *reads + 2 * annotated + LINE_BYTES * pending_lines(pending);
                let context = MAX_CONTEXT_BYTES + notes.max_bytes(maze.size());
                let is_full = room < request.len() + update + context;
                assert!(is_full, "{reply:?}, although {room} bytes are free");
            }
            Ok(Request::State(_)) => {
                assert_eq!(reply, Reply::Ok);
                states.push(request.to_vec());
                for message in pending.drain(..) {
                    let annotations = Annotations::decode(&message, maze.size());
                    for annotation in annotations.expect("the request was accepted").iter() {
                        notes.apply(annotation, maze.size());
                        if let Annotation::Log(text) = annotation {
                            lines.push(LogLine { state: states.len() - 1, text: text.into() });
                        }
                    }
                }
                if states.len() % STRIDE == 1 {
                    snapshots.push(notes.clone());
                }
                *reads = 0;
                notes.check(simulation.history().newest_context().notes(), maze.size());
                expected = Change::State;
            }
            Ok(Request::Info) => {
                let Reply::Info(json) = reply else {
                    panic!("unexpected reply to info: {reply:?}")
                };
                let info: Info = serde_json::from_str(json).expect("the info is JSON");
                let expected =
                    Info::new("fuzz", maze.size(), maze.start(), maze.goals(), states.len());
                assert_eq!(info, expected);
            }
            Ok(Request::Annotations(annotations)) => {
                let mut buffer = vec![0; request.len()];
                let mut writer = AnnotationWriter::new(&mut buffer);
                for annotation in annotations.iter() {
                    writer.push(annotation).expect("a decoded annotation is valid and fits");
                }
                assert_eq!(writer.finish(), Some(request));
                let before: usize = pending.iter().map(|message| message.len() - 1).sum();
                let bytes = before + request.len() - 1;
                let is_accepted = reply == Reply::Ok;
                assert_eq!(is_accepted, bytes <= MAX_PENDING_BYTES, "{reply:?} at {bytes} bytes");
                if is_accepted {
                    pending.push(request.to_vec());
                    expected = Change::Annotations;
                }
                let lines = simulation.trailing().log_lines(states.len()).count();
                assert_eq!(lines, pending_lines(pending));
            }
            Ok(other) => panic!("unexpected request {other:?}"),
            Err(error) => {
                let reason = error.to_string();
                assert!(!reason.contains(char::is_control), "not a single line: {reason:?}");
                assert_eq!(reply, Reply::Error(&reason));
            }
        }
        if let Ok(decoded) = decoded {
            check_encoding(decoded, request);
        }
        assert_eq!(change, expected);
        assert_eq!(simulation.history().len(), states.len());
        assert_eq!(simulation.history().is_empty(), states.is_empty());
        if let Some(last) = states.len().checked_sub(1) {
            check_state(simulation, states, last);
        }
    }

    /// Checks that the history contains exactly the expected states, both in sequence and by index,
    /// with the expected notes and log lines.
    fn check_history(&self) {
        let Self { simulation, states, .. } = self;
        let mut kept = simulation.history().iter();
        for (index, state) in states.iter().enumerate() {
            assert_eq!(kept.next().as_deref(), Some(&state[..]), "state {index}");
        }
        assert!(kept.next().is_none());
        for index in (0..=states.len()).step_by(STRIDE).chain([states.len(), usize::MAX]) {
            check_state(simulation, states, index);
        }
        for (index, notes) in (0..states.len()).step_by(STRIDE).zip(&self.snapshots) {
            let context = simulation.history().context(index).expect("the state exists");
            notes.check(context.notes(), self.maze.size());
        }
        for last in [states.len() / 2, states.len()] {
            let lines = self.lines.iter().filter(|line| line.state <= last);
            let found = simulation.history().log(last, usize::MAX, |_| true);
            assert!(found.iter().eq(lines), "the log up to state {last}");
        }
    }
}

/// Returns the number of log lines in valid requests.
fn pending_lines(pending: &[Vec<u8>]) -> usize {
    let entries = pending.iter().flat_map(|message| Annotations::iter_entries(&message[1..]));
    entries.filter(|entry| matches!(entry, Annotation::Log(_))).count()
}

fn check_state(simulation: &Simulation, states: &[Vec<u8>], index: usize) {
    let kept = simulation.history().get(index);
    assert_eq!(kept.as_deref(), states.get(index).map(Vec::as_slice), "state {index}");
}

/// Adds `count` to the total number of requests, and prints the total every [`PRINT_INTERVAL`]
/// requests.
fn count_requests(count: usize) {
    let before = REQUESTS.fetch_add(count as u64, Ordering::Relaxed);
    let after = before + count as u64;
    if before / PRINT_INTERVAL < after / PRINT_INTERVAL {
        eprintln!("requests: {after}");
    }
}
