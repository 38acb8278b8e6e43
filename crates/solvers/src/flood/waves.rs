//! Waves: the cells at distance 0, 1, 2 and so on.

use super::board::{Board, Chequered, Ways};
use super::half::Bits;

/// The most bits that a distance has: 1,023 steps in a maze of 32×32 cells.
pub(super) const PLANES: usize = 10;

/// What waves leave behind: the distance of each cell of one colour, bit by bit.
pub(super) struct Marks<B> {
    /// Bit i of each distance.
    pub(super) planes: [B; PLANES],
    /// The cells that no wave has come to.
    pub(super) dry: B,
}

/// What waves leave behind in cells of both colours: the near one, in which they began, and the
/// other.
pub(super) struct Flooded<B> {
    pub(super) near: Marks<B>,
    pub(super) far: Marks<B>,
    pub(super) near_is_dark: bool,
}

/// Counts for each cell the waves that have passed it over, in bits from the `FIRST` on.
///
/// The counts are Gray code, of which each wave changes but one bit, and that in all cells that are
/// still dry.
struct Counts<B, const FIRST: usize> {
    code: [B; PLANES],
}

impl<B: Bits, const FIRST: usize> Counts<B, FIRST> {
    #[inline(always)]
    fn new() -> Self {
        Self { code: [B::NONE; PLANES] }
    }

    /// One more of all these, the `count`th to be counted.
    #[inline(always)]
    fn add(&mut self, count: u32, cells: B) {
        // Beyond the last bit there is no cell that a wave still comes to.
        if let Some(bit) = self.code.get_mut(FIRST + count.trailing_zeros() as usize) {
            *bit = bit.xor(cells);
        }
    }

    /// The counts as binary numbers, with `low` for the bits below the first.
    #[inline(always)]
    fn into_marks(mut self, low: B, dry: B) -> Marks<B> {
        for i in (FIRST + 1..PLANES).rev() {
            self.code[i - 1] = self.code[i - 1].xor(self.code[i]);
        }
        for bit in &mut self.code[..FIRST] {
            *bit = low;
        }
        Marks { planes: self.code, dry }
    }
}

/// Floods the maze from its targets outwards.
#[inline(always)]
pub(super) fn flood<B: Bits>(board: &Board<B>, targets: Chequered<B>) -> Flooded<B> {
    let dry =
        Chequered { dark: B::ALL.without(targets.dark), light: B::ALL.without(targets.light) };
    // Waves begin at the edge of a goal; and if that is all of one colour, each has but one.
    let edge = Chequered {
        dark: board.into_dark.from(dry.light, targets.dark),
        light: board.into_light.from(dry.dark, targets.light),
    };
    let is_dark = edge.light.is_empty();
    if !is_dark && !edge.dark.is_empty() {
        return waves_of_both_colours(board, edge, dry);
    }
    // Taken from tables, since nobody can predict which colour it is.
    let (near, far) = (usize::from(!is_dark), usize::from(is_dark));
    let (into, dry) = ([board.into_dark, board.into_light], [dry.dark, dry.light]);
    let edge = [edge.dark, edge.light][near];
    let [near, far] = waves_of_one_colour([&into[far], &into[near]], edge, [dry[near], dry[far]]);
    Flooded { near, far, near_is_dark: is_dark }
}

/// Waves that begin in cells of one colour, the near one; each is of one colour then. Ways and dry
/// cells are those into and of the far and the near colour. Gives near and far marks.
#[inline(always)]
fn waves_of_one_colour<B: Bits>(
    [into_far, into_near]: [&Ways<B>; 2],
    edge: B,
    [mut dry_near, mut dry_far]: [B; 2],
) -> [Marks<B>; 2] {
    let (mut near, mut far) = (Counts::<B, 1>::new(), Counts::<B, 1>::new());
    let (mut wave, far_at_first) = (edge, dry_far);
    for round in 0.. {
        // Twice, so that one count changes the same bit each time, and the end is looked for seldom.
        for count in [2 * round + 1, 2 * round + 2] {
            let far_wave = into_far.from(wave, dry_far);
            dry_far = dry_far.without(far_wave);
            near.add(count, dry_near);
            far.add(count, dry_far);
            wave = into_near.from(far_wave, dry_near);
            dry_near = dry_near.without(wave);
        }
        if wave.is_empty() {
            break;
        }
    }
    // Counted were pairs of waves. Far targets are no edge, but at distance 0.
    [near.into_marks(B::NONE, dry_near), far.into_marks(far_at_first, dry_far)]
}

/// Waves that begin in cells of both colours.
#[inline(always)]
fn waves_of_both_colours<B: Bits>(
    board: &Board<B>,
    edge: Chequered<B>,
    mut dry: Chequered<B>,
) -> Flooded<B> {
    let (mut dark, mut light) = (Counts::<B, 0>::new(), Counts::<B, 0>::new());
    let mut wave = edge;
    for round in 0.. {
        for count in [2 * round + 1, 2 * round + 2] {
            dark.add(count, dry.dark);
            light.add(count, dry.light);
            wave = Chequered {
                dark: board.into_dark.from(wave.light, dry.dark),
                light: board.into_light.from(wave.dark, dry.light),
            };
            dry.dark = dry.dark.without(wave.dark);
            dry.light = dry.light.without(wave.light);
        }
        if wave.dark.or(wave.light).is_empty() {
            break;
        }
    }
    let near = dark.into_marks(B::NONE, dry.dark);
    let far = light.into_marks(B::NONE, dry.light);
    Flooded { near, far, near_is_dark: true }
}

impl<B: Bits> Flooded<B> {
    /// Whether waves have come to every cell that there is room for.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.near.dry.or(self.far.dry).is_empty()
    }
}

/// Waves that begin in cells of one colour, the near one, until one comes to a target: which targets
/// it comes to, and after how many steps; their colour is the near one if that is even. `None` if
/// there is no way. Ways are those into the far and into the near colour, targets near and far ones.
#[inline(always)]
pub(super) fn first_targets<B: Bits>(
    [into_far, into_near]: [&Ways<B>; 2],
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
