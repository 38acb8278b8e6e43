//! Structural mutation of recordings: a recording is split into its MCAP records, which are changed.
//! Chunks, lengths and checksums are made consistent again unless they are the change.
//!
//! Every single change of representative records is tried, and then random combinations. A mutated
//! file must satisfy the invariants of the fuzz target, the states before the first change must be
//! read, and only duplicated states are read twice.

#[expect(unreachable_pub, reason = "the module is public in its own crate")]
#[path = "../../../../fuzz/src/recordings.rs"]
mod invariants;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Cursor, Write};
use std::sync::Arc;
use std::time::Instant;
use std::{fs, thread};

use mcap::records::op;
use mmsim_maze::WyRand;
use mmsim_recording::{Integrity, MemoryBudget, Recording};
use mmsim_tests::{ask, connect_to, within};

use crate::force;
use crate::harness::{Home, Output, limited, recorded};

const MAZE: &str = "o---o---o---o\n|     G |   |\no   o---o   o\n| S |       |\no---o---o---o\n";

/// The memory for the states of a mutated file.
const BUDGET_BYTES: usize = 1 << 20;

/// The limit of the address space of a command that reads a mutated file, in KiB, where the system has
/// such a limit. Decompression may use 16 MiB for earlier bytes.
const ADDRESS_SPACE_KIB: u64 = 400 << 10;

const SEED: u64 = 43;

#[derive(Clone)]
struct Record {
    kind: u8,
    /// The length that the record claims to have.
    length: u64,
    body: Vec<u8>,
    /// If this is less than the length of the record, the record and thus its container ends there.
    end: usize,
    /// The number of states in the record, counting those in a chunk.
    states: usize,
    /// True if the record is or contains the description of the maze or the maze.
    is_description: bool,
}

impl Record {
    fn new(kind: u8, body: Vec<u8>, states: usize) -> Self {
        let length = body.len() as u64;
        Self { kind, length, body, end: usize::MAX, states, is_description: false }
    }

    fn set_body(&mut self, body: Vec<u8>) {
        (self.length, self.body) = (body.len() as u64, body);
    }

    /// Returns the channel if this is a message.
    fn channel(&self) -> Option<[u8; 2]> {
        self.body.first_chunk().copied().filter(|_| self.kind == op::MESSAGE)
    }

    /// Returns the offsets and widths of the numbers in the body.
    fn numbers(&self) -> Vec<(usize, usize)> {
        // A digit is the width of a number, `s` is a string, and `m` a map of strings.
        let layout = match self.kind {
            op::HEADER => "ss",
            op::FOOTER => "884",
            op::SCHEMA => "2sss",
            op::CHANNEL => "22ssm",
            op::MESSAGE => "2488",
            op::CHUNK => "8884s8",
            op::STATISTICS => "824444884",
            op::METADATA => "sm",
            op::METADATA_INDEX => "88s",
            op::SUMMARY_OFFSET => "188",
            op::DATA_END => "4",
            _ => "",
        };
        let (mut at, mut numbers) = (0, Vec::new());
        for field in layout.replace('m', "4ssss").chars() {
            let width = field.to_digit(10).map_or(4, |width| width as usize);
            let Some(bytes) = self.body.get(at..at + width) else { break };
            numbers.push((at, width));
            if field == 's' {
                at += usize::from(bytes[0]) + 256 * usize::from(bytes[1]);
            }
            at += width;
        }
        numbers
    }
}

/// Splits a file or the content of a chunk into records, and replaces chunks by their records.
fn split(mut bytes: &[u8]) -> Vec<Record> {
    let mut records = Vec::new();
    while let Some((&[kind, ref length @ ..], rest)) = bytes.split_first_chunk::<9>() {
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap();
        let (body, rest) = rest.split_at(length);
        if kind == op::CHUNK {
            let (head, packed) = body.split_at(32 + 4 + 8);
            assert!(head[32..].starts_with(b"zstd"), "mmsim compresses with zstd");
            records.extend(split(&zstd::decode_all(packed).unwrap()));
        } else {
            records.push(Record::new(kind, body.to_vec(), 0));
        }
        bytes = rest;
    }
    records
}

/// Splits a file and marks its states. Removes the checksum of all data, which would only ever add
/// damage at the end.
fn split_file(file: &[u8]) -> Vec<Record> {
    let magic = mcap::MAGIC.len();
    let mut records =
        split(&file[magic..file.len() - magic * usize::from(file.ends_with(mcap::MAGIC))]);
    let is_states =
        |record: &&Record| record.kind == op::CHANNEL && record.body[8..].starts_with(b"/state");
    let states = records.iter().find(is_states).unwrap().body[..2].to_vec();
    for record in &mut records {
        record.states = usize::from(record.channel().is_some_and(|channel| channel == states[..]));
        record.is_description = match record.kind {
            op::METADATA => is_description(&record.body),
            op::MESSAGE => record.body[22..].starts_with(MAZE.as_bytes()),
            _ => false,
        };
        if record.kind == op::DATA_END {
            record.body.fill(0);
        }
    }
    records
}

/// Returns the bytes of a file or of the content of a chunk.
fn join(start: &[u8], records: &[Record]) -> Vec<u8> {
    let mut bytes = start.to_vec();
    for Record { kind, length, body, end, .. } in records {
        let record = [&[*kind], &length.to_le_bytes()[..], body].concat();
        bytes.extend(&record[..record.len().min(*end)]);
        if *end < record.len() {
            return bytes;
        }
    }
    // In a chunk and in a file that is being written, nothing follows the records.
    if records.last().is_some_and(|record| record.kind == op::FOOTER) {
        bytes.extend(mcap::MAGIC);
    }
    bytes
}

/// How the records of a file are stored: outside chunks, or in chunks with this compression and of
/// up to this number of records.
type Layout = Option<(&'static str, usize)>;

const LAYOUTS: [Layout; 4] = [None, Some(("", 10)), Some(("zstd", usize::MAX)), Some(("lz4", 25))];

fn compress(bytes: &[u8], compression: &str) -> Vec<u8> {
    match compression {
        "zstd" => zstd::bulk::compress(bytes, 1).unwrap(),
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
        _ => bytes.to_vec(),
    }
}

fn lay_out(records: &[Record], layout: Layout) -> Vec<Record> {
    let Some((compression, count)) = layout else { return records.to_vec() };
    let in_chunk = |record: &Record| matches!(record.kind, op::SCHEMA | op::CHANNEL | op::MESSAGE);
    let groups = records.chunk_by(|one, other| in_chunk(one) && in_chunk(other));
    let parts = groups.flat_map(|group| group.chunks(count));
    parts
        .map(|part| if in_chunk(&part[0]) { chunk(part, compression) } else { part[0].clone() })
        .collect()
}

fn count_states(records: &[Record]) -> usize {
    records.iter().map(|record| record.states).sum()
}

fn chunk(records: &[Record], compression: &str) -> Record {
    let content = join(b"", records);
    let packed = compress(&content, compression);
    let body = [
        &[0; 16],
        &(content.len() as u64).to_le_bytes()[..],
        &crc32fast::hash(&content).to_le_bytes(),
        &u32::try_from(compression.len()).unwrap().to_le_bytes(),
        compression.as_bytes(),
        &(packed.len() as u64).to_le_bytes(),
        &packed,
    ];
    let mut chunk = Record::new(op::CHUNK, body.concat(), count_states(records));
    chunk.is_description = records.iter().any(|record| record.is_description);
    chunk
}

/// A change at a record.
#[derive(Clone, Debug)]
enum Change {
    Drop,
    Repeat,
    /// Swaps the record with an earlier one.
    Swap(usize),
    Kind(u8),
    Length(u64),
    /// Changes the bytes at an offset.
    Bytes(usize, Vec<u8>),
    /// Changes the length of the body to this one, consistently.
    Resize(usize),
    Body(Vec<u8>),
    /// Ends the container, a file or a chunk, after this number of bytes of the record.
    End(usize),
}

impl Change {
    /// Makes the change. Returns the index of the first record that differs.
    fn apply(self, records: &mut Vec<Record>, at: usize) -> usize {
        let record = &mut records[at];
        match self {
            Self::Drop => drop(records.remove(at)),
            Self::Repeat => records.insert(at, records[at].clone()),
            Self::Swap(other) => {
                records.swap(at, other);
                return other;
            }
            Self::Kind(kind) => record.kind = kind,
            Self::Length(length) => record.length = length,
            Self::Bytes(offset, bytes) => {
                let places = record.body.iter_mut().skip(offset);
                places.zip(bytes).for_each(|(place, byte)| *place = byte);
            }
            Self::Resize(length) => {
                let mut body = record.body.clone();
                body.resize(length, 0x80);
                record.set_body(body);
            }
            Self::Body(body) => record.set_body(body),
            Self::End(length) => record.end = length,
        }
        at
    }
}

/// Returns wrong values instead of a number.
fn wrong_numbers(number: u64) -> [u64; 5] {
    [number.wrapping_add(1), number.wrapping_sub(1), 0, 1 << 63, u64::MAX]
}

/// Returns all changes at a record.
fn changes(records: &[Record], at: usize) -> Vec<Change> {
    let Record { kind, length, body, .. } = &records[at];
    let size = body.len();
    let mut all =
        vec![Change::Drop, Change::Repeat, Change::Swap(at.saturating_sub(1)), Change::Swap(0)];
    let kinds = [0, 1, 2, 3, 4, 5, 6, 9, 12, 15, 0x7f, 0xff];
    all.extend(kinds.into_iter().filter(|new| new != kind).map(Change::Kind));
    all.extend(wrong_numbers(*length).map(Change::Length));
    all.extend([0, 1, 8, 9, 10, size + 8].map(Change::End));
    all.extend([0, size / 2, size.saturating_sub(1), size + 1].map(Change::Resize));
    for (offset, width) in records[at].numbers() {
        let mut number = [0; 8];
        number[..width].copy_from_slice(&body[offset..offset + width]);
        let wrong = wrong_numbers(u64::from_le_bytes(number));
        all.extend(wrong.map(|wrong| Change::Bytes(offset, wrong.to_le_bytes()[..width].to_vec())));
    }
    match *kind {
        op::MESSAGE if size > 22 => {
            // Numbers of varying length in updates: none ends, or each is as long as it may be.
            let data = size - 22;
            all.push(Change::Bytes(22, vec![0xff; data]));
            let bytes = (22..size.min(60)).flat_map(|at| [0x80, 0xff].map(|byte| (at, byte)));
            all.extend(bytes.map(|(at, byte)| Change::Bytes(at, vec![byte])));
            let insert = |text: &[u8]| Change::Body([&body[..22], text].concat());
            all.extend(UPDATES.iter().map(|update| insert(update)));
            if body[22..].starts_with(b"o---o") {
                all.extend(MAZES.iter().map(|maze| insert(maze.as_bytes())));
                all.push(insert(MAZE.replace('G', "S").as_bytes()));
                all.push(insert(mmsim_mazes::HARBOUR.as_bytes()));
                all.push(insert(&b"o".repeat(70_000)));
            }
        }
        op::METADATA if is_description(body) => {
            all.extend(infos().iter().map(|info| Change::Body(metadata(info))));
        }
        op::CHUNK if size > 32 && size > 44 + usize::from(body[32]) => {
            let names = ["", "lz4", "zstd", "LZ4", "none", "\x1b[2J", "zstd\0"].map(str::as_bytes);
            let after = 36 + usize::from(body[32]);
            let with = |name: &[u8]| {
                let length = u32::try_from(name.len()).unwrap().to_le_bytes();
                Change::Body([&body[..32], &length, name, &body[after..]].concat())
            };
            all.extend(names.into_iter().chain([&[b'x'; 64][..], &[b'x'; 65]]).map(with));
            let first = after + 8;
            let bytes =
                (first..size.min(first + 20)).flat_map(|at| [0, 0x7f, 0xff].map(|byte| (at, byte)));
            all.extend(bytes.map(|(at, byte)| Change::Bytes(at, vec![byte])));
        }
        _ => {}
    }
    all
}

/// Updates and annotations with wrong counts, numbers and lengths.
const UPDATES: &[&[u8]] = &[
    b"",
    b"U",
    b"N",
    b"R\x02\x01",
    b"R\xff\xffN",
    b"T\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01",
    b"T\xff\xff\xff\xff\x0f\0\x01",
    b"T\x01\xff\xff\xff\xff\x0f\x01",
    b"T\x02\0\xff\xff\xff\xff\x0f\0\xff\xff\xff\xff\x0f",
    b"T\x02\0\xfe\xff\xff\xff\x0f\0\xfe\xff\xff\xff\x0f",
    b"T\x01\0\0\xff",
    b"C\x01\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01G",
    b"C\x02\x05G\xff\xff\xff\xff\x0fG",
    b"D\x02\0?\x0b?",
    b"D\x80\x80\x80\x80\x00",
    b"L\xff\xffx",
    b"M\xff",
    b"S\x01\xff",
    b"AL\0\0",
    b"A",
];

const MAZES: &[&str] = &[
    "",
    "o---o\n| S |\no---o\n",
    "o---o---o---o\n",
    "o---o---o---o\n|     G |   |\no   o---o   o\n| S |       |\no---o---o---\u{1b}\n",
];

fn is_description(metadata: &[u8]) -> bool {
    metadata.starts_with(b"\x05\0\0\0mmsim")
}

fn metadata(info: &str) -> Vec<u8> {
    let string =
        |text: &str| [&u32::try_from(text.len()).unwrap().to_le_bytes(), text.as_bytes()].concat();
    let map = [string("info"), string(info)].concat();
    [string("mmsim"), u32::try_from(map.len()).unwrap().to_le_bytes().to_vec(), map].concat()
}

/// Returns descriptions of the maze with one wrong value each.
fn infos() -> Vec<String> {
    let keys: &[(&str, &[&str])] = &[
        ("maze", &["\"\"", "\"\\u0000\\u001b[2J\\u2028\"", "7"]),
        ("width", &["0", "1", "2", "4", "32", "33", "255", "256", "-1", "1e9", "3.5", "null"]),
        ("height", &["0", "1", "32", "255", "18446744073709551616"]),
        ("start", &["[2,2]", "[255,255]", "[-1,0]", "[0]", "[0,0,0]", "[]"]),
        ("heading", &["\"X\"", "\"\"", "null"]),
        ("goals", &["[]", "[[9,9]]", "[[255,255]]", "[[0,0]]", "{}"]),
        ("states", &["-1", "1", "4294967295", "18446744073709551615", "1e300"]),
        ("protocol", &["-1", "2", "4294967296"]),
    ];
    let good = ["\"small\"", "3", "2", "[0,0]", "\"N\"", "[[1,1]]", "0", "1"];
    let mut infos = vec![String::new(), "{".into(), "[".repeat(10_000), "x".repeat(70_000)];
    for (changed, (_, values)) in keys.iter().enumerate() {
        infos.extend(values.iter().map(|value| {
            let with = |(index, (key, _)): (usize, &(&str, _))| {
                format!("\"{key}\":{}", if index == changed { value } else { good[index] })
            };
            format!("{{{}}}", keys.iter().enumerate().map(with).collect::<Vec<_>>().join(","))
        }));
    }
    infos
}

/// Returns false for a message of JSON, which mmsim does not read, and for one after at least two
/// others in the same channel.
fn is_representative(records: &[Record], at: usize) -> bool {
    let Some(channel) = records[at].channel() else { return true };
    let same = |record: &&Record| record.channel() == Some(channel);
    records[at].body[22] != b'{' && records[..at].iter().filter(same).count() < 2
}

/// Returns the records of a recording that is being written, and of the same recording after it was
/// packed.
fn recordings() -> [Vec<Record>; 2] {
    let home = Home::new();
    home.write("small.txt", MAZE);
    let mut server = home.serve(&["--port", "0", ".", "small", "--record", "kept"]);
    let client = connect_to(&server.address, zmq::REQ);
    let send =
        |request: &[u8]| assert_eq!(ask(&client, request), b"ok", "{}", request.escape_ascii());
    let poses = [*b"\0\0N", *b"\0\x01N", *b"\x01\x01E", *b"\0\x01W", *b"\0\0S"];
    for number in 0..20_u8 {
        let pose = poses[usize::from(number) % poses.len()];
        if number % 4 != 3 {
            let read = poses[usize::from(number / 2) % poses.len()];
            assert_ne!(ask(&client, &[b"W", &read[..]].concat()), b"ok");
        }
        match number % 5 {
            0 => send(b"AM\x05mouseS\x08strategyL\x02\0hi"),
            1 => send(b"AT\x02\x01\x03-99T\0\x01\x011C\x01\0GD\0\0E?"),
            2 => send(b"AtcdRT\x02\x01\x0210"),
            _ => {}
        }
        send(
            &[b"S", &pose[..], b"C", &[number; 6], b"C", &[0x0d, number % 16, 0, 0x1f, 2, 3]]
                .concat(),
        );
    }
    send(b"AL\x06\0RESULTT\x01\0\x03end");
    let path = recorded(&home.path().join("kept"));
    let running = fs::read(&path).unwrap();
    server.signal("TERM");
    server.wait();
    let packed = fs::read(&path).unwrap();
    let has_chunks = |file: &[u8]| file.windows(4).any(|bytes| bytes == b"zstd");
    assert!(!has_chunks(&running) && has_chunks(&packed));
    let [running, mut packed] = [running, packed].map(|file| split_file(&file));
    // The messages for other tools make up most of the file.
    let is_json = |record: &Record| record.channel().is_some() && record.body[22] == b'{';
    let end = packed.iter().rposition(is_json).unwrap() - 6;
    packed = packed
        .into_iter()
        .enumerate()
        .filter(|(at, it)| *at >= end || !is_json(it))
        .map(|it| it.1)
        .collect();
    [running, packed]
}

/// A file with changes, and what is known about them.
struct Mutant {
    records: Vec<Record>,
    /// The base, the layout and the changes.
    name: String,
    /// The number of states before the first change.
    intact: usize,
    /// False if the changes are after the description of the maze.
    may_be_refused: bool,
}

impl Mutant {
    fn new(records: &[Record], name: &str) -> Self {
        Self {
            records: records.to_vec(),
            name: name.into(),
            intact: usize::MAX,
            may_be_refused: false,
        }
    }

    fn change(&mut self, at: usize, change: Change) {
        let kind = self.records[at].kind;
        write!(self.name, ", record {at} of kind {kind}: {change:?}").unwrap();
        let mut is_description = self.records.iter().map(|record| record.is_description);
        let described = is_description.rposition(|it| it).map_or(0, |index| index + 1);
        let before: Vec<_> = self.records.iter().map(|record| record.states).collect();
        let first = change.apply(&mut self.records, at);
        self.intact = self.intact.min(before[..first].iter().sum());
        self.may_be_refused |= first < described;
    }

    /// Changes some records, and some records and chunks of the resulting file.
    fn random(records: &[Record], name: &str, seed: u64) -> Self {
        let mut rng = WyRand::new(seed);
        let mut mutant = Self::new(records, &format!("{name}, seed {seed}"));
        (0..rng.index(4)).for_each(|_| mutant.change_randomly(&mut rng));
        mutant.lay_out(LAYOUTS[rng.index(LAYOUTS.len())]);
        (0..=rng.index(2)).for_each(|_| mutant.change_randomly(&mut rng));
        mutant
    }

    fn change_randomly(&mut self, rng: &mut WyRand) {
        if !self.records.is_empty() {
            let at = rng.index(self.records.len());
            let mut all = changes(&self.records, at);
            self.change(at, all.swap_remove(rng.index(all.len())));
        }
    }

    fn lay_out(&mut self, layout: Layout) {
        write!(self.name, ", {layout:?}").unwrap();
        self.records = lay_out(&self.records, layout);
    }
}

/// The original states, the budget of all files, and the counted results.
struct Reader {
    states: Arc<Vec<Vec<u8>>>,
    budget: Arc<MemoryBudget>,
    /// True if recordings are also saved and read again, which takes longer.
    saves: bool,
    results: BTreeMap<&'static str, u32>,
}

impl Reader {
    fn read(&mut self, mutant: &Mutant) {
        let file = join(mcap::MAGIC, &mutant.records);
        let (states, budget) = (Arc::clone(&self.states), Arc::clone(&self.budget));
        let (saves, intact, max) = (self.saves, mutant.intact, count_states(&mutant.records));
        let name = Named(mutant.name.clone(), file.clone());
        let result = within(&mutant.name, move || {
            invariants::run(&file);
            let recording = match Recording::read_within(Cursor::new(&file), &budget) {
                Ok(recording) => recording,
                Err(error) => return Err(error.to_string()),
            };
            let read = recording.history().len();
            assert!(read <= max, "{read} states of {max}");
            let intact = intact.min(states.len());
            assert!(recording.history().iter().take(intact).eq(states[..intact].iter().cloned()));
            if !saves {
                return Ok(recording.integrity().clone());
            }
            let mut copy = Vec::new();
            recording.save(&mut copy, Some(mmsim_run::messages)).unwrap();
            let again = Recording::read_within(Cursor::new(copy), &budget).unwrap();
            assert!(again.history().iter().eq(recording.history().iter()));
            assert!(again.times().iter().eq(recording.times().iter()));
            assert_eq!(again.last_context(), recording.last_context());
            assert_eq!(again.log(), recording.log());
            Ok(recording.integrity().clone())
        });
        let result = match result {
            Ok(Integrity::Closed) => "closed",
            Ok(Integrity::Truncated { .. }) => "truncated",
            Ok(Integrity::Damaged { .. }) => "damaged",
            Err(error) => {
                assert!(mutant.may_be_refused, "refused: {error}");
                "refused"
            }
        };
        *self.results.entry(result).or_default() += 1;
        drop(name);
    }
}

/// If a check fails, prints the name of a mutated file and saves the file.
struct Named(String, Vec<u8>);

impl Drop for Named {
    fn drop(&mut self) {
        if thread::panicking() {
            let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/mutant.mcap");
            eprintln!("{}; see {path}: {:?}", self.0, fs::write(path, &self.1));
        }
    }
}

#[test]
fn mutated_recordings() {
    for (name, records) in ["running", "packed"].into_iter().zip(recordings()) {
        let file = join(mcap::MAGIC, &records);
        let states: Vec<_> = Recording::read(&file).unwrap().history().iter().collect();
        assert_eq!(states.len(), 20);
        let budget = Arc::new(MemoryBudget::new(BUDGET_BYTES));
        let mut reader =
            Reader { states: Arc::new(states), budget, saves: true, results: BTreeMap::new() };
        reader.saves = name == "running";
        let mut started = Instant::now();
        for layout in LAYOUTS {
            let mut mutant = Mutant::new(&records, name);
            mutant.lay_out(layout);
            reader.read(&mutant);
        }
        assert!(
            reader.results.values().sum::<u32>() == 4 && !reader.results.contains_key("damaged")
        );

        let mut layouts = LAYOUTS.into_iter().cycle();
        for at in (0..records.len()).filter(|&at| is_representative(&records, at)) {
            for (change, layout) in changes(&records, at).into_iter().zip(&mut layouts) {
                let mut mutant = Mutant::new(&records, name);
                mutant.change(at, change);
                mutant.lay_out(layout);
                reader.read(&mutant);
            }
        }
        println!(
            "{name}, each change of each record: {:?} {:?}",
            reader.results,
            started.elapsed()
        );
        started = Instant::now();
        for layout in &LAYOUTS[1..] {
            let laid_out = lay_out(&records, *layout);
            for at in (0..laid_out.len()).filter(|&at| laid_out[at].kind == op::CHUNK) {
                for change in changes(&laid_out, at) {
                    let mut mutant = Mutant::new(&laid_out, &format!("{name}, {layout:?}"));
                    mutant.change(at, change);
                    reader.read(&mutant);
                }
            }
        }
        println!("{name}, each change of each chunk: {:?} {:?}", reader.results, started.elapsed());
        started = Instant::now();
        reader.saves = true;
        for seed in SEED..SEED + 400 * force() as u64 {
            reader.read(&Mutant::random(&records, name, seed));
        }
        println!("{name}, random changes: {:?} {:?}", reader.results, started.elapsed());
    }
}

#[test]
fn commands_with_mutated_recordings() {
    let (home, mut codes) = (Home::new(), [0; 2]);
    let commands: [&[&str]; 6] = [
        &["replay", "a.mcap"],
        &["replay", "a.mcap", "--at", "3"],
        &["export", "a.mcap", "-o", "a.html"],
        &["export", "a.mcap", "-o", "b.mcap"],
        &["export", "a.mcap", "-o", "a.svg"],
        &["export", "a.mcap", "-o", "a.gif"],
    ];
    for (name, records) in ["running", "packed"].into_iter().zip(recordings()) {
        for seed in SEED..SEED + 12 * force() as u64 {
            let mutant = Mutant::random(&records, name, seed);
            home.write("a.mcap", join(mcap::MAGIC, &mutant.records));
            let command = commands[usize::try_from(seed).unwrap() % commands.len()];
            for arguments in [&["replay", "a.mcap", "--json"], command] {
                let limit = format!("-v {ADDRESS_SPACE_KIB}");
                let ended = Output::new(&mut limited(&home.command(arguments), &limit));
                let case = format!("{}: {arguments:?}: {ended:?}", mutant.name);
                match ended.code {
                    Some(0) if arguments.contains(&"--json") => drop(ended.json()),
                    Some(0) => {}
                    Some(1) => {
                        let starts = ["mmsim: ", "a.mcap: damaged after byte "];
                        let is_error = |line: &&str| starts.iter().any(|it| line.starts_with(it));
                        assert_eq!(ended.stderr.lines().filter(is_error).count(), 1, "{case}");
                        assert!(!ended.stderr.contains("panicked"), "{case}");
                    }
                    _ => panic!("{case}"),
                }
                codes[usize::from(ended.code != Some(0))] += 1;
            }
        }
    }
    println!("{codes:?} with exit code 0 and 1");
    assert!(codes.iter().all(|&count| count > 0), "both happen: {codes:?}");
}
