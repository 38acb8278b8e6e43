//! Perfect mazes, with exactly one path between any two cells (spanning trees), and open mazes derived
//! from them.

use mmsim_maze::{Cell, CellMap, CellSet, Heading, MazeSize, Walls, WyRand};

/// The start cell of every maze.
pub(crate) const START: Cell = Cell::new(0, 0);

/// Returns the walls of a perfect maze.
pub(crate) fn perfect(size: MazeSize, rng: &mut WyRand) -> Walls {
    let room = size.central_cells();
    let mut walls = closed_around(size, &room);
    let mut free: CellSet = size.cells().filter(|&cell| !room.contains(cell)).collect();
    // The start is a dead end unless the maze is a single row or column.
    if size.width() > 1 && size.height() > 1 && free.remove(START) {
        walls.set(START, Heading::North, false);
    }
    open_uniform_tree(&mut walls, room, &free, rng);
    walls
}

/// Returns the walls of an open maze: a perfect maze with most walls removed.
pub(crate) fn open(size: MazeSize, rng: &mut WyRand) -> Walls {
    /// The probability, in tenths, that a wall remains.
    const REMAINING_TENTHS: u32 = 3;
    let mut walls = perfect(size, rng);
    for wall in size.walls().filter(|wall| wall.cell != START) {
        if rng.below(10) >= REMAINING_TENTHS {
            walls.set(wall.cell, wall.heading, false);
        }
    }
    walls
}

/// Returns a maze with all walls except those inside the goal room.
pub(crate) fn closed_around(size: MazeSize, room: &CellSet) -> Walls {
    let mut walls = Walls::closed(size);
    for cell in room {
        for heading in Heading::ALL {
            if cell.neighbour(heading).is_some_and(|next| room.contains(next)) {
                walls.set(cell, heading, false);
            }
        }
    }
    walls
}

/// Opens walls until exactly one path leads from each cell of `free` to the cells of `tree`. All
/// possible results are equally likely. Every free cell must be connected to `tree` through free
/// cells.
///
/// This is Wilson's algorithm ("Generating random spanning trees more quickly than the cover time",
/// STOC 1996). Each random walk starts at a cell outside the tree and ends in the tree. After each
/// walk, its loops are erased, and the remaining path becomes a branch of the tree.
fn open_uniform_tree(walls: &mut Walls, mut tree: CellSet, free: &CellSet, rng: &mut WyRand) {
    let size = walls.size();
    let mut exits = CellMap::new(Heading::North);
    for from in free {
        let mut cell = from;
        while !tree.contains(cell) {
            let heading = Heading::ALL[rng.below(4) as usize];
            let next = size.neighbour(cell, heading);
            if let Some(next) = next.filter(|&next| free.contains(next) || tree.contains(next)) {
                exits[cell] = heading;
                cell = next;
            }
        }
        // The last exits of the cells form the walk without its loops.
        cell = from;
        while tree.insert(cell) {
            let heading = exits[cell];
            walls.set(cell, heading, false);
            cell = size.neighbour(cell, heading).unwrap_or(cell);
        }
    }
}

/// Parameters of passages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassageParams {
    /// The weight of going straight, relative to a turn with weight 1.
    pub(crate) straight: u32,
    /// The weight of a turn opposite to the previous turn, relative to other turns with weight 1.
    /// Alternating turns form staircases, which fast mice run diagonally.
    pub(crate) stairs: u32,
    /// The probability, in percent, that the search ends a passage and continues from a random
    /// cell.
    pub(crate) ends_percent: u32,
}

/// Opens walls until there is exactly one path between any two cells of `free`. The search starts
/// in `root`, a cell of `free`, facing `heading`.
///
/// The algorithm is a depth-first search, which creates long passages. To create more dead ends, it
/// also ends passages at random.
pub(crate) fn open_winding_tree(
    walls: &mut Walls,
    (root, heading): (Cell, Heading),
    mut free: CellSet,
    params: PassageParams,
    rng: &mut WyRand,
) {
    let size = walls.size();
    free.remove(root);
    // The cells that may have free neighbours, with the last two headings of the path to each.
    let mut active = vec![(root, [heading; 2])];
    while let Some(last) = active.len().checked_sub(1) {
        let ends = rng.below(100) < params.ends_percent;
        let index = if ends { rng.index(active.len()) } else { last };
        let (cell, [previous, ahead]) = active[index];
        let weights = Heading::ALL.map(|heading| {
            let is_free = size.neighbour(cell, heading).is_some_and(|next| free.contains(next));
            match heading {
                _ if !is_free => 0,
                _ if heading == ahead => params.straight,
                _ if heading == previous => params.stairs,
                _ => 1,
            }
        });
        let drawn = rng.weighted(weights).map(|number| Heading::ALL[number]);
        let Some((heading, next)) = drawn.and_then(|to| Some((to, size.neighbour(cell, to)?)))
        else {
            active.remove(index);
            continue;
        };
        walls.set(cell, heading, false);
        free.remove(next);
        active.push((next, [ahead, heading]));
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    #[test]
    fn all_trees_are_equally_likely() {
        // A maze of 2×3 cells has 15 spanning trees.
        let size = MazeSize::new(2, 3).unwrap();
        let root: CellSet = [Cell::new(1, 1)].into_iter().collect();
        let free = size.cells().filter(|&cell| !root.contains(cell)).collect();
        let mut rng = WyRand::new(1);
        let mut counts: HashMap<Walls, u32> = HashMap::new();
        for _ in 0..15_000 {
            let mut walls = Walls::closed(size);
            open_uniform_tree(&mut walls, root, &free, &mut rng);
            *counts.entry(walls).or_default() += 1;
        }
        assert_eq!(counts.len(), 15);
        assert!(counts.values().all(|count| (850..1_150).contains(count)), "{counts:?}");
    }

    #[test]
    fn parameters_control_straights_stairs_and_dead_ends() {
        let turns = |params: PassageParams| {
            let (size, root) = (MazeSize::HALF_SIZE, (Cell::new(0, 0), Heading::North));
            let mut walls = Walls::closed(size);
            open_winding_tree(
                &mut walls,
                root,
                size.cells().collect(),
                params,
                &mut WyRand::new(1),
            );
            let opposite = |cell: &Cell| {
                let is_open = |heading| !walls.has(*cell, heading);
                Heading::ALL.into_iter().any(|heading| is_open(heading) && is_open(heading.back()))
            };
            let dead_ends = size.cells().filter(|&cell| walls.open_neighbours(cell).count() == 1);
            (size.cells().filter(|cell| !opposite(cell)).count(), dead_ends.count())
        };
        let plain = PassageParams { straight: 1, stairs: 1, ends_percent: 0 };
        let (bends, dead_ends) = turns(plain);
        assert!(turns(PassageParams { straight: 9, ..plain }).0 < bends / 2);
        assert!(turns(PassageParams { stairs: 9, ..plain }).0 > bends * 5 / 4);
        assert!(turns(PassageParams { ends_percent: 50, ..plain }).1 > dead_ends * 3 / 2);
    }
}
