//! A mouse for the simulator mms, on the published crate `mms-rs`, which knows nothing of mmsim: it goes
//! to the neighbour nearest to the centre, and shows its distances and the walls it has seen.
//!
//! `cargo build -p mmsim --examples`, then `mmsim mms --open -- target/debug/examples/mms-mouse`.

use std::collections::VecDeque;
use std::error::Error;

use mms_rs::{Direction, MmsApi};

/// Clockwise from north: where a step leads.
const STEPS: [(i32, i32); 4] = [(0, 1), (1, 0), (0, -1), (-1, 0)];

fn main() -> Result<(), Box<dyn Error>> {
    let mut maze = Maze::new(MmsApi::maze_width()?, MmsApi::maze_height()?);
    let (mut cell, mut heading) = ((0, 0), 0);
    loop {
        let walls = [MmsApi::wall_left()?, MmsApi::wall_front()?, MmsApi::wall_right()?];
        for (side, wall) in [3, 0, 1].into_iter().zip(walls) {
            maze.note(cell, (heading + side) % 4, wall)?;
        }
        let distances = maze.flood();
        for (index, &distance) in distances.iter().enumerate() {
            if maze.shown[index] != distance {
                let (x, y) = maze.cell(index);
                MmsApi::set_text(u32::try_from(x)?, u32::try_from(y)?, &distance.to_string())?;
            }
        }
        maze.shown = distances;
        if maze.is_goal(cell) {
            return Ok(());
        }
        let at = |direction: &usize| maze.shown[maze.index(next(cell, *direction))];
        let open = [0, 1, 3, 2].map(|turn| (heading + turn) % 4);
        let open = open.into_iter().filter(|&direction| !maze.has_wall(cell, direction));
        let best = open.min_by_key(at).ok_or("walls all round")?;
        match (best + 4 - heading) % 4 {
            0 => {}
            1 => MmsApi::turn_right()?,
            3 => MmsApi::turn_left()?,
            _ => {
                MmsApi::turn_right()?;
                MmsApi::turn_right()?;
            }
        }
        MmsApi::move_forward(None)?;
        (cell, heading) = (next(cell, best), best);
    }
}

/// The cell to which a step leads.
fn next((x, y): (i32, i32), direction: usize) -> (i32, i32) {
    (x + STEPS[direction].0, y + STEPS[direction].1)
}

/// What the mouse knows.
struct Maze {
    width: i32,
    height: i32,
    /// For each cell and direction whether a wall was seen.
    walls: Vec<[bool; 4]>,
    /// The distances that are written into the cells.
    shown: Vec<usize>,
}

impl Maze {
    fn new(width: i32, height: i32) -> Self {
        let area = usize::try_from(width * height).unwrap_or(0);
        Self { width, height, walls: vec![[false; 4]; area], shown: vec![usize::MAX; area] }
    }

    fn note(
        &mut self,
        cell: (i32, i32),
        direction: usize,
        wall: bool,
    ) -> Result<(), Box<dyn Error>> {
        if wall && !self.has_wall(cell, direction) {
            let (index, next) = (self.index(cell), self.index(next(cell, direction)));
            self.walls[index][direction] = true;
            self.walls[next][(direction + 2) % 4] = true;
            let letter = [Direction::North, Direction::East, Direction::South, Direction::West];
            MmsApi::set_wall(u32::try_from(cell.0)?, u32::try_from(cell.1)?, &letter[direction])?;
        }
        Ok(())
    }

    /// Steps from each cell to the centre, unseen walls taken as open.
    fn flood(&self) -> Vec<usize> {
        let mut distances = vec![usize::MAX; self.walls.len()];
        let mut queue: VecDeque<_> =
            (0..self.walls.len()).filter(|&index| self.is_goal(self.cell(index))).collect();
        for &goal in &queue {
            distances[goal] = 0;
        }
        while let Some(index) = queue.pop_front() {
            let cell = self.cell(index);
            for direction in (0..4).filter(|&direction| !self.has_wall(cell, direction)) {
                let next = self.index(next(cell, direction));
                if distances[next] == usize::MAX {
                    distances[next] = distances[index] + 1;
                    queue.push_back(next);
                }
            }
        }
        distances
    }

    /// Whether a wall was seen, or the maze ends.
    fn has_wall(&self, cell: (i32, i32), direction: usize) -> bool {
        let (x, y) = next(cell, direction);
        let is_inside = (0..self.width).contains(&x) && (0..self.height).contains(&y);
        !is_inside || self.walls[self.index(cell)][direction]
    }

    fn is_goal(&self, (x, y): (i32, i32)) -> bool {
        let middle = |at: i32, side: i32| at == (side - 1) / 2 || at == side / 2;
        middle(x, self.width) && middle(y, self.height)
    }

    fn index(&self, (x, y): (i32, i32)) -> usize {
        usize::try_from(y * self.width + x).unwrap_or(0)
    }

    fn cell(&self, index: usize) -> (i32, i32) {
        let index = i32::try_from(index).unwrap_or(0);
        (index % self.width, index / self.width)
    }
}
