//! Fast runs, which the page plays in time, and the vehicles that drive them.

use mmsim_fastrun::{
    FastRun, MotionState, NoRun, Planner, Route, Segment, Shape, Side, Trajectory, Vehicle,
};
use mmsim_maze::{CellSet, Maze, MazeSize, Unknown};
use mmsim_run::{DRIVEN_RUN, parse_driven_run};
use serde::Serialize;

use crate::http::jobs::{ApiError, ApiResult, CancelToken};
use crate::source::StateSource;

/// The presets, and vehicles of the user. The page selects the first given one, or the
/// [default](Vehicle::default_for) of the maze.
///
/// ```
/// use mmsim_fastrun::Vehicle;
/// use mmsim_viewer::Vehicles;
///
/// let mine = Vehicle::from_toml("base = 'expert'\nturns.l90.speed = 1500", "mine")?;
/// let vehicles = Vehicles::new([mine])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Vehicles {
    pub(crate) all: Vec<Vehicle>,
    first: Option<Vehicle>,
}

/// The error for two different vehicles with the same name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("two vehicles are called {0:?}; set another name in a file")]
pub struct SameName(pub String);

impl Vehicles {
    /// Adds vehicles to the presets.
    ///
    /// # Errors
    /// Returns an error if two different vehicles, including the presets, have the same name.
    pub fn new(own: impl IntoIterator<Item = Vehicle>) -> Result<Self, SameName> {
        let mut vehicles = Self::default();
        for vehicle in own {
            vehicles.first.get_or_insert_with(|| vehicle.clone());
            match vehicles.get(vehicle.name()) {
                None => vehicles.all.push(vehicle),
                Some(other) if *other == vehicle => {}
                Some(_) => return Err(SameName(vehicle.name().into())),
            }
        }
        Ok(vehicles)
    }

    /// Returns a single vehicle.
    pub(crate) fn only(vehicle: Vehicle) -> Self {
        Self { first: Some(vehicle.clone()), all: vec![vehicle] }
    }

    /// Returns the vehicle that the page selects for a maze of this size.
    pub(crate) fn selected(&self, size: MazeSize) -> Vehicle {
        self.first.clone().unwrap_or_else(|| Vehicle::default_for(size))
    }

    /// Returns the names of all vehicles.
    pub(crate) fn names(&self) -> Vec<String> {
        self.all.iter().map(|vehicle| vehicle.name().into()).collect()
    }

    fn get(&self, name: &str) -> Option<&Vehicle> {
        self.all.iter().find(|vehicle| vehicle.name() == name)
    }

    /// Returns the vehicle with this name.
    pub(crate) fn find(&self, name: &str) -> ApiResult<Vehicle> {
        self.get(name).cloned().ok_or_else(|| {
            let names = self.names().join(", ");
            ApiError::not_found(format!("no vehicle has the name {name:?} (expected {names})"))
        })
    }
}

impl Default for Vehicles {
    fn default() -> Self {
        let all = Vehicle::PRESETS.into_iter().filter_map(Vehicle::preset).collect();
        Self { all, first: None }
    }
}

/// The run along one route, or the reason why there is none. Lengths are in mm, times in s and
/// angles in radians, rounded to millionths.
#[derive(Serialize)]
pub(crate) struct RouteRun {
    /// `fastest`, `known-walls`, `driven` or the name of a [`Route`].
    route: &'static str,
    timed_run: Option<TimedRun>,
    error: Option<String>,
}

/// A fast run in time.
#[derive(Serialize)]
struct TimedRun {
    /// The run as text, as described for [`FastRun`].
    moves: String,
    /// The time from rest to rest.
    time_s: f64,
    /// The time from leaving the start cell to entering a goal cell.
    gate_to_gate_s: f64,
    length_mm: f64,
    /// The number of cells that the run enters.
    cell_count: usize,
    slalom_turns: usize,
    top_speed_mm_s: f64,
    /// The position at the beginning, from the south-west corner of the maze.
    x_mm: f64,
    y_mm: f64,
    /// Half the distance between the centres of two neighbouring cells.
    half_cell_mm: f64,
    segments: Vec<SegmentView>,
}

/// A straight or a turn.
#[derive(Serialize)]
struct SegmentView {
    /// The name of the turn, such as `45inR`, or `None` for a straight.
    turn: Option<String>,
    /// The angle of the turn, positive to the left, or 0 for a straight.
    angle_rad: f64,
    start_s: f64,
    distance_mm: f64,
    x_mm: f64,
    y_mm: f64,
    /// The heading at the beginning, counterclockwise from east.
    heading_rad: f64,
    /// The speed at the beginning.
    entry_speed_mm_s: f64,
    duration_s: f64,
    length_mm: f64,
    exit_speed_mm_s: f64,
    /// The duration, speed, acceleration and jerk of each part of a straight with constant jerk.
    pieces: Vec<[f64; 4]>,
}

/// Returns the runs that depend on the state with the index `at`: the fastest run over the walls that the
/// mouse knows and, if there is one, the latest fast run that the mouse has driven until then.
pub(crate) fn of_mouse(
    source: &StateSource,
    run: u32,
    at: usize,
    vehicle: &Vehicle,
    cancel: &CancelToken,
) -> ApiResult<Vec<RouteRun>> {
    let known = over_known_walls(source, run, at, vehicle)?;
    let goals = *source.describe(run)?.unexplored.goals();
    let driven = driven(source, run, at, cancel)?.map(|run| {
        // The vehicle chooses the speeds.
        let run =
            run.and_then(|run| run.with_fastest_speeds(vehicle).map_err(|error| error.to_string()));
        RouteRun::new("driven", run.as_ref().map_err(String::clone), vehicle, &goals)
    });
    Ok([Some(known)].into_iter().chain([driven]).flatten().collect())
}

/// Returns the latest fast run in the log of the mouse until the state with the index `at`, or the
/// reason why the line describes none.
pub(crate) fn driven(
    source: &StateSource,
    run: u32,
    at: usize,
    cancel: &CancelToken,
) -> ApiResult<Option<Result<FastRun, String>>> {
    let start = source.describe(run)?.unexplored.start().cell;
    let is_run = |line: &str| line.starts_with(DRIVEN_RUN);
    let line = source.driven_run(run, at, cancel, is_run)?;
    Ok(line.and_then(|line| parse_driven_run(&line.text, start)))
}

fn over_known_walls(
    source: &StateSource,
    run: u32,
    at: usize,
    vehicle: &Vehicle,
) -> ApiResult<RouteRun> {
    let states = source.block(run, at)?;
    let known = source.describe(run)?.decode(&states, at, &source.trailing(run, at)?)?.known;
    let (walls, start) = (known.walls(Unknown::Closed), known.start().cell);
    let mut planner = Planner::new(vehicle.clone());
    let unknown = |_| "The mouse does not know a path to the goal in this state.".to_string();
    let found = planner.plan(walls, start, known.goals()).map_err(unknown);
    Ok(RouteRun::new("known-walls", found, vehicle, known.goals()))
}

/// Returns the fastest run through a maze, and the runs along other routes.
pub(crate) fn in_maze(maze: &Maze, vehicle: &Vehicle) -> Vec<RouteRun> {
    let (walls, start, goals) = (maze.walls(), maze.start().cell, maze.goals());
    let mut planner = Planner::new(vehicle.clone());
    let run = |route, found: Result<&FastRun, NoRun>| {
        RouteRun::new(route, found.map_err(sentence), vehicle, goals)
    };
    let mut runs = vec![run("fastest", planner.plan(walls, start, goals))];
    for route in Route::ALL {
        runs.push(run(route.name(), planner.plan_route(route, walls, start, goals)));
    }
    runs
}

/// Returns an error as a sentence.
fn sentence(error: NoRun) -> String {
    let text = error.to_string();
    let mut characters = text.chars();
    let first = characters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(characters).chain(['.']).collect()
}

impl RouteRun {
    fn new(
        route: &'static str,
        found: Result<&FastRun, String>,
        vehicle: &Vehicle,
        goals: &CellSet,
    ) -> Self {
        let driven = found.and_then(|run| {
            let trajectory = run.drive(vehicle).map_err(|error| error.to_string())?;
            Ok(TimedRun::new(run, &trajectory, goals))
        });
        match driven {
            Ok(run) => Self { route, timed_run: Some(run), error: None },
            Err(error) => Self { route, timed_run: None, error: Some(error) },
        }
    }
}

impl TimedRun {
    fn new(run: &FastRun, trajectory: &Trajectory, goals: &CellSet) -> Self {
        let MotionState { x, y, .. } = trajectory.at(0.0);
        Self {
            moves: run.to_string(),
            time_s: rounded(trajectory.duration()),
            gate_to_gate_s: rounded(trajectory.gate_to_gate(goals)),
            length_mm: rounded(trajectory.length()),
            cell_count: run.cells().len() - 1,
            slalom_turns: run.turns().len(),
            top_speed_mm_s: rounded(trajectory.top_speed()),
            x_mm: rounded(x),
            y_mm: rounded(y),
            half_cell_mm: trajectory.half_cell(),
            segments: trajectory.segments().iter().map(SegmentView::new).collect(),
        }
    }
}

impl SegmentView {
    fn new(segment: &Segment) -> Self {
        let (turn, angle) = match segment.shape {
            Shape::Straight(_) => (None, 0.0),
            Shape::Turn(kind, side) => {
                let sign = if side == Side::Left { 1.0 } else { -1.0 };
                (Some(format!("{kind}{}", side.letter())), sign * kind.angle())
            }
        };
        let MotionState { time, distance, x, y, heading, speed, .. } = segment.entry;
        let pieces = segment.pieces.iter().map(|piece| {
            [piece.duration, piece.speed, piece.acceleration, piece.jerk].map(rounded)
        });
        Self {
            turn,
            angle_rad: angle,
            start_s: rounded(time),
            distance_mm: rounded(distance),
            x_mm: rounded(x),
            y_mm: rounded(y),
            heading_rad: heading,
            entry_speed_mm_s: rounded(speed),
            duration_s: rounded(segment.duration),
            length_mm: rounded(segment.length),
            exit_speed_mm_s: rounded(segment.exit_speed),
            pieces: pieces.collect(),
        }
    }
}

/// Rounds to millionths, to keep responses small.
fn rounded(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vehicles_have_different_names() {
        assert_eq!(Vehicles::default().selected(MazeSize::HALF_SIZE), Vehicle::kerise());
        let file =
            |name: &str| Vehicle::from_toml("turns.l90.speed = 1500\nbase = \"expert\"", name);
        let (mine, other) = (file("mine").unwrap(), file("expert").unwrap());
        let vehicles = Vehicles::new([Vehicle::ares(), mine.clone(), mine.clone()]).unwrap();
        assert_eq!(vehicles.names(), ["ukmars", "ares", "expert", "kerise", "mine"]);
        assert_eq!(vehicles.find("mine").unwrap(), mine);
        assert_eq!(vehicles.selected(MazeSize::HALF_SIZE), Vehicle::ares());
        let Err(error) = Vehicles::new([other]) else { panic!("expected an error") };
        assert_eq!(
            error.to_string(),
            r#"two vehicles are called "expert"; set another name in a file"#
        );
    }
}
