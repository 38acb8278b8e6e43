//! Random mazes that agree with the known walls.

use mmsim_maze::{KnownMaze, Unknown, Wall, WallState, Walls, WyRand};

use super::maze_batch::MazeBatch;
use super::wall_prior::WallPrior;

/// Random mazes that agree with the known walls. A [`WallPrior`] gives the probabilities of the
/// unknown walls.
///
/// Each sample is the state of a Markov chain. Resampling draws every unknown wall again at random,
/// given its neighbouring walls (Gibbs sampling). Resampling processes 64 mazes at once. The goal
/// cells form a room with the known entrances or, if none is known, with one random entrance.
#[derive(Clone, Debug)]
pub(super) struct MazeSamples {
    batches: Vec<MazeBatch>,
    /// The number of samples.
    pub(super) len: usize,
    rng: WyRand,
    /// The walls between adjacent goal cells.
    inside: Vec<Wall>,
    /// The walls between a goal cell and a cell outside the goal.
    around: Vec<Wall>,
}

impl MazeSamples {
    /// Creates `len` samples with random walls, then resamples them `sweeps` times so that they no
    /// longer depend on their initial state.
    pub(super) fn new(
        map: &KnownMaze,
        prior: &WallPrior,
        len: usize,
        sweeps: usize,
        seed: u64,
    ) -> Self {
        let mut rng = WyRand::new(seed);
        let goals = |wall: &Wall| wall.cells().filter(|&cell| map.goals().contains(cell)).count();
        let with_goals =
            |count| map.size().inner_walls().filter(|wall| goals(wall) == count).collect();
        let (inside, around) = (with_goals(2), with_goals(1));
        let mut batches =
            vec![MazeBatch::repeat(map.walls(Unknown::Open)); len.div_ceil(MazeBatch::LEN)];
        for batch in &mut batches {
            map.size().inner_walls().for_each(|wall| batch.set(wall, rng.next_u64()));
        }
        let mut samples = Self { batches, len, rng, inside, around };
        for _ in 0..sweeps {
            samples.resample(map, prior);
        }
        samples
    }

    /// Sets the known walls in all samples and draws each unknown wall again at random.
    pub(super) fn resample(&mut self, map: &KnownMaze, prior: &WallPrior) {
        let state = |wall: Wall| map.wall(wall.cell, wall.heading);
        let is_unknown = |wall: &Wall| state(*wall) == WallState::Unknown;
        let (unknown, known): (Vec<Wall>, _) = map.size().inner_walls().partition(is_unknown);
        let inside: Vec<Wall> = self.inside.iter().copied().filter(is_unknown).collect();
        let around: Vec<Wall> = self.around.iter().copied().filter(is_unknown).collect();
        let has_entrance = self.around.iter().any(|&wall| state(wall) == WallState::Absent);
        for batch in &mut self.batches {
            for &wall in &known {
                batch.set(wall, if state(wall) == WallState::Present { u64::MAX } else { 0 });
            }
            for &wall in &unknown {
                let mut present = 0;
                for (eight, neighbours) in batch.neighbours(wall).chunks_exact(8).enumerate() {
                    let random = self.rng.next_u64().to_le_bytes();
                    for (bit, (&neighbours, random)) in neighbours.iter().zip(random).enumerate() {
                        let is_wall = random < prior.probability(neighbours);
                        present |= u64::from(is_wall) << (8 * eight + bit);
                    }
                }
                batch.set(wall, present);
            }
            for &wall in &inside {
                batch.set(wall, 0);
            }
            for &wall in &around {
                batch.set(wall, u64::MAX);
            }
            if !has_entrance && !around.is_empty() {
                for maze in 0..MazeBatch::LEN {
                    let entrance = around[self.rng.index(around.len())];
                    batch.set(entrance, batch.at(entrance) & !(1 << maze));
                }
            }
        }
    }

    /// Returns the sampled mazes, which are equally likely.
    pub(super) fn iter(&self) -> impl Iterator<Item = Walls> + '_ {
        let mazes = |batch| (0..MazeBatch::LEN).map(move |maze| MazeBatch::walls(batch, maze));
        self.batches.iter().flat_map(mazes).take(self.len)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, MazeSize};

    use super::*;

    #[test]
    fn samples_differ_but_agree_with_the_known_walls() {
        let goals = MazeSize::CLASSIC.central_cells();
        let mut map = KnownMaze::new(MazeSize::CLASSIC, Cell::new(0, 0), goals);
        let mut samples = MazeSamples::new(&map, &WallPrior::CONTEST, 100, 2, 1);
        map.set_wall(Cell::new(3, 3), Heading::East, WallState::Present);
        map.set_wall(Cell::new(4, 4), Heading::North, WallState::Absent);
        samples.resample(&map, &WallPrior::CONTEST);
        let all: Vec<Walls> = samples.iter().collect();
        assert_eq!((all.len(), samples.len), (100, 100));
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
