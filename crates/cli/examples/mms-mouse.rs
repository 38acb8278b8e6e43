//! A flood-fill mouse for the mms simulator, without any library. In the simulator's window, it
//! displays the distances it has computed and the walls it has sensed.
//!
//! ```sh
//! cargo build -p mmsim --examples
//! mmsim run --open target/debug/examples/mms-mouse
//! ```

use std::collections::VecDeque;
use std::error::Error;
use std::io::{self, BufRead};

/// The changes in x and y for a step in each direction, clockwise from north.
const STEPS: [(i32, i32); 4] = [(0, 1), (1, 0), (0, -1), (-1, 0)];

fn main() -> Result<(), Box<dyn Error>> {
    let mut map = MazeMap::new(ask("mazeWidth")?.parse()?, ask("mazeHeight")?.parse()?);
    let (mut cell, mut heading) = ((0, 0), 0);
    loop {
        for (turn, question) in [(3, "wallLeft"), (0, "wallFront"), (1, "wallRight")] {
            map.observe(cell, (heading + turn) % 4, ask(question)? == "true");
        }
        let distances = map.flood();
        for (index, &distance) in distances.iter().enumerate() {
            if map.displayed[index] != distance {
                let (x, y) = map.cell(index);
                println!("setText {x} {y} {distance}");
            }
        }
        map.displayed = distances;
        if map.is_goal(cell) {
            return Ok(());
        }
        let distance = |direction: &usize| map.displayed[map.index(next(cell, *direction))];
        let open = [0, 1, 3, 2].map(|turn| (heading + turn) % 4);
        let open = open.into_iter().filter(|&direction| !map.has_wall(cell, direction));
        let best = open.min_by_key(distance).ok_or("walls on all sides")?;
        let turns: &[&str] = match (best + 4 - heading) % 4 {
            0 => &[],
            1 => &["turnRight"],
            3 => &["turnLeft"],
            _ => &["turnRight", "turnRight"],
        };
        for command in turns.iter().chain(&["moveForward"]) {
            ask(command)?;
        }
        (cell, heading) = (next(cell, best), best);
    }
}

/// Sends a command that has a reply, and returns the reply.
fn ask(command: &str) -> io::Result<String> {
    println!("{command}");
    let mut reply = String::new();
    io::stdin().lock().read_line(&mut reply)?;
    Ok(reply.trim_end().to_string())
}

/// Returns the adjacent cell in this direction.
fn next((x, y): (i32, i32), direction: usize) -> (i32, i32) {
    (x + STEPS[direction].0, y + STEPS[direction].1)
}

/// The mouse's map of the maze.
struct MazeMap {
    width: i32,
    height: i32,
    /// For each cell and direction, true if a wall was sensed.
    walls: Vec<[bool; 4]>,
    /// The distances displayed in the cells.
    displayed: Vec<usize>,
}

impl MazeMap {
    fn new(width: i32, height: i32) -> Self {
        let area = usize::try_from(width * height).unwrap_or(0);
        Self { width, height, walls: vec![[false; 4]; area], displayed: vec![usize::MAX; area] }
    }

    /// Adds a sensed wall to the map and displays it.
    fn observe(&mut self, cell: (i32, i32), direction: usize, is_wall: bool) {
        if is_wall && !self.has_wall(cell, direction) {
            let (index, next) = (self.index(cell), self.index(next(cell, direction)));
            self.walls[index][direction] = true;
            self.walls[next][(direction + 2) % 4] = true;
            println!("setWall {} {} {}", cell.0, cell.1, ["n", "e", "s", "w"][direction]);
        }
    }

    /// Returns the distance from each cell to the centre, treating unknown walls as open.
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

    /// Returns true for outer walls, and for walls that the mouse has sensed.
    fn has_wall(&self, cell: (i32, i32), direction: usize) -> bool {
        let (x, y) = next(cell, direction);
        let is_inside = (0..self.width).contains(&x) && (0..self.height).contains(&y);
        !is_inside || self.walls[self.index(cell)][direction]
    }

    fn is_goal(&self, (x, y): (i32, i32)) -> bool {
        let is_central = |at: i32, side: i32| at == (side - 1) / 2 || at == side / 2;
        is_central(x, self.width) && is_central(y, self.height)
    }

    fn index(&self, (x, y): (i32, i32)) -> usize {
        usize::try_from(y * self.width + x).unwrap_or(0)
    }

    fn cell(&self, index: usize) -> (i32, i32) {
        let index = i32::try_from(index).unwrap_or(0);
        (index % self.width, index / self.width)
    }
}
