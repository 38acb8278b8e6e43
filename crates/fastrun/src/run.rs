//! A fast run: straights and turns.

use alloc::vec::Vec;
use core::fmt;

use mmsim_maze::{Cell, CellSet, Direction, Point, Walls};

use crate::turn::{Side, TurnKind};

/// A run from rest in the start cell to rest in a goal cell: straight, turn, straight, turn, …,
/// straight.
///
/// [`Display`](fmt::Display) writes the run as text: the first direction, then the number of
/// lattice steps straight on between the turns, and each turn with its side and, if it has been chosen,
/// its speed in mm/s.
///
/// ```
/// use mmsim_fastrun::FastRun;
/// use mmsim_maze::Cell;
/// let run = FastRun::parse(Cell::new(0, 0), "N 2 45inR@1400 2 45outL@1700 0")?;
/// assert_eq!(run.turns().len(), 2);
/// assert_eq!(run.to_string(), "N 2 45inR@1400 2 45outL@1700 0");
/// assert_eq!(run.goal(), Some(Cell::new(2, 4)));
/// # Ok::<(), mmsim_fastrun::ParseRunError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FastRun {
    start: Cell,
    direction: Direction,
    turns: Vec<Turn>,
    last: u8,
}

/// A turn of a run, and the straight before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// The number of lattice steps straight on before the turn.
    pub straight: u8,
    /// The turn.
    pub kind: TurnKind,
    /// The side to which the mouse turns.
    pub side: Side,
    /// The speed in mm/s, or 0 if it has not been chosen (see [`FastRun::with_fastest_speeds`]).
    pub speed: f64,
}

impl FastRun {
    /// Creates a run. The mouse begins in the given direction, and goes `last` lattice steps
    /// straight on after the last turn. A run without turns and steps stays at rest.
    pub const fn new(start: Cell, direction: Direction, turns: Vec<Turn>, last: u8) -> Self {
        Self { start, direction, turns, last }
    }

    /// Returns the start cell.
    pub const fn start(&self) -> Cell {
        self.start
    }

    /// Returns the direction in which the mouse begins.
    pub const fn direction(&self) -> Direction {
        self.direction
    }

    /// Returns the turns, each with the straight before it.
    pub fn turns(&self) -> &[Turn] {
        &self.turns
    }

    /// Returns the number of lattice steps after the last turn.
    pub const fn last(&self) -> u8 {
        self.last
    }

    /// Returns true if the mouse stays where it is, because its start is a goal.
    pub fn is_empty(&self) -> bool {
        self.turns.is_empty() && self.last == 0
    }

    /// Replaces the run by one without turns, and keeps the memory of its turns.
    pub(crate) fn reset(&mut self, start: Cell, last: u8) -> &mut Vec<Turn> {
        (self.start, self.direction, self.last) = (start, Direction::North, last);
        self.turns.clear();
        &mut self.turns
    }

    pub(crate) const fn set_direction(&mut self, direction: Direction) {
        self.direction = direction;
    }

    /// Returns the lattice points that the run passes, in order: the start, the points of the
    /// straights, and the beginnings, walls and ends of the turns. Returns fewer points if the run
    /// leaves the lattice or turns where no such turn can begin.
    pub fn points(&self) -> Vec<Point> {
        let mut points = Vec::with_capacity(2 * self.turns.len() + 16);
        // `None` means that the run is not possible on the lattice.
        let _ = self.walk(&mut points);
        points
    }

    fn walk(&self, points: &mut Vec<Point>) -> Option<()> {
        let mut at = Point::centre(self.start);
        points.push(at);
        let mut direction = self.direction;
        for turn in &self.turns {
            at = go_straight(at, direction, turn.straight, points)?;
            if !turn.kind.begins_at(at, direction, turn.side) {
                return None;
            }
            for wall in turn.kind.walls(at, direction, turn.side) {
                points.push(wall?);
            }
            (at, direction) = turn.kind.end(at, direction, turn.side)?;
            if at.cell().is_some() {
                points.push(at);
            }
        }
        at = go_straight(at, direction, self.last, points)?;
        (at.cell().is_some() && !direction.is_diagonal()).then_some(())
    }

    /// Returns the cells that the run passes, in order, beginning with the start. A cell that the
    /// run leaves and enters again is listed again.
    pub fn cells(&self) -> Vec<Cell> {
        let mut cells = Vec::new();
        let mut at = self.start;
        cells.push(at);
        // Every wall that the run crosses leads to the next cell.
        for wall in self.points() {
            let Some((cell, heading)) = wall.wall() else { continue };
            let Some(other) = cell.neighbour(heading) else { continue };
            at = if at == cell { other } else { cell };
            cells.push(at);
        }
        cells
    }

    /// Returns the cell in which the run ends, or `None` if the run is not possible on the lattice.
    pub fn goal(&self) -> Option<Cell> {
        let mut points = Vec::new();
        self.walk(&mut points)?;
        points.last().and_then(|point| point.cell())
    }

    /// Returns true if the run is possible in a maze with these walls: it passes no wall, and ends
    /// in one of the goal cells.
    pub fn is_possible(&self, walls: &Walls, goals: &CellSet) -> bool {
        self.goal().is_some_and(|goal| goals.contains(goal))
            && self.points().iter().all(|point| point.is_free(walls))
    }

    /// Reads a run that [`Display`](fmt::Display) has written.
    ///
    /// # Errors
    /// Returns an error if a word is not what it should be. Whether the run is possible is not
    /// checked.
    pub fn parse(start: Cell, text: &str) -> Result<Self, ParseRunError> {
        let mut words = text.split_whitespace().enumerate();
        let mut next = |expected: &'static str| {
            let word = words.next();
            let (index, word) = word.map_or((None, ""), |(index, word)| (Some(index + 1), word));
            (ParseRunError { index, expected, found: word.into() }, word)
        };
        let (error, word) = next("a direction (N, E, S or W)");
        let mut along = Direction::ALL.into_iter().filter(|direction| !direction.is_diagonal());
        let direction = along.find(|direction| direction.abbreviation() == word).ok_or(error)?;
        let mut turns = Vec::new();
        loop {
            let (error, word) = next("a number of steps (0 to 255)");
            let straight = word.parse().map_err(|_| error)?;
            let (error, word) = next("a turn such as 45inR@1400");
            if error.index.is_none() {
                return Ok(Self::new(start, direction, turns, straight));
            }
            let turn = parse_turn(word).ok_or(error)?;
            turns.push(Turn { straight, ..turn });
        }
    }
}

fn go_straight(
    mut at: Point,
    direction: Direction,
    steps: u8,
    points: &mut Vec<Point>,
) -> Option<Point> {
    for _ in 0..steps {
        at = at.advanced(direction, 1)?;
        points.push(at);
    }
    Some(at)
}

fn parse_turn(word: &str) -> Option<Turn> {
    let (turn, speed) = word.split_once('@').unwrap_or((word, "0"));
    let mut characters = turn.chars();
    let letter = characters.next_back()?;
    let side = Side::ALL.into_iter().find(|side| side.letter() == letter)?;
    let kind = TurnKind::from_name(characters.as_str())?;
    let speed = speed.parse().ok().filter(|speed: &f64| speed.is_finite())?;
    Some(Turn { straight: 0, kind, side, speed })
}

impl fmt::Display for FastRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.direction)?;
        for Turn { straight, kind, side, speed } in &self.turns {
            write!(f, " {straight} {kind}{}", side.letter())?;
            if *speed != 0.0 {
                write!(f, "@{speed}")?;
            }
        }
        write!(f, " {}", self.last)
    }
}

/// The error for a text that is not a run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{}: expected {expected}, found {}",
    index.map_or(alloc::string::String::from("at the end"), |index| alloc::format!("word {index}")),
    if index.is_some() { alloc::format!("{found:?}") } else { "nothing".into() }
)]
#[non_exhaustive]
pub struct ParseRunError {
    /// The position of the word, beginning with 1, or `None` if the text ends early.
    pub index: Option<usize>,
    /// What was expected.
    pub expected: &'static str,
    /// The word.
    pub found: alloc::string::String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_reads_back() {
        let start = Cell::new(0, 0);
        for text in [
            "N 0",
            "E 2 s90R@500 0 s90L@500 1",
            "E 2 s90R 0 s90L@500 1",
            "N 1 45inR@1400 3 45outL@902.5 2",
        ] {
            assert_eq!(FastRun::parse(start, text).unwrap().to_string(), text);
        }
        let error = |text| FastRun::parse(start, text).unwrap_err().to_string();
        insta::assert_snapshot!(error(""), @"at the end: expected a direction (N, E, S or W), found nothing");
        insta::assert_snapshot!(error("NE 2"), @r#"word 1: expected a direction (N, E, S or W), found "NE""#);
        insta::assert_snapshot!(error("N 2 l90@900 1"), @r#"word 3: expected a turn such as 45inR@1400, found "l90@900""#);
        insta::assert_snapshot!(error("N 2 l90R@900"), @"at the end: expected a number of steps (0 to 255), found nothing");
        insta::assert_snapshot!(error("N 256"), @r#"word 2: expected a number of steps (0 to 255), found "256""#);
    }

    #[test]
    fn cells_are_those_between_the_walls_crossed() {
        let run = FastRun::parse(Cell::new(0, 0), "N 2 45inR@1400 2 45outL@1700 0").unwrap();
        let cells: Vec<_> = run.cells().iter().map(|cell| (cell.x, cell.y)).collect();
        assert_eq!(cells, [(0, 0), (0, 1), (0, 2), (1, 2), (1, 3), (2, 3), (2, 4)]);
        let walls = Walls::open(mmsim_maze::MazeSize::new(3, 5).unwrap());
        let goals: CellSet = [Cell::new(2, 4)].into_iter().collect();
        assert!(run.is_possible(&walls, &goals));
        assert!(!run.is_possible(&walls, &CellSet::EMPTY));
        for (cell, heading) in run.points().iter().filter_map(|point| point.wall()) {
            let mut closed = walls.clone();
            closed.set(cell, heading, true);
            assert!(!run.is_possible(&closed, &goals), "{cell} {heading}");
        }
    }

    #[test]
    fn runs_that_leave_the_lattice_are_not_possible() {
        let walls = Walls::open(mmsim_maze::MazeSize::CLASSIC);
        let goals = mmsim_maze::MazeSize::CLASSIC.cells().collect();
        for text in
            ["S 2", "N 1 l90R@500 1", "N 1", "N 2 45inR@700 1", "N 34 45inR@700 1 45outL@700 255"]
        {
            let run = FastRun::parse(Cell::new(0, 0), text).unwrap();
            assert!(!run.is_possible(&walls, &goals), "{text}");
        }
    }
}
