//! Floods of every kind held against a plain queue: in real mazes, and in 10,000 generated ones.

use std::collections::VecDeque;

use mmsim_maze::{Catalogue, Cell, CellSet, Heading, MazeSize, Walls};
use mmsim_solvers::{Distances, Downhill, Instructions, steps_between};
use mmsim_tests::{bundled_mazes, shared};

/// The naive twin: steps to the nearest target, row by row, 32 cells to a row.
fn by_queue(walls: &Walls, targets: &CellSet) -> Vec<Option<u16>> {
    let mut steps = vec![None; MazeSize::MAX_AREA];
    let mut queue: VecDeque<_> =
        targets.iter().filter(|&cell| walls.size().contains(cell)).collect();
    for &cell in &queue {
        steps[index(cell)] = Some(0);
    }
    while let Some(cell) = queue.pop_front() {
        for heading in Heading::ALL.into_iter().filter(|&heading| !walls.has(cell, heading)) {
            let next = cell.neighbour(heading).unwrap();
            if steps[index(next)].is_none() {
                steps[index(next)] = steps[index(cell)].map(|steps| steps + 1);
                queue.push_back(next);
            }
        }
    }
    steps
}

fn index(cell: Cell) -> usize {
    32 * usize::from(cell.y) + usize::from(cell.x)
}

/// Floods in every way and compares; gives the longest distance.
fn check(name: &str, walls: &Walls, targets: &CellSet) -> u16 {
    let expected = by_queue(walls, targets);
    let downhill = Downhill::flood(walls, targets);
    let there =
        || Instructions::ALL.iter().copied().filter(|instructions| instructions.is_available());
    let floods: Vec<_> = there().map(|one| Distances::flood_with(one, walls, targets)).collect();
    for cell in walls.size().cells() {
        let steps = expected[index(cell)];
        for (flood, instructions) in floods.iter().zip(there()) {
            assert_eq!(flood.at(cell), steps, "{name}: {cell}, {instructions:?}");
        }
        let leads_down = |&heading: &Heading| {
            let next = cell.neighbour(heading).filter(|_| !walls.has(cell, heading));
            next.is_some_and(|next| {
                expected[index(next)] < steps && expected[index(next)].is_some()
            })
        };
        assert!(
            downhill.headings(cell).eq(Heading::ALL.into_iter().filter(leads_down)),
            "{name}: {cell}"
        );
    }
    for cell in walls.size().cells().step_by(37) {
        assert_eq!(steps_between(walls, cell, targets), expected[index(cell)], "{name}: {cell}");
    }
    expected.into_iter().flatten().max().unwrap_or(0)
}

#[test]
fn real_mazes_are_flooded_as_by_a_queue() {
    let folders = [Some(bundled_mazes()), shared("mazes")];
    for folder in folders.into_iter().flatten() {
        for entry in Catalogue::from_path(&folder).unwrap().entries() {
            let (name, maze) = (entry.name(), entry.maze().unwrap());
            check(&name, maze.walls(), maze.goals());
            check(&name, maze.walls(), &[maze.start().cell].into_iter().collect());
        }
    }
}

/// Numbers without a pattern.
struct Noise(u64);

impl Noise {
    fn below(&mut self, count: usize) -> usize {
        // Knuth's MMIX generator; the upper bits are the good ones.
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap() % count
    }

    /// A maze with one way between any two cells and then some walls taken out: long ways, dead ends
    /// and a few loops, as contest mazes have them.
    fn maze(&mut self) -> Walls {
        let mut cells = |small: bool| 1 + self.below(if small { 16 } else { 32 });
        let small = cells(false) % 2 == 0;
        let size = MazeSize::new(cells(small), cells(small)).unwrap();
        let mut walls = Walls::closed(size);
        let (mut way, mut been) = (vec![Cell::new(0, 0)], CellSet::EMPTY);
        while let Some(&cell) = way.last() {
            been.insert(cell);
            let next = |heading: &Heading| size.neighbour(cell, *heading);
            let is_new = |heading: &Heading| next(heading).is_some_and(|cell| !been.contains(cell));
            let new: Vec<_> = Heading::ALL.into_iter().filter(is_new).collect();
            if new.is_empty() {
                way.pop();
                continue;
            }
            let heading = new[self.below(new.len())];
            walls.set(cell, heading, false);
            way.extend(next(&heading));
        }
        for _ in 0..self.below(1 + size.area() / 8) {
            let cell = self.cell(size);
            walls.set(cell, Heading::ALL[self.below(4)], self.below(4) == 0);
        }
        walls
    }

    fn cell(&mut self, size: MazeSize) -> Cell {
        let mut below = |side: u8| u8::try_from(self.below(side.into())).unwrap();
        Cell::new(below(size.width()), below(size.height()))
    }
}

#[test]
fn generated_mazes_are_flooded_as_by_a_queue() {
    let (mut noise, mut longest) = (Noise(6), 0);
    for count in 0..10_000 {
        let walls = noise.maze();
        let size = walls.size();
        let targets = match count % 3 {
            0 => size.central_cells(),
            1 => [noise.cell(size)].into_iter().collect(),
            _ => (0..noise.below(9)).map(|_| noise.cell(size)).collect(),
        };
        longest = longest.max(check(&format!("maze {count}"), &walls, &targets));
    }
    assert!(longest > 400, "{longest} steps are not far");
}
