//! A flood with one byte per cell, for processors with 32-bit registers.

// The indices of cells are less than 256.
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

use crate::flood::only;
use crate::flood::steps::{ByteRow, SMALL_AREA, SMALL_SIDE};

/// The open sides of a cell are a sum of these numbers.
pub(crate) const NORTH: u8 = 1;
pub(crate) const EAST: u8 = 2;
pub(crate) const SOUTH: u8 = 4;
pub(crate) const WEST: u8 = 8;

/// Added to the open sides of a cell at which a flood stops.
const STOP: u8 = 16;
/// Added to the open sides of an unvisited cell.
pub(crate) const UNVISITED: u8 = 32;

/// The open sides of each cell. When a flood enters a cell, the side through which it enters and
/// `UNVISITED` are removed.
///
/// The first and the last row are outside the maze, so that every cell has four neighbours in
/// memory.
// Aligned, so that four cells can be written at once.
#[derive(Clone, Debug)]
#[repr(align(4))]
pub(crate) struct OpenSides([ByteRow; SMALL_SIDE + 2]);

/// The northern sides of four cells, given the bits of their northern walls.
const NORTHS: [u32; 1 << 4] = open_sides_of_four_cells([(0, NORTH)], 0);

/// The eastern and western sides of four unvisited cells, given the bits of the five walls from the
/// western side of the first cell to the eastern side of the last.
const EASTS_AND_WESTS: [u32; 1 << 5] = open_sides_of_four_cells([(0, WEST), (1, EAST)], UNVISITED);

/// Returns the bytes of four cells for each combination of walls. For each pair in `sides`, bit
/// i + offset of the combination is the wall of cell i on that side.
const fn open_sides_of_four_cells<const N: usize, const M: usize>(
    sides: [(usize, u8); M],
    summand: u8,
) -> [u32; N] {
    let mut table = [0; N];
    let mut walls = 0;
    while walls < N {
        let (mut bytes, mut cell) = ([summand; 4], 0);
        while cell < 4 {
            let mut i = 0;
            while i < M {
                let (offset, side) = sides[i];
                bytes[cell] += if walls >> (cell + offset) & 1 == 0 { side } else { 0 };
                i += 1;
            }
            cell += 1;
        }
        table[walls] = u32::from_le_bytes(bytes);
        walls += 1;
    }
    table
}

/// Floods a small maze from the targets. Targets outside the maze are ignored. Overwrites `bytes`,
/// which has one element for each cell, in rows of 16 cells from south to north, with the distances
/// of the cells, and with 255 if a cell cannot reach a target. Overwrites `sides`, whose contents do
/// not matter. Returns true if 255 is a distance.
pub(crate) fn flood(
    walls: &Walls,
    targets: &CellSet,
    sides: &mut OpenSides,
    bytes: &mut [u8; SMALL_AREA],
) -> bool {
    send_waves::<false>(walls, targets, &CellSet::EMPTY, sides, bytes)
        .is_ok_and(|longest| longest == u8::MAX)
}

/// Returns the cells of `wanted` that are nearest to `from` in a small maze, or no cells if none is
/// reachable. Overwrites `bytes` with the distances from `from`, and with 255 for all cells that are
/// farther than the nearest wanted cells. Overwrites `sides` too.
pub(crate) fn nearest(
    walls: &Walls,
    from: Cell,
    wanted: &CellSet,
    sides: &mut OpenSides,
    bytes: &mut [u8; SMALL_AREA],
) -> CellSet {
    let mut nearest = CellSet::EMPTY;
    let Err(stopped) = send_waves::<true>(walls, &only(from), wanted, sides, bytes) else {
        return nearest;
    };
    let Stopped { distance, mut cell, mut link, next_wave, end } = stopped;
    loop {
        bytes[cell] = distance;
        if wanted.contains(cell_at(cell)) {
            nearest.insert(cell_at(cell));
        }
        if link == end {
            break;
        }
        (cell, link) = (link, bytes[link].into());
    }
    cell = next_wave;
    while cell != end {
        link = bytes[cell % SMALL_AREA].into();
        bytes[cell % SMALL_AREA] = u8::MAX;
        cell = link;
    }
    nearest
}

/// The state of a flood that has stopped in the middle of a wave.
struct Stopped {
    distance: u8,
    /// The first cell of the rest of the wave.
    cell: usize,
    /// The link of `cell`.
    link: usize,
    /// The first cell of the next wave as far as it has been found, or `end`.
    next_wave: usize,
    /// The link of the last cell of each wave.
    end: usize,
}

/// Sends waves from the targets, and returns the distance of the last wave. If a wave reaches a cell
/// of `stops`, the flood stops there.
///
/// Wave i of the flood consists of the cells at distance i. The cells of a wave form a list, in which
/// each cell links to the next one, and the last cell links to the first target. The link of a cell
/// is stored in the byte that later holds its distance.
#[inline(never)]
fn send_waves<const STOPS: bool>(
    walls: &Walls,
    targets: &CellSet,
    stops: &CellSet,
    sides: &mut OpenSides,
    bytes: &mut [u8; SMALL_AREA],
) -> Result<u8, Stopped> {
    bytes.fill(u8::MAX);
    sides.fill_in(walls);
    if STOPS {
        for stop in stops.iter().filter(|&cell| walls.size().contains(cell)) {
            sides.around(index(stop))[SMALL_SIDE] |= STOP;
        }
    }
    let Some(first) = link_targets(walls.size(), targets, sides, bytes) else { return Ok(0) };
    let mut wave = first;
    let mut distance = 0;
    loop {
        let (mut cell, mut next_wave) = (wave, first);
        loop {
            let link = usize::from(bytes[cell]);
            bytes[cell] = distance;
            match enter_neighbours::<STOPS>(cell, sides, bytes, next_wave) {
                Some(next) => next_wave = next,
                None => return Err(Stopped { distance, cell, link, next_wave, end: first }),
            }
            if link == first {
                break;
            }
            cell = link;
        }
        if next_wave == first {
            return Ok(distance);
        }
        wave = next_wave % SMALL_AREA;
        // The last wave of 256 cells has a distance of at most 255.
        distance = distance.wrapping_add(1);
    }
}

impl OpenSides {
    pub(crate) const NONE: Self = Self([[0; SMALL_SIDE]; SMALL_SIDE + 2]);

    /// Sets the open sides of all cells in a small maze.
    #[inline(always)]
    pub(crate) fn fill_in(&mut self, walls: &Walls) {
        let rows = walls.north_rows().iter().zip(walls.east_rows());
        let mut south = usize::MAX;
        for (line, (&north, &east)) in self.0[1..=SMALL_SIDE].iter_mut().zip(rows) {
            let (north, along) = (north as usize, (east as usize) << 1 | 1);
            for (i, bytes) in line.chunks_exact_mut(4).enumerate() {
                let norths = |walls: usize| NORTHS[walls >> (4 * i) & 0xf];
                let easts_and_wests = EASTS_AND_WESTS[along >> (4 * i) & 0x1f];
                let sides = easts_and_wests | norths(north) | norths(south) << 2;
                bytes.copy_from_slice(&sides.to_le_bytes());
            }
            south = north;
        }
    }

    /// Returns the bytes from the southern neighbour of a cell to its northern neighbour. Some of the
    /// neighbours may be outside the maze.
    #[inline(always)]
    pub(crate) fn around(&mut self, cell: usize) -> &mut [u8; 2 * SMALL_SIDE + 1] {
        // There are two rows more than the maze has.
        self.0.as_flattened_mut()[cell % SMALL_AREA..].first_chunk_mut().unwrap()
    }
}

/// Makes a list of the targets inside the maze, and returns the first one.
#[inline(always)]
fn link_targets(
    size: MazeSize,
    targets: &CellSet,
    sides: &mut OpenSides,
    links: &mut [u8; SMALL_AREA],
) -> Option<usize> {
    let mut targets =
        targets.iter().filter(|&cell| size.contains(cell)).map(|cell| index(cell) % SMALL_AREA);
    let first = targets.next()?;
    let mut last = first;
    for target in core::iter::once(first).chain(targets) {
        sides.around(target)[SMALL_SIDE] %= UNVISITED;
        links[last] = target as u8;
        last = target;
    }
    links[last] = first as u8;
    Some(first)
}

/// Adds the unvisited neighbours of `cell` to the list of the next wave, and returns the first cell
/// of the list. Returns `None` if the flood stops at `cell`.
#[inline(always)]
fn enter_neighbours<const STOPS: bool>(
    cell: usize,
    sides: &mut OpenSides,
    links: &mut [u8; SMALL_AREA],
    mut next_wave: usize,
) -> Option<usize> {
    let around = sides.around(cell);
    let mut enter = |sides: &mut u8, from: u8, cell: usize| {
        // An unvisited cell has an open side `from`.
        let others = i32::from(*sides) - i32::from(UNVISITED + from);
        if others >= 0 {
            *sides = others as u8;
            links[cell % SMALL_AREA] = next_wave as u8;
            next_wave = cell;
        }
    };
    // One jump is faster than a branch for each side.
    macro_rules! jump {
        ($($open:literal)*) => {
            match around[SMALL_SIDE] % if STOPS { UNVISITED } else { STOP } {
                0 => {}
                $($open => {
                    if $open & NORTH > 0 {
                        enter(&mut around[2 * SMALL_SIDE], SOUTH, cell + SMALL_SIDE);
                    }
                    if $open & EAST > 0 {
                        enter(&mut around[SMALL_SIDE + 1], WEST, cell + 1);
                    }
                    if $open & SOUTH > 0 {
                        enter(&mut around[0], NORTH, cell.wrapping_sub(SMALL_SIDE));
                    }
                    if $open & WEST > 0 {
                        enter(&mut around[SMALL_SIDE - 1], EAST, cell.wrapping_sub(1));
                    }
                })*
                _ => return None,
            }
        };
    }
    jump!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    Some(next_wave)
}

/// Returns the cell at `index`, which must be less than 256.
#[inline(always)]
pub(crate) const fn cell_at(index: usize) -> Cell {
    Cell::new((index % SMALL_SIDE) as u8, (index / SMALL_SIDE) as u8)
}

/// Returns the index of a cell.
#[inline(always)]
pub(crate) fn index(Cell { x, y }: Cell) -> usize {
    usize::from(y) * SMALL_SIDE + usize::from(x)
}
