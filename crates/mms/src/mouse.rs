//! The simulated mouse: its position, its map and its scores.

use std::convert::Infallible;

use mmsim_fastrun::{FastRun, Side, TurnKind};
use mmsim_maze::{
    Cell, CellSet, Direction, Heading, KnownMaze, MazeSize, Point, Pose, Wall, WallState, Walls,
};

use crate::command::Command;
use crate::display::Display;
use crate::driven_run::DrivenRun;
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

    /// Returns what the sensors of the mouse read on the given side of the cell, which may differ from
    /// [`has_wall`](Self::has_wall). By default, all readings are right.
    ///
    /// # Errors
    /// Returns an error if the wall cannot be determined.
    fn read_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, Self::Error> {
        self.has_wall(cell, heading)
    }

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

/// Senses a wall: by its sensors, or by driving.
type Sense<E> = fn(&mut E, Cell, Heading) -> Result<bool, <E as Environment>::Error>;

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
    run: DrivenRun,
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
            run: DrivenRun::new(start),
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

    /// Returns the latest fast run of the mouse, without speeds: it drove from the centre of the start
    /// cell to the centre of a goal cell, straight on or with slalom turns only.
    pub const fn fast_run(&self) -> Option<&FastRun> {
        self.run.latest()
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
                self.end_drive();
                environment.on_pose_change(self).map(|()| Some(Response::Ack))
            }
            Command::Slalom { kind, side } => self.drive_turn(kind, side, environment).map(Some),
            Command::WasReset => Ok(Some(Response::Bool(self.is_reset_pressed))),
            Command::AckReset => {
                self.point = Point::centre(self.map.start().cell);
                self.direction = Direction::North;
                self.is_reset_pressed = false;
                self.run.begin(self.direction);
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
            && let Some(point) =
                self.free_point_ahead(self.point, self.direction, E::has_wall, environment)?
        {
            if moved == 0 && is_at_start {
                self.score(Scores::begin_run);
            }
            moved += 1;
            self.run.add_straight(1);
            self.advance(point, self.direction, environment)?;
        }
        let is_complete = moved > 0 && moved == half_steps;
        if !is_complete {
            self.end_drive();
        }
        if moved > 0 {
            self.score(|scores| scores.add_movement(half_steps, moved));
            self.update_run();
        }
        Ok(if is_complete { Response::Ack } else { Response::Crash })
    }

    /// Drives a slalom turn. If a wall is in the way, or if no such turn can begin here, the mouse stays
    /// where it is.
    fn drive_turn<E: Environment>(
        &mut self,
        kind: TurnKind,
        side: Side,
        environment: &mut E,
    ) -> Result<Response, E::Error> {
        let (from, direction) = (self.point, self.direction);
        let end = kind.end(from, direction, side);
        let end = end.filter(|_| kind.begins_at(from, direction, side));
        let Some((end, _)) = end else { return Ok(self.crash_turn()) };
        let mut points = Vec::new();
        for wall in kind.walls(from, direction, side) {
            match wall {
                Some(wall) if self.is_free(wall, E::has_wall, environment)? => points.push(wall),
                _ => return Ok(self.crash_turn()),
            }
        }
        // Not all turns end at the middle of a wall.
        points.extend(end.cell().map(|_| end));
        if self.cell() == self.map.start().cell {
            self.score(Scores::begin_run);
        }
        let eighths = if side == Side::Left { -kind.eighths() } else { kind.eighths() };
        let count = i8::try_from(points.len()).unwrap_or(i8::MAX);
        for (number, &point) in (1..=count).zip(&points) {
            self.advance(point, direction.turned(eighths * number / count), environment)?;
        }
        self.run.add_turn(kind, side);
        self.score(Scores::add_turn);
        let half_steps = points.len() as u64;
        self.score(|scores| scores.add_movement(half_steps, half_steps));
        self.update_run();
        Ok(Response::Ack)
    }

    fn crash_turn(&mut self) -> Response {
        self.end_drive();
        Response::Crash
    }

    /// Notes that the mouse stands still after a crash or a turn in place. At the centre of the start
    /// cell, a fast run can begin.
    fn end_drive(&mut self) {
        if self.point == Point::centre(self.map.start().cell) {
            self.run.begin(self.direction);
        } else {
            self.run.stop();
        }
    }

    /// Puts the mouse at the next point of a movement.
    fn advance<E: Environment>(
        &mut self,
        point: Point,
        direction: Direction,
        environment: &mut E,
    ) -> Result<(), E::Error> {
        let (before, from) = (self.pose(), self.point);
        (self.point, self.direction) = (point, direction);
        // The cell that contains the middle of the way.
        let [x, y] = [(from.i, point.i), (from.j, point.j)].map(|(a, b)| a.midpoint(b) / 2);
        self.map.visit(Cell::new(x, y));
        if self.pose() == before {
            return Ok(());
        }
        self.map.visit(self.cell());
        environment.on_pose_change(self)
    }

    /// Completes or cancels the current run, depending on the cell in which the movement or
    /// turn ended.
    fn update_run(&mut self) {
        let cell = self.cell();
        if self.map.goals().contains(cell) {
            self.score(Scores::complete_run);
            if self.point.cell().is_some() && !self.direction.is_diagonal() {
                self.run.reach_goal();
            }
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
            match self.free_point_ahead(point, direction, E::read_wall, environment)? {
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
        sense: Sense<E>,
        environment: &mut E,
    ) -> Result<Option<Point>, E::Error> {
        let Some(next) = point.advanced(direction, 1) else { return Ok(None) };
        Ok(self.is_free(next, sense, environment)?.then_some(next))
    }

    /// Returns true if neither a wall nor a post is at the point.
    fn is_free<E: Environment>(
        &mut self,
        point: Point,
        sense: Sense<E>,
        environment: &mut E,
    ) -> Result<bool, E::Error> {
        Ok(match (point.cell(), point.wall()) {
            (Some(cell), _) => self.map.size().contains(cell),
            (None, Some((cell, side))) => {
                !self.sense_wall(Wall::new(cell, side), sense, environment)?
            }
            (None, None) => false,
        })
    }

    /// Returns true if the wall is present, and records the result on the map.
    fn sense_wall<E: Environment>(
        &mut self,
        Wall { cell, heading, .. }: Wall,
        sense: Sense<E>,
        environment: &mut E,
    ) -> Result<bool, E::Error> {
        if self.map.size().neighbour(cell, heading).is_none() {
            return Ok(true);
        }
        let is_present = sense(environment, cell, heading)?;
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
    use mmsim_fastrun::{Planner, Vehicle};

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

    /// Returns the commands that drive a run.
    fn commands(run: &FastRun) -> Vec<String> {
        let heading = run.direction() as usize;
        let mut lines = vec!["turnRight45".to_string(); heading];
        let forward = |straight: u8| (straight > 0).then(|| format!("moveForwardHalf {straight}"));
        for turn in run.turns() {
            lines.extend(forward(turn.straight));
            lines.push(format!("slalom{:?} {}", turn.side, turn.kind));
        }
        lines.extend(forward(run.last()));
        lines
    }

    #[test]
    fn planned_runs_are_driven_in_the_planned_time() {
        let mazes = mmsim_mazes::FILES.iter();
        let mazes = mazes.filter_map(|(name, text)| Some((name, text.parse().ok()?)));
        let mazes: Vec<(_, mmsim_maze::Maze)> = mazes.collect();
        assert!(mazes.len() > 10);
        for (name, maze) in mazes {
            let (walls, start) = (maze.walls(), maze.start().cell);
            for vehicle in Vehicle::PRESETS.map(|name| Vehicle::preset(name).unwrap()) {
                let mut planner = Planner::new(vehicle.clone());
                let Ok(run) = planner.plan(walls, start, maze.goals()) else { continue };
                let mut mouse = SimulatedMouse::new(maze.size(), start, *maze.goals());
                let mut environment = LoggedWalls { walls: walls.clone(), poses: Vec::new() };
                for line in commands(run) {
                    let command = Command::parse(line.as_bytes(), maze.size()).unwrap();
                    let Ok(reply) = mouse.execute(command, &mut environment);
                    assert_eq!(reply, Some(Response::Ack), "{name}: {line}");
                }
                let driven = mouse.fast_run().unwrap();
                assert_eq!(driven.cells(), run.cells(), "{name}");
                let driven = driven.with_fastest_speeds(&vehicle).unwrap();
                let difference = driven.time(&vehicle).unwrap() - run.time(&vehicle).unwrap();
                assert!(difference.abs() < 1e-9, "{name} {}: {difference}", vehicle.name());
                assert!(run.cells().iter().all(|&cell| mouse.map().visited().contains(cell)));
                for wall in run.points().into_iter().filter_map(Point::wall) {
                    assert_eq!(mouse.map().wall(wall.0, wall.1), WallState::Absent, "{name}");
                }
            }
        }
    }

    #[test]
    fn a_blocked_slalom_turn_crashes_and_moves_nothing() {
        let replies = |lines: &[&str]| {
            let (mouse, poses) = execute(lines);
            (mouse.point(), mouse.direction, poses.len(), mouse.fast_run().is_some())
        };
        let at = |i, j| Point { i, j };
        // A wall after the first cell, no room for such a turn, and then turns in place.
        for line in ["slalomLeft l90", "slalomRight s90", "slalomRight v90", "slalomLeft 180"] {
            assert_eq!(replies(&[line]), (at(1, 1), Direction::North, 0, false), "{line}");
        }
        let goal = ["moveForwardHalf 2", "slalomRight l90", "moveForward"];
        assert_eq!(replies(&goal), (at(5, 5), Direction::East, 5, true));
        let crashed = ["moveForwardHalf 2", "slalomLeft l90", "slalomRight l90", "moveForward"];
        assert!(!replies(&crashed).3, "the mouse has run into a wall on the way");
        for crash in ["slalomLeft l90", "slalomRight s90"] {
            let crashed = [crash, "moveForward", "slalomRight l90", "moveForward"];
            assert!(
                replies(&crashed).3,
                "{crash}: the mouse stays at the centre of the start cell"
            );
        }
        let crashed = ["turnLeft", "moveForward", "turnRight", "moveForward", "slalomRight l90"];
        assert!(replies(&[&crashed[..], &["moveForward"]].concat()).3);
        let turned = ["moveForward 2", "turnRight", "moveForward 2"];
        assert!(!replies(&turned).3, "the mouse has turned in place");
    }

    #[test]
    fn a_mouse_between_two_cells_knows_the_walls_that_it_has_passed() {
        let (mouse, _) = execute(&["moveForwardHalf 3", "slalomRight s90"]);
        assert_eq!((mouse.point(), mouse.direction), (Point { i: 2, j: 5 }, Direction::East));
        insta::assert_snapshot!(mouse.map().picture().with_mouse(mouse.pose()), @"
        o---o---o---o
        |     > . G |
        o   o . o . o
        |   .   .   |
        o   o . o . o
        | S .   .   |
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
