//! The colours that a mouse can give to cells.

/// A cell colour. The simulator [mms](https://github.com/mackorone/mms) has the same colours, with
/// the same letters.
///
/// ```
/// use mmsim_maze::Colour;
/// assert_eq!(Colour::from_letter('G'), Some(Colour::DarkGreen));
/// assert_eq!((Colour::DarkGreen.letter(), Colour::DarkGreen.name()), ('G', "dark green"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names are colours")]
pub enum Colour {
    Black,
    Blue,
    Grey,
    Cyan,
    Green,
    Orange,
    Red,
    White,
    Yellow,
    DarkBlue,
    DarkCyan,
    DarkGrey,
    DarkGreen,
    DarkOrange,
    DarkRed,
    DarkViolet,
    DarkYellow,
}

impl Colour {
    /// All colours.
    pub const ALL: [Self; 17] = [
        Self::Black,
        Self::Blue,
        Self::Grey,
        Self::Cyan,
        Self::Green,
        Self::Orange,
        Self::Red,
        Self::White,
        Self::Yellow,
        Self::DarkBlue,
        Self::DarkCyan,
        Self::DarkGrey,
        Self::DarkGreen,
        Self::DarkOrange,
        Self::DarkRed,
        Self::DarkViolet,
        Self::DarkYellow,
    ];

    /// The letters of all colours, in the order of [`ALL`](Self::ALL).
    pub const LETTERS: &str = "kbacgorwyBCAGORVY";

    /// Returns the letter.
    pub const fn letter(self) -> char {
        Self::LETTERS.as_bytes()[self as usize] as char
    }

    /// Returns the name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Black => "black",
            Self::Blue => "blue",
            Self::Grey => "grey",
            Self::Cyan => "cyan",
            Self::Green => "green",
            Self::Orange => "orange",
            Self::Red => "red",
            Self::White => "white",
            Self::Yellow => "yellow",
            Self::DarkBlue => "dark blue",
            Self::DarkCyan => "dark cyan",
            Self::DarkGrey => "dark grey",
            Self::DarkGreen => "dark green",
            Self::DarkOrange => "dark orange",
            Self::DarkRed => "dark red",
            Self::DarkViolet => "dark violet",
            Self::DarkYellow => "dark yellow",
        }
    }

    /// Returns the colour with this letter.
    pub fn from_letter(letter: char) -> Option<Self> {
        Self::ALL.into_iter().find(|colour| colour.letter() == letter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_letter_is_one_colour() {
        let letters: String = Colour::ALL.map(Colour::letter).iter().collect();
        assert_eq!(letters, Colour::LETTERS);
        for letter in '\0'..='\u{ff}' {
            let colour = Colour::from_letter(letter);
            assert_eq!(colour.is_some(), letters.contains(letter), "{letter}");
            assert!(colour.is_none_or(|colour| colour.letter() == letter));
        }
    }
}
