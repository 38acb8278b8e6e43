//! Guesses: mazes as they may be, in line with what is known.

use fastrand::Rng;
use mmsim_maze::{Cell, KnownMaze, MazeSize, Unknown, WallState, Walls};

use super::habits::{Habits, Place, Rows};

/// Mazes that agree with what is known, each unknown wall guessed by the [`Habits`] of mazes.
///
/// Each guess is a chain of its own: whenever more is known, every unknown wall in it is drawn
/// anew, given those around it (Gibbs sampling). A goal of several cells is taken as a room with
/// one entrance, as contests have it, until more than one is known.
#[derive(Clone, Debug)]
pub(super) struct Guesses {
    mazes: Vec<Rows>,
    rng: Rng,
    /// Between goal cells, and around them.
    inside: Vec<Place>,
    around: Vec<Place>,
}

/// How often every wall is drawn at first, until guesses have forgotten how they began.
const FIRST_SWEEPS: usize = 6;

impl Guesses {
    pub(super) fn new(map: &KnownMaze, habits: &Habits, number: usize, seed: u64) -> Self {
        let mut rng = Rng::with_seed(seed);
        let goals = |place: &Place| {
            let ends = [Some(place.cell()), place.cell().neighbour(place.heading())];
            ends.into_iter().flatten().filter(|&cell| map.goals().contains(cell)).count()
        };
        let with_goals =
            |number| places(map.size()).filter(|place| goals(place) == number).collect();
        let (inside, around) = (with_goals(2), with_goals(1));
        let mut first = Rows::of(map.walls(Unknown::Open));
        let mazes = (0..number)
            .map(|_| {
                for place in unknown(map) {
                    first.set(place, rng.bool());
                }
                first.clone()
            })
            .collect();
        let mut guesses = Self { mazes, rng, inside, around };
        for _ in 0..FIRST_SWEEPS {
            guesses.draw(map, habits);
        }
        guesses
    }

    /// Brings all guesses in line with the map and draws each unknown wall anew.
    pub(super) fn draw(&mut self, map: &KnownMaze, habits: &Habits) {
        let places: Vec<Place> = unknown(map).collect();
        let unseen = |places: &[Place]| -> Vec<Place> {
            places.iter().copied().filter(|&place| is_unknown(map, place)).collect()
        };
        let (inside, around) = (unseen(&self.inside), unseen(&self.around));
        let is_open = |place: &Place| map.wall(place.cell(), place.heading()) == WallState::Absent;
        let has_entrance = self.around.iter().any(is_open);
        for guess in &mut self.mazes {
            guess.learn(map.walls(Unknown::Open), map.walls(Unknown::Closed));
            for &place in &places {
                let chance = habits.wall(guess.around(place));
                guess.set(place, self.rng.u8(..) < chance);
            }
            for &place in &inside {
                guess.set(place, false);
            }
            for &place in &around {
                guess.set(place, true);
            }
            if !has_entrance && let Some(&entrance) = self.rng.choice(&around) {
                guess.set(entrance, false);
            }
        }
    }

    /// The guesses, all of them as likely.
    pub(super) fn iter(&self) -> impl ExactSizeIterator<Item = Walls> + '_ {
        self.mazes.iter().map(Rows::walls)
    }
}

/// The places of inner walls.
fn places(size: MazeSize) -> impl Iterator<Item = Place> {
    let place = |Cell { x, y }| [true, false].map(|north| Place { north, x, y });
    let is_inside = move |place: &Place| size.neighbour(place.cell(), place.heading()).is_some();
    size.cells().flat_map(place).filter(is_inside)
}

/// Those where it is not known whether there is a wall.
fn unknown(map: &KnownMaze) -> impl Iterator<Item = Place> + '_ {
    places(map.size()).filter(|place| is_unknown(map, *place))
}

fn is_unknown(map: &KnownMaze, place: Place) -> bool {
    map.wall(place.cell(), place.heading()) == WallState::Unknown
}
