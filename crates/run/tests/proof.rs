//! The state in which the fastest run is proven.

use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_run::{FastestRun, Judge};
use mmsim_solvers::{FastestPathSearch, Mouse, SearchDriver};

/// The path with the fewest steps has more turns than the fastest one.
const DETOUR: &str = "\
o---o---o---o---o---o
|                   |
o   o---o---o---o   o
|       |       |   |
o   o   o   o   o   o
| S |       | G     |
o---o---o---o---o---o
";

/// The judge looks for the proof by bisection. A check in each state finds the same step.
#[test]
fn the_proof_is_found_in_the_first_state_that_has_it() {
    let maze: Maze = DETOUR.parse().unwrap();
    let (mut planner, mut judge) = (Planner::new(Vehicle::expert()), Judge::new(&maze));
    let map = KnownMaze::unexplored(&maze);
    let mut mouse = Mouse::new(FastestPathSearch::default(), map, maze.start());
    let mut driver = SearchDriver::new(&mut mouse, 1000);
    let (mut first, mut states) = (None, 0);
    while driver.advance_in(&maze) == Ok(true) {
        states += 1;
        let pose = driver.mouse().pose();
        judge.add(pose, false);
        judge.read_walls(pose);
        if FastestRun::new(judge.known(), &mut planner).fastest_run_proven {
            first.get_or_insert(driver.stats().steps());
        }
        assert_eq!(judge.steps_until_fastest_run_proven(&mut planner), first, "state {states}");
    }
    assert!(first.is_some_and(|steps| 0 < steps && steps < states - 1), "{first:?} of {states}");
}
