//! Fastest runs in random completions of a partly known maze.

use mmsim_fastrun::Planner;
use mmsim_maze::{CellMap, KnownMaze, MazeSize, Unknown, Walls, WyRand};

use super::time_bounds::PlannedRun;

/// The fastest runs in random mazes that agree with all known walls. The more of these runs cross a
/// wall, the more likely the fastest run in the actual maze crosses it.
///
/// In the first sample, three eighths of the random walls stand, in the second one a quarter, in the
/// third one an eighth, and so on in turn. The walls of a sample that are still unknown never change,
/// so most readings change only some of the runs.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampledRuns {
    samples: Vec<Sample>,
}

#[derive(Clone, Debug)]
struct Sample {
    /// The walls that stand if they are unknown.
    random: Walls,
    /// The known walls, and the random walls where the map is unknown.
    walls: Option<Walls>,
    run: Option<PlannedRun>,
}

/// The number of sampled mazes.
const SAMPLES: u64 = 12;

impl SampledRuns {
    /// Updates the runs after the mouse has read further walls.
    pub(crate) fn update(&mut self, planner: &mut Planner, map: &KnownMaze) {
        if self.samples.is_empty() {
            self.samples.extend((0..SAMPLES).map(|seed| Sample::new(seed, map.size())));
        }
        for sample in &mut self.samples {
            sample.update(planner, map);
        }
    }

    /// Returns the number of runs, and for each unvisited cell beside an unknown wall the number of
    /// runs that cross this wall. Samples in which the goal is unreachable have no run.
    pub(crate) fn count(&self, map: &KnownMaze) -> (i32, CellMap<u8>) {
        let mut counts = CellMap::new(0);
        let runs = self.samples.iter().filter_map(|sample| sample.run.as_ref());
        let mut number = 0;
        for run in runs {
            number += 1;
            let unvisited = run.cells_beside_unknown_walls(map) - *map.visited();
            for cell in &unvisited {
                counts[cell] += 1;
            }
        }
        (number, counts)
    }
}

impl Sample {
    fn new(seed: u64, size: MazeSize) -> Self {
        let mut rng = WyRand::new(seed);
        let mut bits = || rng.next_u32();
        let mut row = || match seed % 3 {
            0 => bits() & (bits() | bits()),
            1 => bits() & bits(),
            _ => bits() & bits() & bits(),
        };
        let mut rows = || core::array::from_fn(|_| row());
        let random = Walls::from_rows(size, rows(), rows());
        Self { random, walls: None, run: None }
    }

    fn update(&mut self, planner: &mut Planner, map: &KnownMaze) {
        let walls = combined(map, &self.random);
        let has_only_gained =
            |before: &Walls| before.combine(&walls, |before, now| before | now) == walls;
        let is_possible = self.run.as_ref().is_none_or(|run| run.is_possible(&walls));
        // Further walls make no run faster.
        if !(is_possible && self.walls.as_ref().is_some_and(has_only_gained)) {
            self.run = PlannedRun::plan(planner, map, &walls);
        }
        self.walls = Some(walls);
    }
}

/// Returns the known walls, and those of `random` where the map is unknown.
fn combined(map: &KnownMaze, random: &Walls) -> Walls {
    let (certain, possible) = (map.walls(Unknown::Open), map.walls(Unknown::Closed));
    let unknown = possible.combine(random, |possible, random| possible & random);
    certain.combine(&unknown, |certain, unknown| certain | unknown)
}

#[cfg(test)]
mod tests {
    use mmsim_fastrun::Vehicle;
    use mmsim_maze::{Cell, Heading, Maze, Pose, Wall, WallState};
    use proptest::prelude::*;

    use super::*;
    use crate::tests::random_walls;

    #[test]
    fn samples_agree_with_the_known_walls() {
        let size = MazeSize::new(16, 9).unwrap();
        let mut map = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
        let states = [WallState::Present, WallState::Absent, WallState::Unknown];
        for (wall, &state) in size.walls().zip(states.iter().cycle()) {
            map.set_wall(wall.cell, wall.heading, state);
        }
        let (random, other) = (Sample::new(1, size).random, Sample::new(2, size).random);
        assert_ne!(random, other);
        let walls = combined(&map, &random);
        for Wall { cell, heading, .. } in size.walls() {
            let expected = match map.wall(cell, heading) {
                WallState::Present => true,
                WallState::Absent => false,
                WallState::Unknown => random.has(cell, heading),
            };
            assert_eq!(walls.has(cell, heading), expected, "{cell} {heading}");
        }
    }

    #[test]
    fn one_to_three_eighths_of_the_random_walls_stand() {
        let size = MazeSize::HALF_SIZE;
        let count = size.inner_walls().count();
        for (first, percent) in [(0, 37), (1, 25), (2, 12)] {
            for seed in (first..SAMPLES).step_by(3) {
                let walls = Sample::new(seed, size).random;
                let present =
                    size.inner_walls().filter(|wall| walls.has(wall.cell, wall.heading)).count();
                let found = 100 * present / count;
                assert!(found.abs_diff(percent) <= 4, "{found} % instead of {percent} %");
            }
        }
    }

    proptest! {
        #[test]
        fn runs_that_are_kept_are_fastest(
            walls in random_walls(MazeSize::new(8, 8).unwrap(), 0.6),
            seen in prop::collection::vec((0u8..8, 0u8..8), 1..40),
        ) {
            let size = walls.size();
            let mut map = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
            let mut planner = Planner::new(Vehicle::expert());
            let mut runs = SampledRuns::default();
            for (x, y) in seen {
                let pose = Pose::new(Cell::new(x, y), Heading::North);
                map.observe(pose, walls.around(pose)).unwrap();
                runs.update(&mut planner, &map);
            }
            let mut anew = SampledRuns::default();
            anew.update(&mut planner, &map);
            for (kept, anew) in runs.samples.iter().zip(&anew.samples) {
                let time = |sample: &Sample| sample.run.as_ref().map(|run| run.time);
                match (time(kept), time(anew)) {
                    (Some(kept), Some(anew)) => prop_assert!((kept - anew).abs() < 1e-5),
                    (kept, anew) => prop_assert_eq!(kept, anew),
                }
            }
        }
    }

    #[test]
    fn every_run_through_a_corridor_counts_its_unvisited_cells() {
        let maze: Maze = "\
o---o---o---o---o
|             G |
o---o---o   o---o
| S             |
o---o---o---o---o
"
        .parse()
        .unwrap();
        let mut map = KnownMaze::unexplored(&maze);
        let mut planner = Planner::new(Vehicle::expert());
        let mut runs = SampledRuns::default();
        for cell in [Cell::new(0, 0), Cell::new(1, 0), Cell::new(2, 0)] {
            for heading in [Heading::North, Heading::South] {
                let pose = Pose::new(cell, heading);
                map.observe(pose, maze.walls().around(pose)).unwrap();
            }
        }
        // Every run passes the wall to the east of (2, 1) and crosses (3, 1).
        map.set_wall(Cell::new(3, 0), Heading::North, WallState::Present);
        runs.update(&mut planner, &map);
        let (number, counts) = runs.count(&map);
        assert!(number > 0, "all samples close the last wall");
        for cell in map.size().cells() {
            let is_counted = [Cell::new(2, 1), Cell::new(3, 1)].contains(&cell);
            let expected = if is_counted { number } else { 0 };
            assert_eq!(i32::from(counts[cell]), expected, "{cell}");
        }
    }
}
