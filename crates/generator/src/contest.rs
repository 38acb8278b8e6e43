//! Mazes like those of contests.

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Walls};
use mmsim_solvers::Distances;

use crate::posts::{Place, Post, walls_to_the_edge};
use crate::random::Random;
use crate::tree::{self, Habits};
use crate::{START, closed_round};

/// The shortest side with room for a goal that has cells all round.
pub(crate) const SHORTEST_SIDE: u8 = 3;

/// How often a maze is begun anew because its goal is too near.
const TRIES: u32 = 32;

// Each maze draws its own numbers from these, which are chosen such that mazes come out as real
// ones are: see the table in the documentation of the crate.
const STRAIGHT: [u32; 2] = [1, 10];
const STAIRS: [u32; 2] = [1, 8];
const ENDS_PERCENT: [u32; 2] = [0, 20];
/// Loops in a maze of 16×16 cells, besides the one round the goal.
const LOOPS: [u32; 2] = [3, 28];
/// How many of them at most begin in a dead end.
const AT_DEAD_ENDS_PERCENT: [u32; 2] = [0, 60];
/// How long the shortest path is at least, in tenths of its length without walls.
const PATH_TENTHS: [u32; 2] = [20, 60];

/// The walls of a contest maze, whose sides are both at least [`SHORTEST_SIDE`].
pub(crate) fn walls(size: MazeSize, random: &mut Random) -> Walls {
    let room = size.central_cells();
    let direct = Distances::flood(&Walls::open(size), &room).at(START).map_or(0, u32::from);
    for failed in 0..TRIES {
        // Not every size can have any path, so less is asked for each time.
        let tenths = random.between([PATH_TENTHS[0], PATH_TENTHS[1] - failed]);
        let mut draft = Draft::new(size, room, direct * tenths / 10);
        if draft.build(random) {
            return draft.walls;
        }
    }
    let mut draft = Draft::new(size, room, 0);
    draft.build(random);
    draft.walls
}

/// A maze that is being built.
struct Draft {
    walls: Walls,
    /// The goal cells.
    room: CellSet,
    /// Steps that the shortest path has at least.
    min_path: u32,
}

impl Draft {
    fn new(size: MazeSize, room: CellSet, min_path: u32) -> Self {
        Self { walls: closed_round(size, &room), room, min_path }
    }

    /// Builds it and says whether the goal is an island, as far away as it shall be.
    fn build(&mut self, random: &mut Random) -> bool {
        self.lay_passages(random);
        if !self.is_far() {
            return false;
        }
        let is_island = self.cut_goal_off(random);
        self.open_loops(random);
        is_island
    }

    /// Opens one way between any two cells; those to the start and into the room lead no further.
    fn lay_passages(&mut self, random: &mut Random) {
        let free = self.walls.size().cells();
        let free = free.filter(|&cell| cell != START && !self.room.contains(cell)).collect();
        let habits = Habits {
            straight: random.between(STRAIGHT),
            stairs: random.between(STAIRS),
            ends_percent: random.between(ENDS_PERCENT),
        };
        let root = (Cell::new(START.x, START.y + 1), Heading::North);
        self.walls.set(START, Heading::North, false);
        tree::winding(&mut self.walls, root, free, habits, random);
        let ways_in = self.room_walls();
        let (cell, heading) = ways_in[random.index(ways_in.len())];
        self.walls.set(cell, heading, false);
    }

    /// Opens a wall such that none leads from the room to the outer wall, and says whether it could.
    /// Then who follows the walls from the start never comes to the goal, which is why contests
    /// have it so.
    fn cut_goal_off(&mut self, random: &mut Random) -> bool {
        let posts = self.room_walls().into_iter().flat_map(Post::ends);
        match walls_to_the_edge(&self.walls, posts) {
            // With a single way between any two cells all walls hang together, and there is one way
            // along them, too.
            Some(way) => random.shuffled(way).into_iter().any(|place| self.open(place)),
            None => true,
        }
    }

    /// Opens further ways, some of them out of dead ends.
    fn open_loops(&mut self, random: &mut Random) {
        let size = self.walls.size();
        let mut loops = random.between(LOOPS) * u32::from(size.width()) * u32::from(size.height())
            / u32::from(MazeSize::CLASSIC.width()).pow(2);
        let mut at_dead_ends = loops * random.between(AT_DEAD_ENDS_PERCENT) / 100;
        for cell in random.shuffled(size.cells()) {
            let is_dead_end = self.walls.open_neighbours(cell).count() == 1;
            let mut sides = random.shuffled(Heading::ALL).into_iter();
            if at_dead_ends > 0 && is_dead_end && sides.any(|heading| self.open((cell, heading))) {
                at_dead_ends -= 1;
                loops -= 1;
            }
        }
        let places =
            size.cells().flat_map(|cell| [Heading::North, Heading::East].map(|to| (cell, to)));
        for place in random.shuffled(places) {
            if loops > 0 && self.open(place) {
                loops -= 1;
            }
        }
    }

    /// Opens the wall at this place and says so, unless there is none, the start or the room would
    /// have a second way in, a post would carry no wall, or the goal would be too near.
    fn open(&mut self, place: Place) -> bool {
        let (cell, heading) = place;
        let is_kept = |cell| cell == START || self.room.contains(cell);
        let Some(next) = self.walls.size().neighbour(cell, heading) else { return false };
        if is_kept(cell) || is_kept(next) || !self.walls.has(cell, heading) {
            return false;
        }
        self.walls.set(cell, heading, false);
        let is_fine = Post::ends(place).into_iter().all(|post| post.carries_wall(&self.walls))
            && self.is_far();
        if !is_fine {
            self.walls.set(cell, heading, true);
        }
        is_fine
    }

    fn is_far(&self) -> bool {
        let path = Distances::flood(&self.walls, &self.room).at(START);
        path.is_some_and(|steps| u32::from(steps) >= self.min_path)
    }

    /// Where the walls round the room stand; one of them is open in the end.
    fn room_walls(&self) -> Vec<Place> {
        let sides = self.room.iter().flat_map(|cell| Heading::ALL.map(|heading| (cell, heading)));
        let is_outside = |cell: &Cell| !self.room.contains(*cell);
        sides.filter(|&(cell, to)| cell.neighbour(to).as_ref().is_some_and(is_outside)).collect()
    }
}
