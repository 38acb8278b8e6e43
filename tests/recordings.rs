//! Recordings of whole searches: what they take on the disk.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use mmsim_client::{InMemory, search_run};
use mmsim_maze::{Catalogue, KnownMaze, Maze, MazeSize};
use mmsim_server::{Ending, Recording, RecordingWriter, Simulation};
use mmsim_solvers::{BundledStrategy, Mouse};
use mmsim_tests::bundled_mazes;

/// The most that a state takes, with its part of all else in the file, in bytes.
const MAX_STATE_BYTES: usize = 40;

/// From this many states on. In shorter recordings, the maze and the summary weigh more.
const STATES: usize = 170;

#[test]
fn a_recorded_search_takes_forty_bytes_a_state() {
    let folder = tempfile::tempdir().unwrap();
    let (mut searches, mut all_states, mut all_bytes) = (0, 0, 0);
    for entry in Catalogue::from_path(&bundled_mazes()).unwrap().entries() {
        let maze = entry.maze().unwrap();
        for &strategy in BundledStrategy::ALL {
            let path = folder.path().join(format!("{}-{}.mcap", entry.name(), strategy.name()));
            let states = record(&path, &maze, strategy);
            let bytes = usize::try_from(fs::metadata(&path).unwrap().len()).unwrap();
            if maze.size() == MazeSize::CLASSIC && states >= STATES {
                searches += 1;
                assert!(bytes <= MAX_STATE_BYTES * states, "{path:?}: {states} in {bytes} bytes");
            }
            // One that goes round in circles is packed too well to be counted.
            if states < MAX_STATES {
                (all_states, all_bytes) = (all_states + states, all_bytes + bytes);
            }
        }
    }
    assert!(searches >= 30, "{searches} searches");
    assert!(all_bytes <= MAX_STATE_BYTES * all_states, "{all_states} in {all_bytes} bytes");
    println!("{all_states} states of all sizes in {all_bytes} bytes");
}

const MAX_STATES: usize = 3000;

/// Records a search as a server does; gives the number of states.
fn record(path: &Path, maze: &Maze, strategy: BundledStrategy) -> usize {
    let mut simulation = Simulation::new("maze", maze.clone());
    let mut writer = RecordingWriter::create(path, &simulation.info(), Some(maze)).unwrap();
    let mut transport = InMemory::new(|request, reply| {
        if request.starts_with(b"S") {
            writer.write(request).unwrap();
        }
        simulation.handle(request, reply)
    });
    let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(maze), maze.start());
    let most = MAX_STATES.try_into().unwrap();
    // A goal that cannot be reached ends a search as well.
    let _ = search_run(&mut transport, &mut mouse, most, |_, _| ControlFlow::Continue(()));
    writer.close().unwrap();
    let recording = Recording::open(path).unwrap();
    assert!(recording.history().iter().eq(simulation.history().iter()));
    assert_eq!((recording.ending(), recording.maze()), (&Ending::Closed, Some(maze)));
    recording.history().len()
}
