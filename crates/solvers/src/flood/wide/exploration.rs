//! Selection of the cell to explore next, with one bit per cell.

use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown};

use super::bitboard::{Bitboard, CellPlanes, Openings, is_dark, rows};
use super::plane::ParityPlane;
use super::waves::first_targets;

/// Does the same as [`exploration_target`](crate::flood::exploration_target).
#[inline(always)]
pub(crate) fn find<H: ParityPlane>(
    map: &KnownMaze,
    mouse: Cell,
    paths: &mut CellSet,
) -> Option<Cell> {
    let shortest = ShortestPaths::<H>::find(map)?;
    let found = shortest.cells()?;
    let candidates = shortest.candidates(&found);
    let (colour, nearest) = shortest.nearest(mouse, candidates)?;
    let is_one = count(nearest) == 1;
    let target = if is_one { nearest } else { shortest.first_layer_with(colour, nearest) };
    let mut planes = [H::NONE; 2];
    planes[colour] = target;
    let target = CellPlanes::from_near_and_far(planes, shortest.ends_are_dark);
    let all = CellPlanes::from_near_and_far([found[0].all, found[1].all], shortest.ends_are_dark);
    *paths = CellSet::from_rows(rows(all.columns()));
    target.first_cell()
}

/// The visited cells of one chessboard colour, and the open sides through which cells of that
/// colour can be entered.
#[derive(Clone, Copy)]
struct ColourMap<B> {
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
    colours: [ColourMap<B>; 2],
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
        let colour = |i: usize| ColourMap {
            optimistic: optimistic[i],
            known: known[i],
            visited: visited[i],
        };
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
            let ColourMap { known, visited, .. } = &self.colours[colour];
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

    /// Returns the candidates that [`exploration_target`](crate::flood::exploration_target) considers.
    #[inline(always)]
    fn candidates(&self, found: &[PathCells<B>; 2]) -> [B; 2] {
        let mut unexplored = [B::NONE; 2];
        for i in [0, 1] {
            let ColourMap { optimistic, known, visited } = &self.colours[i];
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
