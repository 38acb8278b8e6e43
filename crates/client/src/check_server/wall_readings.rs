//! Checks the replies to `W` against each other.

use std::collections::HashMap;

use mmsim_maze::{Cell, MazeSize, Pose, Wall, WallsAround};

/// The walls in the replies of a server.
pub(super) struct WallReadings {
    size: MazeSize,
    all: Vec<(Pose, WallsAround)>,
    /// True for each wall that is present, and the pose in which the wall was first read.
    walls: HashMap<Wall, (bool, Pose)>,
}

/// Returns the pose and the walls that a reply is about if the server makes a certain mistake.
type Mistake = fn(MazeSize, Pose, WallsAround) -> (Pose, WallsAround);

const MISTAKES: [(&str, Mistake); 4] = [
    ("left and right are swapped", |_, pose, WallsAround { left, front, right }| {
        (pose, WallsAround { left: right, front, right: left })
    }),
    ("x and y are swapped", |_, Pose { cell: Cell { x, y }, heading }, around| {
        (Pose::new(Cell::new(y, x), heading), around)
    }),
    ("y is counted from the north", |size, Pose { cell: Cell { x, y }, heading }, around| {
        (Pose::new(Cell::new(x, size.height() - 1 - y), heading), around)
    }),
    ("0 stands for a wall", |_, pose, WallsAround { left, front, right }| {
        (pose, WallsAround { left: !left, front: !front, right: !right })
    }),
];

impl WallReadings {
    pub(super) fn new(size: MazeSize) -> Self {
        Self { size, all: Vec::new(), walls: HashMap::new() }
    }

    /// Adds the walls around a pose inside the maze.
    ///
    /// # Errors
    /// Returns the first contradiction to an earlier reply or to the outer walls.
    pub(super) fn add(&mut self, pose: Pose, around: WallsAround) -> Result<(), String> {
        self.all.push((pose, around));
        let (Pose { cell, heading }, mut result) = (pose, Ok(()));
        for (side, found) in [
            (heading.left(), around.left),
            (heading, around.front),
            (heading.right(), around.right),
        ] {
            let fault = if self.size.neighbour(cell, side).is_none() {
                (!found).then(|| {
                    format!("expected the outer wall on the {side} side of {cell}, found no wall")
                })
            } else {
                let reading = self.walls.entry(Wall::new(cell, side)).or_insert((found, pose));
                let &mut (expected, first) = reading;
                (expected != found).then(|| {
                    let [expected, found] =
                        [expected, found].map(|wall| if wall { "a wall" } else { "no wall" });
                    format!(
                        "expected {expected} on the {side} side of {cell} as in the reply to W at \
                         {first}, found {found}"
                    )
                })
            };
            result = result.and(fault.map_or(Ok(()), Err));
        }
        result
    }

    /// Returns the mistake of the server that explains all contradictions, if there is one.
    pub(super) fn mistake(&self) -> Option<&'static str> {
        let explains = |mistake: Mistake| {
            let mut corrected = Self::new(self.size);
            self.all.iter().all(|&(pose, around)| {
                let (pose, around) = mistake(self.size, pose, around);
                self.size.contains(pose.cell) && corrected.add(pose, around).is_ok()
            })
        };
        MISTAKES.iter().find(|(_, mistake)| explains(*mistake)).map(|(name, _)| *name)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, Maze};

    use super::*;

    const MAZE: &str =
        "o---o---o---o\n|   |     G |\no   o   o---o\n| S |       |\no---o---o---o\n";

    /// Returns the readings of a server that makes a mistake, and the first contradiction.
    fn read(maze: &str, mistake: Mistake) -> (WallReadings, Result<(), String>) {
        let maze: Maze = maze.parse().unwrap();
        let (mut readings, mut result) = (WallReadings::new(maze.size()), Ok(()));
        for cell in maze.size().cells() {
            for heading in Heading::ALL {
                let pose = Pose::new(cell, heading);
                // Each mistake is its own inverse.
                let none = WallsAround { left: false, front: false, right: false };
                let around = maze.walls().around(mistake(maze.size(), pose, none).0);
                let (_, around) = mistake(maze.size(), pose, around);
                result = result.and(readings.add(pose, around));
            }
        }
        (readings, result)
    }

    #[test]
    fn the_walls_of_a_maze_have_no_contradiction() {
        assert_eq!(read(MAZE, |_, pose, around| (pose, around)).1, Ok(()));
    }

    #[test]
    fn mistakes_are_recognized() {
        let square = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n";
        for (name, mistake) in MISTAKES {
            let (readings, result) = read(square, mistake);
            assert!(result.is_err(), "{name}");
            assert_eq!(readings.mistake(), Some(name));
        }
        // The server ignores the heading.
        let ignored: Mistake =
            |_, Pose { cell, .. }, around| (Pose::new(cell, Heading::East), around);
        let (readings, result) = read(MAZE, ignored);
        assert!(result.is_err());
        assert_eq!(readings.mistake(), None);
    }
}
