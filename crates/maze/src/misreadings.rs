//! Wall readings of which some are wrong.

use crate::cell::{Cell, MazeSize, Pose};
use crate::heading::Heading;
use crate::maze::Maze;
use crate::walls::{Wall, Walls, WallsAround};
use crate::wy_rand::WyRand;

/// How often a mouse reads a wall wrongly, and which readings are wrong.
///
/// A wrong reading reports an absent wall as present, or a present wall as absent. Outer walls are
/// never misread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misreadings {
    /// The probability of a wrong reading, from 0 to 1.
    pub probability: f64,
    /// The random seed.
    pub seed: u64,
    /// True if a wall is always or never misread, false if each reading is wrong or right anew.
    pub are_fixed: bool,
}

/// A sensor that reads the walls of a maze, some of them wrongly.
///
/// The same readings in the same order give the same results on every machine. Without misreadings,
/// all results are right.
///
/// ```
/// use mmsim_maze::{Maze, Misreadings, WallSensor};
/// let maze: Maze = "o---o---o\n|     G |\no   o   o\n| S     |\no---o---o\n".parse()?;
/// let always = Misreadings { probability: 1.0, ..Misreadings::default() };
/// let around = WallSensor::new(always, &maze).around(maze.walls(), maze.start());
/// assert!(around.left && around.front && around.right);
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct WallSensor {
    misreadings: Misreadings,
    /// The seed, mixed with the walls, so that different mazes have different misreadings.
    seed: u64,
    rng: WyRand,
}

impl WallSensor {
    /// Creates a sensor for a maze.
    pub fn new(misreadings: Misreadings, maze: &Maze) -> Self {
        let rows = maze.walls().north_rows().iter().chain(maze.walls().east_rows());
        let mix = |seed: u64, &row| WyRand::new(seed ^ u64::from(row)).next_u64();
        let seed = rows.fold(misreadings.seed, mix);
        Self { misreadings, seed, rng: WyRand::new(seed) }
    }

    /// Begins again, as if nothing had been read yet.
    pub const fn restart(&mut self) {
        self.rng = WyRand::new(self.seed);
    }

    /// Returns the misreadings.
    pub const fn misreadings(&self) -> &Misreadings {
        &self.misreadings
    }

    /// Returns true if no reading is wrong.
    pub fn is_exact(&self) -> bool {
        self.misreadings.probability <= 0.0
    }

    /// Reads whether there is a wall on the `heading` side of `cell`. `walls` are those of the maze.
    pub fn read(&mut self, walls: &Walls, cell: Cell, heading: Heading) -> bool {
        walls.has(cell, heading) != self.misreads(walls.size(), cell, heading)
    }

    /// Reads a wall, and returns true if this reading is wrong. `size` is that of the maze.
    pub fn misreads(&mut self, size: MazeSize, cell: Cell, heading: Heading) -> bool {
        let index = size.wall_index(Wall::new(cell, heading)).filter(|_| !self.is_exact());
        let Some(index) = index else { return false };
        let mut fixed =
            WyRand::new(self.seed ^ (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let rng = if self.misreadings.are_fixed { &mut fixed } else { &mut self.rng };
        rng.chance(self.misreadings.probability)
    }

    /// Reads the walls to the left of a mouse, in front of it and to its right. `walls` are those of
    /// the maze.
    pub fn around(&mut self, walls: &Walls, pose: Pose) -> WallsAround {
        if self.is_exact() {
            return walls.around(pose);
        }
        let Pose { cell, heading } = pose;
        let [left, front, right] = [heading.left(), heading, heading.right()]
            .map(|heading| self.read(walls, cell, heading));
        WallsAround { left, front, right }
    }

    /// Reads the walls around a mouse that drives to this pose from the cell `at`, and sets `at` to its
    /// cell. Returns `None`, and changes nothing, if a wall between neighbouring cells blocks the mouse.
    pub fn around_from(&mut self, walls: &Walls, at: &mut Cell, pose: Pose) -> Option<WallsAround> {
        if walls.separate(*at, pose.cell) {
            return None;
        }
        *at = pose.cell;
        Some(self.around(walls, pose))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maze() -> Maze {
        let mut walls = Walls::open(MazeSize::CLASSIC);
        for (index, wall) in MazeSize::CLASSIC.inner_walls().enumerate() {
            walls.set(wall.cell, wall.heading, index % 3 == 0);
        }
        Maze::new(walls, Cell::new(0, 0), MazeSize::CLASSIC.central_cells()).unwrap()
    }

    /// Returns for each wall whether it is misread.
    fn misread(sensor: &mut WallSensor, maze: &Maze) -> [bool; 512] {
        let mut misread = [false; 512];
        for (wall, misread) in maze.size().walls().zip(&mut misread) {
            let is_present = maze.walls().has(wall.cell, wall.heading);
            *misread = sensor.read(maze.walls(), wall.cell, wall.heading) != is_present;
        }
        misread
    }

    #[test]
    fn a_share_of_the_inner_walls_is_misread() {
        let maze = maze();
        for are_fixed in [false, true] {
            for (probability, expected) in [(0.0, 0..=0), (0.1, 30..=70), (1.0, 480..=480)] {
                let misreadings = Misreadings { probability, seed: 1, are_fixed };
                let mut sensor = WallSensor::new(misreadings, &maze);
                let first = misread(&mut sensor, &maze);
                let count = first.iter().filter(|&&misread| misread).count();
                assert!(expected.contains(&count), "{count} of 480 with {misreadings:?}");
                let is_certain = !(0.001..0.999).contains(&probability);
                let again = misread(&mut sensor, &maze);
                assert_eq!(first == again, are_fixed || is_certain, "{misreadings:?}");
                sensor.restart();
                assert_eq!(misread(&mut sensor, &maze), first);
                let other = Misreadings { seed: 2, ..misreadings };
                let other = misread(&mut WallSensor::new(other, &maze), &maze);
                assert_eq!(first == other, is_certain, "the seed matters");
            }
        }
    }

    #[test]
    fn different_mazes_have_different_misreadings() {
        let (maze, open) = (maze(), Walls::open(MazeSize::CLASSIC));
        let open = Maze::new(open, Cell::new(0, 0), *maze.goals()).unwrap();
        for are_fixed in [false, true] {
            let misreadings = Misreadings { probability: 0.1, seed: 1, are_fixed };
            let [first, second] =
                [&maze, &open].map(|maze| misread(&mut WallSensor::new(misreadings, maze), maze));
            assert_ne!(first, second);
        }
    }
}
