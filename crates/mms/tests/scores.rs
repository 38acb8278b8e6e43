//! The statistics of command sequences by all rules.
//!
//! The expected values follow from these facts about mms 1.2.0 (`src/Window.cpp` and
//! `src/Stats.cpp` of its source):
//! - `moveForward N` counts 2N and `moveForwardHalf N` counts N, on a diagonal too. A movement whose
//!   first half step is blocked counts nothing. Any other movement counts its full requested
//!   distance, even if it ends in a crash.
//! - The effective distance of a movement of d is d up to 2, and d / 2 + 1 beyond.
//! - Each turn counts 1, including turns of 45°.
//! - A movement that begins in the start cell begins a run. A movement or turn that ends in a goal
//!   cell completes the run, and one that ends in the start cell discards it.
//! - `ackReset` discards the run and adds 15 to the effective distance of the next run, once.
//! - The score is the cost of the best run (turns and effective distance) plus a tenth of the total
//!   cost.

use std::fmt::Write as _;

use mmsim_maze::{Cell, CellSet, Maze, Walls};
use mmsim_mms::{Command, ScoreRules, SimulatedMouse, Stat};

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

/// Executes the commands from the south-west corner and returns a row for each of the rules.
fn rows(mut walls: Walls, goals: CellSet, commands: &str) -> String {
    let mut mouse = SimulatedMouse::new(walls.size(), Cell::new(0, 0), goals);
    for line in commands.split(", ") {
        let command = Command::parse(line.as_bytes(), walls.size()).unwrap();
        let Ok(_) = mouse.execute(command, &mut walls);
    }
    ScoreRules::ALL.iter().fold(String::new(), |mut text, &rules| {
        let stat = |stat| mouse.scores_by(rules).stat(stat).to_string();
        let [score, distances @ ..] = [
            Stat::Score,
            Stat::TotalDistance,
            Stat::TotalEffectiveDistance,
            Stat::TotalTurns,
            Stat::CurrentRunDistance,
            Stat::CurrentRunEffectiveDistance,
            Stat::CurrentRunTurns,
            Stat::BestRunDistance,
            Stat::BestRunEffectiveDistance,
            Stat::BestRunTurns,
        ]
        .map(stat);
        let mut groups = distances.chunks(3).map(|group| group.join(" "));
        let mut group = || groups.next().unwrap_or_default();
        let (total, current, best) = (group(), group(), group());
        writeln!(text, "{rules:8} {total:14} {current:14} {best:14} {score}", rules = rules.name())
            .unwrap();
        text
    })
}

fn in_maze(maze: &str, commands: &str) -> String {
    let maze: Maze = maze.parse().unwrap();
    rows(maze.walls().clone(), *maze.goals(), commands)
}

// The columns of each table are the distance, the effective distance and the turns: in total, of
// the current run and of the best run. The last column is the score.

#[test]
fn straight_movements() {
    // mms: 4 counts 3, 6 counts 4. Score: 7 + 1 + 0.1 * 8.
    // Cells: 2 counts 2, 3 counts 2.5. Score: 4.5 + 1 + 0.1 * 5.5.
    insta::assert_snapshot!(in_maze(MAZE, "moveForward 2, turnRight, moveForward 3"), @"
    mms-1.2  10 7 1         10 7 1         10 7 1         8.8
    cells    5 4.5 1        5 4.5 1        5 4.5 1        6.05
    ");
}

#[test]
fn half_steps() {
    // mms: 1 counts 1, 3 counts 2.5, 6 counts 4. Score: 7.5 + 1 + 0.1 * 8.5.
    // Cells: 0.5 + 1.5 + 2.5, with a distance of 0.5 + 1.5 + 3.
    let commands = "moveForwardHalf, moveForwardHalf 3, turnRight, moveForwardHalf 6";
    insta::assert_snapshot!(in_maze(MAZE, commands), @"
    mms-1.2  10 7.5 1       10 7.5 1       10 7.5 1       9.35
    cells    5 4.5 1        5 4.5 1        5 4.5 1        6.05
    ");
}

#[test]
fn diagonals() {
    // The last movement stops after one half step, at the edge of the goal cell.
    // mms: 1 counts 1, 4 counts 3, 3 counts 2.5. Score: 6.5 + 1 + 0.1 * 7.5.
    // Cells: 0.5 + 2 + 0.5. Score: 3 + 1 + 0.1 * 4.
    let commands = "moveForwardHalf, turnRight45, moveForward 2, moveForwardHalf 3";
    insta::assert_snapshot!(in_maze(STAIRCASE, commands), @"
    mms-1.2  8 6.5 1        8 6.5 1        8 6.5 1        8.25
    cells    3 3 1          3 3 1          3 3 1          4.4
    ");
}

#[test]
fn crashes() {
    // The first movement of 9 stops after 2 cells, the second one after 3. The others do not move.
    // mms: 18 counts 10, twice. Score: 20 + 1 + 0.1 * 21.
    // Cells: 2 + 2.5, as for straight movements.
    let commands = "moveForward 9, moveForward, moveForward 0, turnRight, moveForward 9";
    insta::assert_snapshot!(in_maze(MAZE, commands), @"
    mms-1.2  36 20 1        36 20 1        36 20 1        23.1
    cells    5 4.5 1        5 4.5 1        5 4.5 1        6.05
    ");
    // mms: 1,000,000 counts 500,001; as a distance, it has too many digits.
    insta::assert_snapshot!(in_maze(MAZE, "moveForward 500000"), @"
    mms-1.2  -1 500001 0    -1 500001 0    -1 -1 -1       2000
    cells    2 2 0          2 2 0          -1 -1 -1       2000
    ");
}

#[test]
fn resets() {
    // mms: 2 counts 2. The run begins with 15 and adds 3 + 4. Score: 22 + 1 + 0.1 * (24 + 1).
    // Cells: 1 counts 1. The run begins with 15 and adds 2 + 2.5. Score: 20.5 + 0.1 * 21.5.
    let commands = "moveForward, ackReset, ackReset, moveForward 2, turnRight, moveForward 3";
    insta::assert_snapshot!(in_maze(MAZE, commands), @"
    mms-1.2  12 24 1        10 22 1        10 22 1        25.5
    cells    6 20.5 1       5 19.5 1       5 19.5 1       22.65
    ");
    // Without a movement after the reset there is no penalty.
    insta::assert_snapshot!(in_maze(MAZE, "moveForward, ackReset, turnRight"), @"
    mms-1.2  2 2 1          2 2 0          -1 -1 -1       2000
    cells    1 1 1          1 1 0          -1 -1 -1       2000
    ");
}

#[test]
fn a_return_to_the_start() {
    // The run ends at the start, so the last turn does not count towards it.
    let commands = "moveForward, turnRight, turnRight, moveForward, turnRight";
    insta::assert_snapshot!(in_maze(MAZE, commands), @"
    mms-1.2  4 4 3          4 4 2          -1 -1 -1       2000
    cells    2 2 3          2 2 2          -1 -1 -1       2000
    ");
}

#[test]
fn a_second_run_that_is_better() {
    // mms: the first run costs 5 * 2 + 1, the way back 4 + 3 and 5 turns, the second run 3 + 4 + 1.
    // Score: 8 + 0.1 * (24 + 7).
    // Cells: 5 + 1, then 2.5 + 2 and 5 turns, then 2 + 2.5 + 1. Score: 5.5 + 0.1 * (14 + 7).
    let commands = "moveForward, moveForward, turnRight, moveForward, moveForward, moveForward, \
        turnRight, turnRight, moveForward 3, turnLeft, moveForward 2, turnRight, turnRight, \
        moveForward 2, turnRight, moveForward 3";
    insta::assert_snapshot!(in_maze(MAZE, commands), @"
    mms-1.2  30 24 7        10 7 1         10 7 1         11.1
    cells    15 14 7        5 4.5 1        5 4.5 1        7.6
    ");
}

#[test]
fn a_start_at_the_goal() {
    // In mms, the turn completes an empty run. Score: 0 + 0.1 * 1.
    let walls = Walls::open(mmsim_maze::MazeSize::new(2, 2).unwrap());
    let goals = walls.size().central_cells();
    insta::assert_snapshot!(rows(walls, goals, "turnLeft"), @"
    mms-1.2  0 0 1          0 0 0          0 0 0          0.1
    cells    0 0 1          0 0 0          -1 -1 -1       2000
    ");
}
