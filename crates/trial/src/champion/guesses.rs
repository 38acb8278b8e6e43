//! Guesses: mazes as they may be, in line with what is known.

use fastrand::Rng;
use mmsim_maze::{KnownMaze, Unknown, WallState, Walls};

use super::habits::{Habits, Layers, Place};

/// Mazes that agree with what is known, each unknown wall guessed by the [`Habits`] of mazes.
///
/// Each guess is a chain of its own: whenever more is known, every unknown wall in it is drawn
/// anew, given those around it (Gibbs sampling, 64 guesses at once). The goal cells are taken as a room with
/// one entrance, as contests have it, or with those that are known.
#[derive(Clone, Debug)]
pub(super) struct Guesses {
    mazes: Vec<Layers>,
    number: usize,
    rng: Rng,
    /// Between goal cells, and around them.
    inside: Vec<Place>,
    around: Vec<Place>,
}

impl Guesses {
    /// So many guesses. Every wall is drawn so many times at first, until they have forgotten how they
    /// began.
    pub(super) fn new(
        map: &KnownMaze,
        habits: &Habits,
        number: usize,
        sweeps: usize,
        seed: u64,
    ) -> Self {
        let mut rng = Rng::with_seed(seed);
        let goals = |place: &Place| {
            let ends = [Some(place.cell()), place.cell().neighbour(place.heading())];
            ends.into_iter().flatten().filter(|&cell| map.goals().contains(cell)).count()
        };
        let with_goals =
            |number| Place::all(map.size()).filter(|place| goals(place) == number).collect();
        let (inside, around) = (with_goals(2), with_goals(1));
        let layers = number.div_ceil(Layers::NUMBER);
        let mut mazes = vec![Layers::of(map.walls(Unknown::Open)); layers];
        for guess in &mut mazes {
            Place::all(map.size()).for_each(|place| guess.set(place, rng.u64(..)));
        }
        let mut guesses = Self { mazes, number, rng, inside, around };
        for _ in 0..sweeps {
            guesses.draw(map, habits);
        }
        guesses
    }

    /// Brings all guesses in line with the map and draws each unknown wall anew.
    pub(super) fn draw(&mut self, map: &KnownMaze, habits: &Habits) {
        let state = |place: Place| map.wall(place.cell(), place.heading());
        let is_unknown = |place: &Place| state(*place) == WallState::Unknown;
        let (unknown, known): (Vec<Place>, _) = Place::all(map.size()).partition(is_unknown);
        let inside: Vec<Place> = self.inside.iter().copied().filter(is_unknown).collect();
        let around: Vec<Place> = self.around.iter().copied().filter(is_unknown).collect();
        let has_entrance = self.around.iter().any(|&place| state(place) == WallState::Absent);
        for guess in &mut self.mazes {
            for &place in &known {
                guess.set(place, if state(place) == WallState::Present { u64::MAX } else { 0 });
            }
            for &place in &unknown {
                let mut walls = 0;
                for (eight, around) in guess.around(place).chunks_exact(8).enumerate() {
                    let dice = self.rng.u64(..).to_le_bytes();
                    for (bit, (&around, dice)) in around.iter().zip(dice).enumerate() {
                        walls |= u64::from(dice < habits.wall(around)) << (8 * eight + bit);
                    }
                }
                guess.set(place, walls);
            }
            for &place in &inside {
                guess.set(place, 0);
            }
            for &place in &around {
                guess.set(place, u64::MAX);
            }
            if !has_entrance && !around.is_empty() {
                for layer in 0..Layers::NUMBER {
                    let entrance = around[self.rng.usize(..around.len())];
                    guess.set(entrance, guess.at(entrance) & !(1 << layer));
                }
            }
        }
    }

    /// How many there are.
    pub(super) const fn number(&self) -> usize {
        self.number
    }

    /// The guesses, all of them as likely.
    pub(super) fn iter(&self) -> impl Iterator<Item = Walls> + '_ {
        let layers = |guess| (0..Layers::NUMBER).map(move |layer| Layers::walls(guess, layer));
        self.mazes.iter().flat_map(layers).take(self.number)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, MazeSize};

    use super::*;

    #[test]
    fn guesses_differ_but_not_in_what_is_known() {
        let goals = MazeSize::CLASSIC.central_cells();
        let mut map = KnownMaze::new(MazeSize::CLASSIC, Cell::new(0, 0), goals);
        let mut guesses = Guesses::new(&map, &Habits::CONTEST, 100, 2, 1);
        map.set_wall(Cell::new(3, 3), Heading::East, WallState::Present);
        map.set_wall(Cell::new(4, 4), Heading::North, WallState::Absent);
        guesses.draw(&map, &Habits::CONTEST);
        let all: Vec<Walls> = guesses.iter().collect();
        assert_eq!((all.len(), guesses.number()), (100, 100));
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]));
        for walls in all {
            assert!(walls.has(Cell::new(3, 3), Heading::East));
            assert!(!walls.has(Cell::new(4, 4), Heading::North));
            let sides = goals.iter().flat_map(|cell| Heading::ALL.map(|heading| (cell, heading)));
            let open = sides.filter(|&(cell, heading)| !walls.has(cell, heading));
            assert_eq!(open.count(), 2 * 4 + 1, "a room of four cells with one entrance");
        }
    }
}
