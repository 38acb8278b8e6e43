//! Reads every maze in the shared collection and compares its properties with those in
//! `facts.json`.

use std::collections::BTreeMap;
use std::fs;

use mmsim_maze::{Cell, CellSet, MazeSize};
use mmsim_solvers::MazeFacts;
use mmsim_tests::shared;
use serde::Deserialize;

#[derive(Deserialize)]
struct RecordedFacts {
    size: [usize; 2],
    goals: Vec<[u8; 2]>,
    shortest_cells: Option<u16>,
    reachable_cells: usize,
    odd: Vec<String>,
}

#[test]
fn text_mazes_match_their_recorded_facts() {
    let Some(folder) = shared("mazes") else { return };
    let facts = fs::read(folder.join("facts.json")).unwrap();
    let facts: BTreeMap<String, RecordedFacts> = serde_json::from_slice(&facts).unwrap();
    assert_eq!(facts.len(), 281);
    for (name, facts) in facts {
        let maze = mmsim_formats::read_maze(&folder.join(&name)).unwrap();
        let size = MazeSize::new(facts.size[0], facts.size[1]).unwrap();
        let marked: CellSet = facts.goals.iter().map(|&[x, y]| Cell::new(x, y)).collect();
        let goals = if marked.is_empty() { size.central_cells() } else { marked };
        assert_eq!(maze.size(), size, "{name}");
        assert_eq!(*maze.goals(), goals, "{name}");
        assert_eq!(maze.start().cell, Cell::new(0, 0), "{name}");
        let found = MazeFacts::new(&maze);
        assert_eq!(found.shortest_path, facts.shortest_cells, "{name}");
        assert_eq!(found.reachable_cells, facts.reachable_cells, "{name}");
        assert_eq!(maze.to_string().parse().as_ref(), Ok(&maze), "{name}");
        let has_bare_posts = facts.odd.iter().any(|odd| odd == "posts_without_wall");
        assert_eq!(maze.posts_without_wall().next().is_some(), has_bare_posts, "{name}");
    }
}

#[test]
fn trial_mazes_are_readable() {
    let Some(folder) = shared("mazes/trial") else { return };
    for (name, side) in
        [("test_maze_01.txt", 12), ("test_maze_02.txt", 14), ("test_maze_03.txt", 16)]
    {
        let maze = mmsim_formats::read_maze(&folder.join(name)).unwrap();
        assert_eq!(maze.size(), MazeSize::new(side, side).unwrap(), "{name}");
        assert_eq!(*maze.goals(), maze.size().central_cells(), "{name}");
        let facts = MazeFacts::new(&maze);
        assert_eq!(facts.reachable_cells, side * side, "{name}");
        assert!(facts.shortest_path.is_some(), "{name}");
    }
}
