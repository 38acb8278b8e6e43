//! Compares the bundled mazes with the table in the README of their folder.

use std::fs;
use std::path::Path;

use mmsim_formats::{Catalogue, Format, Notation};
use mmsim_solvers::MazeFacts;

#[test]
fn the_readme_lists_size_goal_and_shortest_path_of_each_maze() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mazes");
    let readme = fs::read_to_string(folder.join("README.md")).unwrap();
    let rows: Vec<Vec<&str>> = readme
        .lines()
        .filter(|line| line.starts_with('|') && line.contains(".txt"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let mut rows = rows.iter();
    let (mut classic, mut unreachable, mut not_square, mut half_size, mut trial) = (0, 0, 0, 0, 0);
    for (entry, (_, text)) in Catalogue::bundled().entries().iter().zip(mmsim_mazes::FILES) {
        let maze = entry.maze().unwrap();
        let (size, shortest) = (maze.size(), MazeFacts::new(&maze).shortest_path);
        let goals: Vec<String> = maze.goals().iter().map(|cell| cell.to_string()).collect();
        let expected = [
            entry.path().file_name().unwrap().to_string_lossy().to_string(),
            size.to_string(),
            goals.join(" "),
            shortest.map_or("none".to_string(), |steps| steps.to_string()),
        ];
        let row: Vec<String> =
            rows.next().unwrap()[..4].iter().map(|text| text.replace('`', "")).collect();
        assert_eq!(row, expected);
        let parsed = entry.parsed().unwrap();
        let is_trial = parsed.notation == Notation::Numbers;
        let format = if is_trial { Format::Trial } else { Format::Text };
        assert_eq!(
            format.write(&maze).unwrap(),
            text.as_bytes(),
            "{} is in canonical form",
            entry.name()
        );
        trial += usize::from(is_trial);
        classic += usize::from(size.to_string() == "16x16" && shortest.is_some());
        half_size += usize::from(size.to_string() == "32x32");
        not_square += usize::from(size.width() != size.height());
        unreachable += usize::from(shortest.is_none());
    }
    assert!(rows.next().is_none());
    assert!(classic >= 10 && half_size >= 1 && not_square >= 1 && unreachable >= 1);
    assert_eq!(trial, 4);
}

/// The folder also contains code, licences and a description, in which a few cells could be read.
#[test]
fn the_folder_contains_the_bundled_mazes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mazes");
    let found = Catalogue::from_path(&folder).unwrap();
    let names = found.entries().iter().map(|entry| entry.path().file_name().unwrap());
    let names: Vec<_> = names.map(|name| name.to_string_lossy().to_string()).collect();
    assert!(names.iter().eq(mmsim_mazes::FILES.iter().map(|(name, _)| name)), "{names:?}");
}
