//! Headings and steps.

use core::fmt;

/// The direction in which a mouse faces.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Heading {
    /// The direction of increasing y, and the initial heading of every mouse.
    North,
    /// The direction of increasing x.
    East,
    /// The direction of decreasing y.
    South,
    /// The direction of decreasing x.
    West,
}

impl Heading {
    /// All headings, clockwise from north.
    pub const ALL: [Self; 4] = [Self::North, Self::East, Self::South, Self::West];

    /// Returns the heading after a quarter turn to the left.
    pub const fn left(self) -> Self {
        self.turned(Step::Left)
    }

    /// Returns the heading after a quarter turn to the right.
    pub const fn right(self) -> Self {
        self.turned(Step::Right)
    }

    /// Returns the opposite heading.
    pub const fn back(self) -> Self {
        self.turned(Step::Back)
    }

    /// Returns the heading after `step`.
    // Avoids a branch on the heading, because the turns of a mouse are unpredictable.
    #[must_use]
    pub const fn turned(self, step: Step) -> Self {
        const CLOCKWISE: &[Heading; 4] = &Heading::ALL;
        const RIGHT_TURNS: &[u8; 4] = &[0, 3, 1, 2];
        CLOCKWISE[((self as u8 + RIGHT_TURNS[step as usize]) % 4) as usize]
    }

    /// Returns the heading for the letter `N`, `E`, `S` or `W`, or `None` for any other character.
    ///
    /// ```
    /// use mmsim_maze::Heading;
    /// assert_eq!(Heading::from_letter('W'), Some(Heading::West));
    /// assert_eq!(Heading::from_letter('w'), None);
    /// ```
    pub fn from_letter(letter: char) -> Option<Self> {
        Self::ALL.into_iter().find(|heading| heading.letter() == letter)
    }

    /// Returns the letter of this heading: `N`, `E`, `S` or `W`.
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

/// One step of a mouse: a turn in place (except for [`Front`](Self::Front)), then a move of one
/// cell forward.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// One cell forward.
    Front,
    /// A quarter turn to the left, then one cell forward.
    Left,
    /// A quarter turn to the right, then one cell forward.
    Right,
    /// A half turn, then one cell forward.
    Back,
}

impl Step {
    /// All steps, in the order in which strategies prefer them if several are equally good.
    pub const ALL: [Self; 4] = [Self::Front, Self::Left, Self::Right, Self::Back];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_quarter_turns_are_a_full_turn() {
        for (heading, clockwise) in
            Heading::ALL.into_iter().zip(Heading::ALL.into_iter().cycle().skip(1))
        {
            assert_eq!(heading.right(), clockwise);
            assert_eq!(clockwise.left(), heading);
            assert_eq!(heading.back(), heading.right().right());
            assert_eq!(heading.turned(Step::Back), heading.turned(Step::Left).turned(Step::Left));
            assert_eq!(heading.turned(Step::Front), heading);
        }
    }

    #[test]
    fn headings_have_letters_and_names() {
        let names = ["north", "east", "south", "west"];
        for ((heading, letter), name) in Heading::ALL.into_iter().zip("NESW".chars()).zip(names) {
            assert_eq!(heading.letter(), letter);
            assert_eq!(Heading::from_letter(letter), Some(heading));
            assert_eq!(heading.to_string(), name);
            assert_eq!(format!("{heading:>6}"), format!("{name:>6}"));
        }
        assert_eq!(Heading::from_letter('n'), None);
    }
}
