//! What a mouse displays at a state: texts, colours, declared walls and names.

use std::fmt;

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Wall, WallState};
use mmsim_protocol::{Annotation, Colour, MAX_TEXT_BYTES, colour_letter, wall_letter};

use crate::context::changes::{
    COLOURS, Change, Changes, MOUSE, STRATEGY, TEXTS, WALLS, put_difference, put_list, put_text,
};
use crate::context::update::{AnnotationList, Events};

/// The maximum lengths of encoded changes in bytes: of lists and names without their contents, of a
/// text without its characters, and of a colour or wall.
const LISTS_BYTES: usize = 20;
const TEXT_BYTES: usize = 7;
const VALUE_BYTES: usize = 3;

/// What a mouse displays at a state in addition to the state: a text and a colour for each cell,
/// declared walls, and its name and strategy. The mouse sends them as
/// [`Annotations`](mmsim_protocol::Annotations).
///
/// ```
/// use mmsim_maze::{Cell, MazeSize};
/// use mmsim_protocol::{Annotations, Colour};
/// use mmsim_recording::{History, UpdateTracker};
/// let size = MazeSize::new(1, 1)?;
/// let mut updates = UpdateTracker::default();
/// updates.annotate(Annotations::decode(b"AT\0\0\x0242C\0\0gM\x07Theseus", size)?)?;
/// let mut history = History::new(size);
/// history.push_with_update(updates.update(), b"S\0\0NC\0C\0")?;
///
/// let context = history.context(0).expect("a state with the index 0");
/// let notes = context.notes();
/// assert_eq!(notes.text(Cell::new(0, 0)), "42");
/// assert_eq!(notes.colour(Cell::new(0, 0)), Some(Colour::Green));
/// assert_eq!((notes.mouse(), notes.strategy()), (Some("Theseus"), None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notes {
    size: MazeSize,
    texts: Layer<Text>,
    colours: Layer<Option<Colour>>,
    /// The declared walls, indexed by [`MazeSize::wall_index`].
    walls: Layer<Option<WallState>>,
    mouse: String,
    strategy: String,
}

impl Notes {
    /// Creates the notes at the start of a run.
    pub(crate) const fn new(size: MazeSize) -> Self {
        Self {
            size,
            texts: Layer(Vec::new()),
            colours: Layer(Vec::new()),
            walls: Layer(Vec::new()),
            mouse: String::new(),
            strategy: String::new(),
        }
    }

    /// Returns the text of a cell, which is empty if the mouse displays none.
    pub fn text(&self, cell: Cell) -> &str {
        self.size.index(cell).and_then(|index| self.texts.0.get(index)).map_or("", Text::as_str)
    }

    /// Returns the colour of a cell.
    pub fn colour(&self, cell: Cell) -> Option<Colour> {
        self.size.index(cell).and_then(|index| self.colours.get(index))
    }

    /// Returns what the mouse declares about the wall on the `heading` side of a cell. Returns
    /// `None` if the mouse declares nothing, so the flags in its state apply.
    pub fn declared_wall(&self, cell: Cell, heading: Heading) -> Option<WallState> {
        self.size.wall_index(Wall::new(cell, heading)).and_then(|index| self.walls.get(index))
    }

    /// Returns the name of the mouse, if it has one.
    pub fn mouse(&self) -> Option<&str> {
        Some(&*self.mouse).filter(|name| !name.is_empty())
    }

    /// Returns the name of the strategy, if it has one.
    pub fn strategy(&self) -> Option<&str> {
        Some(&*self.strategy).filter(|name| !name.is_empty())
    }

    /// Returns true if the mouse displays nothing and has no name.
    pub fn is_empty(&self) -> bool {
        *self == Self::new(self.size)
    }

    /// Changes each declared wall of a map to the declaration.
    pub(crate) fn declare(&self, map: &mut KnownMaze) {
        if self.walls.0.is_empty() {
            return;
        }
        for Wall { cell, heading, .. } in self.size.inner_walls() {
            if let Some(state) = self.declared_wall(cell, heading) {
                map.set_wall(cell, heading, state);
            }
        }
    }

    /// Applies an annotation. Log lines, restarts and cells outside the maze have no effect.
    pub(crate) fn apply(&mut self, annotation: Annotation<'_>) {
        let area = self.size.area();
        match annotation {
            Annotation::Text { cell, text } => {
                if let (Some(index), Some(text)) = (self.size.index(cell), Text::new(text)) {
                    self.texts.set(index, text, area);
                }
            }
            Annotation::Colour { cell, colour } => {
                if let Some(index) = self.size.index(cell) {
                    self.colours.set(index, colour, area);
                }
            }
            Annotation::Wall { cell, heading, state } => {
                if let Some(index) = self.size.wall_index(Wall::new(cell, heading)) {
                    self.walls.set(index, state, 2 * area);
                }
            }
            Annotation::Log(_) | Annotation::Restart => {}
            Annotation::Mouse(name) => self.mouse = name.into(),
            Annotation::Strategy(name) => self.strategy = name.into(),
            Annotation::ClearTexts => self.texts.0.clear(),
            Annotation::ClearColours => self.colours.0.clear(),
            Annotation::ClearWalls => self.walls.0.clear(),
        }
    }

    /// Applies annotations. Skips texts, colours and walls that are cleared afterwards, because
    /// each clear and the next value fill the whole layer. Returns the other annotations.
    pub(crate) fn apply_all(&mut self, annotations: AnnotationList<'_>) -> Events {
        let (mut events, mut cleared) = (Events::default(), [0; 3]);
        for (index, annotation) in annotations.iter().enumerate() {
            match annotation {
                Annotation::Restart => events.has_restart = true,
                Annotation::Log(_) => events.lines += 1,
                Annotation::ClearTexts => cleared[0] = index,
                Annotation::ClearColours => cleared[1] = index,
                Annotation::ClearWalls => cleared[2] = index,
                _ => {}
            }
        }
        for (index, annotation) in annotations.iter().enumerate() {
            let last_clear = match annotation {
                Annotation::Text { .. } | Annotation::ClearTexts => cleared[0],
                Annotation::Colour { .. } | Annotation::ClearColours => cleared[1],
                Annotation::Wall { .. } | Annotation::ClearWalls => cleared[2],
                _ => 0,
            };
            if index >= last_clear {
                self.apply(annotation);
            }
        }
        events
    }

    /// Applies changes. Returns false if there are no changes of notes.
    pub(crate) fn apply_changes(&mut self, changes: Changes<'_>) -> bool {
        let (area, mut previous, mut has_changed) = (self.size.area(), 0, false);
        for change in changes.iter() {
            has_changed |=
                !matches!(change, Change::Other(Annotation::Log(_) | Annotation::Restart));
            match change {
                Change::Other(annotation) => self.apply(annotation),
                Change::Colour { cell, colour } => self.colours.set(cell, colour, area),
                Change::Wall { wall, state } => self.walls.set(wall, state, 2 * area),
                Change::Text { cell, text } => {
                    self.texts.set(cell, Text::new(text).unwrap_or_default(), area);
                }
                Change::Number { cell, difference } => {
                    let old = self.texts.0.get(cell).and_then(Text::number);
                    previous = old.unwrap_or(previous).wrapping_add(difference);
                    let text = Text::new(&previous.to_string()).unwrap_or_default();
                    self.texts.set(cell, text, area);
                }
            }
        }
        has_changed
    }

    /// Appends the changes from these notes to `next`.
    pub(crate) fn encode_changes(&self, next: &Self, to: &mut Vec<u8>) {
        let names = [(MOUSE, &self.mouse, &next.mouse), (STRATEGY, &self.strategy, &next.strategy)];
        for (letter, _, new) in names.into_iter().filter(|(_, old, new)| old != new) {
            to.push(letter);
            put_text(to, new);
        }
        let mut previous = 0;
        self.texts.encode_changes(&next.texts, TEXTS, to, |to, old, new| {
            if let Some(number) = new.number() {
                let base = old.number().unwrap_or(previous);
                previous = number;
                put_difference(to, number.wrapping_sub(base));
            } else {
                to.push(0);
                put_text(to, new.as_str());
            }
        });
        self.colours.encode_changes(&next.colours, COLOURS, to, |to, _, new| {
            to.push(colour_letter(*new));
        });
        self.walls.encode_changes(&next.walls, WALLS, to, |to, _, new| to.push(wall_letter(*new)));
    }

    /// Returns the maximum length of the changes from which these notes can be restored.
    pub(crate) fn max_bytes(&self) -> usize {
        let texts = self.texts.0.iter().map(|text| TEXT_BYTES + usize::from(text.length));
        let (colours, walls) = (self.colours.0.len(), self.walls.0.len());
        let names = self.mouse.len() + self.strategy.len();
        LISTS_BYTES + names + texts.sum::<usize>() + VALUE_BYTES * (colours + walls)
    }
}

/// A value for each cell or wall. The list is empty if all values are the default.
#[derive(Clone, Debug, Default)]
struct Layer<T>(Vec<T>);

impl<T: Copy + Default + PartialEq> Layer<T> {
    fn get(&self, index: usize) -> T {
        self.0.get(index).copied().unwrap_or_default()
    }

    /// Changes one of `length` values.
    fn set(&mut self, index: usize, value: T, length: usize) {
        if self.0.is_empty() && value != T::default() {
            self.0.resize(length, T::default());
        }
        if let Some(old) = self.0.get_mut(index) {
            *old = value;
        }
    }

    /// Appends the changes to `next`, which form the list with the letter `list`. `put` appends a
    /// value, given the old value and the new value.
    fn encode_changes(
        &self,
        next: &Self,
        list: u8,
        to: &mut Vec<u8>,
        mut put: impl FnMut(&mut Vec<u8>, T, &T),
    ) {
        let (empty, is_cleared) = (Self::default(), self.is_cheaper_to_clear(next));
        let old = if is_cleared { &empty } else { self };
        if is_cleared {
            to.push(list.to_ascii_lowercase());
        }
        let changes = old.changes(next).map(|(index, new)| (index, (old.get(index), new)));
        put_list(to, list, changes, |to, (old, new)| put(to, old, new));
    }

    /// Returns each value of `next` that differs from the old value, with its index. If `next` has no
    /// values, the old values must have been cleared.
    fn changes<'l>(&'l self, next: &'l Self) -> impl Iterator<Item = (usize, &'l T)> + Clone {
        let has_changed = |&(index, &value): &(usize, &T)| value != self.get(index);
        next.0.iter().enumerate().filter(has_changed)
    }

    /// Returns true if there are fewer changes to `next` if all values are cleared first.
    fn is_cheaper_to_clear(&self, next: &Self) -> bool {
        let is_set = |value: &&T| **value != T::default();
        if next.0.is_empty() {
            self.0.iter().any(|value| is_set(&value))
        } else {
            self.changes(next).count() > 1 + next.0.iter().filter(is_set).count()
        }
    }
}

impl<T: Copy + Default + PartialEq> PartialEq for Layer<T> {
    fn eq(&self, other: &Self) -> bool {
        let length = self.0.len().max(other.0.len());
        (0..length).all(|index| self.get(index) == other.get(index))
    }
}

impl<T: Copy + Default + Eq> Eq for Layer<T> {}

/// The text of a cell.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Text {
    pub(crate) length: u8,
    /// The text, followed by zeros.
    bytes: [u8; MAX_TEXT_BYTES],
}

impl Text {
    /// Returns `None` if the text is too long.
    pub(crate) fn new(text: &str) -> Option<Self> {
        let mut bytes = [0; MAX_TEXT_BYTES];
        bytes.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
        Some(Self { length: text.len().try_into().ok()?, bytes })
    }

    /// Returns the number that the text displays, or `None` if the text is not the decimal
    /// representation of a number.
    pub(crate) fn number(&self) -> Option<u32> {
        let digits = self.as_str();
        let is_decimal = digits.bytes().all(|byte| byte.is_ascii_digit());
        let has_leading_zero = digits.len() > 1 && digits.starts_with('0');
        if is_decimal && !has_leading_zero { digits.parse().ok() } else { None }
    }

    pub(crate) fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.length.into()).unwrap_or_default();
        str::from_utf8(bytes).unwrap_or_default()
    }
}

impl Default for Text {
    fn default() -> Self {
        Self { length: 0, bytes: [0; MAX_TEXT_BYTES] }
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_str().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, HashMap};
    use std::io::Cursor;

    use mmsim_protocol::{AnnotationWriter, Annotations, Info, MAX_ANNOTATIONS_BYTES, state_bytes};
    use proptest::prelude::*;

    use super::*;
    use crate::context::update::{TrailingAnnotations, UpdateTracker};
    use crate::history::History;
    use crate::history::block::Block;
    use crate::history::log::LogLine;
    use crate::recording::Recording;
    use crate::recording::save::save;

    fn size() -> MazeSize {
        MazeSize::new(4, 3).unwrap()
    }

    /// An annotation: its kind, cell, heading, text, and colour or wall.
    type Owned = (u8, Cell, Heading, String, usize);

    fn any_annotation() -> impl Strategy<Value = Owned> {
        let text = prop_oneof![
            3 => "[0-9]{1,4}",
            1 => "0{0,2}[0-9]{0,10}".prop_map(|digits| digits.chars().take(10).collect()),
            1 => "[a-z\u{221e}]{0,5}",
        ];
        (0u8..20, 0u8..4, 0u8..3, 0usize..4, text, 0usize..16).prop_map(
            |(kind, x, y, heading, text, value)| {
                (kind, Cell::new(x, y), Heading::ALL[heading], text, value)
            },
        )
    }

    fn annotation((kind, cell, heading, text, value): &Owned) -> Annotation<'_> {
        let (cell, heading) = (*cell, *heading);
        match kind {
            0 => Annotation::ClearTexts,
            1 => Annotation::ClearColours,
            2 => Annotation::ClearWalls,
            15 => Annotation::Restart,
            3 => Annotation::Mouse(text),
            4 => Annotation::Strategy(text),
            5 | 6 => Annotation::Log(text),
            7..=10 => Annotation::Colour { cell, colour: Colour::ALL.get(*value).copied() },
            11..=13 => {
                let states = [WallState::Present, WallState::Absent, WallState::Unknown];
                Annotation::Wall { cell, heading, state: states.get(value % 4).copied() }
            }
            _ => Annotation::Text { cell, text },
        }
    }

    /// Notes in maps, and all log lines.
    #[derive(Clone, Debug, Default)]
    struct Naive {
        texts: BTreeMap<Cell, String>,
        colours: BTreeMap<Cell, Colour>,
        walls: HashMap<(Cell, Heading), WallState>,
        names: [String; 2],
    }

    impl Naive {
        fn apply(&mut self, annotation: Annotation<'_>) {
            match annotation {
                Annotation::Text { cell, text } => drop(self.texts.insert(cell, text.into())),
                Annotation::Colour { cell, colour } => {
                    self.colours.remove(&cell);
                    self.colours.extend(colour.map(|colour| (cell, colour)));
                }
                Annotation::Wall { cell, heading, state } => {
                    let other = cell.neighbour(heading).map(|there| (there, heading.back()));
                    for side in [Some((cell, heading)), other].into_iter().flatten() {
                        self.walls.remove(&side);
                        let is_inner = size().neighbour(cell, heading).is_some();
                        self.walls.extend(state.filter(|_| is_inner).map(|state| (side, state)));
                    }
                }
                Annotation::Log(_) | Annotation::Restart => {}
                Annotation::Mouse(name) => self.names[0] = name.into(),
                Annotation::Strategy(name) => self.names[1] = name.into(),
                Annotation::ClearTexts => self.texts.clear(),
                Annotation::ClearColours => self.colours.clear(),
                Annotation::ClearWalls => self.walls.clear(),
            }
        }

        fn check(&self, notes: &Notes) {
            for cell in size().cells() {
                assert_eq!(notes.text(cell), self.texts.get(&cell).map_or("", String::as_str));
                assert_eq!(notes.colour(cell), self.colours.get(&cell).copied());
                for heading in Heading::ALL {
                    let wall = self.walls.get(&(cell, heading)).copied();
                    assert_eq!(notes.declared_wall(cell, heading), wall);
                }
            }
            let names = [notes.mouse(), notes.strategy()].map(Option::unwrap_or_default);
            assert_eq!(names, self.names.each_ref().map(String::as_str));
        }
    }

    fn annotate(updates: &mut UpdateTracker, list: &[Owned]) {
        for owned in list {
            let mut buffer = [0; MAX_ANNOTATIONS_BYTES];
            let mut writer = AnnotationWriter::new(&mut buffer);
            writer.push(annotation(owned)).unwrap();
            let request = Annotations::decode(writer.finish().unwrap(), size()).unwrap();
            updates.annotate(request).unwrap();
        }
    }

    fn check(history: &History, frames: &[Naive], lines: &[LogLine]) {
        for (block, frames) in frames.chunks(Block::STATES).enumerate() {
            let states = history.block(block).unwrap().unpack().unwrap();
            for (index, frame) in (block * Block::STATES..).zip(frames) {
                frame.check(states.context(index).unwrap().notes());
            }
        }
        frames.last().unwrap().check(history.newest_context().notes());
        for last in (0..frames.len()).step_by(37) {
            for (max, filter) in [(usize::MAX, ""), (3, "1"), (1, "none")] {
                let matching = |line: &&LogLine| line.state <= last && line.text.contains(filter);
                let all: Vec<_> = lines.iter().filter(matching).cloned().collect();
                let expected = &all[all.len().saturating_sub(max)..];
                assert_eq!(history.log(last, max, |text| text.contains(filter)), expected);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]
        #[test]
        fn histories_and_recordings_equal_a_list_of_frames(
            steps in prop::collection::vec(
                (prop::collection::vec(any_annotation(), 0..12), 1usize..120),
                1..20,
            ),
            is_undone in any::<bool>(),
        ) {
            let state = [b"S\x01\x01NC".to_vec(), vec![0; 12], vec![b'C'], vec![1; 12]].concat();
            assert_eq!(state.len(), state_bytes(size()));
            let (mut history, mut updates) = (History::new(size()), UpdateTracker::default());
            let (mut frame, mut frames, mut lines) = (Naive::default(), vec![], vec![]);
            for (list, repeats) in &steps {
                annotate(&mut updates, list);
                for owned in list {
                    frame.apply(annotation(owned));
                    if let Annotation::Log(text) = annotation(owned) {
                        lines.push(LogLine { state: frames.len(), text: text.into() });
                    }
                }
                for _ in 0..*repeats {
                    if is_undone {
                        history.push_with_update(updates.update(), &state).unwrap();
                        updates.report();
                        history.undo_push();
                        updates.undo_report();
                    }
                    history.push_with_update(updates.update(), &state).unwrap();
                    updates.report();
                    frames.push(frame.clone());
                }
            }
            check(&history, &frames, &lines);
            let blocks = (0..).map_while(|block| history.block(block)?.unpack());
            let states: Vec<_> = blocks.flat_map(|states| {
                let range = states.first..states.first + states.len();
                let all = range.map(|at| (0, states.update(at).unwrap().to_vec(), state.clone()));
                all.collect::<Vec<_>>()
            }).collect();
            let goals = size().central_cells();
            let start = mmsim_maze::Pose::new(Cell::new(0, 0), Heading::North);
            let (mut file, info) = (Cursor::new(vec![]), Info::new("a", size(), start, &goals, 0));
            save(&mut file, &info, None, states, &TrailingAnnotations::default()).unwrap();
            let recording = Recording::read(&file.into_inner()[..]).unwrap();
            check(recording.history(), &frames, &lines);
            prop_assert_eq!(recording.history().bytes(), history.bytes());
        }
    }

    #[test]
    fn annotations_without_effect_need_no_memory() {
        let (mut history, mut updates) = (History::new(size()), UpdateTracker::default());
        let state = [b"S\x01\x01NC".to_vec(), vec![0; 12], vec![b'C'], vec![1; 12]].concat();
        let cell = Cell::new(2, 1);
        let numbers: Vec<_> =
            size().cells().map(|cell| (14, cell, Heading::North, cell.x.to_string(), 0)).collect();
        let clear = (0, cell, Heading::North, String::new(), 0);
        annotate(&mut updates, &numbers);
        history.push_with_update(updates.update(), &state).unwrap();
        updates.report();
        assert!(history.newest_update().len() < 60);
        annotate(&mut updates, std::slice::from_ref(&clear));
        annotate(&mut updates, &numbers);
        history.push_with_update(updates.update(), &state).unwrap();
        updates.report();
        assert_eq!(history.newest_update(), b"");
        annotate(&mut updates, &[clear.clone(), numbers[7].clone()]);
        history.push_with_update(updates.update(), &state).unwrap();
        updates.report();
        assert!(history.newest_update().starts_with(b"tT\x01"));
        annotate(&mut updates, &[clear.clone(), clear]);
        history.push_with_update(updates.update(), &state).unwrap();
        assert_eq!(history.newest_update(), b"t");
        assert!(history.newest_context().notes().is_empty());
    }

    #[test]
    fn long_logs_are_compressed_within_a_block() {
        let (mut history, mut updates) = (History::new(size()), UpdateTracker::default());
        let state = [b"S\x01\x01NC".to_vec(), vec![0; 12], vec![b'C'], vec![1; 12]].concat();
        let line = "x".repeat(1000);
        let lines = vec![(5, Cell::new(0, 0), Heading::North, line.clone(), 0); 64];
        for _ in 0..100 {
            annotate(&mut updates, &lines);
            history.push_with_update(updates.update(), &state).unwrap();
            updates.report();
        }
        assert!(history.bytes() < 1 << 20, "{} bytes", history.bytes());
        let log = history.log(50, 100, |_| true);
        let states: Vec<_> = log.iter().map(|line| line.state).collect();
        assert_eq!(states, [vec![49; 36], vec![50; 64]].concat());
        assert!(log.iter().all(|found| found.text == line));
    }

    #[test]
    fn only_decimal_numbers_are_numbers() {
        let number = |text: &str| Text::new(text).unwrap().number();
        for n in [0, 7, 10, 2000, u32::MAX] {
            assert_eq!(number(&n.to_string()), Some(n));
        }
        for text in ["", "00", "07", "+7", "-7", "7 ", "4294967296", "\u{221e}", "a"] {
            assert_eq!(number(text), None, "{text:?}");
        }
        assert_eq!(Text::new(&"x".repeat(MAX_TEXT_BYTES)).unwrap().as_str().len(), MAX_TEXT_BYTES);
        assert_eq!(Text::new(&"x".repeat(MAX_TEXT_BYTES + 1)), None);
    }

    #[test]
    fn layers_are_equal_if_their_values_are() {
        let (mut layer, empty) = (Layer::default(), Layer::default());
        layer.set(3, 0, 5);
        assert!(layer.0.is_empty());
        layer.set(3, 7, 5);
        assert_ne!(layer, empty);
        assert_eq!((layer.get(3), layer.get(4), layer.get(9)), (7, 0, 0));
        assert!(layer.is_cheaper_to_clear(&empty) && !empty.is_cheaper_to_clear(&layer));
        assert!(empty.changes(&layer).eq([(3, &7)]));
        layer.set(3, 0, 5);
        assert!(layer == empty && !layer.is_cheaper_to_clear(&empty));
    }
}
