//! A naive simulator, written from docs/protocol.md without the decoder of the product.

use std::collections::{HashMap, HashSet};
use std::mem;

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, WallState, Walls, WyRand};
use mmsim_recording::{Context, History, Recording};

/// The widths and heights of random mazes, in cells.
pub(crate) const SIZES: [(u8, u8); 6] = [(16, 16), (1, 1), (2, 1), (21, 21), (32, 32), (5, 32)];

/// The maximum length of a request `A`.
const MAX_ANNOTATIONS_BYTES: usize = 4096;

/// The maximum length of the annotations of one client and of all clients before a state, without the
/// letter of each request.
const MAX_PENDING_BYTES: [usize; 2] = [64 << 10, 256 << 10];

/// What the server must reply.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Expected {
    Bytes(Vec<u8>),
    /// An error with this beginning.
    Error(&'static str),
}

/// Notes are compared at each state whose index is a multiple of this number.
const STRIDE: usize = 17;

const MALFORMED: Expected = Expected::Error("error: expected ");
const FULL: Expected =
    Expected::Error("error: cannot store more annotations before the next state");
const REFUSED: Expected =
    Expected::Error("error: the simulator is running a mouse, and only the connection of ");

impl Expected {
    #[track_caller]
    pub(crate) fn check(&self, reply: &[u8], request: &[u8]) {
        let is_expected = match self {
            Self::Bytes(bytes) => reply == bytes,
            Self::Error(start) => {
                let text = str::from_utf8(reply).unwrap_or_default();
                text.starts_with(start) && !text.contains(char::is_control)
            }
        };
        let (reply, request) = (reply.escape_ascii(), request.escape_ascii());
        assert!(is_expected, "{reply} to {request}, expected {self:?}");
    }
}

/// An entry of a request `A`, or the reading of a wall.
#[derive(Clone, Debug)]
pub(crate) enum Entry {
    Text(Cell, String),
    Colour(Cell, u8),
    Wall(Cell, Heading, u8),
    Line(String),
    Name(u8, String),
    Restart,
    Clear(u8),
    Read(Cell, Heading),
}

impl Entry {
    pub(crate) fn line(&self) -> Option<&str> {
        if let Self::Line(text) = self { Some(text) } else { None }
    }
}

/// What a client has sent between two resets.
#[derive(Clone, Default)]
pub(crate) struct Search {
    /// The states, each with the entries before it.
    pub(crate) states: Vec<(Vec<Entry>, Vec<u8>)>,
    /// The entries after the last state.
    pub(crate) trailing: Vec<Entry>,
    /// The bytes of the requests `A` of each client after the last state, without their letters.
    pub(crate) trailing_bytes: HashMap<usize, usize>,
    /// What the client displayed at the last state.
    pub(crate) notes: Notes,
}

impl Search {
    /// Returns the number of states and log lines of the recording.
    fn items(&self) -> usize {
        let trailing = (!self.states.is_empty()).then_some(&self.trailing);
        let entries = self.states.iter().map(|(entries, _)| entries).chain(trailing).flatten();
        self.states.len() + entries.filter_map(Entry::line).count()
    }

    /// Checks that these are the states of the search, with their contexts. Returns the log lines,
    /// each with the index of its state.
    #[track_caller]
    pub(crate) fn check(&self, history: &History, size: MazeSize) -> Vec<(usize, &str)> {
        assert_eq!(history.len(), self.states.len(), "states of a search");
        let (mut notes, mut lines) = (Notes::default(), Vec::new());
        let mut expected = self.states.iter().enumerate();
        for block in (0..).map_while(|block| history.block(block)) {
            let states = block.unpack().unwrap();
            let mut scan = states.scan().unwrap();
            while let Some(found) = scan.advance() {
                let (index, (entries, state)) = expected.next().unwrap();
                assert!(found.message == state, "state {index} is another one");
                let has_restart = entries.iter().any(|entry| matches!(entry, Entry::Restart));
                assert_eq!(found.has_restart, has_restart, "state {index}");
                notes.apply(entries, size);
                lines.extend(entries.iter().filter_map(Entry::line).map(|line| (index, line)));
                if index % STRIDE == 0 {
                    notes.check(found.context, size);
                }
            }
        }
        assert!(expected.next().is_none(), "a damaged block");
        lines
    }
}

/// What a client has read and displays.
#[derive(Clone, Default)]
pub(crate) struct Notes {
    pub(crate) texts: HashMap<Cell, String>,
    colours: HashMap<Cell, u8>,
    /// The declared walls, each by both of its sides.
    walls: HashMap<(Cell, Heading), u8>,
    pub(crate) names: HashMap<u8, String>,
    /// The walls that were read, each by both of its sides.
    reads: HashSet<(Cell, Heading)>,
    has_read: bool,
}

impl Notes {
    fn apply<'e>(&mut self, entries: impl IntoIterator<Item = &'e Entry>, size: MazeSize) {
        let sides = |cell, heading: Heading| {
            let neighbour = size.neighbour(cell, heading);
            neighbour.into_iter().flat_map(move |it| [(cell, heading), (it, heading.back())])
        };
        entries.into_iter().for_each(|entry| match entry {
            Entry::Text(cell, text) => drop(self.texts.insert(*cell, text.clone())),
            Entry::Colour(cell, colour) => drop(self.colours.insert(*cell, *colour)),
            Entry::Wall(cell, heading, state) => {
                self.walls.extend(sides(*cell, *heading).map(|side| (side, *state)));
            }
            Entry::Name(letter, name) => drop(self.names.insert(*letter, name.clone())),
            Entry::Clear(b't') => self.texts.clear(),
            Entry::Clear(b'c') => self.colours.clear(),
            Entry::Clear(_) => self.walls.clear(),
            Entry::Read(cell, heading) => {
                self.has_read = true;
                self.reads.extend(sides(*cell, *heading));
            }
            Entry::Line(_) | Entry::Restart => {}
        });
    }

    #[track_caller]
    pub(crate) fn check(&self, context: &Context, size: MazeSize) {
        let notes = context.notes();
        assert_eq!(context.walls_read().is_some(), self.has_read);
        for cell in size.cells() {
            assert_eq!(notes.text(cell), self.texts.get(&cell).map_or("", String::as_str));
            let colour = notes.colour(cell).map_or(b'-', |colour| colour.letter() as u8);
            assert_eq!(colour, self.colours.get(&cell).copied().unwrap_or(b'-'), "{cell}");
            for side in Heading::ALL.map(|heading| (cell, heading)) {
                let wall = match notes.declared_wall(cell, side.1) {
                    Some(WallState::Present) => b'1',
                    Some(WallState::Absent) => b'0',
                    Some(WallState::Unknown) => b'?',
                    None => b'-',
                };
                assert_eq!(wall, self.walls.get(&side).copied().unwrap_or(b'-'), "{side:?}");
                if let Some(read) = context.walls_read()
                    && size.neighbour(cell, side.1).is_some()
                {
                    assert_eq!(read.has(cell, side.1), self.reads.contains(&side), "{side:?}");
                }
            }
        }
        let name = |letter| self.names.get(&letter).map(String::as_str).unwrap_or_default();
        assert_eq!(notes.mouse().unwrap_or_default(), name(b'M'));
        assert_eq!(notes.strategy().unwrap_or_default(), name(b'S'));
    }
}

/// A simulator and everything that it has recorded.
#[derive(Clone)]
pub(crate) struct Model {
    name: String,
    pub(crate) maze: Maze,
    /// All searches. The last one continues.
    searches: Vec<Search>,
    /// The request `A` at the beginning of each search, if any.
    first: Vec<u8>,
    /// The number of error replies to the mouse and to strangers.
    pub(crate) errors: [usize; 2],
}

impl Model {
    /// Creates a simulator of this maze. `name` is the name of the maze.
    pub(crate) fn new(name: &str, maze: Maze) -> Self {
        Self {
            name: name.into(),
            maze,
            searches: vec![Search::default()],
            first: vec![],
            errors: [0; 2],
        }
    }

    /// Names the mouse at the beginning of each search.
    pub(crate) fn with_mouse(mut self, name: &str) -> Self {
        self.first = [&b"AM"[..], &[u8::try_from(name.len()).unwrap()], name.as_bytes()].concat();
        self.begin();
        self
    }

    fn begin(&mut self) {
        self.searches.push(Search::default());
        if !self.first.is_empty() {
            self.reply(&self.first.clone(), Some(0));
        }
    }

    /// Returns a simulator of a maze with random walls and the usual goal.
    pub(crate) fn random(name: &str, (width, height): (u8, u8), rng: &mut WyRand) -> Self {
        let size = MazeSize::new(width.into(), height.into()).unwrap();
        let mut walls = Walls::open(size);
        for wall in size.walls() {
            walls.set(wall.cell, wall.heading, rng.flip());
        }
        Self::new(name, Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap())
    }

    /// Returns the reply to a message: its envelope and the expected body. Returns `None` if the
    /// message has no body, and cannot be answered.
    pub(crate) fn answer(
        &mut self,
        frames: &[Vec<u8>],
        mouse: Option<usize>,
    ) -> Option<(Vec<Vec<u8>>, Expected)> {
        let delimiter = frames.iter().position(Vec::is_empty)?;
        let (envelope, body) = frames.split_at(delimiter + 1);
        let expected = match body {
            [] => return None,
            [request] => self.reply(request, mouse),
            _ => MALFORMED,
        };
        let is_error = matches!(expected, Expected::Error(_));
        self.errors[usize::from(mouse.is_none())] += usize::from(is_error);
        Some((envelope.to_vec(), expected))
    }

    /// Returns the reply to a request of the mouse, by the number of its connection, or of a stranger,
    /// who may only read.
    pub(crate) fn reply(&mut self, request: &[u8], mouse: Option<usize>) -> Expected {
        let (search, area) = (self.searches.last_mut().unwrap(), self.maze.size().area());
        let rules = Rules(self.maze.size());
        let ok = Expected::Bytes(b"ok".into());
        match request {
            b"ping" => return Expected::Bytes(b"pong".into()),
            b"info" => return Expected::Bytes(self.info().into()),
            [b'W', x, y, letter] => {
                let pose = rules.cell(*x, *y).zip(heading(*letter));
                let Some((cell, heading)) = pose else { return MALFORMED };
                let sides = [heading.left(), heading, heading.right()];
                if mouse.is_some() {
                    search.trailing.extend(sides.map(|side| Entry::Read(cell, side)));
                }
                let has_wall = |side| self.maze.walls().has(cell, side).into();
                return Expected::Bytes(sides.map(has_wall).into());
            }
            b"reset" if mouse.is_some() => self.begin(),
            b"reset" => {}
            [b'S', x, y, letter, order, matrices @ ..]
                if rules.cell(*x, *y).is_some()
                    && heading(*letter).is_some()
                    && matrices.len() == 2 * area + 1
                    && [*order, matrices[area]].iter().all(|order| b"CF".contains(order)) =>
            {
                if mouse.is_some() {
                    let entries = mem::take(&mut search.trailing);
                    search.notes.apply(&entries, self.maze.size());
                    search.states.push((entries, request.into()));
                    search.trailing_bytes.clear();
                }
            }
            [b'A', rest @ ..] if request.len() <= MAX_ANNOTATIONS_BYTES => {
                let Some(entries) = rules.entries(rest) else { return MALFORMED };
                if let Some(mouse) = mouse {
                    let bytes = &mut search.trailing_bytes;
                    let all = bytes.values().sum::<usize>() + rest.len();
                    let own = bytes.entry(mouse).or_default();
                    if *own + rest.len() > MAX_PENDING_BYTES[0] || all > MAX_PENDING_BYTES[1] {
                        return FULL;
                    }
                    search.trailing.extend(entries);
                    *own += rest.len();
                }
            }
            _ => return MALFORMED,
        }
        if mouse.is_some() { ok } else { REFUSED }
    }

    fn info(&self) -> String {
        let (size, Cell { x, y }) = (self.maze.size(), self.maze.start().cell);
        let goals = size.cells().filter(|cell| self.maze.goals().contains(*cell));
        let goals: Vec<_> = goals.map(|goal| format!("[{},{}]", goal.x, goal.y)).collect();
        [
            format!(r#"{{"maze":"{}","#, self.name),
            format!(r#""width":{},"height":{},"#, size.width(), size.height()),
            format!(r#""start":[{x},{y}],"heading":"N","goals":[{}],"#, goals.join(",")),
            format!(r#""states":{},"#, self.search().states.len()),
            r#""protocol":1,"extensions":["annotations"]}"#.into(),
        ]
        .concat()
    }

    /// Returns the search that continues.
    pub(crate) fn search(&self) -> &Search {
        self.searches.last().unwrap()
    }

    /// Returns the number of states and log lines in the recordings of this simulator.
    pub(crate) fn items(&self) -> usize {
        self.searches.iter().map(Search::items).sum()
    }

    /// Returns the number of states in the recordings of this simulator.
    pub(crate) fn states(&self) -> usize {
        self.searches.iter().map(|search| search.states.len()).sum()
    }

    /// Checks that these are the recordings of this simulator.
    #[track_caller]
    pub(crate) fn check<'r>(&self, recordings: impl IntoIterator<Item = &'r Recording>) {
        let mut recordings = recordings.into_iter();
        let mut next = 0;
        for search in self.searches.iter().filter(|search| !search.states.is_empty()) {
            next += 1;
            let recording = recordings.next().unwrap_or_else(|| panic!("no recording {next}"));
            assert_eq!(recording.maze(), Some(&self.maze));
            self.check_search(search, recording);
        }
        assert!(recordings.next().is_none(), "expected {next} recordings, found more");
    }

    #[track_caller]
    fn check_search(&self, search: &Search, recording: &Recording) {
        let (size, history) = (self.maze.size(), recording.history());
        let mut lines = search.check(history, size);
        let is_recorded = |entry: &&Entry| !matches!(entry, Entry::Read(..));
        let trailing: Vec<_> = search.trailing.iter().filter(is_recorded).collect();
        let mut notes = search.notes.clone();
        notes.apply(trailing.iter().copied(), size);
        notes.check(&recording.last_context(), size);
        let trailing = trailing.into_iter().filter_map(Entry::line);
        lines.extend(trailing.map(|line| (history.len(), line)));
        let mut found = recording.log();
        // The end of a run of the mouse is logged too.
        found.retain(|line| !line.text.starts_with("run end: "));
        assert!(found.iter().map(|line| (line.state, &line.text[..])).eq(lines), "{found:?}");
    }
}

/// The rules of requests for a maze of this size.
#[derive(Clone, Copy)]
struct Rules(MazeSize);

impl Rules {
    fn cell(self, x: u8, y: u8) -> Option<Cell> {
        (x < self.0.width() && y < self.0.height()).then(|| Cell::new(x, y))
    }

    /// Returns the annotations after the letter `A`, or `None` if they are invalid.
    fn entries(self, mut rest: &[u8]) -> Option<Vec<Entry>> {
        let mut entries = Vec::new();
        while !rest.is_empty() {
            let (entry, left) = self.entry(rest)?;
            entries.push(entry);
            rest = left;
        }
        (!entries.is_empty()).then_some(entries)
    }

    /// Returns the first annotation and the bytes after it.
    fn entry(self, bytes: &[u8]) -> Option<(Entry, &[u8])> {
        Some(match *bytes {
            [b'T', x, y, length, ref rest @ ..] => {
                let (text, rest) = text(rest, length.into(), false)?;
                let text = (text.chars().count() <= 10).then_some(text)?;
                (Entry::Text(self.cell(x, y)?, text), rest)
            }
            [b'C', x, y, colour, ref rest @ ..] if b"kbacgorwyBCAGORVY-".contains(&colour) => {
                (Entry::Colour(self.cell(x, y)?, colour), rest)
            }
            [b'D', x, y, side, state, ref rest @ ..] if b"10?-".contains(&state) => {
                (Entry::Wall(self.cell(x, y)?, heading(side)?, state), rest)
            }
            [b'L', low, high, ref rest @ ..] => {
                let length = usize::from(low) + 256 * usize::from(high);
                let (text, rest) = text(rest, (length <= 1000).then_some(length)?, true)?;
                (Entry::Line(text), rest)
            }
            [letter @ (b'M' | b'S'), length @ ..=100, ref rest @ ..] => {
                let (text, rest) = text(rest, length.into(), false)?;
                (Entry::Name(letter, text), rest)
            }
            [b'R', ref rest @ ..] => (Entry::Restart, rest),
            [letter @ (b't' | b'c' | b'd'), ref rest @ ..] => (Entry::Clear(letter), rest),
            _ => return None,
        })
    }
}

/// Returns a text of this length and the bytes after it, or `None` if the text is invalid.
fn text(bytes: &[u8], length: usize, has_tabs: bool) -> Option<(String, &[u8])> {
    let (text, rest) = bytes.split_at_checked(length)?;
    let text = str::from_utf8(text).ok()?;
    let is_printable = |c| match c {
        '\t' => has_tabs,
        '\0'..=' ' | '\u{7f}'..='\u{9f}' => c == ' ',
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' => false,
        _ => !('\u{2066}'..='\u{2069}').contains(&c),
    };
    text.chars().all(is_printable).then(|| (text.into(), rest))
}

fn heading(letter: u8) -> Option<Heading> {
    Heading::ALL.into_iter().find(|heading| heading.letter() == char::from(letter))
}
