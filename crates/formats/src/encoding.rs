//! The encoding of a maze as a number for each cell: the order of the cells and the meaning of the
//! bits.

use std::fmt;
use std::str::FromStr;

use mmsim_maze::{Cell, Heading, MazeSize, Sides};

/// How the numbers of a file describe the cells of a maze. [`Display`](fmt::Display) writes the
/// options of `mmsim mazes` that select the encoding.
///
/// ```
/// use mmsim_formats::Encoding;
/// let encoding = Encoding { bits: "N4E2S1W8".parse()?, rows: "north".parse()? };
/// assert_eq!(encoding.to_string(), "--bits N4E2S1W8 --rows north");
/// # Ok::<(), mmsim_formats::EncodingError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Encoding {
    /// The meaning of each number.
    pub bits: Bits,
    /// The order of the numbers.
    pub rows: Rows,
}

/// The meaning of the number of a cell.
///
/// The text form is the letter of each side and its bit, such as `N1E2S4W8` if a set bit is a wall
/// or `N1E2S4W8-open` if it is an opening, or `codes`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Bits {
    /// Each bit stands for a side.
    Sides {
        /// The sides that the bits 1, 2, 4 and 8 stand for.
        sides: [Heading; 4],
        /// True if a set bit is an opening, false if it is a wall.
        set_is_open: bool,
    },
    /// The codes 1 to 16 of the Python simulators, for walls to the W, N, E, S, SW, SE, NE, NW, WE,
    /// NS, SWE, NSE, NWE, NSW, none and all.
    Codes,
}

/// The order of the numbers of a file.
///
/// The text form is `first_line`, and `-` and `first_item` if it is neither the west of a row nor
/// the south of a column: `north`, `south-east`, `west`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rows {
    /// The edge of the maze that the first line describes.
    first_line: Heading,
    /// The edge of the maze at which each line begins.
    first_item: Heading,
}

/// An error in the text form of [`Bits`] or [`Rows`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, found {found:?}")]
#[non_exhaustive]
pub struct EncodingError {
    /// The valid forms.
    pub expected: &'static str,
    /// What was found.
    pub found: String,
}

/// The walls that the codes 1 to 16 stand for, as bits of [`Sides`].
const CODES: [u8; 16] = [8, 1, 2, 4, 12, 6, 3, 9, 10, 5, 14, 7, 11, 13, 0, 15];

impl Bits {
    /// North 1, east 2, south 4, west 8, for walls.
    pub(crate) const WALLS: Self = Self::Sides { sides: Heading::ALL, set_is_open: false };
    /// North 1, east 2, south 4, west 8, for openings.
    pub(crate) const OPENINGS: Self = Self::Sides { sides: Heading::ALL, set_is_open: true };

    /// Returns all meanings: 24 orders of the bits for walls, the same for openings, and codes.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let orders =
            (0..256).map(|order| [6, 4, 2, 0].map(|shift| Heading::ALL[order >> shift & 3]));
        let orders = orders.filter(|order| Heading::ALL.iter().all(|side| order.contains(side)));
        let sides = |sides| [false, true].map(|set_is_open| Self::Sides { sides, set_is_open });
        orders.flat_map(sides).chain([Self::Codes])
    }

    /// Returns the sides of a cell that have a wall, or `None` for a number without meaning.
    pub(crate) fn sides(self, number: u8) -> Option<Sides> {
        match self {
            Self::Codes => {
                CODES.get(usize::from(number).wrapping_sub(1)).copied().map(Sides::from_bits)
            }
            Self::Sides { sides, set_is_open } => {
                let set = if set_is_open { !number } else { number };
                let bits = sides.into_iter().enumerate();
                Some(Sides::from_bits(bits.map(|(bit, side)| (set >> bit & 1) << side as u8).sum()))
            }
        }
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--bits {} --rows {}", self.bits, self.rows)
    }
}

impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Sides { sides, set_is_open } = self else { return f.write_str("codes") };
        for heading in Heading::ALL {
            let bit = sides.iter().position(|side| *side == heading).unwrap_or(0);
            write!(f, "{}{}", heading.letter(), 1 << bit)?;
        }
        f.write_str(if *set_is_open { "-open" } else { "" })
    }
}

impl FromStr for Bits {
    type Err = EncodingError;

    fn from_str(text: &str) -> Result<Self, EncodingError> {
        let expected = "N, E, S and W, each with its bit, such as N1E2S4W8 for walls or \
                        N1E2S4W8-open for openings, or codes";
        find(Self::all(), text, expected)
    }
}

/// Returns the value with this text form. Ignores case.
fn find<T: fmt::Display>(
    mut all: impl Iterator<Item = T>,
    text: &str,
    expected: &'static str,
) -> Result<T, EncodingError> {
    let found = all.find(|value| value.to_string().eq_ignore_ascii_case(text));
    found.ok_or_else(|| EncodingError { expected, found: text.into() })
}

impl Rows {
    /// Rows from the north, each from the west, as in drawings.
    pub(crate) const NORTH: Self = Self { first_line: Heading::North, first_item: Heading::West };
    /// Columns from the west, each from the south, as in `.maz` files.
    pub(crate) const WEST: Self = Self { first_line: Heading::West, first_item: Heading::South };

    /// Returns all orders.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        Heading::ALL.into_iter().flat_map(|first_line| {
            let items = [first_line.left(), first_line.right()];
            items.map(|first_item| Self { first_line, first_item })
        })
    }

    /// Returns true if each line is a column of the maze instead of a row.
    pub(crate) const fn are_columns(self) -> bool {
        matches!(self.first_line, Heading::East | Heading::West)
    }

    /// Returns the line of a cell and its position in the line.
    pub(crate) fn position(self, size: MazeSize, Cell { x, y }: Cell) -> (usize, usize) {
        let cells_from = |edge| match edge {
            Heading::North => size.height() - 1 - y,
            Heading::East => size.width() - 1 - x,
            Heading::South => y,
            Heading::West => x,
        };
        (cells_from(self.first_line).into(), cells_from(self.first_item).into())
    }
}

impl fmt::Display for Rows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.are_columns(), self.first_item) {
            (false, Heading::West) | (true, Heading::South) => self.first_line.fmt(f),
            (_, item) => write!(f, "{}-{item}", self.first_line),
        }
    }
}

impl FromStr for Rows {
    type Err = EncodingError;

    fn from_str(text: &str) -> Result<Self, EncodingError> {
        let expected = "the edge of the first line: north, south, west or east; for lines that \
                        begin at the other end: north-east, south-east, west-north or east-north";
        find(Self::all(), text, expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_forms_parse() {
        for bits in Bits::all() {
            assert_eq!(bits.to_string().parse(), Ok(bits));
        }
        for rows in Rows::all() {
            assert_eq!(rows.to_string().parse(), Ok(rows));
        }
        assert_eq!((Bits::all().count(), Rows::all().count()), (49, 8));
        assert_eq!("n1e2s4w8".parse(), Ok(Bits::WALLS));
        assert_eq!("N1E2S4W8-OPEN".parse(), Ok(Bits::OPENINGS));
        insta::assert_snapshot!("N1E2S4".parse::<Bits>().unwrap_err(), @r#"expected N, E, S and W, each with its bit, such as N1E2S4W8 for walls or N1E2S4W8-open for openings, or codes, found "N1E2S4""#);
        insta::assert_snapshot!("N1E2S4W4".parse::<Bits>().unwrap_err(), @r#"expected N, E, S and W, each with its bit, such as N1E2S4W8 for walls or N1E2S4W8-open for openings, or codes, found "N1E2S4W4""#);
        insta::assert_snapshot!("up".parse::<Rows>().unwrap_err(), @r#"expected the edge of the first line: north, south, west or east; for lines that begin at the other end: north-east, south-east, west-north or east-north, found "up""#);
    }

    #[test]
    fn every_code_has_its_walls() {
        let codes = "W N E S SW SE NE NW WE NS SWE NSE NWE NSW none all".replace("all", "NESW");
        for (code, walls) in (1..).zip(codes.split(' ')) {
            let sides = Bits::Codes.sides(code).unwrap();
            for (heading, letter) in Heading::ALL.into_iter().zip(['N', 'E', 'S', 'W']) {
                assert_eq!(sides.has(heading), walls.contains(letter), "{code} to the {heading}");
            }
        }
        assert_eq!((Bits::Codes.sides(0), Bits::Codes.sides(17)), (None, None));
    }
}
