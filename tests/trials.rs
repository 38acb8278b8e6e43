//! The trial's environment against recorded runs of the published tester.

use std::fs;

use mmsim_maze::Maze;
use mmsim_tests::{json_lines, shared};
use mmsim_trial::{Action, Ending, Trial, race_optimum};
use serde::Deserialize;

/// A run as it was recorded.
#[derive(Deserialize)]
struct Recorded {
    maze: String,
    steps: Vec<([u8; 3], Answer)>,
    explore_steps: Option<u32>,
    race_steps: Option<u32>,
    score: Option<String>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Answer {
    Move(i64, i64),
    /// `["Reset", "Reset"]`
    Reset(String, String),
}

impl From<&Answer> for Action {
    fn from(answer: &Answer) -> Self {
        match answer {
            Answer::Move(rotation, movement) => Self::of_numbers(*rotation, *movement),
            Answer::Reset(first, second) => {
                assert_eq!((first.as_str(), second.as_str()), ("Reset", "Reset"));
                Self::Reset
            }
        }
    }
}

#[test]
fn recorded_runs_go_the_same_way_again() {
    let (Some(transcripts), Some(mazes)) = (shared("transcripts"), shared("mazes/trial")) else {
        return;
    };
    let is_trial = |name: &str| name.starts_with("trial.");
    let files = fs::read_dir(transcripts).unwrap().map(|entry| entry.unwrap());
    let files: Vec<_> =
        files.filter(|file| is_trial(&file.file_name().to_string_lossy())).collect();
    let mut runs = 0;
    for file in files {
        for (number, recorded) in (1..).zip(json_lines::<Recorded>(&file.path())) {
            let run = format!("{}, run {number}", file.path().display());
            let maze = Maze::read(&mazes.join(&recorded.maze)).unwrap();
            let mut trial = Trial::new(&maze);
            for (step, (readings, answer)) in (1..).zip(&recorded.steps) {
                assert_eq!(trial.ending(), None, "{run}, step {step}");
                assert_eq!(trial.readings(), *readings, "{run}, step {step}");
                trial.act(answer.into());
            }
            match (trial.ending(), recorded.score) {
                (Some(Ending::Scored(score)), Some(expected)) => {
                    assert_eq!(Some(score.explore_steps), recorded.explore_steps, "{run}");
                    assert_eq!(Some(score.race_steps), recorded.race_steps, "{run}");
                    assert_eq!(score.to_string(), expected, "{run}");
                }
                (ending, score) => {
                    assert_eq!((ending, score), (Some(Ending::OutOfTime), None), "{run}");
                }
            }
            runs += 1;
        }
    }
    assert!(runs >= 180, "only {runs} runs were found");
}

#[test]
fn race_optima_are_the_published_ones() {
    let Some(mazes) = shared("mazes/trial") else { return };
    for (name, expected) in [("test_maze_01", 17), ("test_maze_02", 22), ("test_maze_03", 25)] {
        let maze = Maze::read(&mazes.join(name).with_extension("txt")).unwrap();
        let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals());
        assert_eq!(optimum, Some(expected), "{name}");
    }
}
