//! The mouse as the simulator has it: where it stands, what it has shown, how it is scored.

use std::convert::Infallible;

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose, WallState, Walls};

use crate::{Bearing, Command, GridPoint, Place, Reply, Scores};

/// What is around a mouse: who knows the walls, and whoever watches.
pub trait Surroundings {
    /// Why the mouse cannot go on.
    type Error;

    /// Whether there is a wall at this side of this cell. Outer walls are never asked for.
    ///
    /// # Errors
    /// It cannot be told.
    fn wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Self::Error>;

    /// The mouse has come to another cell, also within a longer movement, has turned, or was put back
    /// to the start.
    ///
    /// # Errors
    /// The mouse shall stop here.
    fn moved(&mut self, mouse: &Mouse) -> Result<(), Self::Error> {
        let _ = mouse;
        Ok(())
    }
}

/// The walls of a maze that nobody watches.
impl Surroundings for Walls {
    type Error = Infallible;

    fn wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Infallible> {
        Ok(self.has(cell, heading))
    }
}

/// A mouse in a maze: what its commands have made of it.
#[derive(Clone, Debug)]
pub struct Mouse {
    point: GridPoint,
    bearing: Bearing,
    /// The walls it has asked for or met and those it has marked, and the cells it has been in.
    map: KnownMaze,
    /// The walls it has marked: what it says of them counts more than what was seen.
    marked: Walls,
    /// The number written into each cell, row by row; 0 where there is none.
    numbers: [u16; MazeSize::MAX_AREA],
    scores: Scores,
    is_reset_pressed: bool,
}

impl Mouse {
    /// A mouse that stands in the start cell and heads north.
    pub fn new(size: MazeSize, start: Cell, goals: CellSet) -> Self {
        let mut map = KnownMaze::new(size, start, goals);
        map.visit(start);
        Self {
            point: GridPoint::centre(start),
            bearing: Bearing::NORTH,
            map,
            marked: Walls::open(size),
            numbers: [0; MazeSize::MAX_AREA],
            scores: Scores::default(),
            is_reset_pressed: false,
        }
    }

    /// Where it stands, in half cells.
    pub const fn point(&self) -> GridPoint {
        self.point
    }

    /// The cell that it is counted to, and the heading that is nearest.
    pub const fn pose(&self) -> Pose {
        Pose::new(self.point.cell(), self.bearing.heading())
    }

    /// What can be shown of its knowledge: the walls that it has asked for, passed or run into, those
    /// that it has marked, whatever was seen there, and the cells it has been in.
    pub const fn map(&self) -> &KnownMaze {
        &self.map
    }

    /// The number that it has written into a cell as its text, as mice do with distances; 0 for
    /// another text or none.
    pub fn number(&self, cell: Cell) -> u16 {
        self.index(cell).map_or(0, |index| self.numbers[index])
    }

    /// What was counted of it.
    pub const fn scores(&self) -> &Scores {
        &self.scores
    }

    /// Presses the reset button. The mouse learns of it when it asks.
    pub const fn press_reset(&mut self) {
        self.is_reset_pressed = true;
    }

    /// Does what a command says. Commands that mms does not reply to have no reply.
    ///
    /// # Errors
    /// What is around the mouse cannot be told, or whoever watches has had enough. A movement stops
    /// where it was then, and is not counted.
    pub fn obey<S: Surroundings>(
        &mut self,
        command: Command<'_>,
        around: &mut S,
    ) -> Result<Option<Reply>, S::Error> {
        match command {
            Command::MazeWidth => Ok(Some(Reply::Whole(self.map.size().width().into()))),
            Command::MazeHeight => Ok(Some(Reply::Whole(self.map.size().height().into()))),
            Command::Wall { turn, half_steps } => {
                let bearing = self.bearing.turned(turn);
                self.is_blocked_within(bearing, half_steps, around).map(Reply::Truth).map(Some)
            }
            Command::Forward { half_steps } => self.go(half_steps, around).map(Some),
            Command::Turn { eighths } => {
                self.bearing = self.bearing.turned(eighths);
                self.scores.turn();
                self.arrive();
                around.moved(self).map(|()| Some(Reply::Ack))
            }
            Command::WasReset => Ok(Some(Reply::Truth(self.is_reset_pressed))),
            Command::AckReset => {
                (self.point, self.bearing) = (GridPoint::centre(self.map.start()), Bearing::NORTH);
                self.is_reset_pressed = false;
                self.scores.reset();
                around.moved(self).map(|()| Some(Reply::Ack))
            }
            Command::GetStat(stat) => Ok(Some(self.scores.stat(stat).unwrap_or(Reply::Absent))),
            command => {
                self.show(command);
                Ok(None)
            }
        }
    }

    /// What changes nothing but what is shown. Colours are not.
    fn show(&mut self, command: Command<'_>) {
        match command {
            Command::MarkWall { cell, heading, present } => {
                self.marked.set(cell, heading, true);
                let wall = if present { WallState::Present } else { WallState::Absent };
                self.map.set_wall(cell, heading, wall);
            }
            Command::Text { cell, text } => {
                if let Some(index) = self.index(cell) {
                    self.numbers[index] = number_in(text);
                }
            }
            Command::ClearAllText => self.numbers.fill(0),
            _ => {}
        }
    }

    /// Goes as far as it can, at most so far.
    fn go<S: Surroundings>(&mut self, half_steps: u64, around: &mut S) -> Result<Reply, S::Error> {
        let (start, from) = (self.map.start(), self.point.cell());
        let mut gone = 0;
        while gone < half_steps
            && let Some(point) = self.clear_ahead(self.point, self.bearing, around)?
        {
            if gone == 0 && from == start {
                self.scores.begin_run();
            }
            let before = self.point.cell();
            (self.point, gone) = (point, gone + 1);
            if self.point.cell() != before {
                self.map.visit(self.point.cell());
                around.moved(self)?;
            }
        }
        if gone > 0 {
            self.scores.go(gone);
            self.arrive();
        }
        Ok(if gone > 0 && gone == half_steps { Reply::Ack } else { Reply::Crash })
    }

    /// What follows from where a movement or a turn has ended.
    fn arrive(&mut self) {
        let cell = self.point.cell();
        if self.map.goals().contains(cell) {
            self.scores.reach_goal();
        } else if cell == self.map.start() {
            self.scores.give_up_run();
        }
    }

    fn is_blocked_within<S: Surroundings>(
        &mut self,
        bearing: Bearing,
        half_steps: u64,
        around: &mut S,
    ) -> Result<bool, S::Error> {
        let mut point = self.point;
        // The outer walls end this soon.
        for _ in 0..half_steps {
            match self.clear_ahead(point, bearing, around)? {
                Some(next) => point = next,
                None => return Ok(true),
            }
        }
        Ok(false)
    }

    /// The point half a step ahead, unless something stands there.
    fn clear_ahead<S: Surroundings>(
        &mut self,
        point: GridPoint,
        bearing: Bearing,
        around: &mut S,
    ) -> Result<Option<GridPoint>, S::Error> {
        let Some(next) = point.ahead(bearing) else { return Ok(None) };
        let is_clear = match next.place() {
            Place::Centre => self.map.size().contains(next.cell()),
            Place::Post => false,
            Place::Wall(cell, heading) => !self.sense(cell, heading, around)?,
        };
        Ok(is_clear.then_some(next))
    }

    /// Whether there is a wall, which is known from then on.
    fn sense<S: Surroundings>(
        &mut self,
        cell: Cell,
        heading: Heading,
        around: &mut S,
    ) -> Result<bool, S::Error> {
        if self.map.size().neighbour(cell, heading).is_none() {
            return Ok(true);
        }
        let found = around.wall(cell, heading)?;
        if !self.marked.has(cell, heading) {
            let wall = if found { WallState::Present } else { WallState::Absent };
            self.map.set_wall(cell, heading, wall);
        }
        Ok(found)
    }

    fn index(&self, cell: Cell) -> Option<usize> {
        let size = self.map.size();
        let index = usize::from(cell.y) * usize::from(size.width()) + usize::from(cell.x);
        size.contains(cell).then_some(index)
    }
}

/// The number that a text is, if it is one; one that is too large is as large as can be.
fn number_in(text: &[u8]) -> u16 {
    let digits = text.trim_ascii();
    if !digits.iter().all(u8::is_ascii_digit) {
        return 0;
    }
    let digit = |number: u16, &digit: &u8| {
        number.saturating_mul(10).saturating_add(u16::from(digit - b'0'))
    };
    digits.iter().fold(0, digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAZE: &str = "\
o---o---o---o
|         G |
o   o---o   o
|       |   |
o   o   o   o
| S |       |
o---o---o---o
";

    /// Walls, and the poses in which the mouse was seen.
    struct Watched(Walls, Vec<String>);

    impl Surroundings for Watched {
        type Error = Infallible;

        fn wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Infallible> {
            self.0.wall(cell, heading)
        }

        fn moved(&mut self, mouse: &Mouse) -> Result<(), Infallible> {
            let Pose { cell: Cell { x, y }, heading } = mouse.pose();
            self.1.push(format!("{x},{y}{}", heading.letter()));
            Ok(())
        }
    }

    fn after(lines: &[&str]) -> (Mouse, Vec<String>) {
        let maze: mmsim_maze::Maze = MAZE.parse().unwrap();
        let mut mouse = Mouse::new(maze.size(), maze.start().cell, *maze.goals());
        let mut around = Watched(maze.walls().clone(), Vec::new());
        for line in lines {
            let command = Command::parse(line.as_bytes(), maze.size()).unwrap();
            let Ok(_) = mouse.obey(command, &mut around);
        }
        (mouse, around.1)
    }

    #[test]
    fn each_cell_and_each_turn_is_seen_once() {
        let (mouse, seen) =
            after(&["moveForward 9", "turnRight", "moveForwardHalf 3", "turnLeft45"]);
        assert_eq!(seen.join(" "), "0,1N 0,2N 0,2E 1,2E 2,2E 2,2N");
        assert_eq!(mouse.point(), GridPoint { x: 4, y: 5 });
        let (_, seen) =
            after(&["moveForward", "ackReset", "moveForward 0", "turnLeft", "moveForward"]);
        assert_eq!(seen.join(" "), "0,1N 0,0N 0,0W");
    }

    #[test]
    fn what_was_asked_for_passed_or_met_is_known() {
        let (mouse, _) = after(&["wallRight", "wallLeft", "moveForward"]);
        insta::assert_snapshot!(mouse.map().picture().with_mouse(mouse.pose()), @"
        o---o---o---o
        |   .   . G |
        o . o . o . o
        | ^ .   .   |
        o   o . o . o
        | S |   .   |
        o---o---o---o
        ");
        let (mouse, _) = after(&["turnRight", "moveForward", "turnLeft", "wallFront 9"]);
        insta::assert_snapshot!(mouse.map().picture(), @"
        o---o---o---o
        |   .   . G |
        o   o . o . o
        |   .   .   |
        o   o . o . o
        | S |   .   |
        o---o---o---o
        ");
    }

    #[test]
    fn what_the_mouse_marks_counts_more() {
        let (mouse, _) = after(&["setWall 0 0 n", "clearWall 0 0 e", "wallFront", "wallRight"]);
        assert_eq!(mouse.map().wall(Cell::new(0, 0), Heading::North), WallState::Present);
        assert_eq!(mouse.map().wall(Cell::new(0, 0), Heading::East), WallState::Absent);
        let (mouse, _) = after(&["wallFront", "setWall 0 1 s", "clearWall 0 0 w"]);
        assert_eq!(mouse.map().wall(Cell::new(0, 0), Heading::North), WallState::Present);
        assert_eq!(mouse.map().wall(Cell::new(0, 0), Heading::West), WallState::Present, "outer");
    }

    #[test]
    fn numbers_in_texts_are_kept() {
        for (text, number) in [
            ("7", 7),
            (" 12 ", 12),
            ("300", 300),
            ("99999999", u16::MAX),
            ("a", 0),
            ("-1", 0),
            ("", 0),
        ] {
            let line = format!("setText 2 1 {text}");
            assert_eq!(after(&[&line]).0.number(Cell::new(2, 1)), number, "{text}");
        }
        let number = |lines: &[&str]| after(lines).0.number(Cell::new(0, 2));
        assert_eq!(number(&["setText 0 2 9", "setText 0 2 x"]), 0);
        assert_eq!(number(&["setText 0 2 9", "clearText 0 2"]), 0);
        assert_eq!(number(&["setText 0 2 9", "clearAllText"]), 0);
        assert_eq!(after(&[]).0.number(Cell::new(3, 0)), 0, "outside");
    }
}
