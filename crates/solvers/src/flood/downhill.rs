//! Downhill headings: the headings in which a step leads nearer to a target.

use mmsim_maze::{Cell, CellSet, Heading, Row, Walls};

use super::dispatch::{Instructions, Task, run};
use super::wide::bitboard::{Bitboard, CellPlanes, rows};
use super::wide::plane::ParityPlane;
use super::wide::waves::{self, Marks};
use super::{Distances, steps::SIDE};

/// The downhill headings of all cells. A heading is downhill if a step in that direction leads
/// nearer to a target.
///
/// A mouse that always takes a downhill heading reaches a target. Downhill headings are computed
/// faster than [`Distances`], because they need only the two lowest bits of each
/// distance. Two bits suffice, because the distances of connected neighbours differ by at most 1.
///
/// ```
/// use mmsim_maze::{Cell, Heading, MazeSize, Walls};
/// use mmsim_solvers::Downhill;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let downhill = Downhill::flood(&walls, &MazeSize::CLASSIC.central_cells());
/// assert!(downhill.towards(Heading::North).contains(Cell::new(0, 0)));
/// assert!(downhill.headings(Cell::new(3, 7)).eq([Heading::East]));
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Downhill {
    /// For each heading in [`Heading::ALL`], the cells in which that heading is downhill.
    cells: [CellSet; 4],
}

impl Downhill {
    /// Floods the maze from the targets. Targets outside the maze are ignored.
    #[must_use]
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        run(DownhillTask { walls, targets }, walls.size())
    }

    /// Returns the cells in which `heading` is downhill.
    pub const fn towards(&self, heading: Heading) -> &CellSet {
        &self.cells[heading as usize]
    }

    /// Returns the downhill headings of `cell`, in the order north, east, south, west. Targets,
    /// cells that cannot reach a target, and cells outside the maze have no downhill headings.
    pub fn headings(&self, cell: Cell) -> impl Iterator<Item = Heading> + '_ {
        Heading::ALL.into_iter().filter(move |&heading| self.towards(heading).contains(cell))
    }
}

struct DownhillTask<'a> {
    walls: &'a Walls,
    targets: &'a CellSet,
}

impl Task for DownhillTask<'_> {
    type Output = Downhill;

    #[inline(always)]
    fn run<H: ParityPlane>(self) -> Downhill {
        let Self { walls, targets } = self;
        let flooded = waves::flood(
            &Bitboard::<H>::from_walls(walls),
            CellPlanes::from_cells_inside(targets, walls.size()),
        );
        let rows = |plane: fn(&Marks<H>) -> H| rows(flooded.columns(plane));
        let (low, high) = (rows(|marks| marks.planes[0]), rows(|marks| marks.planes[1]));
        let unvisited = rows(|marks| marks.unvisited);
        let size = walls.size();
        // The cells in which the distance `b` is one step longer than the distance `a`.
        let is_further = |a: (Row, Row), b: (Row, Row)| (a.0 ^ b.0) & !(a.1 ^ b.1 ^ a.0);
        let at = |y: usize| (low[y], high[y]);
        let mut cells = [[0; SIDE]; 4];
        let [north, east, south, west] = &mut cells;
        for y in 0..usize::from(size.height()) {
            let flooded = !unvisited[y];
            if y + 1 < usize::from(size.height()) {
                let open = !walls.north_rows()[y] & flooded;
                north[y] = is_further(at(y + 1), at(y)) & open;
                south[y + 1] = is_further(at(y), at(y + 1)) & open;
            }
            let open = !walls.east_rows()[y] & flooded;
            let eastern = (low[y] >> 1, high[y] >> 1);
            east[y] = is_further(eastern, at(y)) & open;
            west[y] = (is_further(at(y), eastern) & open) << 1;
        }
        Downhill { cells: cells.map(CellSet::from_rows) }
    }

    fn run_on_bytes(self) -> Downhill {
        let Self { walls, targets } = self;
        let distances = Distances::flood_with(Instructions::Bytes, walls, targets);
        let mut cells = [CellSet::EMPTY; 4];
        for cell in walls.size().cells() {
            let (here, around, sides) =
                (distances.raw(cell), distances.raw_around(cell), walls.sides(cell));
            for (heading, cells) in Heading::ALL.into_iter().zip(&mut cells) {
                if !sides.has(heading) && around[heading as usize] < here {
                    cells.insert(cell);
                }
            }
        }
        Downhill { cells }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::flood::dispatch::run_with;
    use crate::flood::tests::{any_targets, any_walls, available};

    proptest! {
        #[test]
        fn downhill_leads_to_smaller_distances(walls in any_walls(), targets in any_targets()) {
            let distances = Distances::flood(&walls, &targets);
            let is_less = |cell: Cell, heading| {
                let beyond = cell.neighbour(heading).and_then(|next| distances.at(next));
                let here = distances.at(cell);
                !walls.has(cell, heading) && here.is_some() && beyond.is_some() && beyond < here
            };
            let check = |downhill: Downhill| {
                for cell in walls.size().cells() {
                    let expected = Heading::ALL.into_iter().filter(|&heading| is_less(cell, heading));
                    assert!(downhill.headings(cell).eq(expected), "{cell}");
                }
                let outside = Cell::new(walls.size().width(), 0);
                assert_eq!(downhill.headings(outside).count(), 0);
            };
            check(Downhill::flood(&walls, &targets));
            for instructions in available() {
                let task = DownhillTask { walls: &walls, targets: &targets };
                check(run_with(instructions, task, walls.size()));
            }
        }
    }
}
