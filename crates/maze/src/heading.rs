//! Headings and steps.

use core::fmt;

/// Where a mouse's nose points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Heading {
    /// Towards greater y, where the mouse starts.
    North,
    /// Towards greater x.
    East,
    /// Towards smaller y.
    South,
    /// Towards smaller x.
    West,
}

impl Heading {
    /// All four, clockwise from north.
    pub const ALL: [Self; 4] = [Self::North, Self::East, Self::South, Self::West];

    /// The heading after a quarter turn to the left.
    pub const fn left(self) -> Self {
        self.turned(Step::Left)
    }

    /// The heading after a quarter turn to the right.
    pub const fn right(self) -> Self {
        self.turned(Step::Right)
    }

    /// The opposite heading.
    pub const fn back(self) -> Self {
        self.turned(Step::Back)
    }

    /// The heading in which a mouse that heads this way takes `step`.
    // Without a branch for a heading, since nobody can predict the turns of a mouse.
    pub const fn turned(self, step: Step) -> Self {
        const CLOCKWISE: &[Heading; 4] = &Heading::ALL;
        const RIGHT_TURNS: &[usize; 4] = &[0, 3, 1, 2];
        CLOCKWISE[(self as usize + RIGHT_TURNS[step as usize]) % 4]
    }

    /// Its letter: `N`, `E`, `S` or `W`.
    pub const fn letter(self) -> char {
        match self {
            Self::North => 'N',
            Self::East => 'E',
            Self::South => 'S',
            Self::West => 'W',
        }
    }
}

impl fmt::Display for Heading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::North => "north",
            Self::East => "east",
            Self::South => "south",
            Self::West => "west",
        })
    }
}

/// One move of a mouse: a turn on the spot, none for [`Front`](Self::Front), then one cell
/// straight on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Straight on.
    Front,
    /// A quarter turn to the left, then one cell.
    Left,
    /// A quarter turn to the right, then one cell.
    Right,
    /// A half turn, then one cell.
    Back,
}

impl Step {
    /// All four, in the order in which ties are broken.
    pub const ALL: [Self; 4] = [Self::Front, Self::Left, Self::Right, Self::Back];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_go_round() {
        for (heading, clockwise) in
            Heading::ALL.into_iter().zip(Heading::ALL.into_iter().cycle().skip(1))
        {
            assert_eq!(heading.right(), clockwise);
            assert_eq!(clockwise.left(), heading);
            assert_eq!(heading.back(), heading.right().right());
            assert_eq!(heading.turned(Step::Back), heading.turned(Step::Left).turned(Step::Left));
        }
    }
}
