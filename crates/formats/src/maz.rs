//! The binary format `.maz`: one byte for each cell of a 16×16 maze.

use mmsim_maze::{Cell, Maze, MazeSize, Sides};

use crate::error::{Location, ParseError};
use crate::parsed_maze::{CellRecord, by_columns, unmarked_maze, walls_of_cells};

const SIZE: MazeSize = MazeSize::CLASSIC;

/// Returns true if the file is a `.maz` file, even if its content has errors. All bytes of a `.maz`
/// file are below 16. The first byte is usually 14, because the start is usually open only to the
/// north. No text file starts with byte 14, and every text file that is not blank contains bytes
/// above 15.
pub(crate) fn matches(content: &[u8]) -> bool {
    let is_low = content.iter().all(|&byte| byte < 16);
    let is_blank = content.iter().all(|byte| (9..=13).contains(byte));
    is_low && !is_blank || content.len() == SIZE.area() && content.first() == Some(&14)
}

pub(crate) fn parse(content: &[u8]) -> Result<Maze, Vec<ParseError>> {
    if content.len() != SIZE.area() {
        let (index, found) = (content.len().min(SIZE.area()), content.len());
        let expected = format!("{} bytes, one for each cell of a {SIZE} maze", SIZE.area());
        let error = ParseError::at(Location::Byte(index + 1), expected, found.to_string());
        return Err(ParseError { cell: cell_at(index), ..error }.into());
    }
    let cells: Vec<CellRecord> = content
        .iter()
        .enumerate()
        .map(|(index, &byte)| parse_cell(index, byte))
        .collect::<Result<_, _>>()?;
    let height = usize::from(SIZE.height());
    let record = |Cell { x, y }| &cells[usize::from(x) * height + usize::from(y)];
    unmarked_maze(walls_of_cells(SIZE, record)?)
}

pub(crate) fn write(maze: &Maze) -> Vec<u8> {
    by_columns(SIZE).map(|cell| maze.walls().sides(cell).bits()).collect()
}

/// Returns the cell for the byte at `index`, or `None` beyond the last cell.
fn cell_at(index: usize) -> Option<Cell> {
    by_columns(SIZE).nth(index)
}

fn parse_cell(index: usize, byte: u8) -> Result<CellRecord, ParseError> {
    let (location, found) = (Location::Byte(index + 1), byte.to_string());
    if byte >= 16 {
        let error = ParseError::at(location, "a byte from 0 to 15", found);
        return Err(ParseError { cell: cell_at(index), ..error });
    }
    Ok(CellRecord { sides: Sides::from_bits(byte), location, found })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mmsim_maze::{CellSet, Heading, Walls};

    use crate::format::Format;

    /// Returns the bytes of a maze whose only inner wall is east of the start.
    fn seed() -> Vec<u8> {
        let mut bytes = vec![0; 256];
        for side in 0..16 {
            bytes[side] |= 8;
            bytes[240 + side] |= 2;
            bytes[16 * side] |= 4;
            bytes[16 * side + 15] |= 1;
        }
        bytes[0] |= 2;
        bytes[16] |= 8;
        bytes
    }

    #[test]
    fn bytes_are_columns_and_bits_are_walls() {
        let mut walls = Walls::open(SIZE);
        walls.set(Cell::new(0, 0), Heading::East, true);
        let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
        let seed = seed();
        assert_eq!(seed[..3], [14, 8, 8]);
        assert_eq!(Format::detect(&seed), Format::Maz);
        assert_eq!(Format::Maz.parse(&seed).as_ref(), Ok(&maze));
        assert_eq!(Format::Maz.write(&maze).as_ref(), Ok(&seed));
    }

    /// In text, bytes 10 and 13 are line endings. In a `.maz` file, byte 10 is a corridor and byte
    /// 13 is a dead end.
    #[test]
    fn whitespace_bytes_are_cells() {
        let walls = Walls::closed(SIZE);
        let closed = Format::Maz.write(&Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap());
        assert_eq!(closed.as_deref(), Ok(&[15; 256][..]));
        let mut walls = Walls::closed(SIZE);
        for x in 0..16 {
            for y in 1..16 {
                walls.set(Cell::new(x, y), Heading::South, false);
            }
        }
        let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
        let bytes = Format::Maz.write(&maze).unwrap();
        assert_eq!(bytes[1..15], [b'\n'; 14]);
        assert_eq!(Format::Maz.parse(&bytes), Ok(maze));
    }

    #[test]
    fn errors_name_the_byte_and_the_cells() {
        let message = |content: &[u8]| {
            let error = Format::Maz.parse(content).unwrap_err();
            let cell = error.cell.map_or("no cell".into(), |cell| cell.to_string());
            format!("{error}; {cell}")
        };
        let error = |index: usize, byte: u8| {
            let mut bytes = seed();
            bytes[index] = byte;
            message(&bytes)
        };
        insta::assert_snapshot!(error(16, 4), @"byte 17: expected a wall between (0, 0) and (1, 0) to match byte 1, found 4; (1, 0)");
        insta::assert_snapshot!(error(255, 1), @"byte 256: expected an outer wall to the east of (15, 15), found 1; (15, 15)");
        insta::assert_snapshot!(error(7, 24), @"byte 8: expected a byte from 0 to 15, found 24; (0, 7)");
        let cut = |length: usize| {
            let bytes = [seed(), vec![b'\n']].concat();
            message(&bytes[..length])
        };
        insta::assert_snapshot!(cut(255), @"byte 256: expected 256 bytes, one for each cell of a 16x16 maze, found 255; (15, 15)");
        insta::assert_snapshot!(cut(257), @"byte 257: expected 256 bytes, one for each cell of a 16x16 maze, found 257; no cell");
    }
}
