//! The expected gain of exploration, estimated from sampled mazes.

use mmsim_maze::{Cell, KnownMaze, Unknown, Walls};

use super::maze_samples::MazeSamples;
use super::unknown_stretch::{StretchFinder, UnknownStretch};
use super::wall_prior::WallPrior;
use crate::race::RaceSteps;

/// The expected gain of exploring each unknown stretch, estimated from sampled mazes.
#[derive(Clone, Debug)]
pub(super) struct ExplorationValue {
    samples: MazeSamples,
    /// The map from which the samples were drawn, first with unknown walls open, then with unknown
    /// walls closed.
    known: [Walls; 2],
    /// The number of samples drawn since the known walls last changed.
    count: usize,
    /// The unknown stretch of the fastest race in each sample. Samples in which no race is faster
    /// than the fastest known race are omitted.
    stretches: Vec<UnknownStretch>,
}

/// The maximum number of samples to draw while the known walls stay the same.
const MAX_SAMPLES: usize = 2048;

/// The number of times that the samples are resampled without being used after the known walls have
/// changed. Otherwise, the samples would still depend on the walls that they had before the change.
const BURN_IN: usize = 4;

/// The weight of the gains of other stretches in the total gain of a stretch.
const OTHERS_WEIGHT: f64 = 2.;

/// The factor by which the steps from one stretch to another count more than other steps.
const ONWARD_FACTOR: u16 = 4;

/// A group of unknown stretches that the robot would enter from the same cell.
struct StretchGroup {
    /// The cell from which the robot would enter the stretches.
    end: Cell,
    /// The [savings](damped) over all samples.
    saved: f64,
    /// The total length of the stretches in time steps.
    length: u32,
}

impl ExplorationValue {
    pub(super) fn new(map: &KnownMaze, prior: &WallPrior, seed: u64) -> Self {
        // Sampling larger mazes takes longer, so draw fewer samples.
        let (len, sweeps) = if map.size().area() > 256 { (32, 4) } else { (MAX_SAMPLES, 8) };
        let samples = MazeSamples::new(map, prior, len, sweeps, seed);
        Self { samples, known: known(map), count: 0, stretches: Vec::new() }
    }

    /// Adds samples. If the known walls have changed since the last call, discards the earlier
    /// samples.
    fn add_samples(&mut self, map: &KnownMaze, prior: &WallPrior, upper: u16) {
        let known = known(map);
        if self.known != known {
            (self.known, self.count) = (known, 0);
            self.stretches.clear();
            for _ in 0..BURN_IN {
                self.samples.resample(map, prior);
            }
        }
        if self.count < MAX_SAMPLES {
            self.samples.resample(map, prior);
            let finder = StretchFinder::new(map);
            self.count += self.samples.len;
            self.stretches
                .extend(self.samples.iter().filter_map(|sample| finder.find(&sample, upper)));
        }
    }

    /// Returns the next cell to explore, or `None` if no cell has a [`gain`](Self::gain) above
    /// `min_gain`. `upper` is the number of steps of the fastest known race.
    pub(super) fn best_target(
        &mut self,
        map: &KnownMaze,
        prior: &WallPrior,
        from_here: &RaceSteps,
        upper: u16,
        min_gain: f64,
    ) -> Option<Cell> {
        self.add_samples(map, prior, upper);
        let candidates = self.candidates(from_here, upper);
        // In the current cell, the robot needs one step to turn.
        let steps_to = |candidate: &StretchGroup| from_here.at_least_one(candidate.end);
        let is_worthwhile = |candidate: &&StretchGroup| {
            steps_to(candidate).is_some_and(|steps| self.gain(candidate, steps) > min_gain)
        };
        let total_gain = |candidate: &StretchGroup| {
            let onwards = RaceSteps::flood_from(map.walls(Unknown::Closed), candidate.end);
            let steps = steps_to(candidate)?;
            let gain = |other: &StretchGroup| {
                let onward = onwards.at(other.end)?.saturating_mul(ONWARD_FACTOR);
                let weight = if other.end == candidate.end { 1. } else { OTHERS_WEIGHT };
                Some(weight * self.gain(other, steps.saturating_add(onward)))
            };
            Some((candidates.iter().filter_map(gain).sum::<f64>(), candidate.end))
        };
        let targets = candidates.iter().filter(is_worthwhile).filter_map(total_gain);
        targets.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, end)| end)
    }

    /// Groups the reachable stretches by the cell from which the robot would enter them.
    fn candidates(&self, from_here: &RaceSteps, upper: u16) -> Vec<StretchGroup> {
        let mut candidates: Vec<StretchGroup> = Vec::new();
        for &UnknownStretch { ends, length, race } in &self.stretches {
            let steps = |end: Cell| Some((from_here.at(end)?, end));
            let nearer = ends.into_iter().filter_map(steps).min_by_key(|&(steps, _)| steps);
            let Some((_, end)) = nearer else { continue };
            let (saved, length) = (damped(upper.saturating_sub(race)), u32::from(length));
            match candidates.iter_mut().find(|candidate| candidate.end == end) {
                Some(candidate) => {
                    candidate.saved += saved;
                    candidate.length += length;
                }
                None => candidates.push(StretchGroup { end, saved, length }),
            }
        }
        candidates
    }

    /// Returns the gain from exploring a candidate that is `steps` steps away: 30 times the
    /// expected [savings](damped) per exploration step. The steps to the candidate count
    /// in every sample. The robot is assumed to see from the nearer end whether a stretch is open,
    /// so the length of the stretch counts only in samples in which it is open.
    fn gain(&self, candidate: &StretchGroup, steps: u16) -> f64 {
        #[allow(clippy::cast_precision_loss)]
        let steps = self.count as f64 * f64::from(steps) + f64::from(candidate.length);
        30. * candidate.saved / steps
    }
}

/// Returns the number of race steps saved, to the power of 3/4. The samples overestimate large savings.
/// Square roots give the same result on every machine, unlike other powers.
fn damped(saved: u16) -> f64 {
    let saved = f64::from(saved);
    (saved * saved.sqrt()).sqrt()
}

fn known(map: &KnownMaze) -> [Walls; 2] {
    [Unknown::Open, Unknown::Closed].map(|unknown| map.walls(unknown).clone())
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{CellSet, Heading, MazeSize, WallState};

    use super::*;

    #[test]
    fn a_stretch_is_a_target_if_it_saves_enough() {
        // The only known path is a detour; one wall on the direct path is unknown.
        let size = MazeSize::new(8, 2).unwrap();
        let (start, goal) = (Cell::new(0, 0), Cell::new(7, 0));
        let mut map = KnownMaze::new(size, start, CellSet::from_iter([goal]));
        for cell in size.cells() {
            map.set_wall(cell, Heading::East, WallState::Absent);
            if cell.y == 0 {
                let is_end = cell == start || cell == goal;
                let wall = if is_end { WallState::Absent } else { WallState::Present };
                map.set_wall(cell, Heading::North, wall);
            }
        }
        map.set_wall(Cell::new(3, 0), Heading::East, WallState::Unknown);
        let from_here = |cell| RaceSteps::flood_from(map.walls(Unknown::Closed), cell);
        let upper = from_here(start).at(goal).unwrap();
        assert_eq!(upper, 5, "one step north, three east, one south");
        let mut value = ExplorationValue::new(&map, &WallPrior::CONTEST, 1);
        let mut target = |here, min_gain| {
            value.best_target(&map, &WallPrior::CONTEST, &from_here(here), upper, min_gain)
        };
        assert_eq!(target(start, 0.1), Some(Cell::new(3, 0)));
        assert_eq!(target(goal, 0.1), Some(Cell::new(4, 0)), "from the other side");
        assert_eq!(target(start, 60.), None, "it saves at most two race steps");
    }
}
