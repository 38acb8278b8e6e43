//! A correct client that runs during the attacks.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

use mmsim_client::{Exchange, InMemory, SearchRun, Timeout, Transport, Zmq, search_run};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_server::Simulation;
use mmsim_solvers::{FloodFill, Mouse};
use mmsim_tests::TIMEOUT;

/// The name of the served maze.
pub(crate) const MAZE: &str = "01-harbour";

/// Returns the served maze.
pub(crate) fn maze() -> Maze {
    mmsim_mazes::HARBOUR.parse().unwrap()
}

fn search(transport: &mut impl Transport, maze: &Maze) -> SearchRun {
    let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(maze), maze.start());
    search_run(transport, &mut mouse, 10_000, |_, _| ControlFlow::Continue(())).unwrap()
}

/// Repeats a search before, during and after `attack`. Every search must give the same results as a
/// search in memory.
pub(crate) fn while_searching<T>(address: &str, attack: impl FnOnce() -> T) -> T {
    let (searches, enough) = (AtomicU32::new(0), AtomicBool::new(false));
    let wait_for_another = || {
        let before = searches.load(Ordering::Acquire);
        // A search may already be running, so wait for the end of the second one.
        while searches.load(Ordering::Acquire) < before + 2 && !enough.load(Ordering::Acquire) {
            thread::sleep(Duration::from_millis(1));
        }
    };
    thread::scope(|scope| {
        let searching = scope.spawn(|| {
            let ended = StopOnDrop(&enough);
            search_on(address, &searches, &enough);
            drop(ended);
        });
        let ended = StopOnDrop(&enough);
        wait_for_another();
        let result = attack();
        wait_for_another();
        drop(ended);
        searching.join().unwrap();
        println!("  {} searches", searches.load(Ordering::Acquire));
        result
    })
}

/// A guard that signals the other thread to stop when this thread ends, even if it panics.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

fn search_on(address: &str, searches: &AtomicU32, enough: &AtomicBool) {
    let maze = maze();
    let mut simulation = Simulation::new(MAZE, maze.clone());
    let in_memory =
        search(&mut InMemory::new(|request, reply| simulation.handle(request, reply)), &maze);
    assert!(in_memory.stats.goal_reached());
    let mut transport = Zmq::connect(address, Timeout::After(TIMEOUT), |_| {}).unwrap();
    while !enough.load(Ordering::Acquire) {
        assert_eq!(search(&mut transport, &maze), in_memory);
        let kept = Exchange::new(&mut transport).info().unwrap().states;
        assert_eq!(kept, simulation.history().len(), "states that the server has kept");
        searches.fetch_add(1, Ordering::AcqRel);
    }
}
