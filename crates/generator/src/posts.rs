//! Posts, and the walls between them.

use mmsim_maze::{Cell, Heading, MazeSize, Wall, Walls};

/// The maximum number of posts along one side of a maze.
const SIDE: usize = MazeSize::MAX_SIDE as usize + 1;

/// A post at the south-west corner of the cell with the same coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Post {
    x: u8,
    y: u8,
}

impl Post {
    const fn new(x: u8, y: u8) -> Self {
        Self { x, y }
    }

    /// Returns the two posts at the ends of a wall.
    pub(crate) const fn ends(wall: Wall) -> [Self; 2] {
        let Cell { x, y } = wall.cell;
        match wall.heading {
            Heading::North => [Self::new(x, y + 1), Self::new(x + 1, y + 1)],
            Heading::East => [Self::new(x + 1, y), Self::new(x + 1, y + 1)],
            Heading::South => [Self::new(x, y), Self::new(x + 1, y)],
            Heading::West => [Self::new(x, y), Self::new(x, y + 1)],
        }
    }

    /// Returns true if a wall ends at the post.
    pub(crate) fn has_wall(self, walls: &Walls) -> bool {
        walls.has_wall_at_corner(Cell::new(self.x, self.y))
    }

    /// Returns true if the post is part of the outer wall.
    const fn is_outer(self, size: MazeSize) -> bool {
        self.x == 0 || self.y == 0 || self.x >= size.width() || self.y >= size.height()
    }

    /// Returns the posts that a wall connects to this inner post, each paired with its wall.
    fn connected(self, walls: &Walls) -> impl Iterator<Item = (Self, Wall)> + '_ {
        let Self { x, y } = self;
        [
            (Self::new(x, y + 1), Wall::new(Cell::new(x, y), Heading::West)),
            (Self::new(x + 1, y), Wall::new(Cell::new(x, y), Heading::South)),
            (Self::new(x, y - 1), Wall::new(Cell::new(x, y - 1), Heading::West)),
            (Self::new(x - 1, y), Wall::new(Cell::new(x - 1, y), Heading::South)),
        ]
        .into_iter()
        .filter(|(_, wall)| walls.has(wall.cell, wall.heading))
    }

    const fn index(self) -> usize {
        self.y as usize * SIDE + self.x as usize
    }
}

/// Returns the shortest chain of walls from any post in `from` to the outer wall, or `None` if no
/// post is connected to the outer wall.
pub(crate) fn walls_to_outer_wall(
    walls: &Walls,
    from: impl IntoIterator<Item = Post>,
) -> Option<Vec<Wall>> {
    let mut seen = [false; SIDE * SIDE];
    // The posts in the order of discovery, each with the wall that leads to it and the index of the
    // post at the other end of the wall.
    let mut found: Vec<(Post, Option<(Wall, usize)>)> = Vec::new();
    for post in from {
        if !std::mem::replace(&mut seen[post.index()], true) {
            found.push((post, None));
        }
    }
    let mut index = 0;
    while let Some(&(post, wall)) = found.get(index) {
        if post.is_outer(walls.size()) {
            let chain = std::iter::successors(wall, |&(_, previous)| found[previous].1);
            return Some(chain.map(|(wall, _)| wall).collect());
        }
        for (next, wall) in post.connected(walls) {
            if !std::mem::replace(&mut seen[next.index()], true) {
                found.push((next, Some((wall, index))));
            }
        }
        index += 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;

    #[test]
    fn finds_chains_to_the_outer_wall_and_islands() {
        let text = "\
o---o---o---o---o
|               |
o   o---o   o   o
|       |   |   |
o   o   o---o   o
|   |           |
o   o   o   o---o
|               |
o---o---o---o---o
";
        let maze: Maze = text.parse().unwrap();
        let post = Post::new;
        assert_eq!(walls_to_outer_wall(maze.walls(), [post(1, 3), post(3, 2)]), None);
        assert_eq!(walls_to_outer_wall(maze.walls(), [post(2, 2), post(0, 2)]), Some(vec![]));
        let connected: Maze = text.replace("o---o   o   o\n", "o---o   o---o\n").parse().unwrap();
        let chain = walls_to_outer_wall(connected.walls(), [post(1, 3)]).unwrap();
        let ends: Vec<_> = chain.into_iter().map(Post::ends).collect();
        assert_eq!(ends[0], [post(3, 3), post(4, 3)]);
        assert_eq!(ends[1], [post(3, 2), post(3, 3)]);
        assert_eq!(
            ends[2..],
            [[post(2, 2), post(3, 2)], [post(2, 2), post(2, 3)], [post(1, 3), post(2, 3)]]
        );
        let has_wall = |x, y| post(x, y).has_wall(maze.walls());
        assert!(
            !has_wall(2, 1) && has_wall(1, 1) && has_wall(1, 2) && has_wall(3, 1) && has_wall(4, 2)
        );
    }
}
