//! Writes the seed corpus of the fuzz targets. Run `seeds CORPUS` from the root folder of the
//! project.
//!
//! The seeds are made from the bundled mazes and, if available, from the mazes and transcripts
//! in `../shared`. A transcript contains the requests that a client sent to a server, and the
//! replies.

use std::ffi::OsStr;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::{env, fs};

use mcap::read::LinearReader;
use mcap::records::Record;
use mcap::{Compression, McapError, MessageStream, WriteOptions};
use mmsim_formats::Format;
use mmsim_fuzz::requests::{self, SIZES};
use mmsim_fuzz::zmtp::WITH_HANDSHAKE;
use mmsim_recording::RecordingWriter;
use mmsim_server::Simulation;
use serde_json::Value;
use walkdir::WalkDir;

// The compiler flags of the targets require this runtime.
use libfuzzer_sys as _;

/// The number of consecutive transcript requests per input.
const REQUESTS_PER_INPUT: usize = 8;

/// The maximum number of inputs from one transcript. From a longer transcript, inputs are selected
/// at regular intervals.
const INPUTS_PER_EXCHANGE: usize = 16;

/// Mazes in every notation, some of them ambiguous or decorated.
const MAZES: [&str; 24] = [
    "o---o\n| S |\no---o\n",
    "o---o\n|SG |\no---o\n",
    "#######\n#  G G#\n# ### #\n#S#   #\n#######\n",
    "+--+--+\n|S    |\n+  +  +\n|G |  |\n+--+--+\n",
    "\u{feff}·-·-·\r\n|  G|\r\n\r\n· ·-·\n|S  |\n·-·-·\nofficial\n|",
    "2\n1,3\n4,12\n",
    "4\n1,7,5,4\n2,10,3,6\n11,13,14,8\n9,5,13,4\n",
    "0 0 0 1 1 1\n0 1 1 0 0 1\n1 0 0 1 1 1\n1 1 1 1 0 0\n",
    "8,2,7\n9,9,9\n11,5,6\n",
    "8.0 7.000000000000000000e+00\n5.0 6.0\n",
    "9553\na93a\naaaa\nec46\n",
    "0x9, 0x3,\n0xe, 0xe,\n",
    "0x\n",
    "{0x}\n",
    "+---+---+\n| S . G |\n+ . +   +\n|   |   |\n+---+---+\n",
    "OSHWDEM Maze Generator\n+---+---+---+\n| A |       |\n+   +   B   +\n|   |   |   |\n\
     +   +   +   +\n|           |\n+---+---+---+\n",
    "Japan 1987\n\n o---o---o\n1|   : g |  row 1\n.   o   o\n0| s 7   |\no---o---o\n  0   1\n",
    "┌───┬───┐\n│ S │ G │\n├   ╵   ┤\n│       │\n└───┴───┘\n",
    "bf\nab\nee\n",
    "93\nC6\n\n0,0\n1,1\nES\n",
    "/* a maze */\nuint8_t m[4] PROGMEM = {\n0x09, 0x03,\n0x0C, 0x06,\n};\nint n[2] = {1, 2};\n",
    "{\"maze\": [[9,3],[12,6]]}",
    "  cell  ,E,W,N,S\n\"(1, 1)\",1,0,0,1\n\"(2, 1)\",1,0,1,0\n\"(1, 2)\",0,1,0,1\n\"(2, 2)\",0,1,1,0\n",
    "2 2\n0xf9 0xf3\n0xfc 0xf6\n",
];

fn main() -> io::Result<()> {
    let Some(corpus) = env::args_os().nth(1).map(PathBuf::from) else {
        return Err(io::Error::other("usage: seeds CORPUS"));
    };
    let shared = Path::new("../shared");
    let mut seeds = SeedFolder::create(&corpus.join("mazes"))?;
    for maze in MAZES {
        seeds.write(maze.as_bytes())?;
    }
    for (_, content) in mmsim_mazes::FILES {
        write_maze(&mut seeds, content.as_bytes())?;
    }
    for file in files(&shared.join("mazes"), "txt") {
        write_maze(&mut seeds, &fs::read(file)?)?;
    }
    let mut seeds = SeedFolder::create(&corpus.join("requests"))?;
    write_generated_requests(&mut seeds)?;
    for file in files(&shared.join("transcripts"), "jsonl") {
        write_exchange(&mut seeds, &fs::read_to_string(file)?)?;
    }
    write_streams(&mut SeedFolder::create(&corpus.join("zmtp"))?)?;
    write_recordings(&mut SeedFolder::create(&corpus.join("recordings"))?)
}

/// Writes a maze file as it is and, if possible, in the `maz` format.
fn write_maze(seeds: &mut SeedFolder, content: &[u8]) -> io::Result<()> {
    if let Ok(Ok(bytes)) = mmsim_formats::parse_maze(content).map(|maze| Format::Maz.write(&maze)) {
        seeds.write(&bytes)?;
    }
    seeds.write(content)
}

/// Returns all files with this extension in a folder and its subfolders. Returns no files if the
/// folder does not exist.
fn files(folder: &Path, extension: &str) -> impl Iterator<Item = PathBuf> {
    let files = WalkDir::new(folder).sort_by_file_name().into_iter().flatten();
    let extension = OsStr::new(extension).to_owned();
    files.map(walkdir::DirEntry::into_path).filter(move |path| path.extension() == Some(&extension))
}

/// Writes inputs for each maze size, with a limited and an unlimited history. The inputs contain
/// valid and malformed requests of every kind, and enough states to fill a compressed block of the
/// history.
fn write_generated_requests(seeds: &mut SeedFolder) -> io::Result<()> {
    let short: [&[u8]; 10] =
        [b"", b"ping", b"PING", b"info", b"reset", b"W", b"W\0", b"W\0\0", b"W\0\0N", b"W\0\0NN"];
    for (number, (width, height)) in (0..).zip(SIZES.into_iter().chain(SIZES)) {
        seeds.write_requests(number, short)?;
        let state_bytes = 6 + 2 * usize::from(width) * usize::from(height);
        for heading in *b"NESWX\0" {
            let last = [b'W', width - 1, height - 1, heading];
            let outside = [[b'W', width, 0, heading], [b'W', 0, height, heading]];
            seeds.write_requests(number, [&last[..], &outside[0], &outside[1]])?;
        }
        let mut state = vec![b'C'; state_bytes];
        state[..4].copy_from_slice(b"S\0\0N");
        for order in *b"CFZ" {
            let mut state = vec![order; state_bytes];
            state[..5].copy_from_slice(&[b'S', width - 1, 0, b'E', order]);
            let longer = [&state[..], b"\0"].concat();
            seeds.write_requests(number, [&state[..], &state[1..], &state[..6], &longer])?;
        }
        let annotations: [&[u8]; 8] = [
            b"A",
            b"AX",
            b"AT\0\0\x041024C\0\0GD\0\0E?L\x02\0hiM\x01mS\x01s",
            b"AT\0\0\0C\0\0-D\0\0E-",
            b"Atcd",
            b"AT\0\0\x03\xe2\x88\x9e",
            b"AL\xff\xff",
            &state,
        ];
        seeds.write_requests(number, annotations)?;
        let pieces: [(&[u8], u8); 4] =
            [(b"S\0\0NC\0\x01\x02F", 255), (b"S\0\0SFF", 40), (b"info", 0), (b"reset", 0)];
        if let Some(input) = requests::input(number, pieces) {
            seeds.write(&input)?;
        }
    }
    Ok(())
}

/// Writes inputs made from a transcript. Each line of a transcript is a JSON object whose member
/// `req` is a request in hex. Lines without `req`, such as those of a recorded trial, are skipped.
fn write_exchange(seeds: &mut SeedFolder, lines: &str) -> io::Result<()> {
    let requests: Vec<Vec<u8>> = lines.lines().filter_map(parse_request).collect();
    let inputs = requests.chunks(REQUESTS_PER_INPUT);
    let step = inputs.len().div_ceil(INPUTS_PER_EXCHANGE).max(1);
    for requests in inputs.step_by(step) {
        seeds.write_requests(0, requests.iter().map(Vec::as_slice))?;
    }
    Ok(())
}

fn parse_request(line: &str) -> Option<Vec<u8>> {
    let exchange: Value = serde_json::from_str(line).ok()?;
    let digits = exchange["req"].as_str()?.as_bytes();
    digits
        .chunks(2)
        .map(|digits| u8::from_str_radix(str::from_utf8(digits).ok()?, 16).ok())
        .collect()
}

/// Writes byte streams as sent by ZMTP 2 and ZMTP 3 clients. The streams contain requests,
/// commands and oversized frames.
fn write_streams(seeds: &mut SeedFolder) -> io::Result<()> {
    let oversized = [&b"\x01\0\x02\0\0\0\0\0\x01\0\x01"[..], &vec![7; 65_537]].concat();
    let streams: [(u8, &[u8]); 6] = [
        (WITH_HANDSHAKE | 6, b"\x01\0\0\x04ping\x01\x01a\x01\0\x01\x01b\0\x01c"),
        (WITH_HANDSHAKE | 1, b"\x04\x0a\x04PING\0\x01abc\x04\x02\x01X"),
        (WITH_HANDSHAKE | 0x7f, b"\x02\x7f\xff\xff\xff\xff\xff\xff\xff"),
        (WITH_HANDSHAKE | 0x63, &oversized),
        (20, b"\xff\0\0\0\0\0\0\0\x01\x7f\x01\x03\0\x02me\x01\0\0\x04ping"),
        (3, b"GET / HTTP/1.1"),
    ];
    for (choice, bytes) in streams {
        seeds.write(&[&[choice], bytes].concat())?;
    }
    Ok(())
}

/// Writes recordings of a search in a small maze. Some recordings contain the maze. Some are
/// complete, some are truncated, and some group their messages in chunks, as other tools do.
fn write_recordings(seeds: &mut SeedFolder) -> io::Result<()> {
    let maze = mmsim_formats::parse_maze(MAZES[0].as_bytes()).map_err(io::Error::other)?;
    let simulation = Simulation::new("small", maze);
    for maze in [Some(simulation.maze()), None] {
        let path = seeds.next_path();
        let _ = fs::remove_file(&path);
        let mut writer =
            RecordingWriter::create(&path, &simulation.info(), maze).map_err(io::Error::other)?;
        for weight in 0..3 {
            writer.write(&[b'S', 0, 0, b'N', b'C', weight, b'F', 31]).map_err(io::Error::other)?;
        }
        writer.close().map_err(io::Error::other)?;
        let recording = fs::read(&path)?;
        for end in [recording.len() / 3, recording.len() / 2, recording.len() - 1] {
            seeds.write(&recording[..end])?;
        }
        for compression in [None, Some(Compression::Zstd)] {
            seeds.write(&in_chunks(&recording, compression).map_err(io::Error::other)?)?;
        }
    }
    Ok(())
}

/// Returns a copy of a recording with its messages grouped in chunks.
fn in_chunks(recording: &[u8], compression: Option<Compression>) -> Result<Vec<u8>, McapError> {
    let mut chunked = Vec::new();
    let options = WriteOptions::new().use_chunks(true).compression(compression);
    let mut writer = options.create(Cursor::new(&mut chunked))?;
    for record in LinearReader::new(recording)? {
        if let Record::Metadata(metadata) = record? {
            writer.write_metadata(&metadata)?;
        }
    }
    for message in MessageStream::new(recording)? {
        writer.write(&message?)?;
    }
    writer.finish()?;
    drop(writer);
    Ok(chunked)
}

/// A folder of seeds in files named `seed-0001`, `seed-0002` and so on.
struct SeedFolder {
    folder: PathBuf,
    count: usize,
}

impl SeedFolder {
    fn create(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        Ok(Self { folder: folder.into(), count: 0 })
    }

    fn write(&mut self, input: &[u8]) -> io::Result<()> {
        fs::write(self.next_path(), input)
    }

    fn next_path(&mut self) -> PathBuf {
        self.count += 1;
        self.folder.join(format!("seed-{:04}", self.count))
    }

    fn write_requests<'a>(
        &mut self,
        size: u8,
        requests: impl IntoIterator<Item = &'a [u8]>,
    ) -> io::Result<()> {
        // Requests that contain the separator are skipped.
        let pieces = requests.into_iter().map(|request| (request, 0));
        requests::input(size, pieces).map_or(Ok(()), |input| self.write(&input))
    }
}
