//! Posts, and the walls between them.

use mmsim_maze::{Cell, Heading, MazeSize, Walls};

/// Posts side by side at most.
const SIDE: usize = MazeSize::MAX_SIDE as usize + 1;

/// Where a wall may stand: at the side of a cell towards a heading.
pub(crate) type Place = (Cell, Heading);

/// The post at the south-west corner of the cell with the same coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Post {
    x: u8,
    y: u8,
}

impl Post {
    const fn new(x: u8, y: u8) -> Self {
        Self { x, y }
    }

    /// The two posts that a wall joins.
    pub(crate) const fn ends((Cell { x, y }, heading): Place) -> [Self; 2] {
        match heading {
            Heading::North => [Self::new(x, y + 1), Self::new(x + 1, y + 1)],
            Heading::East => [Self::new(x + 1, y), Self::new(x + 1, y + 1)],
            Heading::South => [Self::new(x, y), Self::new(x + 1, y)],
            Heading::West => [Self::new(x, y), Self::new(x, y + 1)],
        }
    }

    /// Whether a wall ends at it.
    pub(crate) fn carries_wall(self, walls: &Walls) -> bool {
        self.is_outer(walls.size()) || self.joined(walls).next().is_some()
    }

    /// Whether it stands in the outer wall.
    const fn is_outer(self, size: MazeSize) -> bool {
        self.x == 0 || self.y == 0 || self.x >= size.width() || self.y >= size.height()
    }

    /// The posts that a wall joins with this one, which is no outer one, and where that stands.
    fn joined(self, walls: &Walls) -> impl Iterator<Item = (Self, Place)> + '_ {
        let Self { x, y } = self;
        [
            (Self::new(x, y + 1), (Cell::new(x, y), Heading::West)),
            (Self::new(x + 1, y), (Cell::new(x, y), Heading::South)),
            (Self::new(x, y - 1), (Cell::new(x, y - 1), Heading::West)),
            (Self::new(x - 1, y), (Cell::new(x - 1, y), Heading::South)),
        ]
        .into_iter()
        .filter(|&(_, (cell, heading))| walls.has(cell, heading))
    }

    const fn index(self) -> usize {
        self.y as usize * SIDE + self.x as usize
    }
}

/// The walls that join one of these posts with the outer wall, by the fewest walls that do; `None`
/// where these posts are an island.
pub(crate) fn walls_to_the_edge(
    walls: &Walls,
    from: impl IntoIterator<Item = Post>,
) -> Option<Vec<Place>> {
    let mut seen = [false; SIDE * SIDE];
    // Posts in the order in which they are found, with the wall that leads there and the number of
    // the post it comes from.
    let mut found: Vec<(Post, Option<(Place, usize)>)> = Vec::new();
    for post in from {
        if !std::mem::replace(&mut seen[post.index()], true) {
            found.push((post, None));
        }
    }
    let mut number = 0;
    while let Some(&(post, wall)) = found.get(number) {
        if post.is_outer(walls.size()) {
            let way = std::iter::successors(wall, |&(_, before)| found[before].1);
            return Some(way.map(|(place, _)| place).collect());
        }
        for (next, place) in post.joined(walls) {
            if !std::mem::replace(&mut seen[next.index()], true) {
                found.push((next, Some((place, number))));
            }
        }
        number += 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;

    #[test]
    fn walls_lead_to_the_edge_or_are_an_island() {
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
        assert_eq!(walls_to_the_edge(maze.walls(), [post(1, 3), post(3, 2)]), None);
        assert_eq!(walls_to_the_edge(maze.walls(), [post(2, 2), post(0, 2)]), Some(vec![]));
        let joined: Maze = text.replace("o---o   o   o\n", "o---o   o---o\n").parse().unwrap();
        let way = walls_to_the_edge(joined.walls(), [post(1, 3)]).unwrap();
        let ends: Vec<_> = way.into_iter().map(Post::ends).collect();
        assert_eq!(ends[0], [post(3, 3), post(4, 3)]);
        assert_eq!(ends[1], [post(3, 2), post(3, 3)]);
        assert_eq!(
            ends[2..],
            [[post(2, 2), post(3, 2)], [post(2, 2), post(2, 3)], [post(1, 3), post(2, 3)]]
        );
        let carries = |x, y| post(x, y).carries_wall(maze.walls());
        assert!(!carries(2, 1) && carries(1, 1) && carries(1, 2) && carries(3, 1) && carries(4, 2));
    }
}
