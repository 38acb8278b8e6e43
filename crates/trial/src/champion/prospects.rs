//! What exploring promises, going by guessed mazes.

use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown, Walls};

use super::guesses::Guesses;
use super::habits::Habits;
use super::unseen::{Finder, Unseen};
use crate::RaceSteps;

/// Where a faster race may hide, and how much faster.
#[derive(Clone, Debug)]
pub(super) struct Prospects {
    guesses: Guesses,
    /// What was known when the first of these guesses was drawn: the least and the most walls.
    known: [Walls; 2],
    /// How many guesses have been drawn since, and what has not been seen of the fastest race in
    /// those where it is faster than the best one known.
    number: usize,
    unseen: Vec<Unseen>,
}

/// While nothing new is seen, guesses add up to this many.
const MAX_GUESSES: usize = 1024;

/// A stretch of unknown walls on the fastest race of some guesses.
struct Stretch {
    /// Its end that is nearer to the robot.
    end: Cell,
    /// Steps saved in the race and steps to go along it, added up over the guesses.
    saved: u32,
    along: u32,
}

impl Prospects {
    pub(super) fn new(map: &KnownMaze, habits: &Habits, seed: u64) -> Self {
        // A guess takes longer in a larger maze.
        let (number, sweeps) = if map.size().area() > 256 { (32, 4) } else { (128, 8) };
        let guesses = Guesses::new(map, habits, number, sweeps, seed);
        Self { guesses, known: known(map), number: 0, unseen: Vec::new() }
    }

    /// Draws guesses; while nothing new is seen they add up.
    fn draw(&mut self, map: &KnownMaze, habits: &Habits, best: u16) {
        let known = known(map);
        if self.known != known {
            (self.known, self.number) = (known, 0);
            self.unseen.clear();
        }
        if self.number < MAX_GUESSES {
            self.guesses.draw(map, habits);
            let finder = Finder::new(map);
            self.number += self.guesses.number();
            self.unseen.extend(self.guesses.iter().filter_map(|guess| finder.unseen(&guess, best)));
        }
    }

    /// Where to explore next, if a step of that saves more than `worth` thirtieths of a step of a
    /// race that takes `best` steps.
    pub(super) fn most_worth(
        &mut self,
        map: &KnownMaze,
        habits: &Habits,
        from_here: &RaceSteps,
        best: u16,
        worth: f64,
    ) -> Option<Cell> {
        self.draw(map, habits, best);
        let stretches = self.stretches(from_here, best);
        // To the one the robot stands in it takes a step too, a turn.
        let there = |stretch: &Stretch| from_here.at(stretch.end).map(|steps| steps.max(1));
        let is_worth = |stretch: &&Stretch| {
            there(stretch).is_some_and(|there| self.saved_a_step(stretch, there) > worth)
        };
        let with_others = |stretch: &Stretch| {
            let end = CellSet::from_iter([stretch.end]);
            let on = RaceSteps::flood(map.walls(Unknown::Closed), &end);
            let there = there(stretch)?;
            let over = |other: &Stretch| {
                Some(self.saved_a_step(other, there.saturating_add(on.at(other.end)?)))
            };
            Some((stretches.iter().filter_map(over).sum::<f64>(), stretch.end))
        };
        let all = stretches.iter().filter(is_worth).filter_map(with_others);
        all.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, end)| end)
    }

    /// The stretches of all guesses that the robot can get to.
    fn stretches(&self, from_here: &RaceSteps, best: u16) -> Vec<Stretch> {
        let mut stretches: Vec<Stretch> = Vec::new();
        for &Unseen { ends, along, race } in &self.unseen {
            let steps = |end: Cell| Some((from_here.at(end)?, end));
            let nearer = ends.into_iter().filter_map(steps).min_by_key(|&(steps, _)| steps);
            let Some((_, end)) = nearer else { continue };
            let (saved, along) = (u32::from(best.saturating_sub(race)), u32::from(along));
            match stretches.iter_mut().find(|stretch| stretch.end == end) {
                Some(stretch) => {
                    stretch.saved += saved;
                    stretch.along += along;
                }
                None => stretches.push(Stretch { end, saved, along }),
            }
        }
        stretches
    }

    /// Thirtieths of a step of the race that a step of exploring saves, with so many steps there.
    /// Where the stretch turns out to be shut, that is seen at once: only where it is open it
    /// takes the steps along it.
    fn saved_a_step(&self, stretch: &Stretch, there: u16) -> f64 {
        #[allow(clippy::cast_precision_loss)]
        let steps = self.number as f64 * f64::from(there) + f64::from(stretch.along);
        30. * f64::from(stretch.saved) / steps
    }
}

fn known(map: &KnownMaze) -> [Walls; 2] {
    [Unknown::Open, Unknown::Closed].map(|unknown| map.walls(unknown).clone())
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, MazeSize, WallState};

    use super::*;

    #[test]
    fn the_only_stretch_is_worth_it_while_a_step_saves_enough() {
        // Known to be closed but for a way around, and one wall on the way straight to the goal.
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
        let from_here =
            |cell| RaceSteps::flood(map.walls(Unknown::Closed), &CellSet::from_iter([cell]));
        let best = from_here(start).at(goal).unwrap();
        assert_eq!(best, 5, "one up, three along, one down");
        let mut prospects = Prospects::new(&map, &Habits::CONTEST, 1);
        let mut most = |here, worth| {
            prospects.most_worth(&map, &Habits::CONTEST, &from_here(here), best, worth)
        };
        assert_eq!(most(start, 0.1), Some(Cell::new(3, 0)));
        assert_eq!(most(goal, 0.1), Some(Cell::new(4, 0)), "from the other side");
        assert_eq!(most(start, 60.), None, "two steps are all that it can save");
    }
}
