//! A million states of real searches in a history: what they take in memory, how long it takes to
//! add one, and to read them at random and in order. Beside it, the plain list of the reference.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher};
use std::hint::black_box;
use std::time::{Duration, Instant};

use mmsim_benches::{Noise, Searches, classic_mazes};
use mmsim_maze::{Maze, MazeSize};
use mmsim_protocol::state_bytes;
use mmsim_recording::History;

/// One push in so many packs a block.
const BLOCK_STATES: usize = 256;

/// How many states are read at random.
const READS: usize = 10_000;

fn hash(state: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(state);
    hasher.finish()
}

/// Which of the states in the order of the searches are new, and the hashes of those, `count` in
/// all. So the searches can be run again without a set of what there was.
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

/// What the process holds in memory, in bytes, where the system tells.
fn resident() -> Option<usize> {
    let statm = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: usize = statm.split(' ').nth(1)?.parse().ok()?;
    Some(pages * 4096)
}

#[expect(clippy::cast_precision_loss, reason = "figures for people")]
fn each(total: f64, count: usize) -> f64 {
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
    let before = resident();
    let mut is_new = is_new.into_iter();
    while history.len() < count {
        searches.next(|state| {
            if is_new.next() == Some(true) {
                let begun = Instant::now();
                history.push(black_box(state)).unwrap();
                pushes[number] = begun.elapsed();
                number += 1;
            }
        });
    }
    let after = resident();
    println!(
        "history: {count} states, none twice, of {} searches of {} mazes by {} strategies",
        searches.count(),
        mazes.len(),
        Searches::STRATEGIES
    );

    let mut reader = history.reader();
    for (index, &expected) in hashes.iter().enumerate() {
        assert_eq!(hash(reader.get(index).unwrap()), expected, "state {index}");
    }
    assert_eq!((history.len(), history.get(count)), (count, None));

    #[expect(clippy::cast_precision_loss, reason = "figures for people")]
    let bytes = |total: usize| each(total as f64, count);
    println!("history/memory: {:.1} bytes a state counted", bytes(history.bytes()));
    if let (Some(before), Some(after)) = (before, after) {
        let grown = after.saturating_sub(before);
        let plain = state_bytes(MazeSize::CLASSIC) + size_of::<Vec<u8>>();
        println!(
            "history/memory: {:.1} bytes a state grown by the process (at most 24; a list takes {plain} or more)",
            bytes(grown)
        );
    }
    print_pushes(&pushes);
    print_reads(&history, &hashes);
}

fn print_pushes(pushes: &[Duration]) {
    let mean = each(microseconds(pushes.iter().sum()), pushes.len());
    println!("history/push: {mean:.2} µs on average (at most 3)");
    // The machine may stop for a while in any of them; what packs takes its time in each.
    for (kind, packs) in [("that pack", true), ("that don't", false)] {
        let mut pushes: Vec<_> = pushes
            .iter()
            .enumerate()
            .filter(|(number, _)| (number % BLOCK_STATES == 0) == packs)
            .map(|(_, push)| microseconds(*push))
            .collect();
        pushes.sort_by(f64::total_cmp);
        let (median, longest) = (pushes[pushes.len() / 2], pushes[pushes.len() - 1]);
        let stalls = pushes.iter().filter(|&&push| push > 2000.0).count();
        println!(
            "history/pushes {kind}: {median:.2} µs the median, {longest:.0} µs the longest, \
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
            let begun = Instant::now();
            let state = black_box(history.get(index)).unwrap();
            let time = begun.elapsed();
            assert_eq!(hash(&state), hashes[index]);
            time
        })
        .collect();
    reads.sort();
    let median = microseconds(reads[READS / 2]);
    let most = microseconds(reads[READS * 99 / 100]);
    println!(
        "history/read at random: {median:.1} µs the median (at most 100), {most:.1} µs for 99 of 100"
    );

    let begun = Instant::now();
    let mut reader = history.reader();
    let mut read = 0;
    while let Some(state) = reader.get(read) {
        black_box(state);
        read += 1;
    }
    let rate = each(read_rate(read, begun.elapsed()), 1);
    println!("history/read in order: {rate:.0} states a second (at least 500000)");
}

#[expect(clippy::cast_precision_loss, reason = "figures for people")]
fn read_rate(states: usize, time: Duration) -> f64 {
    states as f64 / time.as_secs_f64()
}
