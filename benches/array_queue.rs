//! The flood of firmware, which serves as the unit of comparison.

use mmsim_maze::Maze;

/// A maze as firmware stores it: four bits per cell, one for each open side.
pub struct Nibbles {
    /// The open sides of each cell, row by row. Bit i is set if the side in direction
    /// `Heading::ALL[i]` is open.
    open: Vec<u8>,
    goals: Vec<usize>,
    width: usize,
}

impl Nibbles {
    /// Prepares a maze.
    pub fn new(maze: &Maze) -> Self {
        let width = usize::from(maze.size().width());
        let open = |cell| !maze.walls().sides(cell).bits() & 0b1111;
        let goals = maze.goals().iter().filter_map(|cell| maze.size().index(cell)).collect();
        Self { open: maze.size().cells().map(open).collect(), goals, width }
    }

    /// Floods the maze, using a fixed-size array as the queue. `AREA` is the number of cells. `S`
    /// is `u8` for mazes of 256 cells and `u16` for larger ones.
    pub fn flood<const AREA: usize, S: Steps>(&self) -> [S; AREA] {
        let mut distances = [S::FAR; AREA];
        let mut queue = [0_u16; AREA];
        let (mut done, mut reached) = (0, 0);
        for &goal in &self.goals {
            distances[goal] = S::ZERO;
            queue[reached] = u16::try_from(goal).unwrap_or(0);
            reached += 1;
        }
        let open = &self.open[..AREA];
        while done < reached {
            let cell = usize::from(queue[done]) % AREA;
            done += 1;
            let next = distances[cell].one_more();
            let steps = [self.width, 1, self.width.wrapping_neg(), usize::MAX];
            for (bit, step) in steps.into_iter().enumerate() {
                let neighbour = cell.wrapping_add(step) % AREA;
                if open[cell] >> bit & 1 == 1 && distances[neighbour] == S::FAR {
                    distances[neighbour] = next;
                    queue[reached % AREA] = u16::try_from(neighbour).unwrap_or(0);
                    reached += 1;
                }
            }
        }
        distances
    }
}

/// A number of steps, stored in one or two bytes.
pub trait Steps: Copy + PartialEq {
    /// The distance of a goal.
    const ZERO: Self;
    /// The distance of a cell that has not been reached.
    const FAR: Self;

    /// Returns the distance of the next cell.
    fn one_more(self) -> Self;
}

impl Steps for u8 {
    const ZERO: Self = 0;
    const FAR: Self = Self::MAX;

    fn one_more(self) -> Self {
        self.wrapping_add(1)
    }
}

impl Steps for u16 {
    const ZERO: Self = 0;
    const FAR: Self = Self::MAX;

    fn one_more(self) -> Self {
        self.wrapping_add(1)
    }
}
