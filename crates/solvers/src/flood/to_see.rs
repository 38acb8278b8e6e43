//! Which cell to see next, of those that decide what the shortest way is.

use mmsim_maze::{Cell, KnownMaze, Unknown};

use super::board::{Board, Chequered, Ways, cells};
use super::half::Half;
use super::processor::{Task, run};
use super::waves;

/// Where a mouse in `mouse` goes to see more of the shortest ways from the start to the goal,
/// unknown walls taken as open: to the nearest of the cells to see, and of those to the farthest from
/// the start, for it comes back that way. `None` once one of the ways is known to be open all along,
/// and where there is none.
///
/// Cells to see are the unseen ones beside unknown walls of the ways, in the narrowest layers of
/// which nothing has been seen yet; where there is no such layer, those in all of them. A layer is
/// what is on these ways at one distance from the start.
pub(crate) fn cell_to_see(map: &KnownMaze, mouse: Cell) -> Option<Cell> {
    run(CellToSee { map, mouse }, map.size())
}

struct CellToSee<'a> {
    map: &'a KnownMaze,
    mouse: Cell,
}

impl Task for CellToSee<'_> {
    type Output = Option<Cell>;

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) -> Option<Cell> {
        let Self { map, mouse } = self;
        let open = Board::<H>::of(map.walls(Unknown::Open));
        let known = Board::<H>::of(map.walls(Unknown::Closed));
        let shortest = ShortestWays::of(map, &open)?;
        let ways = shortest.cells(&known)?;
        let Chequered { dark, light } = Chequered::<H>::of(map.visited());
        let visited = [dark, light];
        let (into, known) = (open.into_each(), known.into_each());
        let mut unseen = [H::NONE; 2];
        for colour in [0, 1] {
            let unknown = into[colour].without(known[colour]);
            unseen[colour] = unknown.from(ways[1 - colour], ways[colour]).without(visited[colour]);
        }
        let to_see = shortest.narrowest(unseen, visited);
        let nearest = nearest(&into, Chequered::of_cell(mouse), to_see)?;
        // The first of those that are equally far.
        cells(nearest).rev().max_by_key(|&cell| shortest.flooded.at(cell))
    }
}

/// The shortest ways from the start to the goal. Colours are dark and light, in this order.
struct ShortestWays<H> {
    flooded: waves::Flooded<H>,
    into: [Ways<H>; 2],
    /// The goal cells where they end.
    ends: H,
    /// How long they are, in steps.
    length: u16,
    /// Cells of each colour at the distances 0 and 1, 4 and 5, and so on from the start, and those at
    /// 2 and 3, 6 and 7 and so on. As neighbours are a step apart, that tells nearer from farther.
    layers: [[H; 2]; 2],
}

impl<H> ShortestWays<H> {
    #[inline(always)]
    fn of<const N: usize>(map: &KnownMaze, open: &Board<H>) -> Option<Self>
    where
        H: Half<N>,
    {
        let flooded = waves::flood(open, Chequered::of_cell(map.start()));
        let steps = |goal| Some((flooded.at(goal)?, goal));
        let length = map.goals().iter().filter_map(steps).map(|(steps, _)| steps).min()?;
        let mut ends = H::NONE;
        for (_, goal) in map.goals().iter().filter_map(steps).filter(|&(steps, _)| steps == length)
        {
            let Chequered { dark, light } = Chequered::<H>::of_cell(goal);
            ends = ends.or(dark.or(light));
        }
        let layers = |marks: &waves::Marks<H>| {
            let reached = H::ALL.without(marks.dry);
            [reached.without(marks.planes[1]), reached.and(marks.planes[1])]
        };
        let (near, far) = (layers(&flooded.near), layers(&flooded.far));
        let layers = if flooded.near_is_dark { [near, far] } else { [far, near] };
        Some(Self { flooded, into: open.into_each(), ends, length, layers })
    }

    /// The colour of cells at this distance.
    #[inline(always)]
    fn colour(&self, steps: u16) -> usize {
        usize::from(steps + u16::from(!self.flooded.near_is_dark)) % 2
    }

    /// The layer that is a step nearer to the start than these cells, at `steps` from it.
    #[inline(always)]
    fn nearer<const N: usize>(&self, cells: H, steps: u16) -> H
    where
        H: Half<N>,
    {
        let colour = self.colour(steps);
        self.into[colour].from(cells, self.layers[colour][usize::from(steps / 2 % 2)])
    }

    /// The cells of all these ways; `None` if one is known to be open all along.
    #[inline(always)]
    fn cells<const N: usize>(&self, known: &Board<H>) -> Option<[H; 2]>
    where
        H: Half<N>,
    {
        let known = known.into_each();
        let mut all = [H::NONE; 2];
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
    fn narrowest<const N: usize>(&self, unseen: [H; 2], visited: [H; 2]) -> [H; 2]
    where
        H: Half<N>,
    {
        let (mut least, mut narrowest) = (u32::MAX, [H::NONE; 2]);
        let mut layer = self.ends;
        for steps in (0..=self.length).rev() {
            let colour = self.colour(steps);
            let to_see = layer.and(unseen[colour]);
            if layer.and(visited[colour]).is_empty() && !to_see.is_empty() {
                let width = layer.words().into_iter().map(u64::count_ones).sum();
                if width < least {
                    (least, narrowest) = (width, [H::NONE; 2]);
                }
                if width == least {
                    narrowest[colour] = narrowest[colour].or(to_see);
                }
            }
            if steps > 0 {
                layer = self.nearer(layer, steps - 1);
            }
        }
        if least == u32::MAX { unseen } else { narrowest }
    }
}

/// Those of some cells that are nearest to where waves begin, all of one colour; the other half is
/// empty. `None` if there is no way to any.
#[inline(always)]
fn nearest<const N: usize, H: Half<N>>(
    into: &[Ways<H>; 2],
    from: Chequered<H>,
    wanted: [H; 2],
) -> Option<Chequered<H>> {
    let (mut dry, mut waves) = ([H::ALL; 2], [from.dark, from.light]);
    let mut colour = usize::from(from.dark.is_empty());
    loop {
        let wave = waves[colour];
        let found = wave.and(wanted[colour]);
        if !found.is_empty() {
            let none = H::NONE;
            return Some(if colour == 0 {
                Chequered { dark: found, light: none }
            } else {
                Chequered { dark: none, light: found }
            });
        }
        if wave.is_empty() {
            return None;
        }
        dry[colour] = dry[colour].without(wave);
        colour = 1 - colour;
        waves[colour] = into[colour].from(wave, dry[colour]);
    }
}
