//! Floods and searches mazes on a microcontroller that QEMU simulates, and counts ticks of the
//! system timer.
//!
//! The program reads the mazes from the file `mazes` in QEMU's working directory. The file contains
//! the text picture of each maze, preceded by its length as four little-endian bytes. For each maze,
//! the program prints one line per computation: its name, the number of times it ran, the total
//! number of ticks, and the largest number of ticks. For each search, it also prints the moves.
#![no_std]
#![no_main]

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use mmsim_maze::{KnownMaze, Maze, MazeSize, Step, Unknown};
use mmsim_protocol::{MAX_STATE_BYTES, MapState, Order};
use mmsim_solvers::{
    Distances, FloodFill, Mouse, Move, ShortestPathSearch, Strategy, WeightIncrement,
};
use semihosting::io::Read;
use semihosting::{fs::File, print, println};

mod queue;

/// The number of bytes of the text picture of the largest maze.
const PICTURE_BYTES: usize = {
    let side = MazeSize::MAX_SIDE as usize;
    (2 * side + 1) * (4 * side + 2)
};

/// The maximum number of steps in a search. Without this limit, a strategy could search for an
/// unreachable goal forever.
const MAX_STEPS: usize = 2000;

/// The ticks of a computation.
struct Ticks {
    name: &'static str,
    runs: u32,
    total: u32,
    most: u32,
}

impl Ticks {
    const fn new(name: &'static str) -> Self {
        Self { name, runs: 0, total: 0, most: 0 }
    }

    #[inline(never)]
    fn count(&mut self, run: &mut dyn FnMut()) {
        // The timer counts down.
        let before = SYST::get_current();
        run();
        let ticks = before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff;
        self.runs += 1;
        self.total += ticks;
        self.most = self.most.max(ticks);
    }

    fn print(&self) {
        println!("{} {} {} {}", self.name, self.runs, self.total, self.most);
    }
}

#[entry]
fn main() -> ! {
    let mut timer = Peripherals::take().unwrap().SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(0x00ff_ffff);
    timer.clear_current();
    timer.enable_counter();
    let mut nothing = Ticks::new("nothing");
    nothing.count(&mut || {});
    nothing.print();

    let mut file = File::open(c"mazes").unwrap();
    let mut length = [0; 4];
    let mut picture = [0; PICTURE_BYTES];
    while file.read(&mut length).unwrap() == length.len() {
        let picture = &mut picture[..u32::from_le_bytes(length) as usize];
        file.read_exact(picture).unwrap();
        let maze: Maze = core::str::from_utf8(picture).unwrap().parse().unwrap();
        flood(&maze);
        update(&maze);
        search(&maze, "flood-fill", FloodFill::new());
        search(&maze, "weight-increment", WeightIncrement::new());
        search(&maze, "shortest-path-search", ShortestPathSearch::new());
    }
    semihosting::process::exit(0)
}

/// Floods the maze from its goal in three ways.
#[inline(never)]
fn flood(maze: &Maze) {
    let mut distances = Distances::unreachable(maze.size());
    let mut ours = Ticks::new("flood");
    ours.count(&mut || distances.reflood(maze.walls(), maze.goals()));
    ours.print();
    if maze.size() == MazeSize::CLASSIC {
        let (walls, targets) = (queue::walls(maze), queue::targets(maze));
        let mut ticks = Ticks::new("textbook-queue");
        let mut from_queue = [0; 256];
        ticks.count(&mut || queue::flood(&walls, &targets, &mut from_queue));
        ticks.print();
        check(&distances, &from_queue);
        let mut ticks = Ticks::new("textbook-queue-in-c");
        ticks.count(&mut || queue::flood_in_c(&walls, &targets, &mut from_queue));
        ticks.print();
        check(&distances, &from_queue);
    }
}

fn check(distances: &Distances, bytes: &[u8; 256]) {
    for (cell, &byte) in MazeSize::CLASSIC.cells().zip(bytes) {
        assert_eq!(distances.at(cell).unwrap_or(255), byte.into());
    }
}

/// Keeps the distances up to date while a flood-fill mouse searches the maze.
#[inline(never)]
fn update(maze: &Maze) {
    let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(maze), maze.start());
    let mut distances = Distances::unreachable(maze.size());
    distances.reflood(mouse.map().walls(Unknown::Open), maze.goals());
    let mut update = Ticks::new("update");
    for _ in 0..MAX_STEPS {
        mouse.see(maze.walls().around(mouse.pose())).unwrap();
        let (walls, cell) = (mouse.map().walls(Unknown::Open), mouse.pose().cell);
        update.count(&mut || {
            distances.update(walls, maze.goals(), cell);
        });
        let Ok(Move::Step(step)) = mouse.decide() else { break };
        mouse.go(step).unwrap();
    }
    update.print();
}

/// Searches the maze, and prints the ticks of the steps and the moves.
#[inline(never)]
fn search(maze: &Maze, name: &'static str, strategy: impl Strategy) {
    let (mut step, mut encode) = (Ticks::new(name), Ticks::new("encode"));
    let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(maze), maze.start());
    let mut moves = Moves(name);
    mouse.see_behind(maze.walls().around(mouse.turned_round())).unwrap();
    for _ in 0..MAX_STEPS {
        let around = maze.walls().around(mouse.pose());
        let mut next = Ok(Move::Stop);
        step.count(&mut || {
            mouse.see(around).unwrap();
            next = mouse.decide();
            if let Ok(Move::Step(step)) = next {
                mouse.go(step).unwrap();
            }
        });
        let Ok(Move::Step(taken)) = next else { break };
        moves.print(taken);
        if step.runs % 8 == 1 {
            encode.count(&mut || {
                let mut message = [0; MAX_STATE_BYTES];
                let weight = |cell| mouse.weight(cell).unwrap_or(u16::MAX);
                let state = MapState::new(mouse.pose(), mouse.map(), weight, Order::F);
                state.encode(&mut message).unwrap();
            });
        }
    }
    println!();
    step.print();
    encode.print();
}

struct Moves(&'static str);

impl Moves {
    fn print(&mut self, step: Step) {
        if !self.0.is_empty() {
            print!("moves {} ", self.0);
            self.0 = "";
        }
        print!(
            "{}",
            match step {
                Step::Front => 'F',
                Step::Left => 'L',
                Step::Right => 'R',
                Step::Back => 'B',
            }
        );
    }
}
