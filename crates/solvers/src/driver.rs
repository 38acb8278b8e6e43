//! The search loop, which reads walls, asks the strategy for moves, and counts steps and turns.

use core::convert::Infallible;

use mmsim_maze::{Cell, Contradiction, Maze, Pose, Step, WallState, WallsAround};

use crate::mouse::{Crash, Mouse};
use crate::stats::SearchStats;
use crate::strategy::{Move, Phase, SearchError, Strategy};
use crate::wall_votes::WallVotes;

/// Drives a [`Mouse`] through a maze, one decision at a time, and counts its steps and turns.
///
/// A driver performs no I/O. The caller provides the walls around a pose, so the same loop works
/// with a maze in memory, a simulator or real sensors:
///
/// ```
/// use mmsim_maze::{KnownMaze, Maze, Pose, WallsAround};
/// use mmsim_solvers::{FloodFill, Mouse, SearchDriver};
///
/// let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse()?;
/// let read_sensors = |pose: Pose| -> Result<WallsAround, std::io::Error> {
///     Ok(maze.walls().around(pose))
/// };
/// let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(&maze), maze.start());
/// let mut driver = SearchDriver::new(&mut mouse, 1000);
/// while driver.advance(read_sensors)? {
///     println!("at {}", driver.mouse().pose());
/// }
/// assert_eq!((driver.stats().steps(), driver.stats().turns()), (4, 4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[must_use = "a driver does nothing until `advance` is called"]
pub struct SearchDriver<'m, S> {
    mouse: &'m mut Mouse<S>,
    /// The votes of a mouse that recovers from wrong readings.
    votes: Option<&'m mut WallVotes>,
    /// True until a mouse that recovers has driven the path of its fast run without a crash.
    is_wary: bool,
    max_states: u32,
    states: u32,
    /// The last decision, or `None` once the mouse has acted on it.
    decision: Option<Move>,
    /// The error of the last decision, stored separately so that `decision` takes only one byte.
    error: Option<SearchError>,
    phase: Phase,
    stats: SearchStats,
}

/// An error that ended a search. `E` is the error type of the wall sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriveError<E> {
    /// The walls could not be read.
    #[error(transparent)]
    Sensor(E),
    /// A sensor reading contradicts an earlier reading.
    #[error(transparent)]
    Contradiction(Contradiction),
    /// The strategy cannot continue.
    #[error(transparent)]
    Search(SearchError),
    /// The strategy chose a step through a side that is not known to be open, or a wall has blocked the
    /// mouse.
    #[error(transparent)]
    Crash(Crash),
}

/// The maximum number of readings around a pose, for a mouse that reads doubtful walls again.
const MAX_READINGS: u32 = 9;

impl<'m, S: Strategy> SearchDriver<'m, S> {
    /// Creates a driver that ends the search after `max_states` decisions.
    pub fn new(mouse: &'m mut Mouse<S>, max_states: u32) -> Self {
        let (phase, stats) = (Phase::SearchRun, SearchStats::default());
        Self {
            mouse,
            votes: None,
            is_wary: false,
            max_states,
            states: 0,
            decision: None,
            error: None,
            phase,
            stats,
        }
    }

    /// Lets the mouse recover from wrong readings, unless `votes` is `None`.
    ///
    /// - The majority of the readings of a wall counts. In each cell, the mouse reads the walls again
    ///   until the majority of each wall leads by two.
    /// - A wall that has blocked the mouse, and an opening that it has driven through, are certain.
    /// - If the goal is unreachable, the mouse tries to drive through the walls around the cells that it
    ///   can reach, those with the fewest readings first.
    /// - Before the fast run, the mouse drives its path once as part of the search, and returns to the
    ///   start.
    ///
    /// ```
    /// use mmsim_maze::{KnownMaze, Maze, Misreadings, WallSensor};
    /// use mmsim_solvers::{FloodFill, Mouse, SearchDriver, WallVotes};
    ///
    /// let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse()?;
    /// let misreadings = Misreadings { probability: 0.2, seed: 1, are_fixed: true };
    /// let (mut sensor, mut at) = (WallSensor::new(misreadings, &maze), maze.start().cell);
    /// let (map, mut votes) = (KnownMaze::unexplored(&maze), WallVotes::new());
    /// let mut mouse = Mouse::new(FloodFill::new(), map, maze.start());
    /// let mut driver = SearchDriver::new(&mut mouse, 100).recovering(Some(&mut votes));
    /// while driver.advance_unless_blocked(|pose| {
    ///     Ok::<_, std::io::Error>(sensor.around_from(maze.walls(), &mut at, pose))
    /// })? {}
    /// assert!(driver.stats().goal_reached());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn recovering(mut self, votes: Option<&'m mut WallVotes>) -> Self {
        self.is_wary = votes.is_some();
        self.votes = votes;
        self
    }

    /// Takes the step that the strategy chose in the previous call (if any). Then reads the walls
    /// around the mouse and asks the strategy for the next move. Returns `false` once the search is
    /// over.
    ///
    /// If the wall behind the mouse is unknown before the first decision, the driver also reads the
    /// walls for the opposite heading.
    ///
    /// # Errors
    /// Returns an error if the walls cannot be read, if they contradict earlier readings, or if the
    /// mouse would crash. If the strategy fails, the next call returns its error, so that the
    /// caller can first report the state in which the error occurred.
    #[inline]
    pub fn advance<E>(
        &mut self,
        mut read_walls: impl FnMut(Pose) -> Result<WallsAround, E>,
    ) -> Result<bool, DriveError<E>> {
        self.advance_unless_blocked(|pose| read_walls(pose).map(Some))
    }

    /// Does the same as [`advance`](Self::advance), but `read_walls` may return `None`: a wall has
    /// blocked the mouse on its way to this pose.
    ///
    /// # Errors
    /// Returns the same errors as [`advance`](Self::advance), and an error if a wall has blocked the
    /// mouse, unless it has moved, [recovers](Self::recovering) and is not on its fast run.
    #[inline]
    pub fn advance_unless_blocked<E>(
        &mut self,
        mut read_walls: impl FnMut(Pose) -> Result<Option<WallsAround>, E>,
    ) -> Result<bool, DriveError<E>> {
        if let Some(error) = self.error {
            return Err(DriveError::Search(error));
        }
        let step = match self.decision {
            Some(Move::Stop) => return Ok(false),
            Some(Move::Step(step)) => Some(step),
            None => None,
        };
        if self.states >= self.max_states {
            return Ok(false);
        }
        let from = self.mouse.pose().cell;
        let mut is_blocked = false;
        if let Some(step) = step {
            self.take(step).map_err(DriveError::Crash)?;
        } else if self.states == 0 && self.is_unknown_behind() {
            is_blocked = !self.see(self.mouse.turned_round(), &mut read_walls)?;
        }
        let pose = self.mouse.pose();
        if is_blocked || !self.see(pose, &mut read_walls)? {
            if step.is_none() {
                return Err(DriveError::Crash(self.mouse.bounce(from)));
            }
            self.crash(from).map_err(DriveError::Crash)?;
        } else if let (Some(votes), Some(_)) = (&mut self.votes, step) {
            votes.pass(from, pose.heading);
        }
        self.decide();
        Ok(true)
    }

    /// Does the same as [`advance`](Self::advance), but reads the walls from a maze in memory.
    ///
    /// # Errors
    /// Returns an error if the strategy cannot continue, if the mouse would crash, or if the
    /// mouse's map contradicts the maze.
    pub fn advance_in(&mut self, maze: &Maze) -> Result<bool, DriveError<Infallible>> {
        self.advance(|pose| Ok(maze.walls().around(pose)))
    }

    /// Returns the mouse.
    pub const fn mouse(&self) -> &Mouse<S> {
        self.mouse
    }

    /// Returns the last decision, or the error if the strategy could not decide. Returns `None`
    /// before the first decision and after a failed wall reading.
    pub fn decision(&self) -> Option<Result<Move, SearchError>> {
        self.error.map(Err).or(self.decision.map(Ok))
    }

    /// Returns the number of steps and turns in each phase.
    pub const fn stats(&self) -> &SearchStats {
        &self.stats
    }

    /// Returns the phase of the last decision. Once the fast run has begun, the phase no longer
    /// changes.
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    fn is_unknown_behind(&self) -> bool {
        let behind = self.mouse.turned_round();
        self.mouse.map().wall(behind.cell, behind.heading) == WallState::Unknown
    }

    fn take(&mut self, step: Step) -> Result<(), Crash> {
        self.mouse.go(step)?;
        self.decision = None;
        self.stats.count(self.phase, step);
        Ok(())
    }

    /// Reads the walls around a pose. Returns false if a wall has blocked the mouse.
    #[inline]
    fn see<E>(
        &mut self,
        pose: Pose,
        read_walls: &mut impl FnMut(Pose) -> Result<Option<WallsAround>, E>,
    ) -> Result<bool, DriveError<E>> {
        for _ in 0..MAX_READINGS {
            let around = read_walls(pose).map_err(DriveError::Sensor)?;
            let Some(around) = around else { return Ok(false) };
            let (map, strategy) = self.mouse.parts_mut();
            let Some(votes) = &mut self.votes else {
                map.observe(pose, around).map_err(DriveError::Contradiction)?;
                break;
            };
            let reading = votes.read(map, pose, around).map_err(DriveError::Contradiction)?;
            if reading.has_changed {
                strategy.reconsider();
            }
            if reading.is_clear {
                break;
            }
        }
        Ok(true)
    }

    /// Puts the mouse back into the cell that it has tried to leave. Returns an error if it does not
    /// recover.
    #[cold]
    fn crash(&mut self, from: Cell) -> Result<(), Crash> {
        let crash = self.mouse.bounce(from);
        self.stats.count_crash(self.phase);
        let (map, strategy) = self.mouse.parts_mut();
        map.set_wall(crash.cell, crash.heading, WallState::Present);
        match &mut self.votes {
            Some(votes) if self.phase != Phase::FastRun => {
                votes.touch(crash.cell, crash.heading);
                self.is_wary = true;
                strategy.reconsider();
                Ok(())
            }
            _ => Err(crash),
        }
    }

    /// Asks the strategy for the next move of a mouse that recovers, until its map allows one.
    fn decide_recovering(&mut self) -> Result<Move, SearchError> {
        let mut decision = self.mouse.decide();
        let Some(votes) = &mut self.votes else { return decision };
        let cell = self.mouse.pose().cell;
        loop {
            match decision {
                Err(SearchError::GoalUnreachable { .. } | SearchError::BoxedIn { .. })
                    if votes.doubt_barrier(self.mouse.parts_mut().0, cell) => {}
                Ok(Move::Stop) if self.is_wary && self.mouse.phase() == Phase::FastRun => {
                    self.is_wary = false;
                }
                _ => return decision,
            }
            self.mouse.parts_mut().1.reconsider();
            decision = self.mouse.decide();
        }
    }

    fn decide(&mut self) {
        match self.decide_recovering() {
            Ok(decision) => self.decision = Some(decision),
            Err(error) => self.error = Some(error),
        }
        self.states += 1;
        if self.phase != Phase::FastRun {
            self.phase = match self.mouse.phase() {
                Phase::FastRun if self.is_wary => Phase::ReturnRun,
                phase => phase,
            };
        }
        if self.mouse.map().goals().contains(self.mouse.pose().cell) {
            let steps = self.stats.steps();
            self.stats.steps_to_goal.get_or_insert(steps);
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, KnownMaze};

    use super::*;
    use crate::swing::Swing;

    const ROOM: &str = "o---o---o\n|     G |\no   o   o\n| S     |\no---o---o\n";
    const CORRIDOR: &str = "o---o\n| G |\no   o\n| S |\no   o\n|   |\no---o\n";

    /// A strategy that replays a list of decisions and phases.
    struct Script {
        decisions: Vec<(Result<Move, SearchError>, Phase)>,
        calls: usize,
    }

    impl Strategy for Script {
        fn next_move(&mut self, _: &KnownMaze, _: Pose) -> Result<Move, SearchError> {
            self.calls += 1;
            self.decisions[self.calls - 1].0
        }

        fn phase(&self) -> Phase {
            self.decisions[self.calls - 1].1
        }
    }

    fn mouse(
        maze: &Maze,
        decisions: impl IntoIterator<Item = (Result<Move, SearchError>, Phase)>,
    ) -> Mouse<Script> {
        let script = Script { decisions: decisions.into_iter().collect(), calls: 0 };
        Mouse::new(script, KnownMaze::unexplored(maze), maze.start())
    }

    fn search_run<const N: usize>(
        steps: [Step; N],
    ) -> impl Iterator<Item = (Result<Move, SearchError>, Phase)> {
        steps.into_iter().map(|step| (Ok(Move::Step(step)), Phase::SearchRun))
    }

    fn pose(x: u8, y: u8, heading: Heading) -> Pose {
        Pose::new(Cell::new(x, y), heading)
    }

    #[test]
    fn steps_and_turns_are_counted_in_the_phase_of_their_decision() {
        let maze: Maze = ROOM.parse().unwrap();
        let step = |step| Ok(Move::Step(step));
        let decisions = [
            (step(Step::Front), Phase::SearchRun),
            (step(Step::Right), Phase::SearchRun),
            (step(Step::Back), Phase::ReturnRun),
            (step(Step::Left), Phase::ReturnRun),
            (step(Step::Back), Phase::FastRun),
            (step(Step::Right), Phase::SearchRun),
            (Ok(Move::Stop), Phase::ReturnRun),
        ];
        let mut mouse = mouse(&maze, decisions);
        let mut driver = SearchDriver::new(&mut mouse, 1000);
        assert_eq!((driver.decision(), driver.phase()), (None, Phase::SearchRun));
        let expected = [
            (pose(0, 0, Heading::North), Phase::SearchRun, None),
            (pose(0, 1, Heading::North), Phase::SearchRun, None),
            (pose(1, 1, Heading::East), Phase::ReturnRun, Some(2)),
            (pose(0, 1, Heading::West), Phase::ReturnRun, Some(2)),
            (pose(0, 0, Heading::South), Phase::FastRun, Some(2)),
            (pose(0, 1, Heading::North), Phase::FastRun, Some(2)),
            (pose(1, 1, Heading::East), Phase::FastRun, Some(2)),
        ];
        for ((steps, (pose, phase, to_goal)), (decision, _)) in (0..).zip(expected).zip(decisions) {
            assert_eq!(driver.advance_in(&maze), Ok(true));
            assert_eq!((driver.mouse().pose(), driver.phase()), (pose, phase));
            assert_eq!(driver.decision(), Some(decision));
            assert_eq!((driver.stats().steps(), driver.stats().steps_to_goal), (steps, to_goal));
        }
        for _ in 0..2 {
            assert_eq!(driver.advance_in(&maze), Ok(false));
        }
        let stats = driver.stats();
        assert_eq!((stats.search_run.steps, stats.search_run.turns), (2, 1));
        assert_eq!((stats.return_run.steps, stats.return_run.turns), (2, 3));
        assert_eq!((stats.fast_run.steps, stats.fast_run.turns), (2, 3));
        assert_eq!(mouse.strategy().calls, 7);
    }

    #[test]
    fn a_search_ends_after_the_maximum_number_of_states() {
        let maze: Maze = ROOM.parse().unwrap();
        for max_states in 0..4 {
            let mut mouse = mouse(&maze, search_run([Step::Front, Step::Right, Step::Right]));
            let mut driver = SearchDriver::new(&mut mouse, max_states);
            for _ in 0..max_states {
                assert_eq!(driver.advance_in(&maze), Ok(true));
            }
            assert_eq!(driver.advance_in(&maze), Ok(false));
            assert_eq!(driver.stats().steps(), max_states.saturating_sub(1));
            assert_eq!(driver.decision().is_some(), max_states > 0);
            assert_eq!(mouse.strategy().calls, max_states as usize);
        }
    }

    #[test]
    fn the_wall_behind_is_read_only_at_the_start_and_only_if_unknown() {
        let readings = |text: &str, step| {
            let maze: Maze = text.parse().unwrap();
            let mut mouse = mouse(&maze, search_run([step, Step::Back]));
            let mut driver = SearchDriver::new(&mut mouse, 2);
            let mut readings = Vec::new();
            let mut read_walls = |pose| {
                readings.push(pose);
                Ok::<_, Infallible>(maze.walls().around(pose))
            };
            while driver.advance(&mut read_walls) == Ok(true) {}
            readings
        };
        let (north, south) = (Heading::North, Heading::South);
        let from_corner = [pose(0, 0, north), pose(0, 1, north)];
        assert_eq!(readings(ROOM, Step::Front), from_corner);
        let from_middle = [pose(0, 1, south), pose(0, 1, north), pose(0, 0, south)];
        assert_eq!(readings(CORRIDOR, Step::Back), from_middle);
    }

    #[test]
    fn a_failed_reading_can_be_repeated() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        let mut mouse = mouse(&maze, search_run([Step::Back, Step::Back, Step::Back]));
        let mut driver = SearchDriver::new(&mut mouse, 1000);
        let fails = |_| Err("no reading");
        let reads = |pose| Ok::<_, &str>(maze.walls().around(pose));
        assert_eq!(driver.advance(fails), Err(DriveError::Sensor("no reading")));
        assert_eq!(driver.decision(), None);
        assert_eq!(driver.advance(reads), Ok(true));
        assert_eq!(driver.advance(fails), Err(DriveError::Sensor("no reading")));
        assert_eq!((driver.decision(), driver.stats().steps()), (None, 1));
        assert_eq!(driver.advance(reads), Ok(true));
        assert_eq!(driver.stats().steps(), 1);
        assert_eq!(driver.mouse().pose(), pose(0, 0, Heading::South));
        assert_eq!(driver.advance(reads), Ok(true));
        assert_eq!(driver.mouse().pose(), pose(0, 1, Heading::North));
        assert_eq!((driver.stats().steps(), driver.stats().turns()), (2, 4));
    }

    #[test]
    fn contradictions_are_errors_in_both_directions_of_the_start() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        for fault in [pose(0, 1, Heading::South), pose(0, 1, Heading::North)] {
            let mut mouse = mouse(&maze, search_run([]));
            let mut driver = SearchDriver::new(&mut mouse, 1000);
            // There is no opening through the outer wall.
            let read_walls = |pose: Pose| {
                let around = maze.walls().around(pose);
                Ok::<_, Infallible>(WallsAround { left: around.left && pose != fault, ..around })
            };
            let Err(DriveError::Contradiction(found)) = driver.advance(read_walls) else {
                panic!("no contradiction at {fault:?}")
            };
            assert_eq!((found.cell, found.heading), (fault.cell, fault.heading.left()));
            assert!(!found.found);
        }
    }

    #[test]
    fn a_crash_leaves_the_mouse_where_it_is() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        let mut mouse = mouse(&maze, search_run([Step::Left]));
        let mut driver = SearchDriver::new(&mut mouse, 1000);
        assert_eq!(driver.advance_in(&maze), Ok(true));
        let Err(DriveError::Crash(crash)) = driver.advance_in(&maze) else { panic!("no crash") };
        assert_eq!((crash.cell, crash.heading), (Cell::new(0, 1), Heading::West));
        assert_eq!(crash.state, WallState::Present);
        assert_eq!((driver.mouse().pose(), driver.stats().steps()), (maze.start(), 0));
    }

    #[test]
    fn a_misread_wall_ends_the_search_of_a_mouse_that_does_not_recover() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        let (goal, start) = (Cell::new(0, 2), maze.start());
        let read_walls = |pose: Pose| {
            Ok::<_, Infallible>((pose.cell != goal).then(|| maze.walls().around(pose)))
        };
        let steps = [Step::Front, Step::Back, Step::Front];
        let mut mouse = mouse(&maze, search_run(steps));
        let mut driver = SearchDriver::new(&mut mouse, 1000);
        assert_eq!(driver.advance_unless_blocked(read_walls), Ok(true));
        let Err(DriveError::Crash(crash)) = driver.advance_unless_blocked(read_walls) else {
            panic!("no crash")
        };
        assert_eq!((crash.cell, crash.heading), (start.cell, Heading::North));
        assert_eq!(crash.state, WallState::Present);
        assert_eq!((driver.stats().steps(), driver.stats().crashes), (0, 1));

        let mut mouse = self::mouse(&maze, search_run(steps));
        let mut votes = WallVotes::new();
        let mut driver = SearchDriver::new(&mut mouse, 1000).recovering(Some(&mut votes));
        let found = [(); 3].map(|()| {
            assert_eq!(driver.advance_unless_blocked(read_walls), Ok(true));
            (driver.mouse().pose().cell, driver.stats().steps())
        });
        assert_eq!(found, [(start.cell, 0), (start.cell, 0), (Cell::new(0, 0), 1)]);
        assert_eq!((driver.stats().turns(), driver.stats().crashes), (2, 1));
        assert_eq!(mouse.map().wall(start.cell, Heading::North), WallState::Present);
    }

    #[test]
    fn a_mouse_that_recovers_drives_the_path_of_its_fast_run_once_before_it() {
        let maze: Maze = ROOM.parse().unwrap();
        let [trusting, wary] = [false, true].map(|recovers| {
            let mut mouse = Mouse::new(Swing::new(), KnownMaze::unexplored(&maze), maze.start());
            let mut votes = recovers.then(WallVotes::new);
            let mut driver = SearchDriver::new(&mut mouse, 1000).recovering(votes.as_mut());
            while driver.advance_in(&maze).unwrap() {}
            *driver.stats()
        });
        assert_eq!(wary.fast_run, trusting.fast_run);
        assert_eq!(wary.steps(), trusting.steps() + 2 * trusting.fast_run.steps);
    }

    #[test]
    fn a_mouse_that_has_not_moved_cannot_recover_from_a_crash() {
        let maze: Maze = CORRIDOR.parse().unwrap();
        for blocked in [Heading::South, Heading::North] {
            let mut mouse = mouse(&maze, search_run([]));
            let mut votes = WallVotes::new();
            let mut driver = SearchDriver::new(&mut mouse, 1000).recovering(Some(&mut votes));
            let read_walls = |pose: Pose| {
                Ok::<_, Infallible>((pose.heading != blocked).then(|| maze.walls().around(pose)))
            };
            let advanced = driver.advance_unless_blocked(read_walls);
            assert!(matches!(advanced, Err(DriveError::Crash(_))), "{advanced:?}");
            assert_eq!(driver.stats(), &SearchStats::default());
        }
    }

    #[test]
    fn an_error_of_the_strategy_is_returned_by_the_next_call_even_at_the_limit() {
        let maze: Maze = ROOM.parse().unwrap();
        let boxed_in = SearchError::BoxedIn { cell: Cell::new(0, 0) };
        let mut mouse = mouse(&maze, [(Err(boxed_in), Phase::ReturnRun)]);
        let mut driver = SearchDriver::new(&mut mouse, 1);
        assert_eq!(driver.advance_in(&maze), Ok(true));
        assert_eq!((driver.decision(), driver.phase()), (Some(Err(boxed_in)), Phase::ReturnRun));
        for _ in 0..2 {
            assert_eq!(driver.advance_in(&maze), Err(DriveError::Search(boxed_in)));
        }
    }

    #[test]
    fn a_mouse_that_starts_in_the_goal_takes_no_steps_to_it() {
        let maze: Maze = "o---o---o\n|SG     |\no---o---o\n".parse().unwrap();
        let mut mouse = mouse(&maze, search_run([Step::Right, Step::Back]));
        let mut driver = SearchDriver::new(&mut mouse, 2);
        while driver.advance_in(&maze) == Ok(true) {}
        assert_eq!((driver.stats().steps(), driver.stats().steps_to_goal), (1, Some(0)));
    }
}
