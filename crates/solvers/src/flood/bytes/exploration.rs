//! Selection of the cell to explore next, with one byte per cell.

// The indices of cells are less than 256.
#![allow(clippy::cast_possible_truncation)]

use core::cmp::Reverse;

use mmsim_maze::{Cell, CellSet, KnownMaze, MazeSize, Row, Unknown, Walls};

use super::FloodMemory;
use super::waves::{EAST, NORTH, OpenSides, SOUTH, UNVISITED, WEST, cell_at, index, nearest};
use crate::flood::steps::{SMALL_AREA, SMALL_SIDE};

/// A flag beside the open sides of a path cell: a path from it to the goal is known to be open.
const OPEN: u8 = 1 << 6;
/// A flag beside the open sides of a path cell: the cell is next to an unknown wall that an
/// optimistic shortest path crosses.
const DOUBTFUL: u8 = 1 << 7;

/// The selection of the cell to explore next in a small maze.
// A struct, because the compiler makes slower loops from arguments whose addresses are constant, as
// those of a `static` mouse are.
pub(crate) struct TargetSelection<'a> {
    pub(crate) map: &'a KnownMaze,
    pub(crate) mouse: Cell,
    pub(crate) paths: &'a mut CellSet,
    pub(crate) memory: &'a mut FloodMemory,
    /// Memory for distances and lists.
    pub(crate) bytes: &'a mut [u8; SMALL_AREA],
}

impl TargetSelection<'_> {
    /// Does the same as [`exploration_target`](crate::flood::exploration_target). Overwrites
    /// `memory` and `bytes`.
    // Not inlined, so that the sets occupy the stack only during this call.
    #[inline(never)]
    pub(crate) fn find(self) -> Option<Cell> {
        let Self { map, mouse, paths, memory, bytes } = self;
        let FloodMemory { sides, from_start, candidates } = memory;
        let open = map.walls(Unknown::Open);
        let goals = nearest(open, map.start().cell, map.goals(), sides, from_start);
        *paths = follow_back(map, &goals, sides, from_start, bytes, candidates)?;
        let nearest = nearest(open, mouse, candidates, sides, bytes);
        nearest.iter().min_by_key(|&cell| Reverse(from_start[index(cell) % SMALL_AREA]))
    }
}

/// Follows the optimistic shortest paths from the nearest goal cells back to the start. Returns all
/// path cells, and puts the cells that [`exploration_target`](crate::flood::exploration_target) considers into `candidates`.
/// Returns `None` if one of the paths is known to be open, or if there is no path.
///
/// The paths are found layer by layer. A layer consists of all path cells with the same distance
/// from the start. The cells of a layer form a list, in which each cell links to the next one.
#[inline(never)]
fn follow_back(
    map: &KnownMaze,
    goals: &CellSet,
    sides: &mut OpenSides,
    from_start: &[u8; SMALL_AREA],
    links: &mut [u8; SMALL_AREA],
    candidates: &mut CellSet,
) -> Option<CellSet> {
    let length = from_start[index(goals.iter().next()?) % SMALL_AREA];
    let visited = map.visited().rows();
    sides.fill_in(map.walls(Unknown::Open));
    let (known, found) = (map.walls(Unknown::Closed), *CellSet::EMPTY.rows());
    let mut paths = Paths { sides, known, from_start, links, found, first: 0, width: 0 };
    for goal in goals.iter().map(index) {
        let byte = &mut paths.sides.around(goal)[SMALL_SIDE];
        *byte = *byte & !UNVISITED | OPEN;
        paths.add(goal);
    }
    let mut least_width = SMALL_AREA;
    *candidates = CellSet::EMPTY;
    for steps in (0..=usize::from(length)).rev() {
        let (first, cells) = (paths.first, paths.width);
        (paths.first, paths.width) = (0, 0);
        let (mut cell, mut width, mut flags, mut unvisited_flags) = (first, cells, 0, 0);
        for _ in 0..cells {
            flags = paths.follow_back_from(cell, steps.wrapping_sub(1));
            if has(visited, cell) {
                // Layers with a visited cell are the last choice.
                width = SMALL_AREA;
            } else {
                unvisited_flags |= flags;
            }
            cell = paths.links[cell % SMALL_AREA].into();
        }
        if steps == 0 && flags & OPEN > 0 {
            return None;
        }
        if unvisited_flags & DOUBTFUL == 0 || width > least_width {
            continue;
        }
        if width < least_width {
            (least_width, *candidates) = (width, CellSet::EMPTY);
        }
        let mut cell = first;
        for _ in 0..cells {
            if paths.sides.around(cell)[SMALL_SIDE] & DOUBTFUL > 0 && !has(visited, cell) {
                candidates.insert(cell_at(cell));
            }
            cell = paths.links[cell % SMALL_AREA].into();
        }
    }
    Some(CellSet::from_rows(paths.found))
}

/// Rows of cells or walls, in the form of [`CellSet::rows`].
type Rows = [Row; MazeSize::MAX_SIDE as usize];

fn has(rows: &Rows, cell: usize) -> bool {
    rows[cell / SMALL_SIDE % SMALL_SIDE] >> (cell % SMALL_SIDE) & 1 == 1
}

/// The optimistic shortest paths found so far.
struct Paths<'a> {
    /// The open sides if unknown walls are open. The byte of a path cell does not contain
    /// `UNVISITED`, but may contain flags.
    sides: &'a mut OpenSides,
    /// The walls if unknown walls are closed.
    known: &'a Walls,
    from_start: &'a [u8; SMALL_AREA],
    links: &'a mut [u8; SMALL_AREA],
    /// All path cells.
    found: Rows,
    /// The first cell of the list of the next layer.
    first: usize,
    /// The number of cells in the list.
    width: usize,
}

impl Paths<'_> {
    #[inline(always)]
    fn add(&mut self, cell: usize) {
        self.links[cell % SMALL_AREA] = self.first as u8;
        self.first = cell % SMALL_AREA;
        self.width += 1;
        self.found[cell / SMALL_SIDE % SMALL_SIDE] |= 1 << (cell % SMALL_SIDE);
    }

    /// Adds the neighbours of `cell` that are `nearer` steps from the start to the next layer.
    /// Returns the byte of the cell.
    #[inline(always)]
    fn follow_back_from(&mut self, cell: usize, nearer: usize) -> u8 {
        let mut here = self.sides.around(cell)[SMALL_SIDE];
        let sides = here;
        let (norths, easts) = (self.known.north_rows(), self.known.east_rows());
        let mut follow =
            |[side, opposite]: [u8; 2], place: usize, next, rows: &Rows, wall: usize| {
                let next: usize = next % SMALL_AREA;
                if sides & side == 0 || usize::from(self.from_start[next]) != nearer {
                    return;
                }
                let flags = if has(rows, wall) { DOUBTFUL } else { here & OPEN };
                here |= flags & DOUBTFUL;
                let there = &mut self.sides.around(cell)[place];
                let is_new = *there & UNVISITED > 0;
                // The other cell need not be followed back to this one.
                *there = (*there | flags) & !(UNVISITED | opposite);
                if is_new {
                    self.add(next);
                }
            };
        let (south, west) = (cell.wrapping_sub(SMALL_SIDE), cell.wrapping_sub(1));
        follow([NORTH, SOUTH], 2 * SMALL_SIDE, cell + SMALL_SIDE, norths, cell);
        follow([EAST, WEST], SMALL_SIDE + 1, cell + 1, easts, cell);
        follow([SOUTH, NORTH], 0, south, norths, south);
        follow([WEST, EAST], SMALL_SIDE - 1, west, easts, west);
        self.sides.around(cell)[SMALL_SIDE] = here;
        here
    }
}
