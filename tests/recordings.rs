//! Checks the size of recordings of complete searches.

use std::fs::{self, File};
use std::io::BufWriter;
use std::ops::ControlFlow;
use std::path::Path;

use mmsim_client::{InMemory, search_run};
use mmsim_formats::Catalogue;
use mmsim_maze::{KnownMaze, Maze, MazeSize};
use mmsim_recording::{Integrity, Recording, RecordingWriter};
use mmsim_server::Simulation;
use mmsim_solvers::{BundledStrategy, Mouse};

/// Returns the maximum size of a recording, in bytes per state.
const fn max_state_bytes(strategy: BundledStrategy) -> usize {
    match strategy {
        // The weights of all cells change with each new target.
        BundledStrategy::FastestPathSearch => 50,
        _ => 40,
    }
}

/// Recordings with fewer states than this are not checked, because the maze and the summary take
/// up most of the space.
const MIN_STATES: usize = 170;

#[test]
fn a_recorded_search_takes_few_bytes_per_state() {
    let folder = tempfile::tempdir().unwrap();
    let (mut searches, mut all_states, mut all_bytes, mut all_json) = (0, 0, 0, 0);
    for entry in Catalogue::bundled().entries() {
        let maze = entry.maze().unwrap();
        for &strategy in BundledStrategy::ALL {
            let path = folder.path().join(format!("{}-{}.mcap", entry.name(), strategy.name()));
            let states = record(&path, &maze, strategy);
            let bytes = length(&path);
            let max = max_state_bytes(strategy);
            if maze.size() == MazeSize::CLASSIC && states >= MIN_STATES {
                searches += 1;
                assert!(bytes <= max * states, "{path:?}: {states} states in {bytes} bytes");
            }
            // Searches that never end are excluded, because their states compress unusually well.
            if states < MAX_STATES {
                (all_states, all_bytes) = (all_states + states, all_bytes + bytes);
                let json_path = path.with_extension("json.mcap");
                let file = BufWriter::new(File::create(&json_path).unwrap());
                Recording::open(&path).unwrap().save(file, Some(mmsim_run::messages)).unwrap();
                all_json += length(&json_path) - bytes;
            }
        }
    }
    assert!(searches >= 30, "only {searches} searches were checked");
    assert!(all_bytes <= 40 * all_states, "{all_states} states in {all_bytes} bytes");
    assert!(all_json <= 60 * all_states, "{all_states} states in {all_json} bytes of JSON");
    println!("{all_states} states of all sizes in {all_bytes} bytes, {all_json} bytes of JSON");
}

fn length(path: &Path) -> usize {
    fs::metadata(path).unwrap().len().try_into().unwrap()
}

/// A search stops after this number of states.
const MAX_STATES: usize = 3000;

/// Records a search as a server would. Returns the number of states.
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
    let max = MAX_STATES.try_into().unwrap();
    // An unreachable goal is an error, but the search is recorded.
    let _ = search_run(&mut transport, &mut mouse, max, |_, _| ControlFlow::Continue(()));
    writer.close().unwrap();
    let recording = Recording::open(path).unwrap();
    assert!(recording.history().iter().eq(simulation.history().iter()));
    assert_eq!((recording.integrity(), recording.maze()), (&Integrity::Closed, Some(maze)));
    recording.history().len()
}
