//! The times of a search and of the fast run after it.

use mmsim_fastrun::{FastRun, Planner, Route, Vehicle};
use mmsim_maze::{Cell, CellSet, Maze, MazeSize, Walls};
use serde::Serialize;

use crate::figures::{SearchFigures, SearchOutcome};

/// The start of a log line with a fast run that a mouse has driven, as text without speeds.
pub const DRIVEN_RUN: &str = "fast run: ";

/// Reads a log line with a fast run that a mouse has driven from `start` into a goal. Returns `None` for
/// other lines, and an error if the line describes no such run.
///
/// ```
/// use mmsim_maze::Cell;
/// use mmsim_run::parse_driven_run;
/// let start = Cell::new(0, 0);
/// let run = parse_driven_run("fast run: N 1 s90R 3", start).unwrap()?;
/// assert_eq!(run.goal(), Some(Cell::new(2, 1)));
/// assert!(parse_driven_run("ready", start).is_none());
/// # Ok::<(), String>(())
/// ```
pub fn parse_driven_run(line: &str, start: Cell) -> Option<Result<FastRun, String>> {
    let parsed = FastRun::parse(start, line.strip_prefix(DRIVEN_RUN)?);
    Some(parsed.map_err(|error| error.to_string()).and_then(|run| match run.goal() {
        Some(_) => Ok(run),
        None => Err("the run leaves the lattice".into()),
    }))
}

/// The times of a mouse with a vehicle. The field names are JSON keys and CSV column names. All
/// values except that of the search and the fastest run of the maze are `None` unless the mouse
/// reached the goal and completed its search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SearchTimes {
    /// The time of the search run and the return run, in s.
    pub search_time_s: f64,
    /// The time of the fast run from rest to rest, in s.
    pub fast_run_time_s: Option<f64>,
    /// How much longer the fast run takes than the fastest run of the true maze, in percent.
    pub fast_run_loss_percent: Option<f64>,
    /// The time until the end of the fast run, in s: of the search, the return to the start and the
    /// fast run.
    pub total_time_s: Option<f64>,
    /// The time of the fastest run through the known walls, in s.
    pub known_run_time_s: Option<f64>,
    /// The time of the fastest run of the true maze, in s, or `None` if the goal is unreachable.
    pub optimal_time_s: Option<f64>,
}

impl SearchTimes {
    /// Calculates the times of all mice in a maze with the vehicle of a planner.
    pub fn measure<'f>(
        planner: &mut Planner,
        maze: &Maze,
        searches: impl Iterator<Item = &'f SearchFigures>,
    ) -> Vec<Self> {
        let optimal = fastest(planner, maze, maze.walls());
        let times = searches.map(|figures| {
            let search_time =
                planner.vehicle().search_time(figures.search_steps, figures.search_turns);
            let at_start = time_at_start(maze, figures, planner.vehicle());
            let is_ready = figures.goal_reached && figures.is_complete;
            let outcome = Some(&figures.outcome).filter(|_| is_ready);
            let time = outcome.and_then(|outcome| {
                let run = plan(planner, maze, outcome)?;
                fast_run_time(planner, maze, outcome, &run)
            });
            let known_walls = outcome.and_then(|outcome| outcome.known_walls.as_ref());
            Self {
                search_time_s: tenth_of_ms(search_time),
                fast_run_time_s: time.map(tenth_of_ms),
                fast_run_loss_percent: time.zip(optimal).map(|(time, optimal)| loss(time, optimal)),
                total_time_s: time.map(|time| tenth_of_ms(at_start + time)),
                known_run_time_s: known_walls
                    .and_then(|walls| fastest(planner, maze, walls))
                    .map(tenth_of_ms),
                optimal_time_s: optimal.map(tenth_of_ms),
            }
        });
        times.collect()
    }

    /// Returns true if the fast run takes as little time as the fastest run of the true maze.
    pub fn is_optimal(&self) -> bool {
        self.fast_run_loss_percent == Some(0.0)
    }
}

/// The clock of a mouse: its search and return runs take the time of the vehicle's search speed and turns,
/// and its fast runs the least time in which the vehicle drives the same way.
///
/// ```
/// use mmsim_fastrun::{Planner, Vehicle};
/// use mmsim_maze::{Cell, MazeSize};
/// use mmsim_run::MouseClock;
/// let mut planner = Planner::new(Vehicle::expert());
/// let mut clock = MouseClock::new(&mut planner, MazeSize::CLASSIC);
/// // 3 cells of 180 mm at 600 mm/s, and a quarter turn of 0.2 s.
/// assert_eq!(clock.search_time(3, 1), 1.1);
/// // 810 mm with 17 m/s² and at most 2.5 m/s: 2.5 / 17 s + 810 mm / 2.5 m/s.
/// let cells: Vec<Cell> = (0..5).map(|y| Cell::new(0, y)).collect();
/// assert_eq!(clock.fast_run_time(&cells), Some(0.4711));
/// ```
pub struct MouseClock<'a> {
    planner: &'a mut Planner,
    size: MazeSize,
    driven: Option<FastRun>,
}

impl<'a> MouseClock<'a> {
    /// Creates the clock for the vehicle of a planner, in a maze of this size.
    pub const fn new(planner: &'a mut Planner, size: MazeSize) -> Self {
        Self { planner, size, driven: None }
    }

    /// Adds the latest fast run that the mouse has driven with slalom turns. It decides the time of runs
    /// through the same cells.
    #[must_use]
    pub fn with_driven(self, driven: Option<FastRun>) -> Self {
        Self { driven, ..self }
    }

    /// Returns the vehicle.
    pub const fn vehicle(&self) -> &Vehicle {
        self.planner.vehicle()
    }

    /// Returns the time in s of steps and quarter turns in a search or a return, rounded to 0.1 ms.
    pub fn search_time(&self, steps: u64, turns: u64) -> f64 {
        tenth_of_ms(self.vehicle().search_time(saturate(steps), saturate(turns)))
    }

    /// Returns the least time in s from rest to rest along the cells of a fast run, rounded to 0.1 ms, or
    /// `None` without cells, or if the vehicle cannot drive along them. The mouse stops and turns before it
    /// enters a cell again.
    pub fn fast_run_time(&mut self, cells: &[Cell]) -> Option<f64> {
        let driven = self.driven.as_ref().filter(|run| run.cells() == cells);
        let time = if let Some(run) = driven {
            let run = run.with_fastest_speeds(self.planner.vehicle()).ok()?;
            run.time(self.planner.vehicle()).ok()?
        } else {
            time_along(self.planner, self.size, cells)?
        };
        Some(tenth_of_ms(time))
    }
}

/// Returns the least time in s along cells, or `None` if the vehicle cannot drive along them. A fast run
/// enters no cell twice: before the mouse enters a cell again, it stops, turns, and begins another run.
fn time_along(planner: &mut Planner, size: MazeSize, cells: &[Cell]) -> Option<f64> {
    let (mut time, mut first) = (0.0, 0);
    loop {
        let mut entered = CellSet::EMPTY;
        let new = cells[first..].iter().take_while(|&&cell| entered.insert(cell));
        let last = first + new.count().checked_sub(1)?;
        let run = planner.plan_along(size, &cells[first..=last]).ok()?.clone();
        time += run.time(planner.vehicle()).ok()?;
        let Some(next) = cells.get(last + 1) else { return Some(time) };
        // The same cell twice is no movement.
        let before = cells.get(last.checked_sub(1)?)?;
        let turns = match (before.x == next.x, before.y == next.y) {
            (true, true) => 2,
            (false, false) => 1,
            _ => 0,
        };
        time += planner.vehicle().search_time(0, turns);
        first = last;
    }
}

/// Returns the time in s from rest to rest of the [planned](plan) fast run of a mouse, and of the detours
/// that its own fast run has made, or `None` if the vehicle cannot drive them.
pub fn fast_run_time(
    planner: &mut Planner,
    maze: &Maze,
    outcome: &SearchOutcome,
    run: &FastRun,
) -> Option<f64> {
    let SearchOutcome { route, driven, .. } = outcome;
    if driven.is_some() || route.is_empty() {
        return run.time(planner.vehicle()).ok();
    }
    time_along(planner, maze.size(), route)
}

/// Returns the time in s of the fastest run through walls.
fn fastest(planner: &mut Planner, maze: &Maze, walls: &Walls) -> Option<f64> {
    let run = planner.plan(walls, maze.start().cell, maze.goals()).ok()?.clone();
    run.time(planner.vehicle()).ok()
}

/// Returns the fast run of a mouse after its search: the one that it has driven with slalom turns,
/// else the fastest run along the cells of its own fast run, else the fastest run through the walls
/// that it knows. Returns `None` if it knows no path, if a wall that it does not know blocks the run,
/// or if the vehicle cannot drive it.
pub fn plan(planner: &mut Planner, maze: &Maze, outcome: &SearchOutcome) -> Option<FastRun> {
    if let Some(driven) = &outcome.driven {
        return driven.with_fastest_speeds(planner.vehicle()).ok();
    }
    if !outcome.route.is_empty()
        && let Ok(run) = planner.plan_along(maze.size(), &outcome.route)
    {
        return Some(run.clone());
    }
    let walls = outcome.known_walls.as_ref()?;
    let run = planner.plan(walls, maze.start().cell, maze.goals()).ok()?;
    let is_blocked = |cells: &[Cell]| maze.walls().separate(cells[0], cells[1]);
    (!run.cells().windows(2).any(is_blocked)).then(|| run.clone())
}

/// Returns the time in s until a mouse is at the start, ready for its fast run. A mouse that ends its
/// search elsewhere is carried back, which takes as long as driving the shortest known path.
pub fn time_at_start(maze: &Maze, figures: &SearchFigures, vehicle: &Vehicle) -> f64 {
    let SearchOutcome { known_walls, last_cell, .. } = &figures.outcome;
    let path = known_walls.as_ref().zip(*last_cell).and_then(|(walls, cell)| {
        let there = [cell].into_iter().collect();
        Route::FewestCells.cells(walls, maze.start().cell, &there).ok()
    });
    let back = return_time(&path.unwrap_or_default(), vehicle);
    vehicle.search_time(figures.search_steps, figures.search_turns) + back
}

/// Returns the time in s that a mouse needs to drive back along a path at the speed of its search, with
/// a U-turn at each end.
pub fn return_time(path: &[Cell], vehicle: &Vehicle) -> f64 {
    let is_turn = |cells: &&[Cell]| cells[0].x != cells[2].x && cells[0].y != cells[2].y;
    let turns = path.windows(3).filter(is_turn).count() + 4;
    match path.len() {
        0 | 1 => 0.0,
        cells => vehicle.search_time(saturate(cells - 1), saturate(turns)),
    }
}

/// Returns a count, or the largest number if it does not fit.
pub(crate) fn saturate(count: impl TryInto<u32>) -> u32 {
    count.try_into().unwrap_or(u32::MAX)
}

/// Returns by how many percent a time is longer than that of the fastest run.
pub fn loss(time: f64, fastest: f64) -> f64 {
    // The planner may find either of two runs whose times differ by a few microseconds.
    let is_longer = time > fastest + 1e-5;
    if is_longer { (time / fastest - 1.0) * 100.0 } else { 0.0 }
}

/// Rounds a time in s to 0.1 ms.
pub fn tenth_of_ms(seconds: f64) -> f64 {
    (seconds * 1e4).round() / 1e4
}

#[cfg(test)]
pub(crate) mod tests {
    use mmsim_solvers::{FloodFill, ShortestPathSearch, Strategy};

    use super::*;
    use crate::search::{Senses, search};

    /// Returns `expert` with a search that takes 0.5 s for each cell and 0.25 s for each quarter turn.
    fn vehicle() -> Vehicle {
        let text = "base = 'expert'\nsearch_speed = 360\nsearch_turn_time = 0.25";
        Vehicle::from_toml(text, "slow").unwrap()
    }

    fn times(drawing: &str, strategy: impl Strategy, vehicle: Vehicle) -> SearchTimes {
        let maze: Maze = drawing.parse().unwrap();
        let figures = search(
            &maze,
            || strategy,
            1000,
            Senses::default(),
            || std::time::Duration::ZERO,
            || false,
        )
        .unwrap();
        SearchTimes::measure(&mut Planner::new(vehicle), &maze, [figures].iter())[0]
    }

    /// A straight of 180·cells + 90 mm with 17 m/s² and at most 2.5 m/s takes this time in s.
    fn straight(cells: f64) -> f64 {
        let distance = 180.0 * cells + 90.0;
        let ramps = 2500.0 * 2500.0 / 17_000.0;
        if distance < ramps {
            2.0 * (distance / 17_000.0).sqrt()
        } else {
            2.0 * 2500.0 / 17_000.0 + (distance - ramps) / 2500.0
        }
    }

    #[test]
    fn a_run_through_a_wall_that_the_mouse_does_not_know_is_no_run() {
        let maze: Maze = "o---o---o\n|     G |\no   o   o\n| S |   |\no---o---o\n".parse().unwrap();
        let known = |walls: Walls| SearchOutcome { known_walls: Some(walls), ..Default::default() };
        let mut misread = Walls::closed(maze.size());
        misread.set(maze.start().cell, mmsim_maze::Heading::East, false);
        misread.set(Cell::new(1, 0), mmsim_maze::Heading::North, false);
        let mut planner = Planner::new(Vehicle::expert());
        let mut cells = |outcome| plan(&mut planner, &maze, &outcome).map(|run| run.cells().len());
        assert_eq!([known(maze.walls().clone()), known(misread)].map(&mut cells), [Some(3), None]);
    }

    #[test]
    fn a_straight_has_the_time_of_the_formula() {
        let maze = "o---o---o---o---o\n| S           G |\no---o---o---o---o\n";
        // Three steps after a turn to the east, and three steps and two U-turns back.
        let times = times(maze, FloodFill::new(), vehicle());
        let expected = straight(3.0);
        assert!((times.search_time_s - 1.75).abs() < 1e-9);
        assert!((times.fast_run_time_s.unwrap() - expected).abs() < 1e-4);
        assert!((times.total_time_s.unwrap() - 1.75 - 2.5 - expected).abs() < 1e-4);
        assert_eq!(times.fast_run_loss_percent, Some(0.0));
        assert_eq!(times.known_run_time_s, times.optimal_time_s);
    }

    /// The path with the fewest steps has more turns than the fastest one.
    pub(crate) const DETOUR: &str = "\
o---o---o---o---o---o
|                   |
o   o---o---o---o   o
|       |       |   |
o   o   o   o   o   o
| S |       | G     |
o---o---o---o---o---o
";

    #[test]
    fn the_shortest_path_search_drives_its_own_path() {
        let maze: Maze = DETOUR.parse().unwrap();
        let times = times(DETOUR, ShortestPathSearch::new(), vehicle());
        let own = times.fast_run_time_s.unwrap();
        let mut planner = Planner::new(Vehicle::expert());
        let cells =
            Route::FewestCells.cells(maze.walls(), maze.start().cell, maze.goals()).unwrap();
        let along = planner.plan_along(maze.size(), &cells).unwrap().time(&Vehicle::expert());
        assert!((own - along.unwrap()).abs() < 1e-4);
        let optimal = times.optimal_time_s.unwrap();
        assert!(optimal <= times.known_run_time_s.unwrap() && optimal <= own);
        let loss = times.fast_run_loss_percent.unwrap();
        // The times are rounded to 0.1 ms.
        assert!((loss - (own / optimal - 1.0) * 100.0).abs() < 0.01);
    }

    #[test]
    fn there_is_no_fast_run_without_a_goal() {
        let times = times("o---o---o\n| S | G |\no---o---o\n", FloodFill::new(), vehicle());
        let expected = SearchTimes {
            search_time_s: 0.0,
            fast_run_time_s: None,
            fast_run_loss_percent: None,
            total_time_s: None,
            known_run_time_s: None,
            optimal_time_s: None,
        };
        assert_eq!(times, expected);
    }

    #[test]
    fn a_mouse_that_starts_in_the_goal_needs_no_time() {
        let times = times("o---o\n|SG |\no---o\n", ShortestPathSearch::new(), vehicle());
        assert_eq!((times.fast_run_time_s, times.total_time_s), (Some(0.0), Some(0.0)));
        assert_eq!(times.fast_run_loss_percent, Some(0.0));
    }

    #[test]
    fn a_path_back_has_a_u_turn_at_each_end() {
        let cells =
            |list: &[(u8, u8)]| list.iter().map(|&(x, y)| Cell::new(x, y)).collect::<Vec<_>>();
        let time = |list: &[(u8, u8)]| return_time(&cells(list), &vehicle());
        assert!(time(&[]) < 1e-12 && time(&[(3, 3)]) < 1e-12);
        assert!((time(&[(0, 0), (1, 0), (2, 0)]) - 2.0).abs() < 1e-12);
        assert!((time(&[(0, 0), (1, 0), (1, 1), (2, 1)]) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_half_size_mouse_searches_half_size_cells() {
        // A turn to the east, three steps, two U-turns in all, and three steps back: 6 steps, 3 turns.
        let maze = "o---o---o---o---o\n| S           G |\no---o---o---o---o\n";
        let time = |vehicle| times(maze, ShortestPathSearch::new(), vehicle).search_time_s;
        // 6 · 180 mm at 600 mm/s and 3 · 0.2 s.
        assert!((time(Vehicle::expert()) - 2.4).abs() < 1e-9);
        let half = "base = 'kerise'\nsearch_speed = 600\nsearch_turn_time = 0.2";
        // 6 · 90 mm at 600 mm/s and 3 · 0.2 s.
        assert!((time(Vehicle::from_toml(half, "half").unwrap()) - 1.5).abs() < 1e-9);
    }

    #[test]
    fn a_mouse_stops_before_it_enters_a_cell_again() {
        let mut planner = Planner::new(Vehicle::expert());
        let mut clock = MouseClock::new(&mut planner, MazeSize::CLASSIC);
        let mut time = |cells: &[(u8, u8)]| {
            let cells: Vec<Cell> = cells.iter().map(|&(x, y)| Cell::new(x, y)).collect();
            clock.fast_run_time(&cells)
        };
        assert_eq!(time(&[]), None);
        let corridor: Vec<(u8, u8)> = (0..4).map(|y| (0, y)).collect();
        assert_eq!(time(&corridor), Some(tenth_of_ms(straight(3.0))));
        // Two cells, a U-turn, one cell, a U-turn, and two cells.
        let back_and_forth = [0, 1, 2, 1, 2, 3].map(|y| (0, y));
        let expected = straight(2.0) + 0.4 + straight(1.0) + 0.4 + straight(2.0);
        assert_eq!(time(&back_and_forth), Some(tenth_of_ms(expected)));
        // A U-turn in a dead end to the east of a corridor.
        let dead_end = [(0, 0), (0, 1), (1, 1), (0, 1), (0, 2)];
        let pieces = time(&dead_end[..3]).unwrap() + 0.4 + time(&dead_end[2..]).unwrap();
        assert!((time(&dead_end).unwrap() - pieces).abs() < 3e-4);
        // A quarter turn before the end of a loop.
        let circle = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)];
        let pieces = time(&circle[..4]).unwrap() + 0.2 + time(&circle[3..]).unwrap();
        assert!((time(&circle).unwrap() - pieces).abs() < 3e-4);
    }
}
