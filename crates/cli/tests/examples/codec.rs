//! Comparing the C codec with `mmsim-protocol`, byte by byte.

use std::fs::File;
use std::process::Stdio;

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Pose, Wall, WallState};
use mmsim_protocol::{
    Annotation, AnnotationWriter, CellWalls, Colour, MAX_STATE_BYTES, MapState, Order, Reply,
    Request, state_bytes,
};
use mmsim_tests::wait_with_output;

use crate::client;
use crate::harness::Home;

/// The input for `codec.c` and its expected output.
#[derive(Default)]
struct Tasks {
    input: Vec<u8>,
    expected: Vec<u8>,
}

impl Tasks {
    /// Adds a task to encode a request into a buffer of `capacity` bytes. If the request does not
    /// fit in the buffer, `expected` must be empty.
    fn request(&mut self, task: u8, capacity: usize, arguments: &[u8], expected: &[u8]) {
        self.input.push(task);
        self.input.extend(number(capacity));
        self.input.extend(arguments);
        self.expected.extend(number(expected.len()));
        self.expected.extend(expected);
        self.expected.push(1); // the rest of the buffer is unchanged
    }

    /// Adds two tasks to encode a request: into a buffer of exactly its size, and into a buffer
    /// that is one byte too small.
    fn both(&mut self, task: u8, arguments: &[u8], expected: &[u8]) {
        self.request(task, expected.len(), arguments, expected);
        self.request(task, expected.len() - 1, arguments, &[]);
    }

    fn reply(&mut self, message: &[u8]) {
        self.input.push(b'?');
        self.input.extend(number(message.len()));
        self.input.extend(message);
        let (head, text) = match Reply::decode(message) {
            Ok(Reply::Pong) => ([1, 0, 0, 0], ""),
            Ok(Reply::Ok) => ([2, 0, 0, 0], ""),
            Ok(Reply::Walls(around)) => {
                let [left, front, right] = [around.left, around.front, around.right].map(u8::from);
                ([3, left, front, right], "")
            }
            Ok(Reply::Error(reason)) => ([4, 0, 0, 0], reason),
            _ => ([0; 4], ""),
        };
        self.expected.extend(head);
        self.expected.push(u8::try_from(text.len()).unwrap());
        self.expected.extend(text.as_bytes());
    }

    /// Asserts that `codec.c` gives the expected output when compiled as C and as C++.
    fn check(self) {
        for (name, language) in client::COMPILERS {
            let home = Home::new();
            let Some(mut program) = client::with_header(name, language, "codec.c", &home) else {
                continue;
            };
            let input = File::open(home.write("tasks", &self.input)).unwrap();
            let output =
                wait_with_output(program.stdin(input).stdout(Stdio::piped()).spawn().unwrap());
            assert!(output.status.success());
            assert!(output.stdout == self.expected, "different bytes with {name}");
        }
    }
}

fn number(value: usize) -> [u8; 2] {
    u16::try_from(value).unwrap().to_be_bytes()
}

/// Returns a partly explored map with present, absent and unknown walls.
fn map(size: MazeSize) -> KnownMaze {
    let mut map = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
    for cell in size.cells() {
        if (5 * cell.x + 3 * cell.y).is_multiple_of(3) {
            map.visit(cell);
        }
    }
    for Wall { cell, heading, .. } in size.inner_walls() {
        let is_present = (5 * cell.x + 3 * cell.y + heading as u8).is_multiple_of(4);
        let state = if is_present { WallState::Present } else { WallState::Absent };
        map.set_wall(cell, heading, state);
    }
    map
}

fn weight(cell: Cell) -> u16 {
    17 * u16::from(cell.x) + 90 * u16::from(cell.y)
}

#[test]
fn states_of_every_size_and_order() {
    let mut tasks = Tasks::default();
    for (width, height) in (1..=32).flat_map(|width| (1..=32).map(move |height| (width, height))) {
        let size = MazeSize::new(width, height).unwrap();
        let map = map(size);
        let heading = Heading::ALL[(width + height) % 4];
        let pose = Pose::new(Cell::new(size.width() - 1, size.height() / 2), heading);
        for (order, letter) in [(Order::C, b'C'), (Order::F, b'F')] {
            let Pose { cell, heading } = pose;
            let head = [size.width(), size.height(), cell.x, cell.y, heading as u8, letter];
            let mut arguments = head.to_vec();
            for cell in size.cells() {
                arguments.extend(number(weight(cell).into()));
                arguments.push(CellWalls::known(&map, cell).0);
            }
            let mut buffer = [0; MAX_STATE_BYTES];
            let length = MapState::new(pose, &map, weight, order).encode(&mut buffer).unwrap();
            tasks.request(b's', length, &arguments, &buffer[..length]);
            tasks.request(b's', length - 1, &head, &[]);
        }
    }
    tasks.check();
}

#[test]
fn requests_without_a_matrix() {
    let mut tasks = Tasks::default();
    tasks.both(b'p', &[], b"ping");
    tasks.both(b'r', &[], b"reset");
    tasks.both(b'e', &[], b"info");
    for heading in Heading::ALL {
        let mut message = [0; 4];
        Request::Walls(Pose::new(Cell::new(31, 7), heading)).encode(&mut message).unwrap();
        tasks.both(b'w', &[31, 7, heading as u8], &message);
    }
    tasks.check();
}

/// Returns the arguments with which `codec.c` appends an annotation.
fn arguments(annotation: Annotation<'_>) -> Vec<u8> {
    match annotation {
        Annotation::Text { cell, text } => {
            [&[b'T', cell.x, cell.y], text.as_bytes(), b"\0"].concat()
        }
        Annotation::Colour { cell, colour } => {
            vec![b'C', cell.x, cell.y, colour.map_or(b'-', |colour| colour.letter() as u8)]
        }
        Annotation::Wall { cell, heading, state } => {
            let state = match state {
                Some(WallState::Present) => b'1',
                Some(WallState::Absent) => b'0',
                Some(WallState::Unknown) => b'?',
                None => b'-',
            };
            vec![b'D', cell.x, cell.y, heading as u8, state]
        }
        Annotation::Log(text) => [b"L", text.as_bytes(), b"\0"].concat(),
        Annotation::Mouse(text) => [b"M", text.as_bytes(), b"\0"].concat(),
        Annotation::Strategy(text) => [b"S", text.as_bytes(), b"\0"].concat(),
        Annotation::Restart => b"R".to_vec(),
        Annotation::ClearTexts => b"t".to_vec(),
        Annotation::ClearColours => b"c".to_vec(),
        Annotation::ClearWalls => b"d".to_vec(),
    }
}

/// Annotations of every kind, among them the longest texts and texts that are invalid.
fn annotations(long: &[String; 4], cell: Cell) -> Vec<Annotation<'_>> {
    let [text, name, line, too_long] = long;
    let mut annotations = vec![
        Annotation::Text { cell, text: "1024" },
        Annotation::Text { cell, text: "" },
        Annotation::Text { cell, text },
        Annotation::Text { cell, text: "12345678901" },
        Annotation::Text { cell, text: "a\tb" },
        Annotation::Text { cell, text: too_long },
        Annotation::Colour { cell, colour: None },
        Annotation::Log("wall\tahead \u{e4}"),
        Annotation::Log(line),
        Annotation::Log("a\nb"),
        Annotation::Log(too_long),
        Annotation::Mouse("Theseus"),
        Annotation::Strategy(name),
        Annotation::Mouse(line),
        Annotation::Text { cell, text: "a\u{85}" },
        Annotation::Text { cell, text: "\u{a0}\u{7ff}\u{800}\u{d7ff}\u{e000}\u{ffff}\u{10000}" },
        Annotation::Mouse("\u{202e}"),
        Annotation::Strategy("a\u{2066}b"),
        Annotation::Log("\u{61c}"),
        Annotation::Log("a\u{2028}"),
        Annotation::Log("\u{2027}\u{202f}\u{206a}"),
        Annotation::Log("\u{200f}"),
        Annotation::Log("\u{7f}"),
        Annotation::Restart,
        Annotation::ClearTexts,
        Annotation::ClearColours,
        Annotation::ClearWalls,
    ];
    let colours = Colour::ALL.map(|colour| Annotation::Colour { cell, colour: Some(colour) });
    annotations.extend(colours);
    for heading in Heading::ALL {
        let states = [WallState::Present, WallState::Absent, WallState::Unknown];
        let states = states.map(Some).into_iter().chain([None]);
        annotations.extend(states.map(|state| Annotation::Wall { cell, heading, state }));
    }
    annotations
}

#[test]
fn annotations_of_every_kind() {
    let mut tasks = Tasks::default();
    let long = ["\u{10ffff}".repeat(10), "n".repeat(100), "l".repeat(1000), "x".repeat(1001)];
    let all = annotations(&long, Cell::new(31, 7));
    for (capacity, annotations) in all
        .chunks(9)
        .map(|chunk| (5000, chunk))
        .chain(all.iter().map(|one| (5000, std::slice::from_ref(one))))
        .chain((0..60).map(|capacity| (capacity, &all[..9])))
    {
        let mut buffer = vec![0; capacity];
        let mut writer = AnnotationWriter::new(&mut buffer);
        let mut task = vec![u8::try_from(annotations.len()).unwrap()];
        let mut is_begun = false;
        for &annotation in annotations {
            let is_valid = AnnotationWriter::new(&mut [0; 5000]).push(annotation).is_ok();
            let is_pushed = writer.push(annotation).is_ok();
            is_begun |= is_pushed;
            tasks.expected.push(match (is_pushed, is_begun, is_valid) {
                (true, ..) => b'+',
                (_, false, _) => b'0',
                (.., true) => b'f',
                (.., false) => b'-',
            });
            task.extend(arguments(annotation));
        }
        tasks.request(b'a', capacity, &task, writer.finish().unwrap_or_default());
    }
    tasks.check();
}

#[test]
fn invalid_utf_8_is_refused() {
    let mut tasks = Tasks::default();
    for text in [
        &b"\xff"[..],
        b"a\x80",
        b"\xc0\xaf",
        b"\xc1\xbf",
        b"\xe0\x9f\xbf",
        b"\xe2\x82",
        b"\xe2\x82a",
        b"\xed\xa0\x80",
        b"\xf0\x8f\xbf\xbf",
        b"\xf4\x90\x80\x80",
        b"\xf8\x88\x80\x80\x80",
    ] {
        assert!(str::from_utf8(text).is_err());
        tasks.expected.push(b'0');
        tasks.request(b'a', 99, &[b"\x01M", text, b"\0"].concat(), &[]);
    }
    tasks.check();
}

#[test]
fn the_extension_is_found_in_info() {
    let mut tasks = Tasks::default();
    for (info, expected) in [
        (r#"{"maze":"a","protocol":1,"extensions":["annotations"]}"#, 1),
        (r#"{"maze":"a","protocol":1,"extensions":["more","annotations"]}"#, 1),
        (r#"{"maze":"annotations","protocol":1,"extensions":[]}"#, 0),
        (r#"{"maze":"a","extensions":["more"],"x":"annotations"}"#, 0),
        (r#"{"maze":"annotations","protocol":1}"#, 0),
        ("", 0),
    ] {
        tasks.input.push(b'i');
        tasks.input.extend(number(info.len()));
        tasks.input.extend(info.as_bytes());
        tasks.expected.push(expected);
    }
    tasks.check();
}

#[test]
fn out_of_range_requests() {
    let mut tasks = Tasks::default();
    tasks.request(b'w', 99, &[0, 0, 4], &[]);
    let room = state_bytes(MazeSize::HALF_SIZE);
    for wrong in [
        [0, 1, 0, 0, 0, b'C'],
        [33, 1, 0, 0, 0, b'C'],
        [1, 33, 0, 0, 0, b'C'],
        [3, 2, 3, 0, 0, b'C'],
        [3, 2, 0, 2, 0, b'C'],
        [3, 2, 0, 0, 4, b'C'],
        [3, 2, 0, 0, 0, b'X'],
    ] {
        tasks.request(b's', room, &wrong, &[]);
    }
    tasks.check();
}

#[test]
fn valid_and_invalid_replies() {
    let mut tasks = Tasks::default();
    for bits in 0..8 {
        tasks.reply(&[bits & 1, bits >> 1 & 1, bits >> 2]);
    }
    for message in ["pong", "ok", "error: expected one frame, found 2", "error: ", "{}", ""] {
        tasks.reply(message.as_bytes());
        // Replies are truncated at every length, have trailing bytes, or have another first byte.
        for length in 0..message.len() {
            tasks.reply(&message.as_bytes()[..length]);
        }
        tasks.reply(format!("{message} ").as_bytes());
        tasks.reply(format!("x{message}").as_bytes());
    }
    for rubbish in [&[0, 1, 2][..], &[0, 0], &[0, 0, 0, 0], &[255; 3], &[0; 2000], b"OK"] {
        tasks.reply(rubbish);
    }
    tasks.check();
}
