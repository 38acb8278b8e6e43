//! Measures a history of a million states from real searches: its memory use, the time to add a
//! state, and the time to read states in random and sequential order. Also measures a mouse that
//! annotates its states.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher};
use std::hint::black_box;
use std::time::{Duration, Instant};

use mmsim_benches::{Searches, classic_mazes, is_measuring, median, print_row, ratio};
use mmsim_client::{Exchange, InMemory};
use mmsim_maze::{KnownMaze, Maze, MazeSize, Unknown, WyRand};
use mmsim_protocol::{Annotation, Colour, state_bytes};
use mmsim_recording::History;
use mmsim_server::{ReplyBuffer, Simulation};
use mmsim_solvers::{BundledStrategy, Distances, Mouse, SearchDriver};

/// The number of states that the history collects before it compresses them together.
const BLOCK_STATES: usize = 256;

const READS: usize = 10_000;

/// The number of searches in each annotated history.
const ANNOTATED_SEARCHES: usize = 20;

/// The number of rounds that compare histories with and without annotations.
const ROUNDS: usize = 5;

fn hash(state: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(state);
    hasher.finish()
}

/// Runs searches until `count` distinct states have occurred. The first returned list indicates for
/// each state whether this is its first occurrence; the second contains the hash of each distinct
/// state. With the first list, the measurement can repeat the searches and skip duplicates without
/// a hash set.
fn new_states(mazes: &[Maze], count: usize) -> (Vec<bool>, Vec<u64>) {
    let (mut seen, mut is_new, mut hashes) = (HashSet::new(), Vec::new(), Vec::new());
    let mut searches = Searches::new(mazes);
    while hashes.len() < count {
        searches.next(|state| {
            let hash = hash(state);
            is_new.push(seen.insert(hash) && hashes.len() < count);
            if is_new.last() == Some(&true) {
                hashes.push(hash);
            }
        });
    }
    (is_new, hashes)
}

/// Returns the resident memory of the process in bytes, if the system reports it.
fn resident_bytes() -> Option<usize> {
    let statm = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: usize = statm.split(' ').nth(1)?.parse().ok()?;
    Some(pages * 4096)
}

#[expect(clippy::cast_precision_loss, reason = "only printed")]
fn mean(total: f64, count: usize) -> f64 {
    total / count as f64
}

fn microseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e6
}

fn main() {
    let count = if is_measuring() { 1_000_000 } else { 20_000 };
    let mazes = classic_mazes();
    let (is_new, hashes) = new_states(&mazes, count);

    let mut searches = Searches::new(&mazes);
    let mut history = History::new(MazeSize::CLASSIC);
    let (mut pushes, mut number) = (vec![Duration::MAX; count], 0);
    let mut copies = Duration::ZERO;
    pushes.fill(Duration::ZERO);
    let before = resident_bytes();
    let mut is_new = is_new.into_iter();
    while history.len() < count {
        searches.next(|state| {
            if is_new.next() == Some(true) {
                let start = Instant::now();
                history.push(black_box(state)).unwrap();
                pushes[number] = start.elapsed();
                number += 1;
                let start = Instant::now();
                drop(black_box(state.to_vec()));
                copies += start.elapsed();
            }
        });
    }
    let after = resident_bytes();
    let mut reader = history.reader();
    for (index, &expected) in hashes.iter().enumerate() {
        assert_eq!(hash(reader.get(index).unwrap()), expected, "state {index}");
    }
    assert_eq!((history.len(), history.get(count)), (count, None));

    if is_measuring() {
        // Systems that do not report the growth of the process get the counted bytes.
        let growth = before.zip(after).map(|(before, after)| after.saturating_sub(before));
        #[expect(clippy::cast_precision_loss, reason = "only printed")]
        let bytes = mean(growth.unwrap_or(history.bytes()) as f64, count);
        let plain = state_bytes(MazeSize::CLASSIC) + size_of::<Vec<u8>>();
        #[expect(clippy::cast_precision_loss, reason = "a few hundred")]
        let result = format!(
            "{} of the bytes of a plain list ({bytes:.1} per state; goal: 24)",
            ratio(bytes / plain as f64)
        );
        print_row("history", &format!("memory of {count} states"), &result);
        print_pushes(&pushes, copies);
    }
    print_reads(&history, &hashes);
    print_annotated(&mazes[..mazes.len().min(if is_measuring() { 30 } else { 2 })]);
}

/// Returns the requests of a flood-fill mouse that displays what the template mouse of mms displays:
/// the distances to the goal as texts, and visited cells in green. It clears its display first.
fn displaying_search(maze: &Maze) -> Vec<Vec<u8>> {
    let (mut requests, mut simulation) = (Vec::new(), Simulation::new("", maze.clone()));
    let mut transport = InMemory::new(|request, reply| {
        requests.push(request.to_vec());
        simulation.handle(request, reply)
    });
    let mut exchange = Exchange::new(&mut transport);
    exchange.annotate([Annotation::ClearTexts, Annotation::ClearColours]).unwrap();
    let map = KnownMaze::unexplored(maze);
    let mut mouse = Mouse::new(BundledStrategy::FloodFill.strategy(), map, maze.start());
    let mut driver = SearchDriver::new(&mut mouse, 1000);
    let mut shown = vec![(String::new(), None); maze.size().area()];
    while driver.advance(|pose| exchange.walls(pose)).is_ok_and(|goes_on| goes_on) {
        let mouse = driver.mouse();
        let distances = Distances::flood(mouse.map().walls(Unknown::Open), maze.goals());
        let cells = maze.size().cells().map(|cell| {
            let text = distances.at(cell).map_or("-".into(), |steps| (8 * steps).to_string());
            (text, mouse.map().visited().contains(cell).then_some(Colour::DarkGreen))
        });
        let cells: Vec<_> = cells.collect();
        let changes = maze.size().cells().zip(cells.iter().zip(&shown));
        let annotations = changes.flat_map(|(cell, ((text, colour), old))| {
            let text = (*text != old.0).then_some(Annotation::Text { cell, text });
            let colour = (*colour != old.1).then_some(Annotation::Colour { cell, colour: *colour });
            text.into_iter().chain(colour)
        });
        exchange.annotate(annotations).unwrap();
        let weight = |cell| mouse.weight(cell).unwrap_or(255);
        exchange.state(mouse.pose(), mouse.map(), weight).unwrap();
        shown = cells;
    }
    requests
}

/// Repeats the search of each maze, with or without its annotations. Returns the number of states,
/// the memory of the histories in bytes, and the time.
fn repeat_searches(
    mazes: &[Maze],
    searches: &[Vec<Vec<u8>>],
    annotates: bool,
) -> (usize, usize, Duration) {
    let (mut states, mut bytes, mut time) = (0, 0, Duration::ZERO);
    let mut reply = ReplyBuffer::new();
    for (maze, requests) in mazes.iter().zip(searches) {
        let mut simulation = Simulation::new("", maze.clone());
        let is_sent = |request: &&Vec<u8>| annotates || request[0] != b'A';
        let start = Instant::now();
        for request in std::iter::repeat_n(requests, ANNOTATED_SEARCHES).flatten().filter(is_sent) {
            simulation.handle(black_box(request), &mut reply);
        }
        time += start.elapsed();
        let history = simulation.history();
        let expected = requests.iter().filter(|request| request[0] == b'S').count();
        assert_eq!(history.len(), ANNOTATED_SEARCHES * expected);
        assert_eq!(history.newest_context().notes().is_empty(), !annotates);
        (states, bytes) = (states + history.len(), bytes + history.bytes());
    }
    (states, bytes, time)
}

fn print_annotated(mazes: &[Maze]) {
    let searches: Vec<_> = mazes.iter().map(displaying_search).collect();
    let (mut times, mut memory) = ([const { Vec::new() }; 2], [0.0; 2]);
    for _ in 0..ROUNDS {
        for annotates in [false, true] {
            let (states, bytes, time) = repeat_searches(mazes, &searches, annotates);
            times[usize::from(annotates)].push(mean(microseconds(time), states));
            #[expect(clippy::cast_precision_loss, reason = "only printed")]
            let bytes = mean(bytes as f64, states);
            memory[usize::from(annotates)] = bytes;
        }
    }
    let [plain, annotated] = times.map(|times| median(&times));
    let [plain_bytes, annotated_bytes] = memory;
    if is_measuring() {
        let result = format!(
            "{} times the time and {} times the bytes without `A` ({annotated:.2} µs, \
             {:.1} bytes more; goal: 16)",
            ratio(annotated / plain),
            ratio(annotated_bytes / plain_bytes),
            annotated_bytes - plain_bytes
        );
        print_row("history", "states with annotations", &result);
    }
}

fn print_pushes(pushes: &[Duration], copies: Duration) {
    let mean_time = mean(microseconds(pushes.iter().sum()), pushes.len());
    let compressing: Vec<_> =
        pushes.iter().step_by(BLOCK_STATES).map(|push| microseconds(*push)).collect();
    let longest = pushes.iter().max().copied().unwrap_or_default();
    let result = format!(
        "{} times a copy of the state (mean {mean_time:.2} µs; goal: 3); {:.0} µs with compression \
         (median); at most {:.0} µs",
        ratio(pushes.iter().sum::<Duration>().as_secs_f64() / copies.as_secs_f64()),
        median(&compressing),
        microseconds(longest)
    );
    print_row("history", "adding a state", &result);
}

fn print_reads(history: &History, hashes: &[u64]) {
    let mut rng = WyRand::new(2);
    let mut reads: Vec<Duration> = (0..READS)
        .map(|_| {
            let index = rng.index(hashes.len());
            let start = Instant::now();
            let state = black_box(history.get(index)).unwrap();
            let time = start.elapsed();
            assert_eq!(hash(&state), hashes[index]);
            time
        })
        .collect();
    reads.sort();
    let median = microseconds(reads[READS / 2]);
    let p99 = microseconds(reads[READS * 99 / 100]);
    let start = Instant::now();
    let mut reader = history.reader();
    let mut read = 0;
    while let Some(state) = reader.get(read) {
        black_box(state);
        read += 1;
    }
    let in_order = mean(microseconds(start.elapsed()), read);
    if is_measuring() {
        let result = format!(
            "{} times a read in order (median {median:.1} µs; goal: 100; 99th percentile {p99:.1} µs; \
             in order {in_order:.2} µs; goal: 2)",
            ratio(median / in_order)
        );
        print_row("history", "reading any state", &result);
    }
}
