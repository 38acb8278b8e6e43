//! A simulator as the environment of a mouse: it reports walls and receives states with what the mouse
//! displays.

use std::mem;
use std::time::{Duration, Instant};

use mmsim_client::{Exchange, RunError, Transport};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Pose, Wall, WallSensor, WallState};
use mmsim_mms::{Environment, SimulatedMouse};
use mmsim_protocol::Annotation;
use mmsim_run::{MovementRules, Phases};

use crate::control::MouseControl;
use crate::log::MouseLog;
use crate::process::ExitCause;

/// The interval between two checks whether a mouse that does not move displays something new. A
/// viewer does not notice a delay of up to two intervals.
const DISPLAY_INTERVAL: Duration = Duration::from_millis(100);

/// A connection to a simulator. Each wall is requested only once.
pub(crate) struct Simulator<'a, T> {
    exchange: Exchange<T>,
    /// The walls that the simulator has reported.
    reported: KnownMaze,
    sensor: Option<WallSensor>,
    control: &'a MouseControl,
    /// A copy of the mouse, made when its state was last sent.
    last: Option<SimulatedMouse>,
    /// The name of the mouse and its log.
    annotator: Option<(&'a str, MouseLog)>,
    /// True if the mouse was put back at the start after its state was last sent.
    is_restart: bool,
    /// The time of the latest check for changes.
    checked: Instant,
    /// True if the latest check has found changes that have not been sent.
    has_changes: bool,
    rules: MovementRules,
    pub(crate) phases: Phases,
}

impl<'a, T: Transport> Simulator<'a, T> {
    /// Resets the simulator, whose maze must have the size, the start and the goal of `maze`. A simulator
    /// that does not accept annotations must have no annotator. Without a sensor, all readings are right.
    pub(crate) fn new(
        transport: T,
        maze: &KnownMaze,
        control: &'a MouseControl,
        annotator: Option<(&'a str, MouseLog)>,
        sensor: Option<WallSensor>,
    ) -> Result<Self, RunError> {
        let mut exchange = Exchange::new(transport);
        exchange.reset()?;
        let reported = KnownMaze::new(maze.size(), Cell::new(0, 0), CellSet::EMPTY);
        let (rules, mut phases) = (MovementRules::from_map(maze, None), Phases::default());
        phases.add(&rules, maze.start(), false);
        Ok(Self {
            exchange,
            reported,
            sensor,
            control,
            last: None,
            annotator,
            is_restart: false,
            checked: Instant::now(),
            has_changes: false,
            rules,
            phases,
        })
    }

    /// Returns the log of the mouse.
    fn log(&self) -> Option<&MouseLog> {
        self.annotator.as_ref().map(|(_, log)| log)
    }

    /// Waits for the last lines of the log of a mouse that has exited.
    pub(crate) fn end_log(&self) {
        self.log().into_iter().for_each(MouseLog::wait_for_end);
    }

    /// Sends the mouse's state if the state or its annotations have changed.
    pub(crate) fn update(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        let lines = self.take_lines();
        if self.is_sent(mouse) && lines.is_empty() { Ok(()) } else { self.send(mouse, &lines) }
    }

    /// Sends the state of a mouse that does not move, if the mouse or its log has changed. Must be
    /// called repeatedly. A change is sent only if it was found at the previous check too, so a mouse
    /// that is about to move has time to finish what it displays.
    pub(crate) fn show_changes(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        if self.checked.elapsed() < DISPLAY_INTERVAL {
            return Ok(());
        }
        self.checked = Instant::now();
        let has_lines = self.log().is_some_and(|log| !log.is_empty());
        let has_changes = has_lines || !self.is_sent(mouse);
        let is_second_time = mem::replace(&mut self.has_changes, has_changes);
        if has_changes && is_second_time { self.update(mouse) } else { Ok(()) }
    }

    fn is_sent(&self, mouse: &SimulatedMouse) -> bool {
        self.last.as_ref().is_some_and(|last| {
            last.pose() == mouse.pose()
                && last.map() == mouse.map()
                && last.display() == mouse.display()
        })
    }

    /// Adds a message of this process to the log of the mouse.
    pub(crate) fn add_to_log(&self, message: &str) {
        self.log().into_iter().for_each(|log| log.add(message));
    }

    /// Takes the lines that the mouse has written to its log.
    fn take_lines(&self) -> Vec<String> {
        self.log().map(MouseLog::take).unwrap_or_default()
    }

    fn send(&mut self, mouse: &SimulatedMouse, lines: &[String]) -> Result<(), ExitCause> {
        if let Some((name, _)) = self.annotator {
            let name = self.last.is_none().then_some(Annotation::Mouse(name));
            let restart = mem::take(&mut self.is_restart).then_some(Annotation::Restart);
            let changes = changes(self.last.as_ref(), mouse);
            let lines = lines.iter().map(|line| Annotation::Log(line));
            self.exchange.annotate(name.into_iter().chain(restart).chain(changes).chain(lines))?;
        }
        let number = |cell| mouse.display().text(cell).number();
        self.exchange.state(mouse.pose(), mouse.map(), number)?;
        self.last = Some(mouse.clone());
        self.has_changes = false;
        Ok(())
    }

    /// Sends the state of a mouse that has moved or was put back at the start, and waits until it may
    /// go on.
    fn show_move(&mut self, mouse: &SimulatedMouse, is_restart: bool) -> Result<(), ExitCause> {
        let lines = self.take_lines();
        self.send(mouse, &lines)?;
        self.phases.add(&self.rules, mouse.pose(), is_restart);
        if self.control.wait_for_step() { ExitCause::check(self.control) } else { Ok(()) }
    }
}

impl<T: Transport> Environment for Simulator<'_, T> {
    type Error = ExitCause;

    fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, ExitCause> {
        match self.reported.wall(cell, heading) {
            WallState::Present => Ok(true),
            WallState::Absent => Ok(false),
            WallState::Unknown => {
                let pose = Pose::new(cell, heading);
                let (around, size) = (self.exchange.walls(pose)?, self.reported.size());
                let observed = self.reported.observe(pose, around);
                observed.map_err(|error| RunError::from_contradiction(error, size))?;
                Ok(around.front)
            }
        }
    }

    fn read_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, ExitCause> {
        let (is_present, size) = (self.has_wall(cell, heading)?, self.reported.size());
        let sensor = self.sensor.as_mut();
        Ok(is_present != sensor.is_some_and(|sensor| sensor.misreads(size, cell, heading)))
    }

    fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        self.show_move(mouse, false)
    }

    fn on_restart(&mut self, mouse: &SimulatedMouse) -> Result<(), ExitCause> {
        self.is_restart = true;
        self.show_move(mouse, true)
    }
}

/// Returns the annotations that change what the mouse displayed before into what it displays now.
/// At first, there are no texts, colours and declared walls.
fn changes<'n>(before: Option<&SimulatedMouse>, now: &'n SimulatedMouse) -> Vec<Annotation<'n>> {
    let cells = || now.map().size().cells();
    let (display, displayed) = (now.display(), before.map(SimulatedMouse::display));
    let text = |cell| Annotation::Text { cell, text: display.text(cell).as_str() };
    let is_new = |&cell: &Cell| match displayed {
        Some(displayed) => displayed.text(cell) != display.text(cell),
        None => !display.text(cell).is_empty(),
    };
    let mut changes: Vec<_> = cells().filter(is_new).map(text).collect();
    let colour = |cell| Annotation::Colour { cell, colour: display.colour(cell) };
    let colour_before = |cell| displayed.and_then(|displayed| displayed.colour(cell));
    let has_new_colour = |&cell: &Cell| display.colour(cell) != colour_before(cell);
    changes.extend(cells().filter(has_new_colour).map(colour));
    if before.is_none_or(|before| before.map() != now.map()) {
        changes.extend(wall_declarations(before.map(SimulatedMouse::map), now.map()));
    }
    changes
}

/// Returns the annotations about walls that the state message cannot express, if they differ from those
/// about an earlier map.
pub fn wall_declarations<'t>(
    before: Option<&KnownMaze>,
    now: &KnownMaze,
) -> impl Iterator<Item = Annotation<'t>> {
    now.size().inner_walls().filter_map(move |wall| {
        let (state, Wall { cell, heading, .. }) = (declaration(now, wall), wall);
        let declared = before.and_then(|before| declaration(before, wall));
        (state != declared).then_some(Annotation::Wall { cell, heading, state })
    })
}

/// Returns what to declare about a wall, or `None` if the state message expresses it. In the state
/// message, a wall is known if it is present or if one of its cells is visited.
fn declaration(map: &KnownMaze, wall: Wall) -> Option<WallState> {
    let is_visited = wall.cells().any(|cell| map.visited().contains(cell));
    match map.wall(wall.cell, wall.heading) {
        WallState::Unknown if is_visited => Some(WallState::Unknown),
        WallState::Absent if !is_visited => Some(WallState::Absent),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use mmsim_maze::{CellSet, MazeSize, Walls, WyRand};
    use mmsim_mms::Command;
    use mmsim_protocol::{Colour, MapState, Order, State};

    use super::*;

    const START: Cell = Cell { x: 0, y: 0 };

    fn mouse(size: MazeSize) -> SimulatedMouse {
        SimulatedMouse::new(size, START, CellSet::EMPTY)
    }

    fn execute(mouse: &mut SimulatedMouse, walls: &mut Walls, line: &str) {
        let Ok(_) = mouse.execute(Command::parse(line.as_bytes(), walls.size()).unwrap(), walls);
    }

    /// Returns the annotations after each block of commands in an open maze of 3x2 cells.
    fn blocks(blocks: &[&[&str]]) -> String {
        let mut walls = Walls::open(MazeSize::new(3, 2).unwrap());
        let (mut mouse, mut before, mut shown) = (mouse(walls.size()), None, Vec::new());
        for block in blocks {
            block.iter().for_each(|line| execute(&mut mouse, &mut walls, line));
            let changes = changes(before.as_ref(), &mouse).into_iter().map(|change| match change {
                Annotation::Text { cell, text } => format!("{cell} {text:?}"),
                Annotation::Colour { cell, colour } => format!("{cell} {colour:?}"),
                Annotation::Wall { cell, heading, state } => format!("{cell} {heading} {state:?}"),
                other => format!("{other:?}"),
            });
            shown.push(changes.collect::<Vec<_>>().join("; "));
            before = Some(mouse.clone());
        }
        shown.join("\n")
    }

    #[test]
    fn changed_texts_and_colours_are_sent() {
        let shown = blocks(&[
            &["setText 0 0 12", "setText 1 0 a b", "setColor 2 1 G"],
            &[],
            &["setText 1 0 a b", "clearText 0 0", "setColor 2 1 r", "setColor 1 1 k"],
            &["clearAllText", "setText 2 0 1", "clearAllColor"],
            &["setText 0 1 2", "clearAllText", "setText 2 0 1"],
        ]);
        insta::assert_snapshot!(shown, @r#"
        (0, 0) "12"; (1, 0) "a b"; (2, 1) Some(DarkGreen); (0, 0) north Some(Unknown); (0, 0) east Some(Unknown)

        (0, 0) ""; (1, 1) Some(Black); (2, 1) Some(Red)
        (1, 0) ""; (2, 0) "1"; (1, 1) None; (2, 1) None

        "#);
    }

    #[test]
    fn walls_that_the_state_cannot_express_are_declared() {
        let shown = blocks(&[
            // The walls of the start cell are not known.
            &[],
            // A wall that was read needs no declaration. The wall ahead is not known.
            &["wallRight", "moveForward"],
            // A wall between unvisited cells.
            &["clearWall 2 0 n", "setWall 1 0 e"],
            &["setWall 2 0 n", "wallRight"],
        ]);
        insta::assert_snapshot!(shown, @"
        (0, 0) north Some(Unknown); (0, 0) east Some(Unknown)
        (0, 0) north None; (0, 0) east None; (0, 1) east Some(Unknown)
        (2, 0) north Some(Absent)
        (2, 0) north None; (0, 1) east None
        ");
    }

    /// What a simulator knows after a number of annotations and states.
    #[derive(Default)]
    struct Receiver {
        texts: HashMap<Cell, String>,
        colours: HashMap<Cell, Colour>,
        walls: HashMap<(Cell, Heading), WallState>,
    }

    impl Receiver {
        fn apply(&mut self, annotation: Annotation<'_>) {
            match annotation {
                Annotation::Text { cell, text: "" } => drop(self.texts.remove(&cell)),
                Annotation::Text { cell, text } => drop(self.texts.insert(cell, text.into())),
                Annotation::Colour { cell, colour: None } => drop(self.colours.remove(&cell)),
                Annotation::Colour { cell, colour: Some(colour) } => {
                    self.colours.insert(cell, colour);
                }
                Annotation::Wall { cell, heading, state: None } => {
                    self.walls.remove(&(cell, heading)).expect("a declared wall");
                }
                Annotation::Wall { cell, heading, state: Some(state) } => {
                    self.walls.insert((cell, heading), state);
                }
                other => panic!("{other:?}"),
            }
        }

        /// Checks that the annotations and the state express what the mouse displays.
        fn check(&self, mouse: &SimulatedMouse) {
            let (size, map) = (mouse.map().size(), mouse.map());
            let mut message = [0; mmsim_protocol::MAX_STATE_BYTES];
            let encoded = MapState::new(mouse.pose(), map, |_| 0, Order::F).encode(&mut message);
            let decoded = State::decode(&message[..encoded.unwrap()], size).unwrap();
            let mut expressed = decoded.map(START, CellSet::EMPTY);
            for (&(cell, heading), &state) in &self.walls {
                assert_ne!(expressed.wall(cell, heading), state, "{cell} {heading}");
                expressed.set_wall(cell, heading, state);
            }
            assert_eq!(&expressed, map);
            for cell in size.cells() {
                let text = self.texts.get(&cell).map_or("", String::as_str);
                assert_eq!(text, mouse.display().text(cell).as_str(), "{cell}");
                let colour = self.colours.get(&cell).copied();
                assert_eq!(colour, mouse.display().colour(cell), "{cell}");
            }
        }
    }

    #[test]
    fn annotations_and_states_express_the_display() {
        let mut rng = WyRand::new(1);
        for _ in 0..200 {
            let size = MazeSize::new(1 + rng.index(5), 1 + rng.index(5)).unwrap();
            let mut rows = || std::array::from_fn(|_| rng.next_u32() & rng.next_u32());
            let mut walls = Walls::from_rows(size, rows(), rows());
            let (mut mouse, mut receiver) = (mouse(size), Receiver::default());
            let mut before = None;
            for _ in 0..60 {
                let [x, y] = [size.width(), size.height()].map(|side| rng.below(side.into()));
                let cell = format!("{x} {y}");
                let letter = ["n", "e", "s", "w"][rng.index(4)];
                let line = match rng.below(16) {
                    0 => format!("setWall {cell} {letter}"),
                    1 => format!("clearWall {cell} {letter}"),
                    2..=4 => format!("setText {cell} {}", rng.below(3)),
                    5 => format!("clearText {cell}"),
                    6 => "clearAllText".into(),
                    7 | 8 => format!("setColor {cell} {}", ["g", "k"][rng.index(2)]),
                    9 => "clearAllColor".into(),
                    10 => "wallLeft".into(),
                    11 => "wallFront 3".into(),
                    12 => "turnRight".into(),
                    13 => "turnLeft45".into(),
                    _ => "moveForward".into(),
                };
                execute(&mut mouse, &mut walls, &line);
                if rng.flip() {
                    for annotation in changes(before.as_ref(), &mouse) {
                        receiver.apply(annotation);
                    }
                    receiver.check(&mouse);
                    before = Some(mouse.clone());
                }
            }
        }
    }
}
