//! Comparing bundled strategies over many mazes.

use std::num::NonZero;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use mmsim_formats::Catalogue;
use mmsim_maze::Maze;
use mmsim_solvers::BundledStrategy;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::connection::{Link, lock};
use crate::error::{Error, read_error, value_error};
use crate::figures::Figures;
use crate::geometry::limit;
use crate::maze::PyMaze;
use crate::signals;
use crate::simulator::Simulator;

/// Reads the mazes in a folder, and the messages for unreadable files.
#[pyfunction]
pub(crate) fn load_folder(py: Python<'_>, path: PathBuf) -> PyResult<(Vec<PyMaze>, Vec<String>)> {
    py.detach(|| {
        let catalogue = Catalogue::from_path(&path).map_err(|error| read_error(&error))?;
        let (mut mazes, mut errors) = (Vec::new(), Vec::new());
        for entry in catalogue.entries() {
            match entry.maze() {
                Ok(maze) => mazes.push(PyMaze { name: entry.name(), maze }),
                Err(error) => errors.push(error.to_string()),
            }
        }
        Ok((mazes, errors))
    })
}

/// Searches each maze with each strategy, in parallel, and returns a row for each search, maze by
/// maze.
#[pyfunction]
#[pyo3(signature = (mazes, strategies, max_states = None))]
pub(crate) fn compare_strategies<'py>(
    py: Python<'py>,
    mazes: Vec<Py<PyMaze>>,
    strategies: Vec<String>,
    max_states: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyList>> {
    let strategies = strategies.iter().map(|name| name.parse().map_err(value_error));
    let strategies: Vec<BundledStrategy> = strategies.collect::<PyResult<_>>()?;
    let searches: Vec<(&Maze, BundledStrategy)> = mazes
        .iter()
        .flat_map(|maze| strategies.iter().map(|&strategy| (&maze.get().maze, strategy)))
        .collect();
    let figures = search_all(py, &searches, limit(max_states)?)?;
    let rows = PyList::empty(py);
    let names = mazes.iter().flat_map(|maze| strategies.iter().map(move |&one| (maze, one)));
    for ((maze, strategy), figures) in names.zip(figures) {
        rows.append(row(py, maze.get(), strategy.name(), &figures)?)?;
    }
    Ok(rows)
}

/// Runs the searches on all processors. Checks for signals in the meantime.
fn search_all(
    py: Python<'_>,
    searches: &[(&Maze, BundledStrategy)],
    max_states: Option<u32>,
) -> PyResult<Vec<Figures>> {
    let is_cancelled = AtomicBool::new(false);
    let search = |&(maze, strategy): &(&Maze, BundledStrategy)| {
        let max_states = max_states.unwrap_or_else(|| strategy.max_states());
        Figures::search(maze, strategy, max_states, &is_cancelled)
    };
    let next = AtomicUsize::new(0);
    let work = |results: mpsc::Sender<_>| {
        while let Some((index, one)) = take(searches, &next) {
            // The receiver waits for all senders.
            let _ = results.send((index, search(one)));
        }
    };
    let (mut figures, interrupted) = py.detach(|| {
        thread::scope(|scope| {
            let (sender, results) = mpsc::channel();
            let threads = thread::available_parallelism().map_or(1, NonZero::get);
            for _ in 0..threads.min(searches.len()) {
                let (sender, work) = (sender.clone(), &work);
                // If the system cannot create a thread, the others do its work.
                let _ = thread::Builder::new().spawn_scoped(scope, move || work(sender));
            }
            drop(sender);
            let (mut found, mut interrupted, mut checked) = (Vec::new(), None, Instant::now());
            loop {
                match results.recv_timeout(signals::INTERVAL) {
                    Ok(result) => found.push(result),
                    Err(mpsc::RecvTimeoutError::Disconnected) => break (found, interrupted),
                    Err(mpsc::RecvTimeoutError::Timeout) => {}
                }
                if checked.elapsed() >= signals::INTERVAL && interrupted.is_none() {
                    checked = Instant::now();
                    if let Err(error) = signals::check() {
                        is_cancelled.store(true, Ordering::Relaxed);
                        interrupted = Some(error);
                    }
                }
            }
        })
    });
    if let Some(error) = interrupted {
        return Err(error);
    }
    figures.sort_unstable_by_key(|&(index, _)| index);
    let figures: Vec<_> = figures.into_iter().filter_map(|(_, figures)| figures).collect();
    if figures.len() < searches.len() {
        return Err(Error::new_err("a search has failed unexpectedly"));
    }
    Ok(figures)
}

/// Takes the next item and its index.
fn take<'a, T>(items: &'a [T], next: &AtomicUsize) -> Option<(usize, &'a T)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    items.get(index).map(|item| (index, item))
}

/// Creates the row for a search.
fn row<'py>(
    py: Python<'py>,
    PyMaze { name, maze }: &PyMaze,
    mouse: &str,
    figures: &Figures,
) -> PyResult<Bound<'py, PyDict>> {
    let row = PyDict::new(py);
    row.set_item("maze", name)?;
    row.set_item("mouse", mouse)?;
    row.set_item("width", maze.size().width())?;
    row.set_item("height", maze.size().height())?;
    figures.put(&row)?;
    Ok(row)
}

/// Returns the row for the states that a mouse has reported to a simulator.
#[pyfunction]
pub(crate) fn history_row<'py>(
    py: Python<'py>,
    simulator: &Bound<'py, Simulator>,
    mouse: &str,
    error: Option<String>,
    ending: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let maze = simulator.get().true_maze().get();
    let figures = match &simulator.as_super().get().link {
        Link::Process(simulated) => {
            let simulated = lock(simulated, py)?;
            let mut figures = Figures::from_history(&maze.maze, simulated.simulation.history());
            figures.error = error;
            figures
        }
        Link::Socket(_) => return Err(value_error("a client has no history")),
    };
    let row = row(py, maze, mouse, &figures)?;
    if let Some(ending) = ending {
        row.set_item("ending", ending)?;
    }
    Ok(row)
}
