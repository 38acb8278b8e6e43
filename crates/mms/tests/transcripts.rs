//! Tests all commands with transcripts, whose statistics count cells. Each line of a transcript is
//! `command -> response`, or only `command` if mms does not respond to the command.

use mmsim_maze::Maze;
use mmsim_mms::{Command, ScoreRules, SimulatedMouse};

const MAZE: &str = "\
o---o---o---o---o
|             G |
o   o   o---o---o
|   |   |       |
o   o---o   o   o
| S |       |   |
o---o---o---o---o
";

/// A maze with a diagonal path from the lower left to the upper right.
const STAIRCASE: &str = "\
o---o---o---o---o
|       |     G |
o---o   o   o---o
|   |       |   |
o   o   o---o   o
|       |       |
o   o---o   o---o
| S     |       |
o---o---o---o---o
";

/// A mouse and its maze.
struct Fixture {
    maze: Maze,
    mouse: SimulatedMouse,
}

impl Fixture {
    fn new(maze: &str) -> Self {
        let maze: Maze = maze.parse().unwrap();
        let mouse = SimulatedMouse::new(maze.size(), maze.start().cell, *maze.goals())
            .with_score_rules(ScoreRules::Cells);
        Self { maze, mouse }
    }

    /// Executes the commands and checks the responses. The response `!` stands for an error.
    #[track_caller]
    fn check(&mut self, transcript: &str) -> &mut Self {
        for line in transcript.lines().filter(|line| !line.trim().is_empty()) {
            let (command, expected) = match line.split_once("->") {
                Some((command, response)) => (command, Some(response.trim())),
                None => (line, None),
            };
            let response = match Command::parse(command.trim_start().as_bytes(), self.maze.size()) {
                Ok(command) => {
                    let Ok(response) = self.mouse.execute(command, &mut self.maze.walls().clone());
                    response.map(|response| response.to_string())
                }
                Err(_) => Some("!".into()),
            };
            assert_eq!(response.as_deref(), expected, "{line}");
        }
        self
    }
}

#[test]
fn maze_width_and_height() {
    Fixture::new(MAZE).check(
        "mazeWidth -> 4
         mazeHeight -> 3
         mazeWidth 1 -> !
         mazewidth -> !",
    );
}

#[test]
fn walls_in_eight_directions() {
    Fixture::new(MAZE).check(
        "wallFront -> false
         wallFrontRight -> true
         wallRight -> true
         wallBackRight -> true
         wallBack -> true
         wallBackLeft -> true
         wallLeft -> true
         wallFrontLeft -> true
         turnRight -> ack
         wallLeft -> false
         wallFront -> true
         wallRight -> true
         wallBack -> true",
    );
}

#[test]
fn walls_within_a_number_of_half_steps() {
    Fixture::new(MAZE).check(
        "wallFront 1 -> false
         wallFront 2 -> false
         wallFront 4 -> false
         wallFront 5 -> true
         wallFront 2147483648 -> true
         wallFront 1000000000000000000000000000000 -> true
         wallFront 0 -> false
         wallFront -1 -> false
         wallFront far -> false
         wallRight 0 -> true
         wallFront   4   -> false
         wallFront 1 1 -> !
         wallFront -> false",
    );
}

#[test]
fn walls_seen_from_between_two_cells() {
    // Between (0, 1) and (0, 2).
    Fixture::new(MAZE).check(
        "moveForwardHalf 3 -> ack
         wallFront -> false
         wallBack -> false
         wallLeft -> true
         wallRight -> true
         wallFrontLeft -> true
         wallFrontRight -> false
         wallBackRight -> true
         wallBackLeft -> true
         wallFront 2 -> true
         wallFrontRight 2 -> true",
    );
}

#[test]
fn forward() {
    Fixture::new(MAZE).check(
        "moveForward -> ack
         moveForward 1 -> ack
         moveForward -> crash
         turnRight -> ack
         moveForward 0 -> crash
         moveForward -1 -> crash
         moveForward much -> crash
         moveForward 1.5 -> crash
         moveForward 1 2 -> !
         moveForward  2  -> ack
         moveForward 2 -> crash
         getStat total-distance -> 5
         moveForward -> crash
         getStat total-distance -> 5",
    );
}

#[test]
fn forward_by_large_numbers() {
    for steps in ["3", "2147483647", "2147483648", "18446744073709551616", &"9".repeat(1000)] {
        let mut fixture = Fixture::new(MAZE);
        fixture.check(&format!("moveForward {steps} -> crash\n getStat total-distance -> 2"));
        assert_eq!(fixture.mouse.pose().cell, mmsim_maze::Cell::new(0, 2), "{steps}");
    }
}

#[test]
fn forward_by_half_steps() {
    Fixture::new(MAZE).check(
        "moveForwardHalf -> ack
         getStat total-distance -> 1
         getStat total-effective-distance -> 0.5
         moveForwardHalf 2 -> ack
         getStat total-distance -> 2
         getStat total-effective-distance -> 1.5
         moveForwardHalf 0 -> crash
         moveForwardHalf -3 -> crash
         moveForwardHalf 1000000000000000000000000000000 -> crash
         getStat total-distance -> 2
         getStat total-effective-distance -> 2
         moveForwardHalf -> crash
         getStat total-effective-distance -> 2",
    );
}

#[test]
fn posts_block_sideways_movement_between_two_cells() {
    Fixture::new(MAZE).check(
        "moveForwardHalf -> ack
         turnRight -> ack
         moveForward -> crash
         moveForwardHalf -> crash
         turnLeft -> ack
         moveForwardHalf -> ack
         turnRight45 -> ack
         moveForwardHalf -> crash",
    );
}

#[test]
fn turns() {
    Fixture::new(MAZE).check(
        "turnRight -> ack
         turnLeft -> ack
         turnRight90 -> ack
         turnLeft90 -> ack
         turnRight45 -> ack
         turnLeft45 -> ack
         wallFront -> false
         wallLeft -> true
         turnRight45 -> ack
         turnRight45 -> ack
         wallLeft -> false
         getStat total-turns -> 8
         turnRight 2 -> !
         getStat total-turns -> 8",
    );
}

#[test]
fn a_diagonal_along_a_staircase() {
    let mut fixture = Fixture::new(STAIRCASE);
    // From between (0, 0) and (0, 1), half a cell east and north at a time.
    fixture.check(
        "moveForwardHalf -> ack
         turnRight45 -> ack
         wallFront -> false
         wallFront 4 -> false
         wallFront 6 -> true
         moveForward 2 -> ack
         getStat total-distance -> 3
         getStat total-effective-distance -> 2.5
         moveForwardHalf 3 -> crash
         wallFront -> true
         moveForwardHalf -> crash
         turnLeft45 -> ack
         getStat total-effective-distance -> 3",
    );
    assert_eq!(fixture.mouse.point(), mmsim_maze::Point { i: 6, j: 7 });
}

#[test]
fn display_commands_have_no_response() {
    Fixture::new(MAZE).check(
        "setWall 0 0 n
         setWall 3 2 w
         clearWall 0 0 e
         setWall 0 0 x -> !
         setWall 4 0 n -> !
         setWall 0 3 n -> !
         setWall -1 0 n -> !
         setWall 0 0 -> !
         clearWall 0 0 n n -> !
         setColor 0 0 G
         setColor 0 0 k
         setColor 0 0 green -> !
         setColor 9 9 g -> !
         clearColor 0 0
         clearColor 0 -> !
         clearAllColor
         clearAllColor 1 -> !
         setText 0 0 a few words
         setText 0 0
         setText 0 3 a -> !
         clearText 0 0
         clearText a b -> !
         clearAllText
         wallFront -> false",
    );
}

#[test]
fn marked_walls_do_not_change_the_maze() {
    Fixture::new(MAZE).check(
        "setWall 0 0 n
         wallFront -> false
         clearWall 0 0 e
         wallRight -> true
         moveForward -> ack",
    );
}

#[test]
fn the_reset_button() {
    let mut fixture = Fixture::new(MAZE);
    fixture.check("wasReset -> false\n moveForward -> ack\n turnRight -> ack");
    fixture.mouse.press_reset();
    fixture.check(
        "wasReset -> true
         wasReset -> true
         ackReset -> ack
         wasReset -> false
         getStat total-effective-distance -> 1
         wallLeft -> true
         wallFront 4 -> false
         moveForward 2 -> ack
         getStat total-distance -> 3
         getStat total-effective-distance -> 18
         getStat current-run-effective-distance -> 17
         ackReset -> ack
         ackReset -> ack
         getStat current-run-effective-distance -> 17
         moveForwardHalf -> ack
         getStat current-run-effective-distance -> 15.5
         wasReset 1 -> !
         ackReset 1 -> !",
    );
}

#[test]
fn statistics() {
    Fixture::new(MAZE).check(
        "getStat score -> 2000
         getStat total-distance -> 0
         getStat total-turns -> 0
         getStat current-run-distance -> 0
         getStat current-run-turns -> 0
         getStat total-effective-distance -> 0
         getStat current-run-effective-distance -> 0
         getStat best-run-distance -> -1
         getStat best-run-turns -> -1
         getStat best-run-effective-distance -> -1
         score -> 2000
         best-run-turns -> -1
         getStat -> !
         getStat speed -> !
         getStat Score -> !
         getStat score score -> !",
    );
}

#[test]
fn a_run_to_the_goal_and_a_better_one() {
    let mut fixture = Fixture::new(MAZE);
    // The turns in the start cell precede the run.
    fixture.check(
        "turnRight -> ack
         turnLeft -> ack
         getStat current-run-turns -> 0
         moveForward -> ack
         moveForward -> ack
         turnRight -> ack
         moveForward -> ack
         moveForward -> ack
         getStat best-run-turns -> -1
         getStat score -> 2000
         moveForward -> ack
         getStat best-run-turns -> 1
         getStat best-run-distance -> 5
         getStat best-run-effective-distance -> 5
         getStat score -> 6.8",
    );
    // The score was 1 turn + 5 cells, plus a tenth of 3 turns + 5 cells. The return is not part of
    // a run.
    fixture.check(
        "turnRight -> ack
         turnRight -> ack
         moveForward 3 -> ack
         turnLeft -> ack
         moveForward 2 -> ack
         getStat current-run-distance -> 5
         getStat current-run-turns -> 1
         getStat total-distance -> 10
         getStat total-turns -> 6
         getStat total-effective-distance -> 9.5
         getStat score -> 7.55
         turnRight -> ack
         turnRight -> ack",
    );
    // 2 cells, a turn, and 3 cells that count 2.5.
    fixture.check(
        "moveForward 2 -> ack
         getStat current-run-distance -> 2
         getStat current-run-turns -> 0
         turnRight -> ack
         moveForward 3 -> ack
         getStat best-run-effective-distance -> 4.5
         getStat best-run-distance -> 5
         getStat score -> 7.8",
    );
}

#[test]
fn returning_to_the_start_cancels_the_run() {
    Fixture::new(MAZE).check(
        "moveForward -> ack
         turnRight -> ack
         turnRight -> ack
         moveForward -> ack
         getStat current-run-distance -> 2
         getStat current-run-turns -> 2
         turnRight -> ack
         getStat current-run-turns -> 2
         getStat total-turns -> 3",
    );
}

#[test]
fn only_the_end_of_a_movement_counts() {
    // The mouse passes the goal, turns around, and stops at the goal.
    let mut fixture = Fixture::new("o---o---o---o---o\n| S       G     |\no---o---o---o---o\n");
    fixture.check(
        "turnRight -> ack
         moveForward 3 -> ack
         getStat score -> 2000
         turnLeft -> ack
         turnLeft -> ack
         moveForward -> ack
         getStat best-run-distance -> 4
         getStat best-run-turns -> 2
         getStat best-run-effective-distance -> 3.5",
    );
}

#[test]
fn a_maze_of_one_cell() {
    Fixture::new("o---o\n| S |\no---o\n").check(
        "mazeWidth -> 1
         wallFront 99 -> true
         wallBackLeft 99 -> true
         moveForward 99 -> crash
         moveForwardHalf -> crash
         turnLeft45 -> ack
         moveForwardHalf -> crash
         getStat total-distance -> 0
         getStat score -> 2000",
    );
}
