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

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use mmsim_maze::{MazeSize, WyRand};
use mmsim_protocol::{AnnotationWriter, Reply, Request, state_bytes};
use mmsim_recording::LogLine;
use mmsim_server::{Change, ReplyBuffer, Simulation};

use model::{Entry, Model, Notes, Search};

#[path = "../../crates/cli/tests/attacks/model.rs"]
#[expect(dead_code, reason = "the attacks need more of the model")]
mod model;

/// The bytes that separate a piece of an input from its count.
pub const CUT: [u8; 2] = [0xa5, 0x5a];

/// The widths and heights of the mazes in cells. The first byte of an input is an index into this
/// array, plus the length of the array if the history is limited.
pub const SIZES: [(u8, u8); 6] = model::SIZES;

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

/// The number of bytes of a limited history that a log line needs in addition to its update.
const LINE_BYTES: usize = size_of::<LogLine>() + size_of::<usize>();

/// Totals are printed once per this number of requests.
const PRINT_INTERVAL: u64 = 1_000_000;

/// The total number of requests sent so far.
static REQUESTS: AtomicU64 = AtomicU64::new(0);

/// A simulator for each size. The walls are pseudorandom, so that all eight possible replies to a
/// `W` request occur.
static MODELS: LazyLock<[Model; SIZES.len()]> =
    LazyLock::new(|| SIZES.map(|size| Model::random("fuzz", size, &mut WyRand::new(1))));

/// Sends the requests of an input to a new simulation. Checks each reply and the stored states.
pub fn run(input: &[u8]) {
    let Some((&first, mut pieces)) = input.split_first() else { return };
    let (choice, first) = (usize::from(first) / SIZES.len(), usize::from(first) % SIZES.len());
    let mut observed = Observed::new(MODELS[first].clone(), (choice % 2 == 1).then_some(LIMIT));
    let mut left = MAX_REQUESTS;
    while !pieces.is_empty() && left > 0 {
        let (piece, count, rest) = cut(pieces);
        pieces = rest;
        let state = if count > 0 { stretched(piece, observed.model.maze.size()) } else { None };
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

/// Returns the number of bytes that a simulation may need to store these notes. It may keep space
/// for values that have been cleared.
fn max_bytes(Search { states, notes, .. }: &Search, size: MazeSize) -> usize {
    let stored = || states.iter().flat_map(|(entries, _)| entries);
    let each = [
        (stored().any(|entry| matches!(entry, Entry::Text(..))), 7),
        (stored().any(|entry| matches!(entry, Entry::Colour(..))), 3),
        (stored().any(|entry| matches!(entry, Entry::Wall(..))), 6),
    ];
    let each = each.map(|(is_set, bytes)| if is_set { bytes } else { 0 });
    let texts = notes.texts.values().chain(notes.names.values()).map(String::len);
    texts.sum::<usize>() + each.iter().sum::<usize>() * size.area()
}

/// Checks that a decoded request is encoded as it was received.
fn check_encoding(decoded: Request<'_>, request: &[u8]) {
    let mut buffer = vec![0xa5; request.len()];
    assert_eq!(decoded.encode(&mut buffer), Ok(request.len()));
    assert_eq!(buffer, request, "the request changes when it is decoded and re-encoded");
    if let Request::Annotations(annotations) = decoded {
        let mut writer = AnnotationWriter::new(&mut buffer);
        for annotation in annotations.iter() {
            writer.push(annotation).expect("a decoded annotation is valid and fits");
        }
        assert_eq!(writer.finish(), Some(request));
    }
}

/// A simulation and the model that predicts its replies.
struct Observed {
    model: Model,
    simulation: Simulation,
    limit: Option<usize>,
    reply: ReplyBuffer,
    /// The notes at each state whose index is a multiple of [`STRIDE`].
    snapshots: Vec<Notes>,
}

impl Observed {
    fn new(model: Model, limit: Option<usize>) -> Self {
        let unlimited = Simulation::new("fuzz", model.maze.clone());
        let simulation = match limit {
            Some(bytes) => unlimited.with_history_limit(bytes),
            None => unlimited,
        };
        Self { model, simulation, limit, reply: ReplyBuffer::new(), snapshots: Vec::new() }
    }

    /// Sends a request. Checks the reply, the reported change and the history.
    fn ask(&mut self, request: &[u8]) {
        let size = self.model.maze.size();
        let decoded = Request::decode(request, size);
        if decoded == Ok(Request::Reset) {
            self.check_history();
            self.snapshots.clear();
        }
        let Self { model, simulation, reply, .. } = self;
        reply.clear();
        reply.extend_from_slice(b"an earlier reply");
        let change = simulation.handle(request, reply);
        let decoded_reply = Reply::decode(reply).expect("the reply follows the protocol");
        let is_error = matches!(decoded_reply, Reply::Error(_));
        let expected_change = match decoded {
            Ok(Request::State(_)) if is_error => Change::Nothing,
            Ok(Request::State(_)) => Change::State,
            Ok(Request::Annotations(_)) if !is_error => Change::Annotations,
            Ok(Request::Reset) => Change::Reset,
            _ => Change::Nothing,
        };
        assert_eq!(change, expected_change);
        if matches!(decoded, Ok(Request::State(_))) && is_error {
            self.check_full(request.len());
        } else {
            model.reply(request, Some(0)).check(reply, request);
        }
        match decoded {
            Ok(decoded) => check_encoding(decoded, request),
            Err(error) => {
                assert_eq!(Reply::decode(&self.reply), Ok(Reply::Error(&error.to_string())));
            }
        }
        let (history, search) = (self.simulation.history(), self.model.search());
        assert_eq!(history.len(), search.states.len());
        assert_eq!(history.is_empty(), search.states.is_empty());
        let lines = search.trailing.iter().filter_map(Entry::line);
        let trailing = self.simulation.trailing();
        assert!(trailing.log_lines(0).map(|line| line.text).eq(lines));
        if change == Change::State {
            search.notes.check(&history.newest_context(), size);
            let index = search.states.len() - 1;
            if index % STRIDE == 0 {
                self.snapshots.push(search.notes.clone());
            }
        }
        if let Some(last) = search.states.len().checked_sub(1) {
            self.check_state(last);
        }
    }

    /// Checks that a state of this length cannot be stored.
    fn check_full(&self, length: usize) {
        let search = self.model.search();
        let room = self.limit.expect("the history is limited") - self.simulation.history().bytes();
        let reads = search.trailing.iter().filter(|entry| matches!(entry, Entry::Read(..))).count();
        let lines = search.trailing.iter().filter_map(Entry::line).count();
        let annotated = search.trailing_bytes.values().sum::<usize>();
        let update = READ_BYTES * reads / 3 + 2 * annotated + LINE_BYTES * lines;
        let context = MAX_CONTEXT_BYTES + max_bytes(search, self.model.maze.size());
        assert!(room < length + update + context, "refused, although {room} bytes are free");
    }

    /// Checks that the history contains exactly the expected states, both in sequence and by index,
    /// with the expected notes and log lines.
    fn check_history(&self) {
        let (history, search) = (self.simulation.history(), self.model.search());
        let (size, count) = (self.model.maze.size(), search.states.len());
        let lines = search.check(history, size);
        assert!(history.iter().eq(search.states.iter().map(|(_, state)| state.clone())));
        for index in (0..=count).step_by(STRIDE).chain([count, usize::MAX]) {
            self.check_state(index);
        }
        for (index, notes) in (0..count).step_by(STRIDE).zip(&self.snapshots) {
            notes.check(&history.context(index).expect("the state exists"), size);
        }
        for last in [count / 2, count] {
            let lines = lines.iter().copied().filter(|(state, _)| *state <= last);
            let found = history.log(last, usize::MAX, |_| true);
            let found = found.iter().map(|line| (line.state, &line.text[..]));
            assert!(found.eq(lines), "the log up to state {last}");
        }
    }

    fn check_state(&self, index: usize) {
        let kept = self.simulation.history().get(index);
        let expected = self.model.search().states.get(index);
        assert_eq!(kept.as_ref(), expected.map(|(_, state)| state), "state {index}");
    }
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
