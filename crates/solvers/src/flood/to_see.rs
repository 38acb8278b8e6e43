//! Which cell to see next, of those that decide what the shortest way is.

use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown};

use super::board::{Board, Chequered, Ways, rows};
use super::half::{Bits, Half};
use super::processor::{Task, run};

/// Where a mouse in `mouse` goes to see more of the shortest ways from the start to the goal,
/// unknown walls taken as open: to the nearest of the cells to see, and of those to the farthest from
/// the start, for it comes back that way. `None` once one of the ways is known to be open all along,
/// and where there is none.
///
/// Cells to see are the unseen ones beside unknown walls of the ways, in the narrowest layers of
/// which nothing has been seen yet; where there is no such layer, those in all of them. A layer is
/// what is on these ways at one distance from the start.
pub(crate) fn cell_to_see(map: &KnownMaze, mouse: Cell) -> Option<ToSee> {
    run(CellToSee { map, mouse }, map.size())
}

/// What [`cell_to_see`] says.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct ToSee {
    /// Where to go.
    pub(crate) cell: Cell,
    /// All cells of the shortest ways.
    pub(crate) ways: CellSet,
}

struct CellToSee<'a> {
    map: &'a KnownMaze,
    mouse: Cell,
}

impl Task for CellToSee<'_> {
    type Output = Option<ToSee>;

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) -> Option<ToSee> {
        let Self { map, mouse } = self;
        let open = Board::<H>::of(map.walls(Unknown::Open));
        let known = Board::<H>::of(map.walls(Unknown::Closed)).into_each();
        let into = open.into_each();
        let shortest = ShortestWays::of(map, into)?;
        let ways = shortest.cells(&known)?;
        let Chequered { dark, light } = Chequered::<H>::of(map.visited());
        let visited = [dark, light];
        let mut unseen = [H::NONE; 2];
        for colour in [0, 1] {
            let unknown = into[colour].without(known[colour]);
            unseen[colour] = unknown.from(ways[1 - colour], ways[colour]).without(visited[colour]);
        }
        let to_see = shortest.narrowest(unseen, visited);
        let nearest = nearest(&into, Chequered::of_cell(mouse), to_see)?;
        let farthest_out = shortest.first_layer_with(nearest);
        let [dark, light] = ways;
        Some(ToSee {
            cell: Chequered { dark: farthest_out[0], light: farthest_out[1] }.first_cell()?,
            ways: CellSet::of_rows(rows(Chequered { dark, light }.columns())),
        })
    }
}

/// The shortest ways from the start to the goal. Each pair is of dark and light cells.
struct ShortestWays<H> {
    into: [Ways<H>; 2],
    /// The goal cells where they end.
    ends: H,
    /// How long they are, in steps.
    length: u16,
    /// The colour of the start.
    start: usize,
    /// Cells of each colour at the distances 0 and 1, 4 and 5, and so on from the start, and those at
    /// 2 and 3, 6 and 7 and so on. As neighbours are a step apart, that tells nearer from farther.
    layers: [[H; 2]; 2],
}

impl<B: Bits> ShortestWays<B> {
    /// Waves from the start until one comes to a goal cell.
    #[inline(always)]
    fn of<const N: usize>(map: &KnownMaze, into: [Ways<B>; 2]) -> Option<Self>
    where
        B: Half<N>,
    {
        let (from, goals) = (Chequered::<B>::of_cell(map.start()), Chequered::<B>::of(map.goals()));
        let goals = [goals.dark, goals.light];
        let start = usize::from(from.dark.is_empty());
        let (near, far) = (start, 1 - start);
        let mut layers = [[B::NONE; 2]; 2];
        let mut wave = from.dark.or(from.light);
        let (mut dry_near, mut dry_far) = (B::ALL.without(wave), B::ALL);
        let (mut ends, mut length) = (wave.and(goals[near]), 0);
        layers[near][0] = wave;
        while ends.is_empty() {
            let far_wave = into[far].from(wave, dry_far);
            let kind = usize::from(length / 2 % 2);
            layers[far][kind] = layers[far][kind].or(far_wave);
            dry_far = dry_far.without(far_wave);
            length += 1;
            ends = far_wave.and(goals[far]);
            if !ends.is_empty() {
                break;
            }
            wave = into[near].from(far_wave, dry_near);
            layers[near][1 - kind] = layers[near][1 - kind].or(wave);
            dry_near = dry_near.without(wave);
            length += 1;
            ends = wave.and(goals[near]);
            if wave.is_empty() {
                return None;
            }
        }
        Some(Self { into, ends, length, start, layers })
    }

    /// The colour of cells at this distance.
    #[inline(always)]
    fn colour(&self, steps: u16) -> usize {
        (usize::from(steps) + self.start) % 2
    }

    /// The layer that is a step nearer to the start than these cells, at `steps` from it.
    #[inline(always)]
    fn nearer(&self, cells: B, steps: u16) -> B {
        let colour = self.colour(steps);
        self.into[colour].from(cells, self.layers[colour][usize::from(steps / 2 % 2)])
    }

    /// The cells of all these ways; `None` if one is known to be open all along.
    #[inline(always)]
    fn cells(&self, known: &[Ways<B>; 2]) -> Option<[B; 2]> {
        let mut all = [B::NONE; 2];
        let (mut layer, mut sure) = (self.ends, self.ends);
        all[self.colour(self.length)] = layer;
        for steps in (0..self.length).rev() {
            let colour = self.colour(steps);
            layer = self.nearer(layer, steps);
            sure = known[colour].from(sure, layer);
            all[colour] = all[colour].or(layer);
        }
        sure.is_empty().then_some(all)
    }

    /// Those of the unseen cells that are in the narrowest layers without a visited cell, and all if
    /// there are none.
    #[inline(always)]
    fn narrowest<const N: usize>(&self, unseen: [B; 2], visited: [B; 2]) -> [B; 2]
    where
        B: Half<N>,
    {
        let (mut least, mut narrowest) = (u32::MAX, [B::NONE; 2]);
        let mut layer = self.ends;
        for steps in (0..=self.length).rev() {
            let colour = self.colour(steps);
            let to_see = layer.and(unseen[colour]);
            let is_new = layer.and(visited[colour]).is_empty() & !to_see.is_empty();
            let width: u32 = layer.words().into_iter().map(u64::count_ones).sum();
            let width = if is_new { width } else { u32::MAX };
            if width < least {
                (least, narrowest) = (width, [B::NONE; 2]);
            }
            if is_new & (width == least) {
                narrowest[colour] = narrowest[colour].or(to_see);
            }
            if steps > 0 {
                layer = self.nearer(layer, steps - 1);
            }
        }
        if least == u32::MAX { unseen } else { narrowest }
    }

    /// Those of some cells of these ways that are farthest from the start.
    #[inline(always)]
    fn first_layer_with(&self, cells: [B; 2]) -> [B; 2] {
        let mut layer = self.ends;
        for steps in (0..=self.length).rev() {
            let colour = self.colour(steps);
            let found = layer.and(cells[colour]);
            if !found.is_empty() {
                let mut both = [B::NONE; 2];
                both[colour] = found;
                return both;
            }
            layer = self.nearer(layer, steps.saturating_sub(1));
        }
        cells
    }
}

/// Those of some cells that are nearest to where waves begin, all of one colour; the other half is
/// empty. `None` if there is no way to any.
#[inline(always)]
fn nearest<B: Bits>(into: &[Ways<B>; 2], from: Chequered<B>, wanted: [B; 2]) -> Option<[B; 2]> {
    let mut dry = [B::ALL; 2];
    let (mut wave, mut colour) = (from.dark.or(from.light), usize::from(from.dark.is_empty()));
    while !wave.is_empty() {
        let found = wave.and(wanted[colour]);
        if !found.is_empty() {
            let mut both = [B::NONE; 2];
            both[colour] = found;
            return Some(both);
        }
        dry[colour] = dry[colour].without(wave);
        colour = 1 - colour;
        wave = into[colour].from(wave, dry[colour]);
    }
    None
}
