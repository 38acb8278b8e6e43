//! Counts the instructions of floods, steps and encodings on Cortex-M processors, which QEMU
//! simulates. The program for these processors is in the folder `mcu`.
//!
//! In test mode, all moves in all mazes are compared with those on this computer, and nothing else
//! is measured.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

use mmsim_benches::{all_mazes, classic_mazes, is_measuring, print_row, ratio};
use mmsim_maze::{KnownMaze, Maze, Step, WyRand};
use mmsim_solvers::{BundledStrategy, Mouse, Move};

/// A board that QEMU simulates.
struct Board {
    core: &'static str,
    target: &'static str,
    machine: &'static str,
    /// The number of instructions per tick of the system timer. With `-icount shift=5`, an
    /// instruction takes 32 ns.
    instructions_per_tick: f64,
}

const BOARDS: [Board; 3] = [
    // 62.5 ns per tick
    Board {
        core: "M0",
        target: "thumbv6m-none-eabi",
        machine: "microbit",
        instructions_per_tick: 62.5 / 32.0,
    },
    // 40 ns per tick
    Board {
        core: "M3",
        target: "thumbv7m-none-eabi",
        machine: "mps2-an385",
        instructions_per_tick: 40.0 / 32.0,
    },
    Board {
        core: "M4",
        target: "thumbv7em-none-eabi",
        machine: "mps2-an386",
        instructions_per_tick: 40.0 / 32.0,
    },
];

const STRATEGIES: [BundledStrategy; 3] = [
    BundledStrategy::FloodFill,
    BundledStrategy::WeightIncrement,
    BundledStrategy::ShortestPathSearch,
];

/// The computation that the others are compared with.
const PEER: &str = "textbook-queue-in-c";

/// The names of the computations in the program, and their names in the table.
const ROWS: [(&str, &str); 8] = [
    ("flood", "flood"),
    ("textbook-queue", "textbook queue"),
    ("textbook-queue-in-c", "textbook queue in C"),
    ("update", "update of the distances after a wall reading"),
    ("flood-fill", "step of flood-fill"),
    ("weight-increment", "step of weight-increment"),
    ("shortest-path-search", "step of shortest-path-search"),
    ("encode", "encoding of a state"),
];

/// The maximum number of steps in a search, as in the program.
const MAX_STEPS: usize = 2000;

/// The number of mazes in which computations are measured.
const MEASURED: usize = 40;

fn main() -> io::Result<()> {
    if Command::new("qemu-system-arm").arg("--version").output().is_err() {
        assert!(env::var_os("MMSIM_QEMU").is_none(), "qemu-system-arm cannot be run");
        eprintln!("note: qemu-system-arm is not installed, so nothing is measured");
        return Ok(());
    }
    if !is_measuring() {
        let (small, large): (Vec<_>, _) = all_mazes()
            .into_iter()
            .partition(|maze| maze.size().width().max(maze.size().height()) <= 16);
        BOARDS[1].run(&small, &[])?;
        BOARDS[1].run(&large, &["--features", "half-size"])?;
        println!("{} mazes: the moves are the same as on this computer", small.len() + large.len());
        return Ok(());
    }
    let (mut mazes, mut rng) = (classic_mazes(), WyRand::new(1));
    let mixed: Vec<_> =
        (0..MEASURED.min(mazes.len())).map(|_| mazes.swap_remove(rng.index(mazes.len()))).collect();
    let mut table = BTreeMap::<String, Vec<[f64; 2]>>::new();
    for board in &BOARDS {
        let counts = board.run(&mixed, &[])?;
        let overhead = counts["nothing"][0][1];
        for (name, counts) in counts {
            let runs: u32 = counts.iter().map(|&[runs, ..]| runs).sum();
            let total: u32 = counts.iter().map(|&[_, total, _]| total).sum();
            let most = counts.iter().map(|&[.., most]| most).max().unwrap_or(0) - overhead;
            let instructions = |ticks: f64| (ticks * board.instructions_per_tick).round();
            let mean = instructions(f64::from(total - runs * overhead) / f64::from(runs));
            table.entry(name).or_default().push([mean, instructions(most.into())]);
        }
    }
    for (name, label) in ROWS {
        let cores = BOARDS.iter().zip(&table[name]).zip(&table[PEER]);
        let results = cores.map(|((board, [mean, most]), [peer, _])| {
            format!("{}: {} ({mean}, at most {most})", board.core, ratio(mean / peer))
        });
        print_row("mcu", label, &results.collect::<Vec<_>>().join("; "));
    }
    Ok(())
}

/// For each computation, the ticks in each maze: the number of runs, the total and the maximum.
type Counts = BTreeMap<String, Vec<[u32; 3]>>;

impl Board {
    /// Runs the program in these mazes.
    ///
    /// # Panics
    /// Panics if the program does not compile or fails, or if the moves of a strategy differ from
    /// those on this computer.
    fn run(&self, mazes: &[Maze], features: &[&str]) -> io::Result<Counts> {
        let program = self.build(features)?;
        let folder = tempfile::tempdir()?;
        let pictures = mazes.iter().flat_map(|maze| {
            let picture = maze.to_string();
            let length = u32::try_from(picture.len()).unwrap().to_le_bytes();
            length.into_iter().chain(picture.into_bytes())
        });
        fs::write(folder.path().join("mazes"), pictures.collect::<Vec<_>>())?;
        let output = Command::new("qemu-system-arm")
            .args(["-M", self.machine, "-icount", "shift=5", "-semihosting"])
            .args(["-nographic", "-monitor", "none", "-serial", "none", "-kernel"])
            .arg(program)
            .current_dir(folder.path())
            .output()?;
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{} failed: {stderr}", self.machine);
        let mut counts = Counts::new();
        let mut searches =
            mazes.iter().flat_map(|maze| STRATEGIES.map(|strategy| (maze, strategy)));
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            let words: Vec<_> = line.split_whitespace().collect();
            match words[..] {
                ["moves", name, moves] => {
                    let (maze, strategy) = searches.next().expect("one search for each strategy");
                    assert_eq!(name, strategy.name());
                    assert_eq!(moves, moves_here(maze, strategy), "{name} in\n{maze}");
                }
                [name, runs, total, most] => {
                    let numbers = [runs, total, most].map(|number| number.parse().unwrap());
                    counts.entry(name.to_string()).or_default().push(numbers);
                }
                _ => panic!("unexpected output: {line}"),
            }
        }
        assert!(searches.next().is_none(), "the program stopped early");
        Ok(counts)
    }

    fn build(&self, features: &[&str]) -> io::Result<PathBuf> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("mcu");
        let target = folder.join("target").join(if features.is_empty() { "16" } else { "32" });
        let status = Command::new(env!("CARGO"))
            .args(["build", "--quiet", "--release", "--target", self.target])
            .args(features)
            .arg("--target-dir")
            .arg(&target)
            .current_dir(&folder)
            .status()?;
        assert!(
            status.success(),
            "cannot build benches/mcu; try: rustup target add {}",
            self.target
        );
        Ok(target.join(self.target).join("release/mmsim-mcu"))
    }
}

/// Searches the maze on this computer and returns the moves as letters.
fn moves_here(maze: &Maze, strategy: BundledStrategy) -> String {
    let map = KnownMaze::unexplored(maze);
    let mut mouse = Mouse::new(strategy.strategy(), map, maze.start());
    mouse.see_behind(maze.walls().around(mouse.turned_round())).unwrap();
    let mut moves = String::new();
    for _ in 0..MAX_STEPS {
        mouse.see(maze.walls().around(mouse.pose())).unwrap();
        let Ok(Move::Step(step)) = mouse.decide() else { break };
        mouse.go(step).unwrap();
        moves.push(match step {
            Step::Front => 'F',
            Step::Left => 'L',
            Step::Right => 'R',
            Step::Back => 'B',
        });
    }
    moves
}
