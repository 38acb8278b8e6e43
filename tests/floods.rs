//! Compares every flood implementation with a simple flood that uses a queue, in real mazes and in
//! 10,000 generated mazes.

use std::collections::VecDeque;

use mmsim_formats::Catalogue;
use mmsim_maze::{Cell, CellMap, CellSet, Heading, MazeSize, Walls, WyRand};
use mmsim_solvers::{Distances, Downhill, Instructions, steps_between};
use mmsim_tests::shared;

/// The reference implementation. Returns the number of steps from each cell to the nearest target.
fn flood_with_queue(walls: &Walls, targets: &CellSet) -> CellMap<Option<u16>> {
    let mut steps = CellMap::new(None);
    let mut queue: VecDeque<_> =
        targets.iter().filter(|&cell| walls.size().contains(cell)).collect();
    for &cell in &queue {
        steps[cell] = Some(0);
    }
    while let Some(cell) = queue.pop_front() {
        for heading in Heading::ALL.into_iter().filter(|&heading| !walls.has(cell, heading)) {
            let next = cell.neighbour(heading).unwrap();
            if steps[next].is_none() {
                steps[next] = steps[cell].map(|steps| steps + 1);
                queue.push_back(next);
            }
        }
    }
    steps
}

/// Compares every flood implementation with the reference implementation. Returns the longest
/// distance, in steps.
fn check(name: &str, walls: &Walls, targets: &CellSet) -> u16 {
    let expected = flood_with_queue(walls, targets);
    let downhill = Downhill::flood(walls, targets);
    let available = Instructions::ALL.iter().copied().filter(|one| one.is_available());
    let flood = |instructions| Distances::flood_with(instructions, walls, targets);
    let floods: Vec<_> = available.clone().map(flood).collect();
    for cell in walls.size().cells() {
        let steps = expected[cell];
        for (flood, instructions) in floods.iter().zip(available.clone()) {
            assert_eq!(flood.at(cell), steps, "{name}: {cell}, {instructions:?}");
        }
        let is_downhill = |&heading: &Heading| {
            let next = cell.neighbour(heading).filter(|_| !walls.has(cell, heading));
            next.is_some_and(|next| expected[next] < steps && expected[next].is_some())
        };
        assert!(
            downhill.headings(cell).eq(Heading::ALL.into_iter().filter(is_downhill)),
            "{name}: {cell}"
        );
    }
    for cell in walls.size().cells().step_by(37) {
        assert_eq!(steps_between(walls, cell, targets), expected[cell], "{name}: {cell}");
    }
    walls.size().cells().filter_map(|cell| expected[cell]).max().unwrap_or(0)
}

#[test]
fn floods_of_real_mazes_match_the_reference() {
    let real = shared("mazes").map(|folder| Catalogue::from_path(&folder).unwrap());
    for catalogue in [Some(Catalogue::bundled()), real].into_iter().flatten() {
        for entry in catalogue.entries() {
            let (name, maze) = (entry.name(), entry.maze().unwrap());
            check(&name, maze.walls(), maze.goals());
            check(&name, maze.walls(), &[maze.start().cell].into_iter().collect());
        }
    }
}

/// A generator of pseudorandom mazes.
struct MazeNoise(WyRand);

impl MazeNoise {
    /// Returns a maze with long paths, dead ends and a few loops, like a contest maze. The maze is
    /// made from a spanning tree by adding or removing some walls.
    fn maze(&mut self) -> Walls {
        let mut random_side = |is_small: bool| 1 + self.0.index(if is_small { 16 } else { 32 });
        let is_small = random_side(false) % 2 == 0;
        let size = MazeSize::new(random_side(is_small), random_side(is_small)).unwrap();
        let mut walls = Walls::closed(size);
        let (mut path, mut visited) = (vec![Cell::new(0, 0)], CellSet::EMPTY);
        while let Some(&cell) = path.last() {
            visited.insert(cell);
            let next = |heading: &Heading| size.neighbour(cell, *heading);
            let is_new =
                |heading: &Heading| next(heading).is_some_and(|cell| !visited.contains(cell));
            let new: Vec<_> = Heading::ALL.into_iter().filter(is_new).collect();
            if new.is_empty() {
                path.pop();
                continue;
            }
            let heading = new[self.0.index(new.len())];
            walls.set(cell, heading, false);
            path.extend(next(&heading));
        }
        for _ in 0..self.0.index(1 + size.area() / 8) {
            let cell = self.cell(size);
            walls.set(cell, Heading::ALL[self.0.index(4)], self.0.index(4) == 0);
        }
        walls
    }

    fn cell(&mut self, size: MazeSize) -> Cell {
        let mut below = |side: u8| u8::try_from(self.0.index(side.into())).unwrap();
        Cell::new(below(size.width()), below(size.height()))
    }
}

#[test]
fn floods_of_generated_mazes_match_the_reference() {
    let (mut noise, mut longest) = (MazeNoise(WyRand::new(6)), 0);
    for count in 0..10_000 {
        let walls = noise.maze();
        let size = walls.size();
        let targets = match count % 3 {
            0 => size.central_cells(),
            1 => [noise.cell(size)].into_iter().collect(),
            _ => (0..noise.0.index(9)).map(|_| noise.cell(size)).collect(),
        };
        longest = longest.max(check(&format!("maze {count}"), &walls, &targets));
    }
    assert!(longest > 400, "the longest distance is only {longest} steps");
}
