//! What has not been seen of the fastest race in a guessed maze.

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Unknown, WallState, Walls};

use crate::race::{Straights, Wave};

/// The part of a race that has not been seen, from the first unknown wall to the last.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Unseen {
    /// The cells before and behind it.
    pub(super) ends: [Cell; 2],
    /// Time steps along it.
    pub(super) along: u16,
    /// Time steps of the whole race.
    pub(super) race: u16,
}

/// Finds what is [`Unseen`] of races over a map.
pub(super) struct Finder<'m> {
    map: &'m KnownMaze,
    /// How many walls of a step from there are unknown, by its cells - 1, its heading, x and y.
    unknown: Box<[[[[u8; SIDE]; SIDE]; 4]; 3]>,
}

const SIDE: usize = MazeSize::MAX_SIDE as usize;

impl<'m> Finder<'m> {
    pub(super) fn new(map: &'m KnownMaze) -> Self {
        let (possible, certain) = (map.walls(Unknown::Closed), map.walls(Unknown::Open));
        let mut unknown = Box::new([[[[0; SIDE]; SIDE]; 4]; 3]);
        for cell in map.size().cells() {
            for (heading, towards) in Heading::ALL.into_iter().enumerate() {
                let (mut here, mut walls) = (cell, 0);
                for unknown in &mut *unknown {
                    let Some(next) = map.size().neighbour(here, towards) else { break };
                    walls += u8::from(possible.has(here, towards) && !certain.has(here, towards));
                    unknown[heading][usize::from(cell.x)][usize::from(cell.y)] = walls;
                    here = next;
                }
            }
        }
        Self { map, unknown }
    }

    /// That of the fastest race in a guessed maze, if that takes less than `best` steps; of several,
    /// of one with the fewest unknown walls.
    pub(super) fn unseen(&self, guess: &Walls, best: u16) -> Option<Unseen> {
        if guess.size().height() <= 16 {
            self.find(&Straights::<16, 22>::of(guess), best)
        } else {
            self.find(&Straights::<32, 38>::of(guess), best)
        }
    }

    fn find<const ROWS: usize, const PADDED: usize>(
        &self,
        straights: &Straights<ROWS, PADDED>,
        best: u16,
    ) -> Option<Unseen> {
        let start = self.map.start();
        // Cells by their steps to the goal, until the start is among them.
        let mut waves = Vec::with_capacity(best.into());
        let mut wave = Wave::of(self.map.goals());
        let mut reached = wave;
        while !wave.contains(start) {
            waves.push(wave);
            wave = straights.next(&wave, &reached);
            if wave.is_empty() || waves.len() >= usize::from(best) {
                return None;
            }
            reached.add(&wave);
        }
        // Those of them that are on a fastest race, by their steps to the goal.
        let mut wave = Wave::of(&CellSet::from_iter([start]));
        for layer in waves.iter_mut().rev() {
            wave = straights.next(&wave, &layer.others());
            *layer = wave;
        }
        let mut unknown = [[0; SIDE]; SIDE];
        for pair in waves.windows(2) {
            pair[1].for_each(|cell| {
                if let Some((walls, ..)) = self.step(straights, cell, &pair[0], &unknown) {
                    unknown[usize::from(cell.x)][usize::from(cell.y)] = walls;
                }
            });
        }
        // Along the best one.
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
        Some(Unseen { ends: [before, behind], along: to - from + 1, race })
    }

    /// The step from a cell into a layer with the fewest unknown walls from there to the goal: these,
    /// its heading and its cells.
    fn step<const ROWS: usize, const PADDED: usize>(
        &self,
        straights: &Straights<ROWS, PADDED>,
        cell: Cell,
        layer: &Wave<PADDED>,
        unknown: &[[u8; SIDE]; SIDE],
    ) -> Option<(u8, Heading, usize)> {
        let (x, y) = (usize::from(cell.x), usize::from(cell.y));
        let mut best: Option<(u8, Heading, usize)> = None;
        for (heading, towards) in Heading::ALL.into_iter().enumerate() {
            for (longer, end) in straights.ends(cell, towards).enumerate() {
                if layer.contains(end) {
                    let on = unknown[usize::from(end.x)][usize::from(end.y)];
                    let walls = on.saturating_add(self.unknown[longer][heading][x][y]);
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
    use proptest::prelude::*;

    use super::*;
    use crate::RaceSteps;

    /// The naive twin: all fastest races, step by step, as the unknown walls each crosses, and its
    /// unseen part.
    fn naive(map: &KnownMaze, guess: &Walls) -> Vec<(usize, Unseen)> {
        let race = RaceSteps::flood(guess, map.goals());
        let Some(steps) = race.at(map.start()) else { return Vec::new() };
        // The cell it has come to, and the unknown walls on the way with the step and the cells.
        let mut races = vec![(map.start(), Vec::<(u16, [Cell; 2])>::new())];
        for step in 0..steps {
            let mut longer = Vec::new();
            for (cell, crossed) in races {
                for heading in Heading::ALL {
                    let (mut here, mut crossed) = (cell, crossed.clone());
                    for next in crate::race::straight(guess, cell, heading) {
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
        let unseen = |(_, crossed): &(Cell, Vec<(u16, [Cell; 2])>)| {
            let ((from, [before, _]), (to, [_, behind])) = (*crossed.first()?, *crossed.last()?);
            let unseen = Unseen { ends: [before, behind], along: to - from + 1, race: steps };
            Some((crossed.len(), unseen))
        };
        races.iter().filter_map(unseen).collect()
    }

    proptest! {
        #[test]
        fn what_is_unseen_equals_its_naive_twin(
            (width, height) in prop_oneof![(2usize..=5, 2usize..=5), (2usize..=3, 17usize..20)],
            present in prop::collection::vec(prop::bool::weighted(0.35), 2 * 60),
            known in prop::collection::vec(prop::bool::weighted(0.6), 2 * 60),
            (start, goal) in ((0u8..5, 0u8..20), (0u8..5, 0u8..20)),
            best in 0u16..25,
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let (start, goals) = (inside(start), CellSet::from_iter([inside(goal)]));
            let mut guess = Walls::open(size);
            let mut map = KnownMaze::new(size, start, goals);
            let places = size.cells().flat_map(|cell| [(cell, Heading::North), (cell, Heading::East)]);
            for ((cell, heading), (present, known)) in places.zip(present.into_iter().zip(known)) {
                guess.set(cell, heading, present);
                if known && size.neighbour(cell, heading).is_some() {
                    let wall = if present { WallState::Present } else { WallState::Absent };
                    map.set_wall(cell, heading, wall);
                }
            }
            let found = Finder::new(&map).unseen(&guess, best);
            let all = naive(&map, &guess);
            let steps = RaceSteps::flood(&guess, map.goals()).at(start);
            let fewest = all.iter().map(|&(walls, _)| walls).min();
            if steps.is_none_or(|steps| steps >= best) {
                prop_assert_eq!(found, None);
            } else if let Some(found) = found {
                prop_assert!(all.contains(&(fewest.unwrap(), found)));
            } else {
                // One of them is known from end to end.
                let known = RaceSteps::flood(map.walls(Unknown::Closed), map.goals());
                prop_assert_eq!(known.at(start), steps);
            }
        }
    }
}
