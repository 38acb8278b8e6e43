//! Which cell to see next, of those that decide what the shortest way is.

use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown};

use super::board::{Board, Chequered, Ways, is_dark, rows};
use super::half::{Bits, Half};
use super::processor::{Task, run};
use super::waves::first_targets;

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
        let shortest = ShortestWays::of(map, &open)?;
        let known = shortest.each(&Board::of(map.walls(Unknown::Closed)));
        let Chequered { dark, light } = Chequered::<H>::of(map.visited());
        let visited = shortest.pick(dark, light);
        let (ways, new) = shortest.cells(&known, visited)?;
        let mut unseen = [H::NONE; 2];
        for colour in [0, 1] {
            let unknown = shortest.into[colour].without(known[colour]);
            unseen[colour] = unknown.from(ways[1 - colour], ways[colour]).without(visited[colour]);
        }
        // Mostly there is something to see in the narrowest layers that are new.
        let to_see = [new[0].and(unseen[0]), new[1].and(unseen[1])];
        let is_any = !to_see[0].or(to_see[1]).is_empty();
        let to_see = if is_any { to_see } else { shortest.narrowest(unseen, visited) };
        let near = usize::from(is_dark(mouse) != shortest.ends_are_dark);
        let (ways_to, to_see) = (&shortest.into, [to_see[near], to_see[1 - near]]);
        let mouse = Chequered::<H>::from_cell(mouse);
        let mouse = mouse.dark.or(mouse.light);
        let (nearest, steps) = first_targets([&ways_to[1 - near], &ways_to[near]], mouse, to_see)?;
        let colour = (near + usize::from(steps)) % 2;
        let is_one = count::<N, H>(nearest) == 1;
        let farthest_out =
            if is_one { nearest } else { shortest.first_layer_with(colour, nearest) };
        let mut colours = [H::NONE; 2];
        colours[colour] = farthest_out;
        let farthest_out = shortest.chequered(colours);
        let ways = CellSet::from_rows(rows(shortest.chequered(ways).columns()));
        Some(ToSee { cell: farthest_out.first_cell()?, ways })
    }
}

/// The shortest ways from the start to the goal, layer by layer from the goal on. Each pair is of
/// cells of the colour of their ends, and of those of the other.
struct ShortestWays<B> {
    into: [Ways<B>; 2],
    /// The goal cells where they end.
    ends: B,
    start: B,
    /// Cells that may be in the next four layers, in the four after these, and so on. They are at the
    /// same distance from the start, but for multiples of 4; neighbours are a step apart, so that
    /// this tells nearer from farther.
    layers: [B; 4],
    ends_are_dark: bool,
    /// How far the start is from the ends, in steps.
    length: usize,
}

impl<B: Bits> ShortestWays<B> {
    /// Waves from the start until one comes to a goal cell.
    #[inline(always)]
    fn of<const N: usize>(map: &KnownMaze, open: &Board<B>) -> Option<Self>
    where
        B: Half<N>,
    {
        let (from, goals) =
            (Chequered::<B>::from_cell(map.start().cell), Chequered::<B>::of(map.goals()));
        let start_is_dark = from.light.is_empty();
        let pick = |dark, light| if start_is_dark { [dark, light] } else { [light, dark] };
        let [near_goals, far_goals] = pick(goals.dark, goals.light);
        let [into_near, into_far] = if start_is_dark {
            [open.into_dark, open.into_light]
        } else {
            [open.into_light, open.into_dark]
        };
        let start = from.dark.or(from.light);
        let mut layers = [start, B::NONE, B::NONE, B::NONE];
        let (mut wave, mut far_wave) = (start, B::NONE);
        let (mut ends, mut length) = (start.and(near_goals), 0);
        while ends.is_empty() {
            if wave.is_empty() {
                return None;
            }
            for odd in [1, 3] {
                far_wave = into_far.onward(wave, far_wave);
                layers[odd] = layers[odd].or(far_wave);
                length += 1;
                ends = far_wave.and(far_goals);
                if !ends.is_empty() {
                    break;
                }
                wave = into_near.onward(far_wave, wave);
                layers[(odd + 1) % 4] = layers[(odd + 1) % 4].or(wave);
                length += 1;
                ends = wave.and(near_goals);
                if !ends.is_empty() {
                    break;
                }
            }
        }
        let ends_are_near = length % 2 == 0;
        let into = if ends_are_near { [into_near, into_far] } else { [into_far, into_near] };
        // From the layer before the ends on, backwards.
        let mut before = [B::NONE; 4];
        for (i, layer) in before.iter_mut().enumerate() {
            *layer = layers[(length + 3 - i) % 4];
        }
        let ends_are_dark = ends_are_near == start_is_dark;
        Some(Self { into, ends, start, layers: before, ends_are_dark, length })
    }

    /// Something of dark and of light cells, as that of the ends' colour and of the other.
    #[inline(always)]
    fn pick<T>(&self, dark: T, light: T) -> [T; 2] {
        if self.ends_are_dark { [dark, light] } else { [light, dark] }
    }

    /// The way back.
    #[inline(always)]
    fn chequered(&self, [ends_colour, other]: [B; 2]) -> Chequered<B> {
        let [dark, light] = self.pick(ends_colour, other);
        Chequered { dark, light }
    }

    #[inline(always)]
    fn each(&self, board: &Board<B>) -> [Ways<B>; 2] {
        self.pick(board.into_dark, board.into_light)
    }

    /// Shows each layer and whose colour it has, from the ends back to the start, and possibly a few
    /// empty ones after it. Stops after a few more once the question whether to go on is answered
    /// with no.
    #[inline(always)]
    fn for_each_layer(&self, mut show: impl FnMut(usize, B) -> bool) {
        let mut layer = self.ends;
        let mut goes_on = show(0, layer);
        for _ in 0..self.length.div_ceil(4) {
            // Four at a time, so that it is known beforehand what each one needs.
            for (i, &cells) in self.layers.iter().enumerate() {
                let colour = (i + 1) % 2;
                layer = self.into[colour].from(layer, cells);
                goes_on = show(colour, layer);
            }
            if !goes_on {
                break;
            }
        }
    }

    /// The cells of all these ways, and those of the narrowest layers without a visited cell; `None`
    /// if one of the ways is known to be open all along.
    #[inline(always)]
    fn cells<const N: usize>(
        &self,
        known: &[Ways<B>; 2],
        visited: [B; 2],
    ) -> Option<([B; 2], [B; 2])>
    where
        B: Half<N>,
    {
        if self.length == 0 {
            return None;
        }
        let (mut all, mut all_sure) = ([B::NONE; 2], [B::NONE; 2]);
        let mut new = Narrowest::NONE;
        // Those from which a way on to the goal is known to be open, which soon there are no more.
        let (mut sure, mut is_over) = (B::ALL, false);
        self.for_each_layer(|colour, layer| {
            all[colour] = all[colour].or(layer);
            if !is_over {
                sure = known[colour].from(sure, layer);
                all_sure[colour] = all_sure[colour].or(sure);
                is_over = sure.is_empty();
            }
            if layer.and(visited[colour]).is_empty() {
                new.add(colour, layer, layer);
            }
            true
        });
        let is_known = !all_sure[self.length % 2].and(self.start).is_empty();
        (!is_known).then_some((all, new.cells))
    }

    /// Those of the unseen cells that are in the narrowest layers without a visited cell, and all if
    /// there are none.
    #[inline(always)]
    fn narrowest<const N: usize>(&self, unseen: [B; 2], visited: [B; 2]) -> [B; 2]
    where
        B: Half<N>,
    {
        let mut narrowest = Narrowest::NONE;
        self.for_each_layer(|colour, layer| {
            let to_see = layer.and(unseen[colour]);
            if layer.and(visited[colour]).is_empty() && !to_see.is_empty() {
                narrowest.add(colour, layer, to_see);
            }
            true
        });
        if narrowest.width == Narrowest::<B>::NONE.width { unseen } else { narrowest.cells }
    }

    /// Those of some cells of one colour of these ways that are farthest from the start.
    #[inline(always)]
    fn first_layer_with(&self, cells_colour: usize, cells: B) -> B {
        let mut first = B::NONE;
        self.for_each_layer(|colour, layer| {
            if first.is_empty() && colour == cells_colour {
                first = layer.and(cells);
            }
            first.is_empty()
        });
        first
    }
}

/// Cells of the narrowest of some layers.
struct Narrowest<B> {
    width: u32,
    cells: [B; 2],
}

impl<B: Bits> Narrowest<B> {
    const NONE: Self = Self { width: u32::MAX, cells: [B::NONE; 2] };

    /// One more layer, if it is not empty, with these cells.
    #[inline(always)]
    fn add<const N: usize>(&mut self, colour: usize, layer: B, cells: B)
    where
        B: Half<N>,
    {
        let width = count(layer);
        if width < self.width && width > 0 {
            *self = Self { width, ..Self::NONE };
        }
        if width == self.width {
            self.cells[colour] = self.cells[colour].or(cells);
        }
    }
}

#[inline(always)]
fn count<const N: usize, H: Half<N>>(cells: H) -> u32 {
    cells.words().into_iter().map(u64::count_ones).sum()
}

#[cfg(test)]
mod tests {
    use core::cmp::Reverse;
    use core::ops::Range;

    use mmsim_maze::{Heading, Maze, MazeSize, Pose, WallState};
    use proptest::prelude::*;

    use super::*;
    use crate::Distances;
    use crate::flood::processor::with_each;
    use crate::flood::tests::{any_targets, any_walls};

    #[test]
    fn it_looks_at_narrow_layers_of_which_nothing_is_seen() {
        let maze: Maze = "\
o---o---o---o---o---o
|       |   |     G |
o   o   o---o   o   o
|                   |
o   o   o---o   o   o
| S     |   |       |
o---o---o---o---o---o
"
        .parse()
        .unwrap();
        let mut map = KnownMaze::unexplored(&maze);
        for y in [0, 2] {
            for heading in Heading::ALL {
                map.set_wall(Cell::new(2, y), heading, WallState::Present);
            }
        }
        let mut see = |x, y| {
            for heading in [Heading::North, Heading::South] {
                let pose = Pose::new(Cell::new(x, y), heading);
                map.observe(pose, maze.walls().around(pose)).unwrap();
            }
            let from_start = Distances::flood(map.walls(Unknown::Open), &only(map.start().cell));
            let to_see = shortest_ways(&map, &from_start);
            assert_eq!(cell_to_see(&map, Cell::new(x, y)), naive(&map, Cell::new(x, y)));
            to_see.map(|(cells, _)| cells.iter().map(|cell| (cell.x, cell.y)).collect::<Vec<_>>())
        };
        assert_eq!(see(0, 0), Some(vec![(1, 1), (2, 1), (3, 1), (4, 2)]), "layers of one cell");
        assert_eq!(see(4, 2), Some(vec![(1, 1), (2, 1), (3, 1)]));
        assert_eq!(see(2, 1), Some(vec![(1, 1), (3, 1)]), "doubtful on their other sides");
        assert_eq!(see(1, 1), Some(vec![(3, 1)]));
        assert_eq!(see(3, 1), None, "a way is open all along");
    }

    proptest! {
        #[test]
        fn what_to_see_is_what_the_naive_twin_says(
            walls in any_walls(),
            goals in any_targets(),
            seen in prop::collection::vec((0u8..32, 0u8..32, 0usize..4), 0..200),
            (start, mouse) in ((0u8..32, 0u8..32), (0u8..32, 0u8..32)),
        ) {
            let size = walls.size();
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let mut map = KnownMaze::new(size, inside(start), goals);
            for (x, y, heading) in seen {
                let pose = Pose::new(inside((x, y)), Heading::ALL[heading]);
                map.observe(pose, walls.around(pose)).unwrap();
            }
            let (map, mouse) = (&map, inside(mouse));
            let expected = naive(map, mouse);
            prop_assert_eq!(cell_to_see(map, mouse), expected);
            with_each(|| CellToSee { map, mouse }, size, |to_see| assert_eq!(to_see, expected));
        }
    }

    /// The naive twin: cell by cell, with distances written down.
    fn naive(map: &KnownMaze, mouse: Cell) -> Option<ToSee> {
        let open = map.walls(Unknown::Open);
        let from_start = Distances::flood(open, &only(map.start().cell));
        let (to_see, ways) = shortest_ways(map, &from_start)?;
        let from_mouse = Distances::flood(open, &only(mouse));
        let near_and_far_out = |&cell: &Cell| (from_mouse.at(cell), Reverse(from_start.at(cell)));
        let within_reach = to_see.iter().filter(|&cell| from_mouse.at(cell).is_some());
        Some(ToSee { cell: within_reach.min_by_key(near_and_far_out)?, ways })
    }

    /// Follows the shortest ways from goal to start, unknown walls taken as open, and says which cells
    /// of them to see next. `None` once one of the ways is known to be open all along.
    ///
    /// Those are the unseen cells beside unknown walls of the ways, in the narrowest layers of which
    /// nothing has been seen yet; where there is no such layer, those in all of them.
    fn shortest_ways(map: &KnownMaze, from_start: &Distances) -> Option<(CellSet, CellSet)> {
        let mut ways = Ways::to_goals(map, from_start);
        let (mut width, mut narrowest, mut others) = (usize::MAX, CellSet::EMPTY, CellSet::EMPTY);
        let mut layer = 0..ways.count;
        while !layer.is_empty() {
            let nearer = ways.go_back(map, from_start, layer.clone());
            let cells = &ways.cells[layer];
            let is_unseen = |&cell: &Cell| !map.visited().contains(cell);
            let is_to_see = |&cell: &Cell| is_unseen(&cell) && ways.doubtful.contains(cell);
            let mut to_see = cells.iter().copied().filter(is_to_see).peekable();
            if to_see.peek().is_none() || !cells.iter().all(is_unseen) {
                others.extend(to_see);
            } else if cells.len() < width {
                (width, narrowest) = (cells.len(), to_see.collect());
            } else if cells.len() == width {
                narrowest.extend(to_see);
            }
            layer = nearer;
        }
        let to_see = if narrowest.is_empty() { others } else { narrowest };
        Some((to_see, ways.found)).filter(|_| !ways.sure.contains(map.start().cell))
    }

    /// The cells of the shortest ways, found from the goal backwards, layer by layer.
    struct Ways {
        cells: [Cell; MazeSize::MAX_AREA],
        count: usize,
        found: CellSet,
        /// Those from which a way on to the goal is known to be open.
        sure: CellSet,
        /// Those with an unknown wall on a way.
        doubtful: CellSet,
    }

    impl Ways {
        /// Their ends: the goal cells nearest to the start. There are none without a way.
        fn to_goals(map: &KnownMaze, from_start: &Distances) -> Self {
            let nearest = map.goals().iter().filter_map(|goal| from_start.at(goal)).min();
            let is_end = |&goal: &Cell| nearest.is_some() && from_start.at(goal) == nearest;
            let ends = map.goals().iter().filter(is_end).collect();
            let cells = [Cell::new(0, 0); MazeSize::MAX_AREA];
            let mut ways =
                Self { cells, count: 0, found: ends, sure: ends, doubtful: CellSet::EMPTY };
            for (place, end) in ways.cells.iter_mut().zip(ends.iter()) {
                *place = end;
                ways.count += 1;
            }
            ways
        }

        /// Finds the layer that is one step nearer to the start than this one.
        fn go_back(
            &mut self,
            map: &KnownMaze,
            from_start: &Distances,
            layer: Range<usize>,
        ) -> Range<usize> {
            for index in layer.clone() {
                let cell = self.cells[index];
                let steps = from_start.at(cell).and_then(|steps| steps.checked_sub(1));
                let is_nearer = |&next: &Cell| steps.is_some() && from_start.at(next) == steps;
                for heading in Heading::ALL {
                    let Some(next) = cell.neighbour(heading).filter(is_nearer) else { continue };
                    match map.wall(cell, heading) {
                        WallState::Present => continue,
                        WallState::Absent if !self.sure.contains(cell) => {}
                        WallState::Absent => self.sure.extend([next]),
                        WallState::Unknown => self.doubtful.extend([cell, next]),
                    }
                    if self.found.insert(next) {
                        self.cells[self.count] = next;
                        self.count += 1;
                    }
                }
            }
            layer.end..self.count
        }
    }

    fn only(cell: Cell) -> CellSet {
        [cell].into_iter().collect()
    }
}
