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
        let shortest = ShortestWays::of(map, &open)?;
        let known = shortest.each(&Board::of(map.walls(Unknown::Closed)));
        let ways = shortest.cells(&known)?;
        let Chequered { dark, light } = Chequered::<H>::of(map.visited());
        let visited = shortest.pick(dark, light);
        let mut unseen = [H::NONE; 2];
        for colour in [0, 1] {
            let unknown = shortest.into[colour].without(known[colour]);
            unseen[colour] = unknown.from(ways[1 - colour], ways[colour]).without(visited[colour]);
        }
        let to_see = shortest.narrowest(unseen, visited);
        let Chequered { dark, light } = Chequered::<H>::of_cell(mouse);
        let nearest = nearest(&shortest.into, shortest.pick(dark, light), to_see)?;
        let is_one = count(nearest[0]) + count(nearest[1]) == 1;
        let farthest_out = if is_one { nearest } else { shortest.first_layer_with(nearest) };
        let farthest_out = shortest.chequered(farthest_out);
        let ways = CellSet::of_rows(rows(shortest.chequered(ways).columns()));
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
        let (from, goals) = (Chequered::<B>::of_cell(map.start()), Chequered::<B>::of(map.goals()));
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
        let (mut dry_near, mut dry_far) = (B::ALL.without(start), B::ALL);
        let (mut wave, mut ends, mut length) = (start, start.and(near_goals), 0);
        while ends.is_empty() {
            if wave.is_empty() {
                return None;
            }
            for odd in [1, 3] {
                let far_wave = into_far.from(wave, dry_far);
                layers[odd] = layers[odd].or(far_wave);
                dry_far = dry_far.without(far_wave);
                length += 1;
                ends = far_wave.and(far_goals);
                if !ends.is_empty() {
                    break;
                }
                wave = into_near.from(far_wave, dry_near);
                layers[(odd + 1) % 4] = layers[(odd + 1) % 4].or(wave);
                dry_near = dry_near.without(wave);
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
    /// empty ones after it.
    #[inline(always)]
    fn for_each_layer(&self, mut show: impl FnMut(usize, B)) {
        show(0, self.ends);
        let mut layer = self.ends;
        for _ in 0..self.length.div_ceil(4) {
            // Four at a time, so that it is known beforehand what each one needs.
            for (i, &cells) in self.layers.iter().enumerate() {
                let colour = (i + 1) % 2;
                layer = self.into[colour].from(layer, cells);
                show(colour, layer);
            }
        }
    }

    /// The cells of all these ways; `None` if one is known to be open all along.
    #[inline(always)]
    fn cells(&self, known: &[Ways<B>; 2]) -> Option<[B; 2]> {
        if self.length == 0 {
            return None;
        }
        let (mut all, mut all_sure) = ([B::NONE; 2], [B::NONE; 2]);
        // Those from which a way on to the goal is known to be open, which soon there are no more.
        let (mut sure, mut is_over) = (B::ALL, false);
        self.for_each_layer(|colour, layer| {
            all[colour] = all[colour].or(layer);
            if !is_over {
                sure = known[colour].from(sure, layer);
                all_sure[colour] = all_sure[colour].or(sure);
                is_over = sure.is_empty();
            }
        });
        let is_known = !all_sure[self.length % 2].and(self.start).is_empty();
        (!is_known).then_some(all)
    }

    /// Those of the unseen cells that are in the narrowest layers without a visited cell, and all if
    /// there are none.
    #[inline(always)]
    fn narrowest<const N: usize>(&self, unseen: [B; 2], visited: [B; 2]) -> [B; 2]
    where
        B: Half<N>,
    {
        let (mut least, mut narrowest) = (u32::MAX, [B::NONE; 2]);
        self.for_each_layer(|colour, layer| {
            let to_see = layer.and(unseen[colour]);
            let is_new = layer.and(visited[colour]).is_empty() & !to_see.is_empty();
            let width = count(layer);
            let width = if is_new { width } else { u32::MAX };
            if width < least {
                (least, narrowest) = (width, [B::NONE; 2]);
            }
            if is_new && width == least {
                narrowest[colour] = narrowest[colour].or(to_see);
            }
        });
        if least == u32::MAX { unseen } else { narrowest }
    }

    /// Those of some cells of these ways that are farthest from the start.
    #[inline(always)]
    fn first_layer_with(&self, cells: [B; 2]) -> [B; 2] {
        let mut first = [B::NONE; 2];
        self.for_each_layer(|colour, layer| {
            if first[0].or(first[1]).is_empty() {
                first[colour] = layer.and(cells[colour]);
            }
        });
        first
    }
}

#[inline(always)]
fn count<const N: usize, H: Half<N>>(cells: H) -> u32 {
    cells.words().into_iter().map(u64::count_ones).sum()
}

/// Those of some cells that are nearest to where waves begin, `None` if there is no way to any.
#[inline(always)]
fn nearest<B: Bits>(into: &[Ways<B>; 2], from: [B; 2], wanted: [B; 2]) -> Option<[B; 2]> {
    let mut dry = [B::ALL.without(from[0]), B::ALL.without(from[1])];
    let mut waves = from;
    loop {
        let found = [waves[0].and(wanted[0]), waves[1].and(wanted[1])];
        if !found[0].or(found[1]).is_empty() {
            return Some(found);
        }
        waves = [into[0].from(waves[1], dry[0]), into[1].from(waves[0], dry[1])];
        dry = [dry[0].without(waves[0]), dry[1].without(waves[1])];
        if waves[0].or(waves[1]).is_empty() {
            return None;
        }
    }
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
        let mut map = KnownMaze::before(&maze);
        for y in [0, 2] {
            for heading in Heading::ALL {
                map.set_wall(Cell::new(2, y), heading, WallState::Present);
            }
        }
        let mut see = |x, y| {
            for heading in [Heading::North, Heading::South] {
                let pose = Pose::new(Cell::new(x, y), heading);
                map.note(pose, maze.walls().around(pose)).unwrap();
            }
            let from_start = Distances::flood(map.walls(Unknown::Open), &only(map.start()));
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
                map.note(pose, walls.around(pose)).unwrap();
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
        let from_start = Distances::flood(open, &only(map.start()));
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
        Some((to_see, ways.found)).filter(|_| !ways.sure.contains(map.start()))
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
