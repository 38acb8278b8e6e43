//! Waves: the sets of cells at distance 0, 1, 2 and so on from the cells where a flood begins.

use super::bitboard::{Bitboard, CellPlanes, Openings, even_rows};
use super::plane::{BitOps, ParityPlane};
use crate::flood::steps::ByteRow;

/// The number of bits in a distance. The longest distance in a maze of 32×32 cells is 1,023 steps.
pub(crate) const PLANES: usize = 10;

/// The distances of all cells of one chessboard colour, stored bit by bit.
pub(crate) struct Marks<B> {
    /// Element i holds bit i of each distance.
    pub(crate) planes: [B; PLANES],
    /// The cells that no wave has reached.
    pub(crate) unvisited: B,
}

/// The distances of all cells. If the cells where the flood begins all have the same chessboard
/// colour, `near` holds the distances of the cells of that colour; otherwise, it holds those of the
/// dark cells. `far` holds the distances of the cells of the opposite colour.
pub(crate) struct Flooded<B> {
    pub(crate) near: Marks<B>,
    pub(crate) far: Marks<B>,
    pub(crate) near_is_dark: bool,
}

/// One counter per cell, incremented until a wave reaches the cell. Element `FIRST` + i of `code`
/// holds bit i of each counter.
///
/// The counters are Gray codes, so an increment changes only one bit of a counter.
struct Counts<B, const FIRST: usize> {
    code: [B; PLANES],
}

impl<B: BitOps, const FIRST: usize> Counts<B, FIRST> {
    #[inline(always)]
    fn new() -> Self {
        Self { code: [B::NONE; PLANES] }
    }

    /// Increments the counters of `cells` from `count` - 1 to `count`.
    #[inline(always)]
    fn add(&mut self, count: u32, cells: B) {
        // No distance has more bits than there are planes.
        if let Some(bit) = self.code.get_mut(FIRST + count.trailing_zeros() as usize) {
            *bit = bit.xor(cells);
        }
    }

    /// Converts the counters from Gray codes to binary distances. The lowest `FIRST` bits of each
    /// distance are taken from `low`.
    #[inline(always)]
    fn into_marks(mut self, low: B, unvisited: B) -> Marks<B> {
        for i in (FIRST + 1..PLANES).rev() {
            self.code[i - 1] = self.code[i - 1].xor(self.code[i]);
        }
        for bit in &mut self.code[..FIRST] {
            *bit = low;
        }
        Marks { planes: self.code, unvisited }
    }
}

/// Floods the maze from the targets.
#[inline(always)]
pub(crate) fn flood<B: BitOps>(board: &Bitboard<B>, targets: CellPlanes<B>) -> Flooded<B> {
    let unvisited =
        CellPlanes { dark: B::ALL.without(targets.dark), light: B::ALL.without(targets.light) };
    // Waves begin at targets with an open neighbour. If all of these have the same colour, each
    // wave contains cells of only one colour.
    let edge = CellPlanes {
        dark: board.dark.from(unvisited.light, targets.dark),
        light: board.light.from(unvisited.dark, targets.light),
    };
    let is_dark = edge.light.is_empty();
    if !is_dark && !edge.dark.is_empty() {
        return waves_of_both_colours(board, edge, unvisited);
    }
    // The planes are indexed by colour, because a branch on the colour would be unpredictable.
    let (near, far) = (usize::from(!is_dark), usize::from(is_dark));
    let (into, unvisited) = ([board.dark, board.light], [unvisited.dark, unvisited.light]);
    let edge = [edge.dark, edge.light][near];
    let [near, far] =
        waves_of_one_colour([&into[far], &into[near]], edge, [unvisited[near], unvisited[far]]);
    Flooded { near, far, near_is_dark: is_dark }
}

/// Sends waves from `edge`, whose cells all have the same chessboard colour. Each wave then also
/// contains cells of only one colour. Returns the distances of all cells with the colour of `edge`,
/// followed by the distances of the other cells.
#[inline(always)]
fn waves_of_one_colour<B: BitOps>(
    [into_far, into_near]: [&Openings<B>; 2],
    edge: B,
    [mut unvisited_near, mut unvisited_far]: [B; 2],
) -> [Marks<B>; 2] {
    let (mut near, mut far) = (Counts::<B, 1>::new(), Counts::<B, 1>::new());
    let (mut wave, far_at_first) = (edge, unvisited_far);
    for round in 0.. {
        // Each round runs two iterations. The odd counts then always change the same bit, and the
        // end is checked less often.
        for count in [2 * round + 1, 2 * round + 2] {
            let far_wave = into_far.from(wave, unvisited_far);
            unvisited_far = unvisited_far.without(far_wave);
            near.add(count, unvisited_near);
            far.add(count, unvisited_far);
            wave = into_near.from(far_wave, unvisited_near);
            unvisited_near = unvisited_near.without(wave);
        }
        if wave.is_empty() {
            break;
        }
    }
    // The counters count pairs of waves. Far targets have no open neighbour, and their distance is
    // 0.
    [near.into_marks(B::NONE, unvisited_near), far.into_marks(far_at_first, unvisited_far)]
}

/// Sends waves from `edge`, which contains both dark and light cells of the chessboard pattern.
#[inline(always)]
fn waves_of_both_colours<B: BitOps>(
    board: &Bitboard<B>,
    edge: CellPlanes<B>,
    mut unvisited: CellPlanes<B>,
) -> Flooded<B> {
    let (mut dark, mut light) = (Counts::<B, 0>::new(), Counts::<B, 0>::new());
    let mut wave = edge;
    for round in 0.. {
        for count in [2 * round + 1, 2 * round + 2] {
            dark.add(count, unvisited.dark);
            light.add(count, unvisited.light);
            wave = CellPlanes {
                dark: board.dark.from(wave.light, unvisited.dark),
                light: board.light.from(wave.dark, unvisited.light),
            };
            unvisited.dark = unvisited.dark.without(wave.dark);
            unvisited.light = unvisited.light.without(wave.light);
        }
        if wave.dark.or(wave.light).is_empty() {
            break;
        }
    }
    let near = dark.into_marks(B::NONE, unvisited.dark);
    let far = light.into_marks(B::NONE, unvisited.light);
    Flooded { near, far, near_is_dark: true }
}

impl<B: ParityPlane> Flooded<B> {
    /// Calls `plane` once per chessboard colour to get two sets of cells. Returns the same cells,
    /// grouped into even and odd columns.
    #[inline(always)]
    pub(crate) fn columns(&self, plane: impl Fn(&Marks<B>) -> B) -> [B; 2] {
        let even: B = even_rows();
        let odd = B::ALL.without(even);
        let (near, far) = (plane(&self.near), plane(&self.far));
        let swapped = near.xor(far).and(if self.near_is_dark { odd } else { even });
        [near.xor(swapped), far.xor(swapped)]
    }

    /// Writes one byte of each cell's distance: the low byte if `first` is 0, the high byte if it is
    /// 8. The rows are ordered from south to north, and the cells of each row from west to east. The
    /// bytes of unvisited cells have all bits set.
    #[inline(always)]
    pub(crate) fn write_bytes(&self, first: usize, rows: &mut [[ByteRow; 8]]) {
        let (mut even, mut odd) = ([B::NONE; 8], [B::NONE; 8]);
        for i in 0..8 {
            let plane = |marks: &Marks<B>| match marks.planes.get(first + i) {
                Some(plane) => plane.or(marks.unvisited),
                None => marks.unvisited,
            };
            [even[i], odd[i]] = self.columns(plane);
        }
        B::spread(even, odd, rows);
    }

    /// Returns true if the maze is the largest that the bit sets can hold and the waves have reached
    /// every cell.
    #[inline(always)]
    pub(crate) fn is_full(&self) -> bool {
        self.near.unvisited.or(self.far.unvisited).is_empty()
    }
}

/// Sends waves from `from`, whose cells all have the same chessboard colour, until a wave reaches a
/// target. Returns the targets nearest to `from`, together with their distance in steps, or `None`
/// if no target is reachable. If this distance is even, the returned targets have the same colour
/// as the cells of `from`, otherwise the opposite colour.
#[inline(always)]
pub(crate) fn first_targets<B: BitOps>(
    [into_far, into_near]: [&Openings<B>; 2],
    from: B,
    [near_targets, far_targets]: [B; 2],
) -> Option<(B, u16)> {
    let found = from.and(near_targets);
    if !found.is_empty() {
        return Some((found, 0));
    }
    let (mut wave, mut far_wave, mut steps) = (from, B::NONE, 0);
    loop {
        far_wave = into_far.onward(wave, far_wave);
        wave = into_near.onward(far_wave, wave);
        let (in_far, in_near) = (far_wave.and(far_targets), wave.and(near_targets));
        if !in_far.or(in_near).is_empty() {
            let far_is_first = !in_far.is_empty();
            return Some(if far_is_first { (in_far, steps + 1) } else { (in_near, steps + 2) });
        }
        if wave.is_empty() {
            return None;
        }
        steps += 2;
    }
}
