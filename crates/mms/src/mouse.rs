//! The simulated mouse: its position, its map and its scores.

use std::convert::Infallible;

use mmsim_maze::{
    Cell, CellSet, Direction, Heading, KnownMaze, MazeSize, Point, Pose, Wall, WallState, Walls,
};

use crate::command::Command;
use crate::display::Display;
use crate::response::Response;
use crate::scores::{ScoreRules, Scores};

/// Provides the walls to a simulated mouse and is notified when the pose of the mouse changes.
pub trait Environment {
    /// The reason why a wall cannot be determined or why the mouse must stop.
    type Error;

    /// Returns true if there is a wall on the given side of the cell. This method is not called for
    /// outer walls.
    ///
    /// # Errors
    /// Returns an error if the wall cannot be determined.
    fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Self::Error>;

    /// Called when the mouse turns or enters a cell. A movement over
    /// several cells calls this method for each cell.
    ///
    /// # Errors
    /// If the implementation returns an error, the mouse stops and the error is passed on.
    fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), Self::Error> {
        let _ = mouse;
        Ok(())
    }

    /// Called when the mouse is put back at the start.
    ///
    /// # Errors
    /// If the implementation returns an error, the mouse stops and the error is passed on.
    fn on_restart(&mut self, mouse: &SimulatedMouse) -> Result<(), Self::Error> {
        self.on_pose_change(mouse)
    }
}

impl Environment for Walls {
    type Error = Infallible;

    fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Infallible> {
        Ok(self.has(cell, heading))
    }
}

/// A simulated mouse that executes commands.
#[derive(Clone, Debug)]
pub struct SimulatedMouse {
    point: Point,
    direction: Direction,
    /// The walls that were sensed or marked, and the visited cells.
    map: KnownMaze,
    /// The walls that the mouse has marked. A sensed wall does not overwrite a marked wall.
    marked: Walls,
    display: Display,
    /// The rules by which `getStat` replies.
    rules: ScoreRules,
    /// The scores by all rules, in the order of [`ScoreRules::ALL`].
    scores: [Scores; ScoreRules::ALL.len()],
    is_reset_pressed: bool,
}

impl SimulatedMouse {
    /// Creates a mouse in the start cell, heading north.
    pub fn new(size: MazeSize, start: Cell, goals: CellSet) -> Self {
        let mut map = KnownMaze::new(size, start, goals);
        map.visit(start);
        Self {
            point: Point::centre(start),
            direction: Direction::North,
            map,
            marked: Walls::open(size),
            display: Display::new(size),
            rules: ScoreRules::default(),
            scores: ScoreRules::ALL.map(Scores::new),
            is_reset_pressed: false,
        }
    }

    /// Returns the mouse with these rules for the replies to `getStat`. The default is
    /// [`ScoreRules::Mms12`].
    #[must_use]
    pub fn with_score_rules(mut self, rules: ScoreRules) -> Self {
        self.rules = rules;
        self
    }

    /// Returns the position: the centre of a cell or the middle of an absent wall.
    pub const fn point(&self) -> Point {
        self.point
    }

    /// Returns the pose. As in mms, a point between two cells belongs to the northern or eastern
    /// cell. On a diagonal, the heading is the next one counterclockwise.
    pub const fn pose(&self) -> Pose {
        Pose::new(self.cell(), Heading::ALL[self.direction as usize / 2])
    }

    const fn cell(&self) -> Cell {
        Cell::new(self.point.i / 2, self.point.j / 2)
    }

    /// Returns the map to display. The map contains the visited cells and the walls that the mouse
    /// has read, passed, crashed into or marked. Walls that the mouse has marked may differ from
    /// the true walls.
    pub const fn map(&self) -> &KnownMaze {
        &self.map
    }

    /// Returns the texts and colours to display.
    pub const fn display(&self) -> &Display {
        &self.display
    }

    /// Returns the scores according to the rules for the replies to `getStat`.
    pub const fn scores(&self) -> &Scores {
        self.scores_by(self.rules)
    }

    /// Returns the scores according to `rules`.
    pub const fn scores_by(&self, rules: ScoreRules) -> &Scores {
        &self.scores[rules as usize]
    }

    /// Presses the reset button, which the mouse polls with `wasReset`.
    pub const fn press_reset(&mut self) {
        self.is_reset_pressed = true;
    }

    /// Executes a command and returns the response, or `None` if mms does not respond to the
    /// command.
    ///
    /// # Errors
    /// Returns the error from the environment. An error during a movement stops the mouse,
    /// and the movement is not scored.
    pub fn execute<E: Environment>(
        &mut self,
        command: Command<'_>,
        environment: &mut E,
    ) -> Result<Option<Response>, E::Error> {
        match command {
            Command::MazeWidth => Ok(Some(Response::Count(self.map.size().width().into()))),
            Command::MazeHeight => Ok(Some(Response::Count(self.map.size().height().into()))),
            Command::Goals => Ok(Some(Response::Cells(Box::new(*self.map.goals())))),
            Command::Wall { turn, half_steps } => {
                let direction = self.direction.turned(turn);
                let is_blocked = self.is_blocked_within(direction, half_steps, environment)?;
                Ok(Some(Response::Bool(is_blocked)))
            }
            Command::Forward { half_steps } => self.move_forward(half_steps, environment).map(Some),
            Command::Turn { eighths } => {
                self.direction = self.direction.turned(eighths);
                self.score(Scores::add_turn);
                self.update_run();
                environment.on_pose_change(self).map(|()| Some(Response::Ack))
            }
            Command::WasReset => Ok(Some(Response::Bool(self.is_reset_pressed))),
            Command::AckReset => {
                self.point = Point::centre(self.map.start().cell);
                self.direction = Direction::North;
                self.is_reset_pressed = false;
                self.score(Scores::reset);
                environment.on_restart(self).map(|()| Some(Response::Ack))
            }
            Command::GetStat(stat) => Ok(Some(self.scores().stat(stat))),
            Command::MarkWall { cell, heading, is_present } => {
                self.marked.set(cell, heading, true);
                self.map.set_wall(cell, heading, wall_state(is_present));
                Ok(None)
            }
            Command::Text { .. }
            | Command::ClearAllText
            | Command::Colour { .. }
            | Command::ClearAllColours => {
                self.display.execute(command);
                Ok(None)
            }
        }
    }

    /// Moves the mouse forward by the given distance, or less if the mouse is blocked.
    fn move_forward<E: Environment>(
        &mut self,
        half_steps: u64,
        environment: &mut E,
    ) -> Result<Response, E::Error> {
        let is_at_start = self.cell() == self.map.start().cell;
        let mut moved = 0;
        while moved < half_steps
            && let Some(point) = self.free_point_ahead(self.point, self.direction, environment)?
        {
            if moved == 0 && is_at_start {
                self.score(Scores::begin_run);
            }
            let before = self.cell();
            (self.point, moved) = (point, moved + 1);
            if self.cell() != before {
                self.map.visit(self.cell());
                environment.on_pose_change(self)?;
            }
        }
        if moved > 0 {
            self.score(|scores| scores.add_movement(half_steps, moved));
            self.update_run();
        }
        Ok(if moved > 0 && moved == half_steps { Response::Ack } else { Response::Crash })
    }

    /// Completes or cancels the current run, depending on the cell in which the movement or
    /// turn ended.
    fn update_run(&mut self) {
        let cell = self.cell();
        if self.map.goals().contains(cell) {
            self.score(Scores::complete_run);
        } else if cell == self.map.start().cell {
            self.score(Scores::cancel_run);
        }
    }

    /// Counts an event by all rules.
    fn score(&mut self, event: impl Fn(&mut Scores)) {
        self.scores.iter_mut().for_each(event);
    }

    fn is_blocked_within<E: Environment>(
        &mut self,
        direction: Direction,
        half_steps: u64,
        environment: &mut E,
    ) -> Result<bool, E::Error> {
        let mut point = self.point;
        // The outer walls bound the number of iterations.
        for _ in 0..half_steps {
            match self.free_point_ahead(point, direction, environment)? {
                Some(next) => point = next,
                None => return Ok(true),
            }
        }
        Ok(false)
    }

    /// Returns the point half a step ahead, or `None` if a wall or post is there.
    fn free_point_ahead<E: Environment>(
        &mut self,
        point: Point,
        direction: Direction,
        environment: &mut E,
    ) -> Result<Option<Point>, E::Error> {
        let Some(next) = point.advanced(direction, 1) else { return Ok(None) };
        let is_free = match (next.cell(), next.wall()) {
            (Some(cell), _) => self.map.size().contains(cell),
            (None, Some((cell, side))) => !self.sense_wall(Wall::new(cell, side), environment)?,
            (None, None) => false,
        };
        Ok(is_free.then_some(next))
    }

    /// Returns true if the wall is present, and records the result on the map.
    fn sense_wall<E: Environment>(
        &mut self,
        Wall { cell, heading, .. }: Wall,
        environment: &mut E,
    ) -> Result<bool, E::Error> {
        if self.map.size().neighbour(cell, heading).is_none() {
            return Ok(true);
        }
        let is_present = environment.has_wall(cell, heading)?;
        if !self.marked.has(cell, heading) {
            self.map.set_wall(cell, heading, wall_state(is_present));
        }
        Ok(is_present)
    }
}

const fn wall_state(is_present: bool) -> WallState {
    if is_present { WallState::Present } else { WallState::Absent }
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

    /// An environment that logs the poses of the mouse.
    struct LoggedWalls {
        walls: Walls,
        poses: Vec<String>,
    }

    impl Environment for LoggedWalls {
        type Error = Infallible;

        fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Infallible> {
            self.walls.has_wall(cell, heading)
        }

        fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), Infallible> {
            let Pose { cell: Cell { x, y }, heading } = mouse.pose();
            self.poses.push(format!("{x},{y}{}", heading.letter()));
            Ok(())
        }
    }

    /// Executes the commands and returns the mouse and the logged poses.
    fn execute(lines: &[&str]) -> (SimulatedMouse, Vec<String>) {
        let maze: mmsim_maze::Maze = MAZE.parse().unwrap();
        let mut mouse = SimulatedMouse::new(maze.size(), maze.start().cell, *maze.goals());
        let mut environment = LoggedWalls { walls: maze.walls().clone(), poses: Vec::new() };
        for line in lines {
            let command = Command::parse(line.as_bytes(), maze.size()).unwrap();
            let Ok(_) = mouse.execute(command, &mut environment);
        }
        (mouse, environment.poses)
    }

    #[test]
    fn each_entered_cell_and_each_turn_is_reported_once() {
        let (mouse, poses) =
            execute(&["moveForward 9", "turnRight", "moveForwardHalf 3", "turnLeft45"]);
        assert_eq!(poses.join(" "), "0,1N 0,2N 0,2E 1,2E 2,2E 2,2N");
        assert_eq!(mouse.point(), Point { i: 4, j: 5 });
        let (_, poses) =
            execute(&["moveForward", "ackReset", "moveForward 0", "turnLeft", "moveForward"]);
        assert_eq!(poses.join(" "), "0,1N 0,0N 0,0W");
    }

    #[test]
    fn read_passed_and_hit_walls_are_on_the_map() {
        let (mouse, _) = execute(&["wallRight", "wallLeft", "moveForward"]);
        insta::assert_snapshot!(mouse.map().picture().with_mouse(mouse.pose()), @"
        o---o---o---o
        |   .   . G |
        o . o . o . o
        | ^ .   .   |
        o   o . o . o
        | S |   .   |
        o---o---o---o
        ");
        let (mouse, _) = execute(&["turnRight", "moveForward", "turnLeft", "wallFront 9"]);
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
    fn marked_walls_override_sensed_walls() {
        let (mouse, _) = execute(&["setWall 0 0 n", "clearWall 0 0 e", "wallFront", "wallRight"]);
        assert_eq!(mouse.map().wall(Cell::new(0, 0), Heading::North), WallState::Present);
        assert_eq!(mouse.map().wall(Cell::new(0, 0), Heading::East), WallState::Absent);
        let (mouse, _) = execute(&["wallFront", "setWall 0 1 s", "clearWall 0 0 w"]);
        assert_eq!(mouse.map().wall(Cell::new(0, 0), Heading::North), WallState::Present);
        assert_eq!(
            mouse.map().wall(Cell::new(0, 0), Heading::West),
            WallState::Present,
            "an outer wall"
        );
    }

    #[test]
    fn texts_and_colours_are_displayed() {
        let (mouse, _) = execute(&[
            "setText 1 2 gone",
            "setColor 1 2 r",
            "clearAllText",
            "clearAllColor",
            "setText 0 2  a b ",
            "setText 2 0 12",
            "setText 2 1 gone",
            "clearText 2 1",
            "setColor 2 0 g",
            "setColor 2 1 b",
            "clearColor 2 1",
        ]);
        let display = mouse.display();
        let texts = mouse.map().size().cells().map(|cell| display.text(cell).to_string());
        assert_eq!(texts.collect::<Vec<_>>(), ["", "", "12", "", "", "", " a b ", "", ""]);
        let colours = mouse.map().size().cells().filter_map(|cell| display.colour(cell));
        assert_eq!(colours.collect::<Vec<_>>(), [mmsim_maze::Colour::Green]);
    }
}
