//! Mazes with one way between any two cells: spanning trees.

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Walls};

use crate::random::Random;

/// Opens walls until there is one way from each cell of `free` to the cells of `tree`. Every such
/// maze is as likely as any other. From each free cell there has to be a way over others.
///
/// Wilson's algorithm ("Generating random spanning trees more quickly than the cover time", STOC
/// 1996): walk at random from a cell outside of the tree until the tree is met; the walk without
/// its loops is a new branch.
pub(crate) fn uniform(walls: &mut Walls, mut tree: CellSet, free: &CellSet, random: &mut Random) {
    let size = walls.size();
    let mut exits = [Heading::North; MazeSize::MAX_AREA];
    let index = |cell: Cell| usize::from(cell.y) * usize::from(size.width()) + usize::from(cell.x);
    for from in free.iter() {
        let mut cell = from;
        while !tree.contains(cell) {
            let heading = Heading::ALL[random.below(4) as usize];
            let next = size.neighbour(cell, heading);
            if let Some(next) = next.filter(|&next| free.contains(next) || tree.contains(next)) {
                exits[index(cell)] = heading;
                cell = next;
            }
        }
        // The last exit of each cell leads past all loops.
        cell = from;
        while tree.insert(cell) {
            let heading = exits[index(cell)];
            walls.set(cell, heading, false);
            cell = size.neighbour(cell, heading).unwrap_or(cell);
        }
    }
}

/// How passages wind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Habits {
    /// How many times as likely it is to go straight on as to turn.
    pub(crate) straight: u32,
    /// How many times as likely it is to turn back to the heading of the step before the last one:
    /// a staircase, which fast mice run diagonally.
    pub(crate) stairs: u32,
    /// In how many of a hundred cells a passage ends, and another one begins somewhere else.
    pub(crate) ends_percent: u32,
}

/// Opens walls until there is one way between any two cells of `free`, beginning in one of them
/// with a heading.
///
/// A search in depth, which makes long passages, but for those that end too early.
pub(crate) fn winding(
    walls: &mut Walls,
    (root, heading): (Cell, Heading),
    mut free: CellSet,
    habits: Habits,
    random: &mut Random,
) {
    let size = walls.size();
    free.remove(root);
    // Cells that may have free neighbours, with the last two headings on the way there.
    let mut begun = vec![(root, [heading; 2])];
    while let Some(last) = begun.len().checked_sub(1) {
        let ends = random.below(100) < habits.ends_percent;
        let index = if ends { random.index(begun.len()) } else { last };
        let (cell, [before, ahead]) = begun[index];
        let weights = Heading::ALL.map(|heading| {
            let is_free = size.neighbour(cell, heading).is_some_and(|next| free.contains(next));
            match heading {
                _ if !is_free => 0,
                _ if heading == ahead => habits.straight,
                _ if heading == before => habits.stairs,
                _ => 1,
            }
        });
        let drawn = random.weighted(weights).map(|number| Heading::ALL[number]);
        let Some((heading, next)) = drawn.and_then(|to| Some((to, size.neighbour(cell, to)?)))
        else {
            begun.remove(index);
            continue;
        };
        walls.set(cell, heading, false);
        free.remove(next);
        begun.push((next, [ahead, heading]));
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
        let mut random = Random::new(1);
        let mut counts: HashMap<Walls, u32> = HashMap::new();
        for _ in 0..15_000 {
            let mut walls = Walls::closed(size);
            uniform(&mut walls, root, &free, &mut random);
            *counts.entry(walls).or_default() += 1;
        }
        assert_eq!(counts.len(), 15);
        assert!(counts.values().all(|count| (850..1_150).contains(count)), "{counts:?}");
    }

    #[test]
    fn habits_make_straights_and_stairs() {
        let turns = |habits: Habits| {
            let (size, root) = (MazeSize::HALF_SIZE, (Cell::new(0, 0), Heading::North));
            let mut walls = Walls::closed(size);
            winding(&mut walls, root, size.cells().collect(), habits, &mut Random::new(1));
            let opposite = |cell: &Cell| {
                let is_open = |heading| !walls.has(*cell, heading);
                Heading::ALL.into_iter().any(|heading| is_open(heading) && is_open(heading.back()))
            };
            let dead_ends = size.cells().filter(|&cell| walls.open_neighbours(cell).count() == 1);
            (size.cells().filter(|cell| !opposite(cell)).count(), dead_ends.count())
        };
        let plain = Habits { straight: 1, stairs: 1, ends_percent: 0 };
        let (bends, dead_ends) = turns(plain);
        assert!(turns(Habits { straight: 9, ..plain }).0 < bends / 2);
        assert!(turns(Habits { stairs: 9, ..plain }).0 > bends * 5 / 4);
        assert!(turns(Habits { ends_percent: 50, ..plain }).1 > dead_ends * 3 / 2);
    }
}
