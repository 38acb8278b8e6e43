//! The colours of the simulator mms.

/// A cell colour. The simulator [mms](https://github.com/mackorone/mms) has the same 15 colours,
/// with the same letters.
///
/// ```
/// use mmsim_protocol::Colour;
/// assert_eq!(Colour::from_letter('G'), Some(Colour::DarkGreen));
/// assert_eq!(Colour::DarkGreen.letter(), 'G');
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names are colours")]
pub enum Colour {
    Black,
    Blue,
    Gray,
    Cyan,
    Green,
    Orange,
    Red,
    White,
    Yellow,
    DarkBlue,
    DarkCyan,
    DarkGray,
    DarkGreen,
    DarkRed,
    DarkYellow,
}

impl Colour {
    /// All colours.
    pub const ALL: [Self; 15] = [
        Self::Black,
        Self::Blue,
        Self::Gray,
        Self::Cyan,
        Self::Green,
        Self::Orange,
        Self::Red,
        Self::White,
        Self::Yellow,
        Self::DarkBlue,
        Self::DarkCyan,
        Self::DarkGray,
        Self::DarkGreen,
        Self::DarkRed,
        Self::DarkYellow,
    ];

    /// Returns the letter of the colour.
    pub const fn letter(self) -> char {
        b"kbacgorwyBCAGRY"[self as usize] as char
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
        let letters = Colour::ALL.map(Colour::letter);
        assert_eq!(letters.iter().collect::<String>(), "kbacgorwyBCAGRY");
        for letter in '\0'..='\u{ff}' {
            let colour = Colour::from_letter(letter);
            assert_eq!(colour.is_some(), letters.contains(&letter), "{letter}");
            assert!(colour.is_none_or(|colour| colour.letter() == letter));
        }
    }
}
