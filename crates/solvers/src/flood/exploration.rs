//! Selection of the cell that a mouse explores next while it searches for a proven shortest path.

use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown};

use super::bytes;
use super::bytes::waves::OpenSides;
use super::dispatch::run;
use super::task::Task;
use super::wide::bitboard::{Bitboard, CellPlanes, Openings, is_dark, rows};
use super::wide::plane::ParityPlane;
use super::wide::waves::first_targets;
use super::{Distances, Instructions};

/// The cell to explore next, and the paths to which it belongs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct ExplorationTarget {
    /// The cell to explore next.
    pub(crate) cell: Cell,
    /// All cells on the optimistic shortest paths from the start to the goal.
    pub(crate) paths: CellSet,
}

/// Memory for floods and for [`ExplorationTarget::find`], so that they need less of the stack. Its
/// contents do not matter.
#[derive(Clone, Debug)]
pub(crate) struct ExplorationMemory {
    pub(crate) sides: OpenSides,
    pub(super) from_start: [u8; 256],
    pub(super) candidates: CellSet,
}

impl ExplorationMemory {
    pub(crate) const NEW: Self =
        Self { sides: OpenSides::NONE, from_start: [0; 256], candidates: CellSet::EMPTY };
}

impl ExplorationTarget {
    /// True if [`find`](Self::find) does not overwrite distances.
    pub(crate) const KEEPS_DISTANCES: bool = !Instructions::PREFERS_BYTES;

    /// Selects the cell that a mouse at `mouse` should explore next. Returns `None` if one of the
    /// optimistic shortest paths is known to be open, or if there is no path.
    ///
    /// A layer consists of all cells on the optimistic shortest paths that have the same distance
    /// from the start. A candidate is an unvisited cell with an unknown wall that an optimistic
    /// shortest path crosses. If some layers contain candidates but no visited cell, only the
    /// candidates in the narrowest of these layers (those with the fewest cells) are considered.
    /// The target is the candidate nearest to the mouse. If several candidates are equally near,
    /// the target is the candidate farthest from the start, because the mouse can visit the other
    /// candidates on its way back.
    ///
    /// Overwrites `memory`. Also overwrites `distances`, which must belong to a maze of the same
    /// size, unless [`KEEPS_DISTANCES`](Self::KEEPS_DISTANCES) is true.
    pub(crate) fn find(
        map: &KnownMaze,
        mouse: Cell,
        memory: &mut ExplorationMemory,
        distances: &mut Distances,
    ) -> Option<Self> {
        run(FindTarget { map, mouse, memory, distances }, map.size())
    }
}

pub(super) struct FindTarget<'a> {
    pub(super) map: &'a KnownMaze,
    pub(super) mouse: Cell,
    /// Memory for [`run_on_bytes`](Task::run_on_bytes).
    pub(super) memory: &'a mut ExplorationMemory,
    /// More memory for [`run_on_bytes`](Task::run_on_bytes).
    pub(super) distances: &'a mut Distances,
}

impl Task for FindTarget<'_> {
    type Output = Option<ExplorationTarget>;

    #[inline(always)]
    fn run<H: ParityPlane>(self) -> Option<ExplorationTarget> {
        let shortest = ShortestPaths::<H>::find(self.map)?;
        let found = shortest.cells()?;
        let candidates = shortest.candidates(&found);
        let (colour, nearest) = shortest.nearest(self.mouse, candidates)?;
        let is_one = count(nearest) == 1;
        let target = if is_one { nearest } else { shortest.first_layer_with(colour, nearest) };
        let mut planes = [H::NONE; 2];
        planes[colour] = target;
        let target = CellPlanes::from_near_and_far(planes, shortest.ends_are_dark);
        let paths = [found[0].all, found[1].all];
        let paths = CellPlanes::from_near_and_far(paths, shortest.ends_are_dark);
        Some(ExplorationTarget {
            cell: target.first_cell()?,
            paths: CellSet::from_rows(rows(paths.columns())),
        })
    }

    fn run_on_bytes(self) -> Option<ExplorationTarget> {
        bytes::exploration::find(self)
    }
}

/// The visited cells of one chessboard colour, and the open sides through which cells of that
/// colour can be entered.
#[derive(Clone, Copy)]
struct Colour<B> {
    /// The sides through which cells of this chessboard colour can be entered, with unknown walls
    /// treated as open.
    optimistic: Openings<B>,
    /// The sides through which cells of this chessboard colour can be entered, with unknown walls
    /// treated as closed.
    known: Openings<B>,
    visited: B,
}

/// The cells of one chessboard colour on the optimistic shortest paths.
#[derive(Clone, Copy)]
struct PathCells<B> {
    all: B,
    /// The cells of the narrowest layers (those with the fewest cells) among the layers without a
    /// visited cell. A layer consists of all path cells with the same distance from the start.
    narrowest: B,
}

/// The optimistic shortest paths from the start to the goal.
///
/// The cells are coloured like a chessboard, so each step of a path changes the colour. Two-element
/// arrays have one element per colour. The first element belongs to the colour of the goal cells
/// nearest to the start.
struct ShortestPaths<B> {
    colours: [Colour<B>; 2],
    ends_are_dark: bool,
    /// The goal cells with the shortest optimistic distance from the start.
    ends: B,
    start: B,
    /// The cells that waves from the start have reached, grouped into four sets by their distance
    /// from the start modulo 4. The first set contains the cells that are one step nearer to the
    /// start than `ends`. The distances of connected neighbours differ by 1, so the distance modulo
    /// 4 shows which neighbour is nearer to the start.
    layers: [B; 4],
    /// The length of each optimistic shortest path, in steps.
    length: usize,
}

impl<B: ParityPlane> ShortestPaths<B> {
    /// Sends waves from the start until a wave reaches a goal cell.
    #[inline(always)]
    fn find(map: &KnownMaze) -> Option<Self> {
        let start = CellPlanes::<B>::from_cell(map.start().cell);
        let start_is_dark = start.light.is_empty();
        let start = start.dark.or(start.light);
        let open = Bitboard::<B>::from_walls(map.walls(Unknown::Open));
        let goals = CellPlanes::<B>::from_cells(map.goals());
        let [into_near, into_far] = open.near_and_far(start_is_dark);
        let [near_goals, far_goals] = goals.near_and_far(start_is_dark);
        let mut layers = [start, B::NONE, B::NONE, B::NONE];
        let (mut near_wave, mut far_wave) = (start, B::NONE);
        let (mut ends, mut length) = (start.and(near_goals), 0);
        while ends.is_empty() {
            if near_wave.is_empty() {
                return None;
            }
            for odd in [1, 3] {
                far_wave = into_far.onward(near_wave, far_wave);
                layers[odd] = layers[odd].or(far_wave);
                length += 1;
                ends = far_wave.and(far_goals);
                if !ends.is_empty() {
                    break;
                }
                near_wave = into_near.onward(far_wave, near_wave);
                layers[(odd + 1) % 4] = layers[(odd + 1) % 4].or(near_wave);
                length += 1;
                ends = near_wave.and(near_goals);
                if !ends.is_empty() {
                    break;
                }
            }
        }
        // The sets are stored backwards, beginning with the layer before the ends.
        let mut before = [B::NONE; 4];
        for (i, layer) in before.iter_mut().enumerate() {
            *layer = layers[(length + 3 - i) % 4];
        }
        let ends_are_dark = (length % 2 == 0) == start_is_dark;
        let optimistic = open.near_and_far(ends_are_dark);
        let known = Bitboard::<B>::from_walls(map.walls(Unknown::Closed));
        let known = known.near_and_far(ends_are_dark);
        let visited = CellPlanes::<B>::from_cells(map.visited()).near_and_far(ends_are_dark);
        let colour =
            |i: usize| Colour { optimistic: optimistic[i], known: known[i], visited: visited[i] };
        let colours = [colour(0), colour(1)];
        Some(Self { colours, ends_are_dark, ends, start, layers: before, length })
    }

    /// Calls `visit` for each layer (all path cells with the same distance from the start), from
    /// the goal back to the start. Its arguments are the index of the layer's chessboard colour and
    /// the layer's cells. Layers are computed four at a time, so `visit` may be called for up to
    /// three empty layers at the end. `visit` returns `false` to stop early. After that, it may be
    /// called up to four more times, and must return `false` each time.
    #[inline(always)]
    fn for_each_layer(&self, mut visit: impl FnMut(usize, B) -> bool) {
        let mut layer = self.ends;
        let mut goes_on = visit(0, layer);
        for _ in 0..self.length.div_ceil(4) {
            // Four layers at a time, so that the indices are constants.
            for (i, &cells) in self.layers.iter().enumerate() {
                let colour = (i + 1) % 2;
                layer = self.colours[colour].optimistic.from(layer, cells);
                goes_on = visit(colour, layer);
            }
            if !goes_on {
                break;
            }
        }
    }

    /// Returns the cells on the optimistic shortest paths, or `None` if one of these paths is known
    /// to be open.
    #[inline(always)]
    fn cells(&self) -> Option<[PathCells<B>; 2]> {
        if self.length == 0 {
            return None;
        }
        let (mut all, mut all_open) = ([B::NONE; 2], [B::NONE; 2]);
        let mut narrowest = Narrowest::NONE;
        // The cells of a layer from which a path to the goal is known to be open. After a few
        // layers, this set is usually empty.
        let (mut open, mut is_over) = (B::ALL, false);
        self.for_each_layer(|colour, layer| {
            let Colour { known, visited, .. } = &self.colours[colour];
            all[colour] = all[colour].or(layer);
            if !is_over {
                open = known.from(open, layer);
                all_open[colour] = all_open[colour].or(open);
                is_over = open.is_empty();
            }
            if layer.and(*visited).is_empty() {
                narrowest.add(colour, layer, layer);
            }
            true
        });
        let is_open = !all_open[self.length % 2].and(self.start).is_empty();
        let cells = |i: usize| PathCells { all: all[i], narrowest: narrowest.cells[i] };
        (!is_open).then(|| [cells(0), cells(1)])
    }

    /// Returns the candidates that [`ExplorationTarget::find`] considers.
    #[inline(always)]
    fn candidates(&self, found: &[PathCells<B>; 2]) -> [B; 2] {
        let mut unexplored = [B::NONE; 2];
        for i in [0, 1] {
            let Colour { optimistic, known, visited } = &self.colours[i];
            let beside_unknown = optimistic.without(*known).from(found[1 - i].all, found[i].all);
            unexplored[i] = beside_unknown.without(*visited);
        }
        // The narrowest layers usually contain unexplored cells.
        let candidates =
            [found[0].narrowest.and(unexplored[0]), found[1].narrowest.and(unexplored[1])];
        let is_any = !candidates[0].or(candidates[1]).is_empty();
        if is_any { candidates } else { self.narrowest(unexplored) }
    }

    /// Among the layers that contain unexplored cells but no visited cell, selects those with the
    /// fewest cells. Returns the unexplored cells in the selected layers, or all unexplored cells
    /// if no layer is selected.
    #[inline(always)]
    fn narrowest(&self, unexplored: [B; 2]) -> [B; 2] {
        let mut narrowest = Narrowest::NONE;
        self.for_each_layer(|colour, layer| {
            let cells = layer.and(unexplored[colour]);
            if layer.and(self.colours[colour].visited).is_empty() && !cells.is_empty() {
                narrowest.add(colour, layer, cells);
            }
            true
        });
        if narrowest.width == Narrowest::<B>::NONE.width { unexplored } else { narrowest.cells }
    }

    /// Returns the candidates nearest to the mouse, preceded by the index of their common
    /// chessboard colour.
    #[inline(always)]
    fn nearest(&self, mouse: Cell, candidates: [B; 2]) -> Option<(usize, B)> {
        let near = usize::from(is_dark(mouse) != self.ends_are_dark);
        let far = 1 - near;
        let into = [&self.colours[far].optimistic, &self.colours[near].optimistic];
        let mouse = CellPlanes::<B>::from_cell(mouse);
        let mouse = mouse.dark.or(mouse.light);
        let (nearest, steps) = first_targets(into, mouse, [candidates[near], candidates[far]])?;
        Some(((near + usize::from(steps)) % 2, nearest))
    }

    /// Returns those of `cells` that are farthest from the start. All of `cells` have the
    /// chessboard colour with the index `cells_colour`.
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

/// Cells collected from the narrowest layers so far. Each of these layers has `width` cells.
struct Narrowest<B> {
    width: u32,
    cells: [B; 2],
}

impl<B: ParityPlane> Narrowest<B> {
    const NONE: Self = Self { width: u32::MAX, cells: [B::NONE; 2] };

    /// Adds `cells`, which belong to `layer`. Ignores empty layers and layers with more than
    /// `self.width` cells. If a layer has fewer cells, its `cells` replace all previously added
    /// cells.
    #[inline(always)]
    fn add(&mut self, colour: usize, layer: B, cells: B) {
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
fn count<H: ParityPlane>(cells: H) -> u32 {
    cells.to_words().as_ref().iter().map(|word| word.count_ones()).sum()
}

#[cfg(test)]
mod tests {
    use core::cmp::Reverse;
    use core::ops::Range;

    use mmsim_maze::{Heading, Maze, MazeSize, Pose, WallState};
    use proptest::prelude::*;

    use super::*;
    use crate::flood::Distances;
    use crate::flood::dispatch::{available, run_with};
    use crate::flood::tests::{any_targets, any_walls};

    #[test]
    fn explores_narrow_layers_without_a_visited_cell() {
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
            let candidates = candidates(&map, &from_start);
            let mouse = Cell::new(x, y);
            let mut memory = ExplorationMemory::NEW;
            let mut distances = Distances::unreachable(map.size());
            let found = ExplorationTarget::find(&map, mouse, &mut memory, &mut distances);
            assert_eq!(found, naive(&map, mouse));
            candidates
                .map(|(cells, _)| cells.iter().map(|cell| (cell.x, cell.y)).collect::<Vec<_>>())
        };
        assert_eq!(see(0, 0), Some(vec![(1, 1), (2, 1), (3, 1), (4, 2)]), "layers of one cell");
        assert_eq!(see(4, 2), Some(vec![(1, 1), (2, 1), (3, 1)]));
        assert_eq!(see(2, 1), Some(vec![(1, 1), (3, 1)]), "unknown on their other sides");
        assert_eq!(see(1, 1), Some(vec![(3, 1)]));
        assert_eq!(see(3, 1), None, "a path is known to be open");
    }

    proptest! {
        // Most random maps have few candidates.
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn the_target_equals_the_naive_one(
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
            let mut memory = ExplorationMemory::NEW;
            let mut distances = Distances::unreachable(size);
            for instructions in available() {
                let task = FindTarget { map, mouse, memory: &mut memory, distances: &mut distances };
                prop_assert_eq!(run_with(instructions, task, size), expected);
            }
        }
    }

    /// Finds the target naively, by comparing distances cell by cell.
    fn naive(map: &KnownMaze, mouse: Cell) -> Option<ExplorationTarget> {
        let open = map.walls(Unknown::Open);
        let from_start = Distances::flood(open, &only(map.start().cell));
        let (candidates, paths) = candidates(map, &from_start)?;
        let from_mouse = Distances::flood(open, &only(mouse));
        let near_and_far_out = |&cell: &Cell| (from_mouse.at(cell), Reverse(from_start.at(cell)));
        let reachable = candidates.iter().filter(|&cell| from_mouse.at(cell).is_some());
        Some(ExplorationTarget { cell: reachable.min_by_key(near_and_far_out)?, paths })
    }

    /// Follows the optimistic shortest paths from goal to start. Returns the candidates that
    /// [`ExplorationTarget::find`] considers, and all cells on the optimistic shortest paths, or
    /// `None` if one of these paths is known to be open.
    fn candidates(map: &KnownMaze, from_start: &Distances) -> Option<(CellSet, CellSet)> {
        let mut paths = Paths::to_goals(map, from_start);
        let (mut width, mut narrowest, mut others) = (usize::MAX, CellSet::EMPTY, CellSet::EMPTY);
        let mut layer = 0..paths.count;
        while !layer.is_empty() {
            let nearer = paths.go_back(map, from_start, layer.clone());
            let cells = &paths.cells[layer];
            let is_unvisited = |&cell: &Cell| !map.visited().contains(cell);
            let is_candidate = |&cell: &Cell| is_unvisited(&cell) && paths.doubtful.contains(cell);
            let mut candidates = cells.iter().copied().filter(is_candidate).peekable();
            if candidates.peek().is_none() || !cells.iter().all(is_unvisited) {
                others.extend(candidates);
            } else if cells.len() < width {
                (width, narrowest) = (cells.len(), candidates.collect());
            } else if cells.len() == width {
                narrowest.extend(candidates);
            }
            layer = nearer;
        }
        let candidates = if narrowest.is_empty() { others } else { narrowest };
        Some((candidates, paths.found)).filter(|_| !paths.sure.contains(map.start().cell))
    }

    /// The cells on the optimistic shortest paths, found layer by layer from the goal back to the
    /// start.
    struct Paths {
        cells: [Cell; MazeSize::MAX_AREA],
        count: usize,
        found: CellSet,
        /// The cells from which a path to the goal is known to be open.
        sure: CellSet,
        /// The cells on both sides of each unknown wall that an optimistic shortest path crosses.
        doubtful: CellSet,
    }

    impl Paths {
        /// Creates a list of the goal cells nearest to the start.
        fn to_goals(map: &KnownMaze, from_start: &Distances) -> Self {
            let nearest = map.goals().iter().filter_map(|goal| from_start.at(goal)).min();
            let is_end = |&goal: &Cell| nearest.is_some() && from_start.at(goal) == nearest;
            let ends = map.goals().iter().filter(is_end).collect();
            let cells = [Cell::new(0, 0); MazeSize::MAX_AREA];
            let mut paths =
                Self { cells, count: 0, found: ends, sure: ends, doubtful: CellSet::EMPTY };
            for (place, end) in paths.cells.iter_mut().zip(ends.iter()) {
                *place = end;
                paths.count += 1;
            }
            paths
        }

        /// Adds the path cells that are one step nearer to the start than the cells of `layer`.
        /// Returns the indices of the added cells.
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
