//! The unknown stretch of the fastest race in a sampled maze.

use mmsim_maze::{Cell, CellMap, CellSet, Heading, KnownMaze, Unknown, WallState, Walls};

use crate::race::{Straights, Wave};

/// The part of a race between its first and its last unknown wall, including both walls.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct UnknownStretch {
    /// The cell before the first unknown wall and the cell after the last one.
    pub(super) ends: [Cell; 2],
    /// The number of time steps that the race takes along the stretch.
    pub(super) length: u16,
    /// The number of time steps of the whole race.
    pub(super) race: u16,
}

/// Finds the [`UnknownStretch`] of the fastest race in a sampled maze.
pub(super) struct StretchFinder<'m> {
    map: &'m KnownMaze,
    /// The number of unknown walls that a step from a cell crosses, indexed as
    /// `[cell][heading][cells - 1]`.
    unknown: Box<CellMap<[[u8; 3]; 4]>>,
}

impl<'m> StretchFinder<'m> {
    pub(super) fn new(map: &'m KnownMaze) -> Self {
        let (possible, certain) = (map.walls(Unknown::Closed), map.walls(Unknown::Open));
        let mut unknown = Box::new(CellMap::new([[0; 3]; 4]));
        for cell in map.size().cells() {
            for (heading, towards) in Heading::ALL.into_iter().enumerate() {
                let (mut here, mut walls) = (cell, 0);
                for unknown in &mut unknown[cell][heading] {
                    let Some(next) = map.size().neighbour(here, towards) else { break };
                    walls += u8::from(possible.has(here, towards) && !certain.has(here, towards));
                    *unknown = walls;
                    here = next;
                }
            }
        }
        Self { map, unknown }
    }

    /// Returns the unknown stretch of the fastest race in a sampled maze. If several races are
    /// equally fast, uses a race with the fewest unknown walls. Returns `None` if every race
    /// takes at least `upper` steps, or if the fastest race crosses no unknown wall.
    pub(super) fn find(&self, sample: &Walls, upper: u16) -> Option<UnknownStretch> {
        if sample.size().height() <= 16 {
            self.find_in(&Straights::<16, 22>::new(sample), upper)
        } else {
            self.find_in(&Straights::<32, 38>::new(sample), upper)
        }
    }

    fn find_in<const ROWS: usize, const PADDED: usize>(
        &self,
        straights: &Straights<ROWS, PADDED>,
        upper: u16,
    ) -> Option<UnknownStretch> {
        let start = self.map.start().cell;
        // The cells at each distance from the goal, up to the distance of the start.
        let mut waves = Vec::with_capacity(upper.into());
        let mut wave = Wave::from_cells(self.map.goals());
        let mut reached = wave;
        while !wave.contains(start) {
            waves.push(wave);
            wave = straights.next(&wave, &reached);
            if wave.is_empty() || waves.len() >= usize::from(upper) {
                return None;
            }
            reached.add(&wave);
        }
        // Keep only the cells of fastest races.
        let mut wave = Wave::from_cells(&CellSet::from_iter([start]));
        for layer in waves.iter_mut().rev() {
            wave = straights.next(&wave, &layer.complement());
            *layer = wave;
        }
        let mut unknown = CellMap::new(0);
        for pair in waves.windows(2) {
            pair[1].for_each(|cell| {
                if let Some((walls, ..)) = self.step(straights, cell, &pair[0], &unknown) {
                    unknown[cell] = walls;
                }
            });
        }
        // Follow the race with the fewest unknown walls.
        let (mut first, mut last) = (None, None);
        let mut cell = start;
        let race = u16::try_from(waves.len()).ok()?;
        for (step, layer) in (0..race).zip(waves.iter().rev()) {
            let (_, heading, cells) = self.step(straights, cell, layer, &unknown)?;
            for _ in 0..cells {
                let next = cell.neighbour(heading)?;
                if self.map.wall(cell, heading) == WallState::Unknown {
                    first.get_or_insert((cell, step));
                    last = Some((next, step));
                }
                cell = next;
            }
        }
        let ((before, from), (behind, to)) = (first?, last?);
        Some(UnknownStretch { ends: [before, behind], length: to - from + 1, race })
    }

    /// Among the steps from `cell` to the cells of `layer`, which are one step nearer to the goal,
    /// selects the one that leads to the goal through the fewest unknown walls. Returns the number
    /// of unknown walls, the heading of the step, and its length in cells.
    fn step<const ROWS: usize, const PADDED: usize>(
        &self,
        straights: &Straights<ROWS, PADDED>,
        cell: Cell,
        layer: &Wave<PADDED>,
        unknown: &CellMap<u8>,
    ) -> Option<(u8, Heading, usize)> {
        let mut best: Option<(u8, Heading, usize)> = None;
        for (heading, towards) in Heading::ALL.into_iter().enumerate() {
            for (longer, end) in straights.ends(cell, towards).enumerate() {
                if layer.contains(end) {
                    let walls = unknown[end].saturating_add(self.unknown[cell][heading][longer]);
                    if best.is_none_or(|(fewest, ..)| walls < fewest) {
                        best = Some((walls, towards, longer + 1));
                    }
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{MazeSize, Wall};
    use proptest::prelude::*;

    use super::*;
    use crate::race::{RaceSteps, straight};

    /// The reference implementation, which enumerates all fastest races. For each of these races
    /// that crosses an unknown wall, returns the number of unknown walls and the unknown stretch.
    fn reference(map: &KnownMaze, sample: &Walls) -> Vec<(usize, UnknownStretch)> {
        let race = RaceSteps::flood(sample, map.goals());
        let Some(steps) = race.at(map.start().cell) else { return Vec::new() };
        // The last cell of each race and, for each unknown wall of the race, the step and the cells
        // on both sides.
        let mut races = vec![(map.start().cell, Vec::<(u16, [Cell; 2])>::new())];
        for step in 0..steps {
            let mut longer = Vec::new();
            for (cell, crossed) in races {
                for heading in Heading::ALL {
                    let (mut here, mut crossed) = (cell, crossed.clone());
                    for next in straight(sample, cell, heading) {
                        if map.wall(here, heading) == WallState::Unknown {
                            crossed.push((step, [here, next]));
                        }
                        here = next;
                        if race.at(next) == Some(steps - step - 1) {
                            longer.push((next, crossed.clone()));
                        }
                    }
                }
            }
            races = longer;
        }
        let stretch = |(_, crossed): &(Cell, Vec<(u16, [Cell; 2])>)| {
            let ((from, [before, _]), (to, [_, behind])) = (*crossed.first()?, *crossed.last()?);
            let stretch =
                UnknownStretch { ends: [before, behind], length: to - from + 1, race: steps };
            Some((crossed.len(), stretch))
        };
        races.iter().filter_map(stretch).collect()
    }

    proptest! {
        #[test]
        fn stretches_equal_the_reference(
            (width, height) in prop_oneof![(2usize..=5, 2usize..=5), (2usize..=3, 17usize..20)],
            present in prop::collection::vec(prop::bool::weighted(0.35), 2 * 60),
            known in prop::collection::vec(prop::bool::weighted(0.6), 2 * 60),
            (start, goal) in ((0u8..5, 0u8..20), (0u8..5, 0u8..20)),
            upper in 0u16..25,
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let (start, goals) = (inside(start), CellSet::from_iter([inside(goal)]));
            let mut sample = Walls::open(size);
            let mut map = KnownMaze::new(size, start, goals);
            for (wall, (present, known)) in size.walls().zip(present.into_iter().zip(known)) {
                let Wall { cell, heading, .. } = wall;
                sample.set(cell, heading, present);
                if known && size.neighbour(cell, heading).is_some() {
                    let wall = if present { WallState::Present } else { WallState::Absent };
                    map.set_wall(cell, heading, wall);
                }
            }
            let found = StretchFinder::new(&map).find(&sample, upper);
            let all = reference(&map, &sample);
            let steps = RaceSteps::flood(&sample, map.goals()).at(start);
            let fewest = all.iter().map(|&(walls, _)| walls).min();
            if steps.is_none_or(|steps| steps >= upper) {
                prop_assert_eq!(found, None);
            } else if let Some(found) = found {
                prop_assert!(all.contains(&(fewest.unwrap(), found)));
            } else {
                // The walls of a fastest race are all known.
                let known = RaceSteps::flood(map.walls(Unknown::Closed), map.goals());
                prop_assert_eq!(known.at(start), steps);
            }
        }
    }
}
