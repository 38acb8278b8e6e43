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
        let (columns_north, columns_east) = (north.transposed(), east.transposed());
        let columns_goals = goals.transposed();
        let frame = |forward, aside, goals| Frame { forward, aside, goals };
        [
            frame(columns_north, columns_east, columns_goals),
            frame(east, north, goals),
            frame(
                columns_north.behind().reversed(),
                columns_east.reversed(),
                columns_goals.reversed(),
            ),
            frame(east.behind().reversed(), north.reversed(), goals.reversed()),
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

#[cfg(test)]
mod tests {
    use mmsim_maze::{Direction, Heading, MazeSize, Point};
    use proptest::prelude::*;

    use super::*;
    use crate::planner::classes::ORDER;
    use crate::turn::{Side, TurnKind};
    use crate::vehicle::Vehicle;

    /// Closes one dead end after another.
    fn without_dead_ends(mut walls: Walls, start: Cell, goals: &CellSet) -> Walls {
        loop {
            let is_dead_end = |cell: &Cell| {
                let count = walls.open_neighbours(*cell).count();
                count == 1 && *cell != start && !goals.contains(*cell)
            };
            let Some(cell) = walls.size().cells().find(is_dead_end) else { return walls };
            for heading in Heading::ALL {
                walls.set(cell, heading, true);
            }
        }
    }

    /// Returns true if a mouse that has come to a point can go on, or is in a goal.
    fn can_go_on(walls: &Walls, goals: &CellSet, at: Point, direction: Direction) -> bool {
        let next = at.advanced(direction, 1);
        let is_wall = at.wall().is_some() && !direction.is_diagonal();
        is_wall
            || next.is_some_and(|next| next.is_free(walls))
            || at.cell().is_some_and(|cell| goals.contains(cell))
    }

    fn check<L: Line, const N: usize>(walls: &Walls, start: Cell, goals: &CellSet) {
        let tables = Tables::new(&Vehicle::kerise());
        let openings = Openings::<L, N>::new(walls, goals).without_dead_ends(start);
        let walls = without_dead_ends(walls.clone(), start, goals);
        let size = walls.size();
        let is_legal = |kind: TurnKind, at: Point, direction: Direction, side: Side| {
            let passes = kind
                .walls(at, direction, side)
                .all(|wall| wall.is_some_and(|wall| wall.is_free(&walls)));
            let end = kind.end(at, direction, side);
            passes && end.is_some_and(|(end, direction)| can_go_on(&walls, goals, end, direction))
        };
        let frames = openings.frames();
        for (ahead, heading) in Heading::ALL.into_iter().enumerate() {
            let (frame, turns) = (&frames[ahead], frames[ahead].along_turns(&tables));
            let direction = Direction::from(heading);
            for cell in size.cells() {
                let (x, y) = (usize::from(cell.x), usize::from(cell.y));
                let (line, position) = [(x, y), (y, x), (x, N - 1 - y), (y, N - 1 - x)][ahead];
                let bit = |rows: &Rows<L, N>| rows.0[line].to_bits() >> position & 1 == 1;
                assert_eq!(bit(&frame.forward), !walls.has(cell, heading));
                assert_eq!(bit(&frame.goals), goals.contains(cell));
                // The next line is that to the east or north.
                let next_is_right = matches!(heading, Heading::North | Heading::West);
                let sides = if next_is_right {
                    [Side::Right, Side::Left]
                } else {
                    [Side::Left, Side::Right]
                };
                let centre = Point::centre(cell);
                for (lane, rows) in turns.0.iter().enumerate() {
                    let kind = ORDER[lane / 2];
                    let at = if lane < 2 { centre.advanced(direction, 1) } else { Some(centre) };
                    let is_free = at.is_some_and(|at| at.is_free(&walls));
                    let legal = is_free && is_legal(kind, at.unwrap(), direction, sides[lane % 2]);
                    assert_eq!(bit(rows), legal, "{kind} {cell} {heading}");
                }
                if ahead % 2 == 0 {
                    continue;
                }
                let (up, down) = (frame.diagonals_up(&tables), frame.diagonals_down(&tables));
                for (turns, vertical) in [(up, Heading::North), (down, Heading::South)] {
                    for (wall, turns) in turns.iter().enumerate() {
                        let to_wall = if wall == 0 { heading } else { Heading::North };
                        let Some(at) =
                            centre.advanced(to_wall.into(), 1).filter(|at| at.is_free(&walls))
                        else {
                            continue;
                        };
                        let is_east = heading == Heading::East;
                        let diagonal = match (is_east, vertical) {
                            (true, Heading::North) => Direction::NorthEast,
                            (true, _) => Direction::SouthEast,
                            (false, Heading::North) => Direction::NorthWest,
                            (false, _) => Direction::SouthWest,
                        };
                        let next =
                            at.advanced(diagonal, 1).is_some_and(|next| next.is_free(&walls));
                        assert_eq!(bit(&turns.next), next, "{cell} {heading} {vertical}");
                        for (turn, rows) in turns.turns.iter().enumerate() {
                            let kind = ORDER[5 + turn];
                            let mut sides = Side::ALL
                                .into_iter()
                                .filter(|&side| kind.begins_at(at, diagonal, side));
                            let legal = sides.any(|side| is_legal(kind, at, diagonal, side));
                            assert_eq!(bit(rows), legal, "{kind} {cell} {diagonal}");
                        }
                    }
                }
            }
        }
    }

    proptest! {
        #[test]
        fn bits_are_those_of_the_rules(
            (width, height) in (1usize..=32, 1usize..=32),
            rows in prop::collection::vec(any::<[u32; 4]>(), 32),
            cells in prop::collection::vec(any::<(u8, u8)>(), 2..4),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let row = |index: usize| from_fn(|y| rows[y][index] & rows[y][index + 1]);
            let walls = Walls::from_rows(size, row(0), row(2));
            let cell = |&(x, y): &(u8, u8)| Cell::new(x % size.width(), y % size.height());
            let goals: CellSet = cells[1..].iter().map(cell).collect();
            check::<u32, 32>(&walls, cell(&cells[0]), &goals);
            if width <= 16 && height <= 16 {
                check::<u16, 16>(&walls, cell(&cells[0]), &goals);
            }
        }
    }
}
