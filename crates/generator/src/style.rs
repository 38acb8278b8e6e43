//! The styles of generated mazes.

use std::fmt;

/// The style of a generated maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Style {
    /// Like contest mazes: loops and dead ends, straights and staircases. The goal has one
    /// entrance, and each post has a wall except the one in the middle of the goal.
    ///
    /// If both sides are at least five cells long, the goal is an island: no wall connects it to the
    /// outer wall, so a wall follower never reaches it. In a maze of 16×16 cells the shortest path
    /// is at least 28 steps long, twice its length without walls.
    ///
    /// If a side is shorter than three cells, the goal cannot be surrounded by cells, and the maze
    /// is [`Perfect`](Self::Perfect).
    Contest,
    /// Exactly one path between any two cells, if the goal counts as one cell. All such mazes are
    /// equally likely.
    Perfect,
    /// Few walls and many paths, for training.
    Open,
}

impl Style {
    /// All styles.
    pub const ALL: &'static [Self] = &[Self::Contest, Self::Perfect, Self::Open];

    /// Returns the name used on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Contest => "contest",
            Self::Perfect => "perfect",
            Self::Open => "open",
        }
    }

    /// Returns a short description.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Contest => "like contest mazes: loops, dead ends, a goal with one entrance",
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
