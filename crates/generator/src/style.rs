//! What a maze is made for.

use std::fmt;

/// What a maze is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Style {
    /// As in contests: loops and dead ends, straights and staircases. There is one way into the
    /// goal, and each post carries a wall but the one in the middle of the goal.
    ///
    /// If both sides are at least five cells, the goal is an island: no wall leads from it to the
    /// outer wall, so who follows the walls never gets there. In a classic maze the shortest path
    /// is at least 28 steps long, twice what it is without walls.
    ///
    /// If a side is shorter than three cells, the goal cannot have cells all round; then the
    /// maze is [`Perfect`](Self::Perfect).
    Contest,
    /// One way between any two cells, if the goal is counted as one. Each such maze is as likely
    /// as any other.
    Perfect,
    /// Few walls and many ways, as on a training field.
    Open,
}

impl Style {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Contest, Self::Perfect, Self::Open];

    /// Its name, as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Contest => "contest",
            Self::Perfect => "perfect",
            Self::Open => "open",
        }
    }

    /// What it is, in a few words.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Contest => "as in contests: loops, dead ends, a goal with one way in",
            Self::Perfect => "one way between any two cells",
            Self::Open => "few walls and many ways, to train in",
        }
    }
}

impl fmt::Display for Style {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
