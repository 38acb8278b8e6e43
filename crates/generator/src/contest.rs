//! Contest-like mazes.

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Wall, Walls, WyRand};
use mmsim_solvers::Distances;

use crate::perfect::{PassageParams, START, closed_around, open_winding_tree};
use crate::posts::{Post, walls_to_outer_wall};

/// The minimum side length, in cells, of a maze in which the goal does not touch the outer wall.
pub(crate) const MIN_SIDE: u8 = 3;

/// The maximum number of attempts to generate a maze whose goal is far enough from the start.
const MAX_ATTEMPTS: u32 = 32;

// The parameters of each maze are drawn from these ranges, which are chosen so that the mazes
// resemble real mazes. The crate documentation has a comparison.
const STRAIGHT: [u32; 2] = [1, 10];
const STAIRS: [u32; 2] = [1, 8];
const ENDS_PERCENT: [u32; 2] = [0, 20];
/// The number of loops in a maze of 16×16 cells, not counting the loop around the goal.
const LOOPS: [u32; 2] = [3, 28];
/// The maximum share of loops that are created at dead ends, in percent.
const AT_DEAD_ENDS_PERCENT: [u32; 2] = [0, 60];
/// The minimum length of the shortest path, in tenths of its length in a maze without walls.
const PATH_TENTHS: [u32; 2] = [20, 60];

/// Returns the walls of a contest maze. Both sides of the maze must be at least [`MIN_SIDE`] cells
/// long.
pub(crate) fn walls(size: MazeSize, rng: &mut WyRand) -> Walls {
    let room = size.central_cells();
    let direct = Distances::flood(&Walls::open(size), &room).at(START).map_or(0, u32::from);
    for failed in 0..MAX_ATTEMPTS {
        // Long paths do not fit every size, so each attempt lowers the upper limit.
        let tenths = rng.between([PATH_TENTHS[0], PATH_TENTHS[1] - failed]);
        let mut draft = Draft::new(size, room, direct * tenths / 10);
        if draft.build(rng) {
            return draft.walls;
        }
    }
    let mut draft = Draft::new(size, room, 0);
    draft.build(rng);
    draft.walls
}

/// A maze under construction.
struct Draft {
    walls: Walls,
    /// The goal cells.
    room: CellSet,
    /// The minimum length, in steps, of the shortest path from the start to the goal.
    min_path: u32,
}

impl Draft {
    fn new(size: MazeSize, room: CellSet, min_path: u32) -> Self {
        Self { walls: closed_around(size, &room), room, min_path }
    }

    /// Builds the maze. Returns true if the shortest path to the goal has at least `min_path`
    /// steps, and no chain of walls connects the goal to the outer wall.
    fn build(&mut self, rng: &mut WyRand) -> bool {
        self.create_passages(rng);
        if !self.is_far() {
            return false;
        }
        let is_island = self.isolate_goal(rng);
        self.open_loops(rng);
        is_island
    }

    /// Opens walls until there is exactly one path between any two cells. The start and the goal
    /// room become dead ends.
    fn create_passages(&mut self, rng: &mut WyRand) {
        let free = self.walls.size().cells();
        let free = free.filter(|&cell| cell != START && !self.room.contains(cell)).collect();
        let params = PassageParams {
            straight: rng.between(STRAIGHT),
            stairs: rng.between(STAIRS),
            ends_percent: rng.between(ENDS_PERCENT),
        };
        let root = (Cell::new(START.x, START.y + 1), Heading::North);
        self.walls.set(START, Heading::North, false);
        open_winding_tree(&mut self.walls, root, free, params, rng);
        let entrances = self.room_walls();
        let entrance = entrances[rng.index(entrances.len())];
        self.walls.set(entrance.cell, entrance.heading, false);
    }

    /// Opens a wall so that no chain of walls connects the goal room to the outer wall. As in most
    /// contest mazes, a wall follower then cannot reach the goal. Returns true on success.
    fn isolate_goal(&mut self, rng: &mut WyRand) -> bool {
        let posts = self.room_walls().into_iter().flat_map(Post::ends);
        match walls_to_outer_wall(&self.walls, posts) {
            // In a perfect maze all walls are connected, and there is only one such chain.
            Some(chain) => shuffled(chain, rng).into_iter().any(|wall| self.open(wall)),
            None => true,
        }
    }

    /// Creates loops by opening walls, some of them at dead ends.
    fn open_loops(&mut self, rng: &mut WyRand) {
        let size = self.walls.size();
        let mut loops = rng.between(LOOPS) * u32::from(size.width()) * u32::from(size.height())
            / u32::from(MazeSize::CLASSIC.width()).pow(2);
        let mut at_dead_ends = loops * rng.between(AT_DEAD_ENDS_PERCENT) / 100;
        for cell in shuffled(size.cells(), rng) {
            let is_dead_end = self.walls.open_neighbours(cell).count() == 1;
            let mut walls = shuffled(Heading::ALL.map(|to| Wall::new(cell, to)), rng).into_iter();
            if at_dead_ends > 0 && is_dead_end && walls.any(|wall| self.open(wall)) {
                at_dead_ends -= 1;
                loops -= 1;
            }
        }
        for wall in shuffled(size.walls(), rng) {
            if loops > 0 && self.open(wall) {
                loops -= 1;
            }
        }
    }

    /// Opens an inner wall. Returns false if the wall is absent, an outer wall, or must stay. The start
    /// and the goal room keep a single entrance, each post keeps at least one wall, and the goal stays
    /// far enough from the start.
    fn open(&mut self, wall: Wall) -> bool {
        let Wall { cell, heading, .. } = wall;
        let is_protected = |cell| cell == START || self.room.contains(cell);
        let Some(next) = self.walls.size().neighbour(cell, heading) else { return false };
        if is_protected(cell) || is_protected(next) || !self.walls.has(cell, heading) {
            return false;
        }
        self.walls.set(cell, heading, false);
        let is_valid =
            Post::ends(wall).into_iter().all(|post| post.has_wall(&self.walls)) && self.is_far();
        if !is_valid {
            self.walls.set(cell, heading, true);
        }
        is_valid
    }

    fn is_far(&self) -> bool {
        let path = Distances::flood(&self.walls, &self.room).at(START);
        path.is_some_and(|steps| u32::from(steps) >= self.min_path)
    }

    /// Returns the walls around the goal room, which are the candidates for its entrance.
    fn room_walls(&self) -> Vec<Wall> {
        let walls = self.room.iter().flat_map(|cell| Heading::ALL.map(|to| Wall::new(cell, to)));
        walls.filter(|wall| wall.cells().any(|cell| !self.room.contains(cell))).collect()
    }
}

/// Returns the items in random order.
fn shuffled<T>(items: impl IntoIterator<Item = T>, rng: &mut WyRand) -> Vec<T> {
    let mut items: Vec<T> = items.into_iter().collect();
    rng.shuffle(&mut items);
    items
}
