//! The styles of generated mazes.

use std::fmt;

/// The style of a generated maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Style {
    /// A maze that resembles contest mazes, with loops, dead ends, straight passages and
    /// staircases. The goal has one entrance. Every post has a wall, except the post in the middle
    /// of the goal.
    ///
    /// If both sides of the maze are at least five cells long, no chain of walls connects the goal
    /// to the outer wall, so a wall follower never reaches the goal. In a contest maze of 16×16
    /// cells, the shortest path is at least 28 steps long, which is twice its length in a maze
    /// without walls.
    ///
    /// If a side of the maze is shorter than three cells, the goal touches the outer wall, and the
    /// maze is a [`Perfect`](Self::Perfect) maze.
    Contest,
    /// A maze with exactly one path between any two cells, if the goal counts as one cell. All
    /// perfect mazes are equally likely.
    Perfect,
    /// A maze with few walls and many paths, for training.
    Open,
}

impl Style {
    /// All styles.
    pub const ALL: &'static [Self] = &[Self::Contest, Self::Perfect, Self::Open];

    /// Returns the name that selects the style on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Contest => "contest",
            Self::Perfect => "perfect",
            Self::Open => "open",
        }
    }

    /// Returns a short description of the style.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Contest => "contest-like maze with loops, dead ends and one goal entrance",
            Self::Perfect => "exactly one path between any two cells",
            Self::Open => "few walls and many paths, for training",
        }
    }
}

impl fmt::Display for Style {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
