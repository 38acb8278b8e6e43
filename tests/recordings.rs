//! Recordings of whole searches.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use mmsim_client::{InMemory, search_run};
use mmsim_maze::{Catalogue, KnownMaze, Maze};
use mmsim_server::{Ending, Recording, RecordingWriter, Simulation};
use mmsim_solvers::{Bundled, Mouse};
use mmsim_tests::bundled_mazes;

#[test]
fn sizes() {
    let folder = tempfile::tempdir().unwrap();
    for entry in Catalogue::of_path(&bundled_mazes()).unwrap().entries() {
        let maze = entry.maze().unwrap();
        for strategy in Bundled::ALL {
            let path = folder.path().join(format!("{}-{}.mcap", entry.name(), strategy.name()));
            let states = record(&path, &maze, strategy);
            let bytes = fs::metadata(&path).unwrap().len();
            println!(
                "{} {} {} {states} {bytes} {:.1}",
                entry.name(),
                maze.size(),
                strategy.name(),
                bytes as f64 / states as f64
            );
        }
    }
}

fn record(path: &Path, maze: &Maze, strategy: Bundled) -> usize {
    let mut simulation = Simulation::new("maze", maze.clone());
    let mut writer = RecordingWriter::create(path, &simulation.info(), Some(maze)).unwrap();
    let mut states = 0;
    let mut transport = InMemory::new(|request, reply| {
        if request.starts_with(b"S") {
            writer.write(request).unwrap();
            states += 1;
        }
        simulation.handle(request, reply)
    });
    let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::before(maze), maze.start());
    let _ = search_run(&mut transport, &mut mouse, 10_000, |_, _| ControlFlow::Continue(()));
    writer.close().unwrap();
    let _ = Recording::open(path).unwrap().ending() == &Ending::Closed;
    states
}
