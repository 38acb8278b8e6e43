//! The maze that `mmsim run` serves, and the runs of the mouse there.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use mmsim_compare::NamedMaze;
use mmsim_maze::Misreadings;
use mmsim_mouse::{MouseControl, MouseKind, Pace, Program, RunEnd, Runs};
use mmsim_server::Monitor;
use mmsim_viewer::ViewerConfig;

use super::{Kind, RunArgs};
use crate::args::{ServerArgs, WATCHED_PACE_MS};
use crate::local_server::{HOST, prepare};
use crate::output::note;
use crate::selection::Selection;

/// A mouse and the way in which it is served.
pub(super) struct Serving<'a> {
    pub(super) program: &'a Program,
    pub(super) control: &'a Arc<MouseControl>,
    /// How clients misread walls.
    pub(super) misreadings: Misreadings,
    /// True for a robot of the two-run trial.
    pub(super) is_trial: bool,
}

/// Returns the control of the mouse.
pub(super) fn control(args: &RunArgs, program: &Program) -> Arc<MouseControl> {
    // If the page opens in a browser, the default is slow enough to watch.
    let default = if args.server.viewer.open { WATCHED_PACE_MS } else { 0 };
    let pace = Pace::from_interval(Duration::from_millis(args.pace.unwrap_or(default)));
    let kind = match args.kind {
        Some(Kind::Mouse(kind)) => Some(kind),
        // Only a mouse for mms can search the maze of another simulator.
        _ => args.remote.connect.is_some().then_some(MouseKind::Mms),
    };
    let control = MouseControl::new(pace, Some(program.name.clone()))
        .with_kind(kind)
        .with_time_limit(args.time_limit)
        .with_stop_at_goal(args.stop_at_goal);
    Arc::new(control)
}

/// Serves the selected maze and runs the mouse there. Clients connect to `address`, or to the address of
/// the server. `begin` returns the function that runs the mouse once. Returns the exit code.
pub(super) fn serve<R: FnMut() -> Result<RunEnd, Box<dyn Error>>>(
    args: &RunArgs,
    &Serving { program, control, misreadings, is_trial }: &Serving<'_>,
    port: Option<u16>,
    address: Option<&str>,
    begin: impl FnOnce(Monitor, NamedMaze) -> Result<R, Box<dyn Error>>,
) -> Result<i32, Box<dyn Error>> {
    let ServerArgs { retention, viewer, .. } = &args.server;
    let selection = Selection::read(args.maze.as_deref().map(Path::as_os_str).unwrap_or_default())?;
    let selected = selection.first()?;
    let config = ViewerConfig::default();
    let config =
        if is_trial { config.with_trial() } else { config.with_mazes(selection.catalogue) };
    let mouse = Some((Arc::clone(control), address.map(String::from)));
    let (port, page) = ((HOST, port), Some(viewer));
    let ready = prepare(selected.clone(), misreadings, config, port, retention, page, mouse)?;
    let monitor = ready.server.monitor();
    let server = ready.server.spawn(ready.simulation);
    let closing = Arc::clone(control);
    ready.interrupt.then(move || closing.close());
    let run_once = begin(monitor.clone(), selected)?;
    let runs = Runs {
        monitor: Some(&monitor),
        repeat: args.repeat,
        stays: args.stay || args.watch || viewer.open,
        watched: program.file.as_deref().filter(|_| args.watch),
        has_page: !viewer.no_viewer,
        ..Runs::new(control, address.unwrap_or(server.address()), |text| note(text))
    };
    let code = runs.run(run_once)?;
    server.stop()?;
    Ok(code)
}
