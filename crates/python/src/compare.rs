//! Comparing mice and robots over many mazes.

use std::ffi::OsString;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use mmsim_compare::{
    ComparedMouse, Contest, Exploration, NamedMaze, NamedMouse, OwnRobot, RobotKind, RuleSet,
    RunContext, SearchRow, Searches, TrialRobot, TrialTable, TrialTables, measure_times,
    own_figures,
};
use mmsim_fastrun::{Planners, Vehicle};
use mmsim_formats::Catalogue;
use mmsim_maze::Misreadings;
use mmsim_mouse::{Program, SearchLimits};
use mmsim_run::{EndFacts, Ending, Judge, SearchFigures, Senses, Verdict};
use mmsim_solvers::Tolerance;
use mmsim_trial::Settings;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use serde::Serialize;

use crate::connection::lock;
use crate::convert::{limit, named, number, probability, to_python};
use crate::error::{io_error, read_error, value_error};
use crate::fast_run::vehicle;
use crate::maze::PyMaze;
use crate::signals;
use crate::simulator::PySimulator;

/// The limit of states of functions and programs. An endless search must end.
const MAX_STATES: u32 = 10_000;

/// Reads the mazes in a folder, and the messages for unreadable files.
#[pyfunction]
pub(crate) fn load_folder(py: Python<'_>, path: PathBuf) -> PyResult<(Vec<PyMaze>, Vec<String>)> {
    py.detach(|| {
        let catalogue = Catalogue::from_path(&path).map_err(|error| read_error(&error))?;
        let (mut mazes, mut errors) = (Vec::new(), Vec::new());
        for entry in catalogue.entries() {
            match PyMaze::from_entry(entry) {
                Ok(maze) => mazes.push(maze),
                Err(error) => errors.push(error.to_string()),
            }
        }
        Ok((mazes, errors))
    })
}

/// The arguments of `compare` and `contest`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Competition<'py> {
    mazes: Vec<Py<PyMaze>>,
    /// Names, and strategies, commands or functions.
    mice: Vec<(String, Bound<'py, PyAny>)>,
    max_states: Option<Bound<'py, PyAny>>,
    vehicle: Option<String>,
    time_limit: f64,
    misread: f64,
    misread_fixed: bool,
    misread_seed: Bound<'py, PyAny>,
    recover: bool,
    stop_at_goal: bool,
}

/// The row of a search.
#[derive(Serialize)]
struct MouseSearchRow<'a> {
    mouse: &'a str,
    #[serde(flatten)]
    search: SearchRow,
}

/// Runs each mouse in each maze, and returns a row for each search, maze by maze. With the name of a
/// rule set, returns the results of a contest.
#[pyfunction]
#[pyo3(signature = (competition, rules = None))]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    competition: Competition<'py>,
    rules: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let rules = rules.map(|name| named(&RuleSet::ALL, RuleSet::name, name)).transpose()?;
    let vehicle = competition.vehicle.as_deref().map(|text| vehicle(py, text)).transpose()?;
    let mazes: Vec<NamedMaze> = competition.mazes.iter().map(|maze| maze.get().named()).collect();
    let mut figures = competition.search(py, &mazes, vehicle.as_ref())?;
    let names: Vec<&String> = competition.mice.iter().map(|(name, _)| name).collect();
    if let Some(rules) = rules {
        let hold = |_: &_| Contest::new(&names, &mazes, &figures, vehicle.clone(), rules.rules());
        return to_python(py, &signals::interruptible(py, hold)?);
    }
    let planners = Planners::new(vehicle);
    signals::interruptible(py, |_| measure_times(&mut figures, &mazes, &planners))?;
    let row = |(maze, mouse): (usize, usize)| {
        let search = SearchRow::new(&mazes[maze], figures[mouse][maze].clone());
        MouseSearchRow { mouse: names[mouse], search }
    };
    let indices =
        (0..mazes.len()).flat_map(|maze| (0..names.len()).map(move |mouse| (maze, mouse)));
    let rows: Vec<MouseSearchRow<'_>> = indices.map(row).collect();
    to_python(py, &rows)
}

impl Competition<'_> {
    /// Returns the figures of each mouse in each maze.
    fn search(
        &self,
        py: Python<'_>,
        mazes: &[NamedMaze],
        vehicle: Option<&Vehicle>,
    ) -> PyResult<Vec<Vec<SearchFigures>>> {
        let max_states = limit(self.max_states.as_ref())?;
        let time = seconds(self.time_limit)?;
        let states = max_states.unwrap_or(MAX_STATES);
        let limits = SearchLimits { time, states, stops_at_goal: self.stop_at_goal };
        let texts =
            self.mice.iter().filter_map(|(name, mouse)| Some((&**name, mouse.extract().ok()?)));
        let mice = texts.map(|named| mouse(py, named)).collect::<PyResult<Vec<_>>>()?;
        let exploration = Exploration::new(vehicle.cloned(), Tolerance::ZERO);
        let misreadings = Misreadings {
            probability: probability(self.misread)?,
            seed: number(&self.misread_seed)?,
            are_fixed: self.misread_fixed,
        };
        let senses = Senses { misreadings, recovers: self.recover };
        let searches =
            Searches { exploration: &exploration, senses, limits, max_states, jobs: None };
        let found = signals::interruptible(py, |must_stop| {
            searches.run(&mice, mazes, &|| {}, || must_stop.load(Ordering::Relaxed))
        })?
        .map_err(|shortage| io_error(io::ErrorKind::Other, shortage))?;
        let mut found = found.into_iter();
        let figures = self.mice.iter().map(|(_, mouse)| {
            if mouse.is_callable() {
                let run = |maze| run_function(py, mouse, maze, limits, misreadings);
                self.mazes.iter().map(run).collect()
            } else {
                Ok(found.next().unwrap_or_default())
            }
        });
        figures.collect()
    }
}

/// Returns a bundled strategy, or the program of a command.
fn mouse(py: Python<'_>, (name, text): (&str, String)) -> PyResult<ComparedMouse> {
    let strategy = text.parse().map(ComparedMouse::Bundled);
    strategy.or_else(|error| Ok(ComparedMouse::Own(program(py, name, &text, error)?)))
}

/// Returns the program of a command. A text of one word without a folder is a name, which is unknown.
fn program(py: Python<'_>, name: &str, text: &str, unknown: impl Display) -> PyResult<NamedMouse> {
    if !text.contains([' ', '/', '\\']) {
        return Err(value_error(unknown));
    }
    use_guard(py)?;
    let mouse = NamedMouse::new(name, text).map_err(value_error)?;
    match mouse.program.missing_file() {
        None => Ok(mouse),
        Some(file) => {
            let message = format!("{} does not exist", file.display());
            Err(io_error(io::ErrorKind::NotFound, message))
        }
    }
}

/// Lets the command that the wheel has installed end programs, even after this process was killed.
fn use_guard(py: Python<'_>) -> PyResult<()> {
    #[cfg(unix)]
    if let Some(command) =
        py.import("micromouse_sim.__main__")?.call_method0("command")?.extract()?
    {
        mmsim_mouse::use_guard(command);
    }
    Ok(())
}

fn seconds(seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds).map_err(value_error)
}

/// Runs a function, and returns the figures of the states that it has reported. Its exception becomes
/// the error.
fn run_function(
    py: Python<'_>,
    mouse: &Bound<'_, PyAny>,
    maze: &Py<PyMaze>,
    SearchLimits { states, stops_at_goal, .. }: SearchLimits,
    misreadings: Misreadings,
) -> PyResult<SearchFigures> {
    let initializer = PySimulator::initializer(maze.clone_ref(py), Some(states), misreadings);
    let simulator = Bound::new(py, initializer)?;
    let error = match mouse.call1((&simulator,)) {
        Err(error) if !error.is_instance_of::<PyException>(py) => return Err(error),
        result => result.err().map(|error| error.to_string()),
    };
    let simulated = lock(&simulator.get().simulated, py)?;
    let history = simulated.simulation.history();
    let mut judge =
        Judge::from_history(&maze.get().maze, history, &simulated.crashes, stops_at_goal);
    drop(simulated);
    let error = error.filter(|_| !(stops_at_goal && judge.phases().is_goal_reached()));
    let ending = match error {
        None => Ending::Finished,
        Some(_) if judge.phases().states >= states => Ending::StepLimit,
        Some(_) => Ending::Failed,
    };
    let cause = judge.cause(&EndFacts { ending, ..EndFacts::default() });
    let verdict = Verdict::new(judge.phases(), ending, error, cause);
    let figures = own_figures(&mut judge, verdict);
    Ok(SearchFigures {
        crashes: figures.crashes.filter(|_| misreadings.probability > 0.0),
        ..figures
    })
}

/// Returns the robot in a file with the published interface, which is followed by words of its command
/// line.
fn published(
    py: Python<'_>,
    (name, words): (String, Vec<OsString>),
    python: Option<&OsString>,
    answer_limit: Duration,
) -> PyResult<OwnRobot> {
    use_guard(py)?;
    let Some((file, words)) = words.split_first() else {
        return Err(value_error(format_args!("{name}: expected a file")));
    };
    let file = Path::new(file);
    if !file.is_file() {
        let message = format!("{} is not a file", file.display());
        return Err(io_error(io::ErrorKind::NotFound, message));
    }
    let find = || Program::from_published_robot(file, words, python.map(OsString::as_os_str));
    let program = py.detach(find).map_err(|error| {
        let message = error.to_string().replace("--python EXE", "`python`");
        let message = format!("cannot run {}: {message}", file.display());
        io_error(io::ErrorKind::NotFound, message)
    })?;
    Ok(OwnRobot { name, program, answer_limit })
}

/// Runs each robot in each maze, and returns a row for each trial. Without robots, returns the rows of
/// `mmsim trial --compare`.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "those of the function in Python")]
pub(crate) fn trial(
    py: Python<'_>,
    mazes: Vec<Py<PyMaze>>,
    robots: Option<Vec<(String, String)>>,
    published_robots: Option<Vec<(String, Vec<OsString>)>>,
    python: Option<OsString>,
    seed: u64,
    noise: f64,
    answer_limit: f64,
) -> PyResult<Bound<'_, PyAny>> {
    let settings = Settings { seed, noise: probability(noise)?, ..Settings::default() };
    let answer_limit = seconds(answer_limit)?;
    let tables = match robots {
        None if published_robots.is_none() => TrialTable::all(settings, Vec::new()),
        robots => {
            let row = |(name, text): (String, String)| {
                let kind = text.parse().map(RobotKind::Bundled).or_else(|error| {
                    let NamedMouse { name, program, .. } = program(py, &name, &text, error)?;
                    PyResult::Ok(RobotKind::Own(OwnRobot { name, program, answer_limit }))
                })?;
                Ok((name, TrialRobot { kind, settings }))
            };
            let published = |(name, words): (String, Vec<OsString>)| {
                let robot = published(py, (name.clone(), words), python.as_ref(), answer_limit)?;
                Ok((name, TrialRobot { kind: RobotKind::Own(robot), settings }))
            };
            let own = published_robots.into_iter().flatten().map(published);
            let rows = robots.into_iter().flatten().map(row).chain(own);
            let rows = rows.collect::<PyResult<_>>()?;
            vec![TrialTable { rows, ..TrialTable::from_robots([]) }]
        }
    };
    let mazes: Vec<NamedMaze> = mazes.iter().map(|maze| maze.get().named()).collect();
    let trials = signals::interruptible(py, |flag| {
        let flag = Arc::clone(flag);
        let must_stop = Arc::new(move || flag.load(Ordering::Relaxed));
        TrialTables::run(&tables, &mazes, &RunContext { must_stop, shows_stderr: false })
    })?
    .map_err(|shortage| io_error(io::ErrorKind::Other, shortage))?;
    to_python(py, &trials.map(|trials| trials.rows()))
}
