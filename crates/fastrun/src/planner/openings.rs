//! The openings of a maze without its dead ends, and where turns can begin, as bit rows.

use core::array::from_fn;

use mmsim_maze::{Cell, CellSet, Walls};

use super::rows::{Line, Rows};
use super::tables::Tables;

/// The openings of a maze: bit x of line y stands for the cell (x, y).
#[derive(Clone, Copy)]
pub(super) struct Openings<L, const N: usize> {
    /// The cells that are open to the north.
    north: Rows<L, N>,
    /// The cells that are open to the east.
    east: Rows<L, N>,
    goals: Rows<L, N>,
}

impl<L: Line, const N: usize> Openings<L, N> {
    /// Creates the openings of a maze. No goal lies outside of it.
    pub(super) fn new(walls: &Walls, goals: &CellSet) -> Self {
        Self {
            north: !Rows::from_rows(walls.north_rows()),
            east: !Rows::from_rows(walls.east_rows()),
            goals: Rows::from_rows(goals.rows()),
        }
    }

    /// Closes all dead ends, except for the start and the goals. A mouse cannot turn round, so no
    /// run enters them.
    pub(super) fn without_dead_ends(mut self, start: Cell) -> Self {
        let mut kept = self.goals;
        kept.0[usize::from(start.y)] =
            kept.0[usize::from(start.y)] | L::from_low_bits(1).shl(start.x.into());
        loop {
            let (north, east) = (self.north, self.east);
            let (south, west) = (north.below(), east.behind());
            let (vertical, horizontal) = (north | south, east | west);
            let passable = (vertical & horizontal) | (north & south) | (east & west) | kept;
            let closed = (vertical | horizontal) & !passable;
            if closed.is_empty() {
                return self;
            }
            self.north = north & passable & passable.above();
            self.east = east & passable & passable.ahead(1);
        }
    }

    /// Returns the openings as a mouse sees them that drives east, north, west and south, in the
    /// order of [`Heading`](mmsim_maze::Heading): north, east, south, west.
    pub(super) fn frames(&self) -> [Frame<L, N>; 4] {
        let Self { north, east, goals } = *self;
        let backwards = |rows: Rows<L, N>| rows.reversed();
        let (columns_north, columns_east) = (north.transposed(), east.transposed());
        let columns_goals = goals.transposed();
        let frame = |forward, aside, goals| Frame { forward, aside, goals };
        [
            frame(columns_north, columns_east, columns_goals),
            frame(east, north, goals),
            frame(
                backwards(columns_north.behind()),
                backwards(columns_east),
                backwards(columns_goals),
            ),
            frame(backwards(east.behind()), backwards(north), backwards(goals)),
        ]
    }
}

/// The openings of a maze as seen by a mouse that drives in one of four directions. The cells of a
/// line follow each other in this direction. Lines are counted from south to north or from west to
/// east.
///
/// A run can only use a turn that begins where the mouse can come from and ends where the mouse can
/// go on: either straight, or because the turn ends in a goal.
#[derive(Clone, Copy)]
pub(super) struct Frame<L, const N: usize> {
    /// The cells that are open ahead.
    pub(super) forward: Rows<L, N>,
    /// The cells that are open towards the next line.
    pub(super) aside: Rows<L, N>,
    pub(super) goals: Rows<L, N>,
}

/// The cells from which each turn along a line can begin: `s90` (at the wall ahead of the cell),
/// `l90`, `45in`, `180` and `135in`, each first to the next line and then to the line before.
#[derive(Clone, Copy)]
pub(super) struct AlongTurns<L, const N: usize>(pub(super) [Rows<L, N>; 10]);

/// The walls from which each turn on a diagonal can begin.
#[derive(Clone, Copy)]
pub(super) struct DiagonalTurns<L, const N: usize> {
    /// The walls after which the next wall of the diagonal is open.
    pub(super) next: Rows<L, N>,
    /// `45out`, `135out`, `v90` and `k90`.
    pub(super) turns: [Rows<L, N>; 4],
}

impl<L: Line, const N: usize> DiagonalTurns<L, N> {
    pub(super) const NONE: Self = Self { next: Rows::NONE, turns: [Rows::NONE; 4] };
}

impl<L: Line, const N: usize> Frame<L, N> {
    #[inline(always)]
    pub(super) fn along_turns(&self, tables: &Tables) -> AlongTurns<L, N> {
        let down = self.aside.below();
        let [up, down] = [
            self.along_turns_aside(
                [self.forward.above(), self.goals.above()],
                [self.aside, self.aside.above()],
                tables,
            ),
            self.along_turns_aside(
                [self.forward.below(), self.goals.below()],
                [down, down.below()],
                tables,
            ),
        ];
        AlongTurns(from_fn(|lane| [up, down][lane % 2][lane / 2]))
    }

    /// Returns the turns to one side, given the openings ahead and the goals of the line on this
    /// side, and the openings from the cells to this line and from there to the line after it.
    #[inline(always)]
    fn along_turns_aside(
        &self,
        [forward, goals]: [Rows<L, N>; 2],
        [aside, beyond]: [Rows<L, N>; 2],
        tables: &Tables,
    ) -> [Rows<L, N>; 5] {
        let s90 = self.forward & aside.ahead(1);
        let round = s90 & forward;
        let turns = [
            s90,
            s90 & (beyond | goals).ahead(1),
            s90 & forward.ahead(1),
            round & (forward.behind() | goals),
            round & beyond,
        ];
        from_fn(|turn| if tables.has(turn) { turns[turn] } else { Rows::NONE })
    }

    /// Returns the turns on diagonals that lead forward and to the next line: first from the walls
    /// ahead of the cells, then from those between the cells and the next line.
    #[inline(always)]
    pub(super) fn diagonals_up(&self, tables: &Tables) -> [DiagonalTurns<L, N>; 2] {
        let Self { forward, aside, goals } = *self;
        let (above, aside_above, goals_above) = (forward.above(), aside.above(), goals.above());
        let next = aside.ahead(1);
        let around = next & above;
        let from_ahead = [
            next & (aside_above | goals_above).ahead(1),
            around & (above.behind() | goals_above),
            around & aside_above,
            next & aside_above.ahead(1) & above.above() & aside_above.above(),
        ];
        let around = above & aside.ahead(1);
        let from_aside = [
            above & (above | goals_above).ahead(1),
            around & (aside.below() | goals).ahead(1),
            around & forward.ahead(1),
            above & above.ahead(1) & aside.ahead(2) & forward.ahead(2),
        ];
        [diagonal_turns(next, from_ahead, tables), diagonal_turns(above, from_aside, tables)]
    }

    /// Does the same as [`diagonals_up`](Self::diagonals_up) for the line before.
    #[inline(always)]
    pub(super) fn diagonals_down(&self, tables: &Tables) -> [DiagonalTurns<L, N>; 2] {
        let Self { forward, aside, goals } = *self;
        let (below, aside_below, goals_below) = (forward.below(), aside.below(), goals.below());
        let beyond = aside_below.below();
        let next = aside_below.ahead(1);
        let around = next & below;
        let from_ahead = [
            next & (beyond | goals_below).ahead(1),
            around & (below.behind() | goals_below),
            around & beyond,
            next & beyond.ahead(1) & below.below() & beyond.below(),
        ];
        let around = forward & aside.ahead(1);
        let (above, goals_above) = (forward.above(), goals.above());
        let from_aside = [
            forward & (forward | goals).ahead(1),
            around & (aside.above() | goals_above).ahead(1),
            around & above.ahead(1),
            forward & forward.ahead(1) & aside.ahead(2) & above.ahead(2),
        ];
        [diagonal_turns(next, from_ahead, tables), diagonal_turns(forward, from_aside, tables)]
    }
}

#[inline(always)]
fn diagonal_turns<L: Line, const N: usize>(
    next: Rows<L, N>,
    turns: [Rows<L, N>; 4],
    tables: &Tables,
) -> DiagonalTurns<L, N> {
    let turns = from_fn(|turn| if tables.has(5 + turn) { turns[turn] } else { Rows::NONE });
    DiagonalTurns { next, turns }
}
