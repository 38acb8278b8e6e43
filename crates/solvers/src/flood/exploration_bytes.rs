//! Selection of the cell to explore next, with one byte per cell.

// The indices of cells are less than 256.
#![allow(clippy::cast_possible_truncation)]

use core::cmp::Reverse;

use mmsim_maze::{CellSet, KnownMaze, MazeSize, Row, Unknown, Walls};

use super::SMALL_SIDE;
use super::exploration::{ExplorationTarget, FindTarget};
use super::queue::{AREA, EAST, NORTH, OpenSides, SOUTH, UNVISITED, WEST, index, nearest};

/// A flag beside the open sides of a path cell: a path from it to the goal is known to be open.
const OPEN: u8 = 1 << 6;
/// A flag beside the open sides of a path cell: the cell is next to an unknown wall that an
/// optimistic shortest path crosses.
const DOUBTFUL: u8 = 1 << 7;

/// Does the same as [`ExplorationTarget::find`] in a maze of up to 16×16 cells.
pub(super) fn find(FindTarget { map, mouse, memory }: FindTarget) -> Option<ExplorationTarget> {
    let open = map.walls(Unknown::Open);
    let [from_start, others] = memory;
    let goals = nearest(open, map.start().cell, map.goals(), from_start);
    let (candidates, paths) = follow_back(map, &goals, from_start, others)?;
    let nearest = nearest(open, mouse, &candidates, others);
    let cell = nearest.iter().min_by_key(|&cell| Reverse(from_start[index(cell) % AREA]))?;
    Some(ExplorationTarget { cell, paths })
}

/// Follows the optimistic shortest paths from the nearest goal cells back to the start. Returns the cells that
/// [`ExplorationTarget::find`] considers, and all path cells. Returns `None` if one of the paths is
/// known to be open, or if there is no path.
///
/// The paths are found layer by layer. A layer consists of all path cells with the same distance
/// from the start. The cells of a layer form a list, in which each cell links to the next one.
// The stack has no room for the paths during a flood.
#[inline(never)]
fn follow_back(
    map: &KnownMaze,
    goals: &CellSet,
    from_start: &[u8; AREA],
    links: &mut [u8; AREA],
) -> Option<(CellSet, CellSet)> {
    let length = from_start[index(goals.iter().next()?) % AREA];
    let (rows, visited) = ([0; MazeSize::MAX_SIDE as usize], map.visited().rows());
    let mut paths = Paths {
        sides: OpenSides::NONE,
        known: map.walls(Unknown::Closed),
        from_start,
        links,
        found: rows,
        first: 0,
        width: 0,
    };
    paths.sides.fill_in(map.walls(Unknown::Open));
    for goal in goals.iter().map(index) {
        let byte = &mut paths.sides.around(goal)[SMALL_SIDE];
        *byte = *byte & !UNVISITED | OPEN;
        paths.add(goal);
    }
    let (mut least_width, mut candidates) = (AREA, rows);
    for steps in (0..=usize::from(length)).rev() {
        let (first, cells) = (paths.first, paths.width);
        (paths.first, paths.width) = (0, 0);
        let (mut cell, mut width, mut flags, mut unvisited_flags) = (first, cells, 0, 0);
        for _ in 0..cells {
            flags = paths.follow_back_from(cell, steps.wrapping_sub(1));
            if has(visited, cell) {
                // Layers with a visited cell are the last choice.
                width = AREA;
            } else {
                unvisited_flags |= flags;
            }
            cell = paths.links[cell % AREA].into();
        }
        if steps == 0 && flags & OPEN > 0 {
            return None;
        }
        if unvisited_flags & DOUBTFUL == 0 || width > least_width {
            continue;
        }
        if width < least_width {
            (least_width, candidates) = (width, rows);
        }
        let mut cell = first;
        for _ in 0..cells {
            if paths.sides.around(cell)[SMALL_SIDE] & DOUBTFUL > 0 && !has(visited, cell) {
                add(&mut candidates, cell);
            }
            cell = paths.links[cell % AREA].into();
        }
    }
    Some((CellSet::from_rows(candidates), CellSet::from_rows(paths.found)))
}

/// Rows of cells or walls, in the form of [`CellSet::rows`].
type Rows = [Row; MazeSize::MAX_SIDE as usize];

fn has(rows: &Rows, cell: usize) -> bool {
    rows[cell / SMALL_SIDE % SMALL_SIDE] >> (cell % SMALL_SIDE) & 1 == 1
}

fn add(rows: &mut Rows, cell: usize) {
    rows[cell / SMALL_SIDE % SMALL_SIDE] |= 1 << (cell % SMALL_SIDE);
}

/// The optimistic shortest paths found so far.
struct Paths<'a> {
    /// The open sides if unknown walls are open. The byte of a path cell does not contain
    /// `UNVISITED`, but may contain flags.
    sides: OpenSides,
    /// The walls if unknown walls are closed.
    known: &'a Walls,
    from_start: &'a [u8; AREA],
    links: &'a mut [u8; AREA],
    /// All path cells, in the form of [`CellSet::from_rows`].
    found: Rows,
    /// The first cell of the list of the next layer.
    first: usize,
    /// The number of cells in the list.
    width: usize,
}

impl Paths<'_> {
    #[inline(always)]
    fn add(&mut self, cell: usize) {
        self.links[cell % AREA] = self.first as u8;
        self.first = cell % AREA;
        self.width += 1;
        add(&mut self.found, cell);
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
                let next: usize = next % AREA;
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
