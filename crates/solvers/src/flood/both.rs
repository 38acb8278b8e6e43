//! Two floods at once.

use mmsim_maze::{CellSet, KnownMaze, Unknown};

use super::board::{Board, Chequered, Ways};
use super::half::{Bits, Half};
use super::waves::{self, Marks, PLANES};
use super::{Distances, Task, run};

/// The halves of two floods, side by side: while a processor waits for one it works on the other.
#[derive(Clone, Copy)]
struct Pair<B>(B, B);

impl Distances {
    /// Floods what a mouse knows from some targets outwards, at the same time with unknown walls
    /// taken as open and as closed; in this order.
    ///
    /// ```
    /// use mmsim_maze::{Cell, KnownMaze, MazeSize, Unknown};
    /// use mmsim_solvers::Distances;
    /// let (start, goals) = (Cell::new(0, 0), MazeSize::CLASSIC.central_cells());
    /// let map = KnownMaze::new(MazeSize::CLASSIC, start, goals);
    /// let [open, closed] = Distances::flood_both(&map, map.goals());
    /// assert_eq!((open.at(start), closed.at(start)), (Some(14), None));
    /// assert_eq!(open, Distances::flood(map.walls(Unknown::Open), map.goals()));
    /// ```
    pub fn flood_both(map: &KnownMaze, targets: &CellSet) -> [Self; 2] {
        let size = map.size();
        let mut both = [Self::unreachable(size), Self::unreachable(size)];
        run(FloodBoth { map, targets, both: &mut both }, size);
        both
    }
}

struct FloodBoth<'a> {
    map: &'a KnownMaze,
    targets: &'a CellSet,
    both: &'a mut [Distances; 2],
}

impl Task for FloodBoth<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) {
        let Self { map, targets, both: [of_open, of_closed] } = self;
        let board = |unknown| Board::<H>::of(map.walls(unknown));
        let (open, closed) = (board(Unknown::Open), board(Unknown::Closed));
        let pair = |open: Ways<H>, closed: Ways<H>| open.zip(closed, Pair);
        let board = Board {
            into_dark: pair(open.into_dark, closed.into_dark),
            into_light: pair(open.into_light, closed.into_light),
        };
        let Chequered { dark, light } = Chequered::<H>::of(targets);
        let targets = Chequered { dark: Pair(dark, dark), light: Pair(light, light) };
        let Chequered { dark, light } = waves::flood(&board, targets);
        let ((open_dark, closed_dark), (open_light, closed_light)) = (dark.parted(), light.parted());
        of_open.write(&Chequered { dark: open_dark, light: open_light });
        of_closed.write(&Chequered { dark: closed_dark, light: closed_light });
    }
}

impl<B: Bits> Marks<Pair<B>> {
    #[inline(always)]
    fn parted(&self) -> (Marks<B>, Marks<B>) {
        let (mut first, mut second) = ([B::NONE; PLANES], [B::NONE; PLANES]);
        for (i, Pair(a, b)) in self.planes.iter().enumerate() {
            (first[i], second[i]) = (*a, *b);
        }
        let Pair(a, b) = self.dry;
        (Marks { planes: first, dry: a }, Marks { planes: second, dry: b })
    }
}

impl<B: Bits> Bits for Pair<B> {
    const NONE: Self = Self(B::NONE, B::NONE);
    const ALL: Self = Self(B::ALL, B::ALL);

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0.and(other.0), self.1.and(other.1))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(self.0.or(other.0), self.1.or(other.1))
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(self.0.xor(other.0), self.1.xor(other.1))
    }

    #[inline(always)]
    fn without(self, other: Self) -> Self {
        Self(self.0.without(other.0), self.1.without(other.1))
    }

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        Self(self.0.up::<BITS>(), self.1.up::<BITS>())
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        Self(self.0.down::<BITS>(), self.1.down::<BITS>())
    }

    #[inline(always)]
    fn north(self) -> Self {
        Self(self.0.north(), self.1.north())
    }

    #[inline(always)]
    fn south(self) -> Self {
        Self(self.0.south(), self.1.south())
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.0.or(self.1).is_empty()
    }

    #[inline(always)]
    fn and_or(self, mask: Self, others: Self) -> Self {
        Self(self.0.and_or(mask.0, others.0), self.1.and_or(mask.1, others.1))
    }

    #[inline(always)]
    fn or_and(self, others: Self, mask: Self) -> Self {
        Self(self.0.or_and(others.0, mask.0), self.1.or_and(others.1, mask.1))
    }
}
