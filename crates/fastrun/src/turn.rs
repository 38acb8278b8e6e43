//! The nine slalom turns.

use core::f64::consts::{FRAC_PI_4, SQRT_2};
use core::fmt;

use mmsim_maze::{Direction, Point};

/// A slalom turn, which a mouse drives without stopping.
///
/// A turn begins and ends at lattice points. Turns along a row or column begin at the centre of a
/// cell, except for [`S90`](Self::S90), which begins at the middle of a wall. Turns on a diagonal
/// begin at the middle of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TurnKind {
    /// A turn by 90° within one cell.
    S90,
    /// A turn by 90° from the centre of a cell to the centre of a diagonal neighbour.
    L90,
    /// A turn by 180° round a wall, to the centre of a neighbouring cell.
    L180,
    /// A turn by 45° onto a diagonal.
    In45,
    /// A turn by 135° onto a diagonal.
    In135,
    /// A turn by 45° off a diagonal.
    Out45,
    /// A turn by 135° off a diagonal.
    Out135,
    /// A turn by 90° from a diagonal to a diagonal, round one post.
    V90,
    /// A wide turn by 90° from a diagonal to a diagonal.
    K90,
}

/// The side to which a mouse turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Counterclockwise.
    Left,
    /// Clockwise.
    Right,
}

impl Side {
    /// Both sides.
    pub const ALL: [Self; 2] = [Self::Left, Self::Right];

    /// Returns the abbreviation: `L` or `R`.
    pub const fn letter(self) -> char {
        match self {
            Self::Left => 'L',
            Self::Right => 'R',
        }
    }
}

/// The geometry of a turn on the lattice, in half cells. The coordinates are (to the side, forward)
/// for turns that begin along a row or column, and (to the outside, to the inside of the turn) for
/// turns that begin on a diagonal, both along the rows and columns.
pub(crate) struct Geometry {
    pub(crate) name: &'static str,
    pub(crate) eighths: i8,
    pub(crate) end: (i8, i8),
    /// The middles of the walls that the turn passes, in this order, including the end if it is
    /// one.
    pub(crate) walls: &'static [(i8, i8)],
    /// The distances from the beginning to the corner of the two lines, and from there to the end.
    /// Zero for the turn by 180°, which has no corner.
    pub(crate) corner: (f64, f64),
}

impl TurnKind {
    /// All turns.
    pub const ALL: [Self; 9] = [
        Self::S90,
        Self::L90,
        Self::L180,
        Self::In45,
        Self::In135,
        Self::Out45,
        Self::Out135,
        Self::V90,
        Self::K90,
    ];

    /// Returns the name, such as `l90` or `45in`.
    pub const fn name(self) -> &'static str {
        self.geometry().name
    }

    /// Returns the turn with this name.
    ///
    /// ```
    /// use mmsim_fastrun::TurnKind;
    /// assert_eq!(TurnKind::from_name("45in"), Some(TurnKind::In45));
    /// assert_eq!(TurnKind::from_name("45"), None);
    /// ```
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Returns the angle by which the mouse turns, in eighths of a full turn.
    pub const fn eighths(self) -> i8 {
        self.geometry().eighths
    }

    /// Returns the angle by which the mouse turns, in radians.
    pub fn angle(self) -> f64 {
        FRAC_PI_4 * f64::from(self.eighths())
    }

    /// Returns true if the turn begins on a diagonal.
    pub const fn begins_diagonal(self) -> bool {
        matches!(self, Self::Out45 | Self::Out135 | Self::V90 | Self::K90)
    }

    /// Returns true if the turn ends on a diagonal.
    pub const fn ends_diagonal(self) -> bool {
        matches!(self, Self::In45 | Self::In135 | Self::V90 | Self::K90)
    }

    pub(crate) const fn geometry(self) -> &'static Geometry {
        const TURNS: [Geometry; 9] = [
            geometry("s90", 2, (1, 1), &[(1, 1)], (1.0, 1.0)),
            geometry("l90", 2, (2, 2), &[(0, 1), (1, 2)], (2.0, 2.0)),
            geometry("180", 4, (2, 0), &[(0, 1), (1, 2), (2, 1)], (0.0, 0.0)),
            geometry("45in", 1, (1, 2), &[(0, 1), (1, 2)], (1.0, SQRT_2)),
            geometry("135in", 3, (2, 1), &[(0, 1), (1, 2), (2, 1)], (3.0, 2.0 * SQRT_2)),
            geometry("45out", 1, (1, 2), &[(1, 1)], (SQRT_2, 1.0)),
            geometry("135out", 3, (-1, 2), &[(1, 1), (0, 2)], (2.0 * SQRT_2, 3.0)),
            geometry("v90", 2, (0, 2), &[(1, 1), (0, 2)], (SQRT_2, SQRT_2)),
            geometry("k90", 2, (0, 4), &[(1, 1), (1, 3), (0, 4)], (2.0 * SQRT_2, 2.0 * SQRT_2)),
        ];
        const TABLE: &[Geometry; 9] = &TURNS;
        &TABLE[self as usize]
    }

    /// Returns true if a turn to this side can begin at `from` in the given direction, regardless
    /// of walls.
    pub fn begins_at(self, from: Point, direction: Direction, side: Side) -> bool {
        if self.begins_diagonal() != direction.is_diagonal() {
            return false;
        }
        if self.begins_diagonal() {
            return diagonal_side(from, direction) == Some(side);
        }
        match from.wall() {
            // A mouse crosses a wall, it does not drive along it.
            Some(_) => self == Self::S90 && (from.i & 1 == 0) == (direction.vector().0 != 0),
            None => self != Self::S90 && from.cell().is_some(),
        }
    }

    /// Returns where the turn leads from `from`: the end and the direction there. Returns `None`
    /// outside of the coordinates 0 to 255.
    pub fn end(self, from: Point, direction: Direction, side: Side) -> Option<(Point, Direction)> {
        let point = place(from, direction, side, self.geometry().end)?;
        Some((point, self.turned(direction, side)))
    }

    /// Returns the direction after the turn.
    pub(crate) const fn turned(self, direction: Direction, side: Side) -> Direction {
        let eighths = self.geometry().eighths;
        direction.turned(match side {
            Side::Left => -eighths,
            Side::Right => eighths,
        })
    }

    /// Returns the middles of the walls that a turn from `from` passes, in this order, including
    /// its end if it is one. Points outside of the coordinates 0 to 255 are `None`.
    pub fn walls(
        self,
        from: Point,
        direction: Direction,
        side: Side,
    ) -> impl Iterator<Item = Option<Point>> {
        let walls = self.geometry().walls.iter();
        walls.map(move |&offset| place(from, direction, side, offset))
    }
}

impl fmt::Display for TurnKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

const fn geometry(
    name: &'static str,
    eighths: i8,
    end: (i8, i8),
    walls: &'static [(i8, i8)],
    corner: (f64, f64),
) -> Geometry {
    Geometry { name, eighths, end, walls, corner }
}

/// Returns the side to which a mouse on a diagonal can turn: the side on which the cell ahead lies.
fn diagonal_side(from: Point, direction: Direction) -> Option<Side> {
    from.wall()?;
    let is_west_or_east_wall = from.i & 1 == 0;
    let is_steep = matches!(direction, Direction::NorthEast | Direction::SouthWest);
    Some(if is_west_or_east_wall == is_steep { Side::Left } else { Side::Right })
}

/// Returns the point at an offset of the canonical form of a turn.
fn place(from: Point, direction: Direction, side: Side, (a, b): (i8, i8)) -> Option<Point> {
    // The two axes of the canonical form, as (east, north).
    let (first, second) = if direction.is_diagonal() {
        // The diagonal lies between the outside of the turn and its inside.
        match side {
            Side::Left => (direction.turned(1), direction.turned(-1)),
            Side::Right => (direction.turned(-1), direction.turned(1)),
        }
    } else {
        match side {
            Side::Left => (direction.turned(-2), direction),
            Side::Right => (direction.turned(2), direction),
        }
    };
    let ((first_east, first_north), (second_east, second_north)) =
        (first.vector(), second.vector());
    from.shifted(
        (a * first_east + b * second_east).into(),
        (a * first_north + b * second_north).into(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_parse_back() {
        for kind in TurnKind::ALL {
            assert_eq!(TurnKind::from_name(kind.name()), Some(kind));
        }
        assert_eq!(TurnKind::from_name("l180"), None);
    }

    /// Each end is where the two lines through the corner lead.
    #[test]
    fn ends_lie_on_the_lines_through_the_corner() {
        let (centre, wall) = (Point { i: 21, j: 21 }, Point { i: 20, j: 21 });
        for kind in TurnKind::ALL {
            for direction in Direction::ALL {
                for side in Side::ALL {
                    for from in [centre, wall, Point { i: 21, j: 20 }] {
                        if !kind.begins_at(from, direction, side) {
                            continue;
                        }
                        let (end, after) = kind.end(from, direction, side).unwrap();
                        let (before, past) = kind.geometry().corner;
                        let step = |direction: Direction, length: f64| {
                            let (sin, cos) = direction.angle().sin_cos();
                            (length * cos, length * sin)
                        };
                        let (there, on) = (step(direction, before), step(after, past));
                        let expected = [
                            f64::from(from.i) + there.0 + on.0,
                            f64::from(from.j) + there.1 + on.1,
                        ];
                        let found = [f64::from(end.i), f64::from(end.j)];
                        let off =
                            expected.iter().zip(found).map(|(a, b)| (a - b).abs()).sum::<f64>();
                        let is_straight_back = kind == TurnKind::L180;
                        assert!(is_straight_back || off < 1e-9, "{kind} {direction} {side:?}");
                        let walls: Vec<_> = kind.walls(from, direction, side).flatten().collect();
                        assert!(walls.iter().all(|wall| wall.wall().is_some()), "{kind}");
                        assert!(end.cell().is_some() || walls.last() == Some(&end), "{kind}");
                        assert_eq!(
                            end.cell().is_some(),
                            !kind.ends_diagonal() && kind != TurnKind::S90
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn turns_begin_only_where_a_mouse_can_be() {
        let south = Point { i: 3, j: 2 };
        for direction in Direction::ALL {
            let crosses = matches!(direction, Direction::North | Direction::South);
            for side in Side::ALL {
                assert_eq!(TurnKind::S90.begins_at(south, direction, side), crosses);
                assert!(!TurnKind::L90.begins_at(south, direction, side));
                let post = Point { i: 2, j: 2 };
                assert!(!TurnKind::ALL.iter().any(|kind| kind.begins_at(post, direction, side)));
            }
            let sides = Side::ALL.map(|side| TurnKind::V90.begins_at(south, direction, side));
            assert_eq!(sides[0] != sides[1], direction.is_diagonal());
        }
    }
}
