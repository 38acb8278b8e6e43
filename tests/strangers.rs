//! Checks maze files in the manner of strangers.

use std::fs;
use std::path::{Path, PathBuf};

use mmsim_formats::{Catalogue, Choice, Entry, NoteKind, ParseErrorKind, ParsedMaze, read_content};
use mmsim_maze::{Cell, CellSet, Maze};
use mmsim_tests::shared;

fn read(path: &Path) -> ParsedMaze {
    let parsed = Choice::default().read(&read_content(path).unwrap());
    parsed.unwrap_or_else(|errors| panic!("{}: {}", path.display(), errors[0]))
}

fn own(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("strangers/mazes").join(name)
}

/// Checks that every file in `tests/strangers/mazes` describes the same maze. Files with the
/// extension `.out` have a start and a goal of their own.
#[test]
fn every_family_is_read() {
    let maze = read(&own("maze.txt")).maze;
    let mut files: Vec<PathBuf> =
        fs::read_dir(own("")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert_eq!(files.len(), 32);
    for path in files {
        let parsed = read(&path);
        let name = path.file_name().unwrap().to_str().unwrap();
        assert_eq!(parsed.maze.walls(), maze.walls(), "{name}");
        if path.extension().is_none_or(|extension| extension != "out") {
            assert_eq!(parsed.maze, maze, "{name}");
        }
        let notes = parsed.notes.len();
        let expected = match name {
            "cells.txt" => 3,
            "posts.txt" | "title.txt" => 2,
            "row-numbers.txt" => 6,
            "digits-title.txt" | "flags.h" | "array.json" | "unknown.maze" => 1,
            _ => 0,
        };
        assert_eq!(notes, expected, "{name}: {:?}", parsed.notes);
    }
    let ends = |name| {
        let maze = read(&own(name)).maze;
        (maze.start().cell, maze.goals().iter().collect::<Vec<Cell>>())
    };
    assert_eq!(ends("a-maze-ing.out"), (Cell::new(0, 0), vec![Cell::new(2, 3)]));
    assert_eq!(ends("pyamaze.out"), (Cell::new(5, 0), vec![Cell::new(0, 5)]));
}

#[test]
fn shared_inputs_have_the_right_answer() {
    let Some(folder) = shared("strangers/mazes") else { return };
    let read = |name: &str| read(&folder.join(name));
    let maze = read("folder/a.txt").maze;
    for (name, notes) in [
        ("corner-post.txt", 1),
        ("centre-post.txt", 1),
        ("cell-numbers.txt", 1),
        ("lower-case-marks.txt", 0),
        ("walls-hex.txt", 0),
        ("walls-decimal.csv", 0),
        ("walls-c-array.h", 0),
    ] {
        let parsed = read(name);
        assert_eq!(parsed.maze, maze, "{name}");
        assert_eq!(parsed.notes.len(), notes, "{name}: {:?}", parsed.notes);
        assert!(parsed.notes.iter().all(|note| note.kind == NoteKind::Ignored), "{name}");
    }
    let moved: CellSet =
        [(3, 5), (4, 5), (3, 6), (4, 6)].map(|(x, y)| Cell::new(x, y)).into_iter().collect();
    assert_eq!(*read("goal-off-by-one.txt").maze.goals(), moved);

    let digits = read_content(&folder.join("hex-north-4-mirrored.txt")).unwrap();
    let error = Choice::default().read(&digits).unwrap_err().remove(0);
    assert_eq!(error.kind, ParseErrorKind::Ambiguous);
    let truth = read("hex-north-4-true.txt").maze;
    assert!(error.readings.iter().any(|reading| reading.maze == truth));
    let (bits, rows) = ("N4E2S1W8".parse().ok(), "north".parse().ok());
    assert_eq!(Choice { bits, rows }.read(&digits).unwrap().maze, truth);

    let amazeing = read("amazeing-10x6.txt");
    assert_eq!(amazeing.maze.size().to_string(), "10x6");
    assert_eq!(amazeing.maze.start().cell, Cell::new(0, 5));
    assert!(amazeing.maze.goals().iter().eq([Cell::new(9, 0)]));
    assert_eq!(amazeing.notes, [], "the path leads to the goal");
    let pyamaze: Maze = "o---o---o\n| G |   |\no   o   o\n|     S |\no---o---o\n".parse().unwrap();
    assert_eq!(read("pyamaze-2x2.csv").maze, pyamaze);

    let listed = Catalogue::from_path(&folder.join("folder")).unwrap();
    assert_eq!(listed.entries().iter().map(Entry::name).collect::<Vec<_>>(), ["a"]);
    for other in ["README", "a.png", "tool.py"] {
        let named = Catalogue::from_path(&folder.join("folder").join(other)).unwrap();
        assert!(named.entries()[0].maze().is_err(), "{other}");
    }
}
