//! Measures a history of a million states from real searches: its memory use, the time to add a
//! state, and the time to read states in random and sequential order.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher};
use std::hint::black_box;
use std::time::{Duration, Instant};

use mmsim_benches::{Noise, Searches, classic_mazes};
use mmsim_maze::{Maze, MazeSize};
use mmsim_protocol::state_bytes;
use mmsim_recording::History;

/// The number of states that the history collects before it compresses them together.
const BLOCK_STATES: usize = 256;

const READS: usize = 10_000;

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
    let count =
        if std::env::args().any(|argument| argument == "--test") { 20_000 } else { 1_000_000 };
    let mazes = classic_mazes();
    let (is_new, hashes) = new_states(&mazes, count);

    let mut searches = Searches::new(&mazes);
    let mut history = History::new(MazeSize::CLASSIC);
    let (mut pushes, mut number) = (vec![Duration::MAX; count], 0);
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
            }
        });
    }
    let after = resident_bytes();
    println!(
        "history: {count} distinct states of {} searches in {} mazes with {} strategies",
        searches.count(),
        mazes.len(),
        Searches::STRATEGIES
    );

    let mut reader = history.reader();
    for (index, &expected) in hashes.iter().enumerate() {
        assert_eq!(hash(reader.get(index).unwrap()), expected, "state {index}");
    }
    assert_eq!((history.len(), history.get(count)), (count, None));

    #[expect(clippy::cast_precision_loss, reason = "only printed")]
    let bytes = |total: usize| mean(total as f64, count);
    println!("history/memory: {:.1} bytes per state, counted", bytes(history.bytes()));
    if let (Some(before), Some(after)) = (before, after) {
        let growth = after.saturating_sub(before);
        let plain = state_bytes(MazeSize::CLASSIC) + size_of::<Vec<u8>>();
        println!(
            "history/memory: {:.1} bytes per state, growth of the process (at most 24; a plain list takes {plain} or more)",
            bytes(growth)
        );
    }
    print_pushes(&pushes);
    print_reads(&history, &hashes);
}

fn print_pushes(pushes: &[Duration]) {
    let mean_time = mean(microseconds(pushes.iter().sum()), pushes.len());
    println!("history/push: {mean_time:.2} µs mean (at most 3)");
    // The two kinds are reported separately, because the system may interrupt any push, but
    // compression always takes time.
    for (kind, compresses) in [("with compression", true), ("without compression", false)] {
        let mut pushes: Vec<_> = pushes
            .iter()
            .enumerate()
            .filter(|(number, _)| (number % BLOCK_STATES == 0) == compresses)
            .map(|(_, push)| microseconds(*push))
            .collect();
        pushes.sort_by(f64::total_cmp);
        let (median, longest) = (pushes[pushes.len() / 2], pushes[pushes.len() - 1]);
        let stalls = pushes.iter().filter(|&&push| push > 2000.0).count();
        println!(
            "history/push {kind}: {median:.2} µs median, {longest:.0} µs maximum, \
             {stalls} of {} over 2 ms",
            pushes.len()
        );
    }
}

fn print_reads(history: &History, hashes: &[u64]) {
    let mut noise = Noise::new(2);
    let mut reads: Vec<Duration> = (0..READS)
        .map(|_| {
            let index = noise.below(hashes.len());
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
    println!(
        "history/read at random: {median:.1} µs median (at most 100), {p99:.1} µs 99th percentile"
    );

    let start = Instant::now();
    let mut reader = history.reader();
    let mut read = 0;
    while let Some(state) = reader.get(read) {
        black_box(state);
        read += 1;
    }
    let rate = read_rate(read, start.elapsed());
    println!("history/read in order: {rate:.0} states per second (at least 500000)");
}

#[expect(clippy::cast_precision_loss, reason = "only printed")]
fn read_rate(states: usize, time: Duration) -> f64 {
    states as f64 / time.as_secs_f64()
}
