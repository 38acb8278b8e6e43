//! The user's own mouse, in a maze that this process serves.

use std::error::Error;
use std::sync::Arc;

use mmsim_mouse::{MouseControl, OwnMouse, Program, RunEnd, Runs};
use mmsim_server::Monitor;
use mmsim_viewer::ViewerConfig;

use crate::args::{MouseArgs, ServerArgs, UsageError, ViewerArgs};
use crate::local_server::{HOST, prepare};
use crate::output::note;
use crate::selection::Collection;

/// Returns the control of the mouse. Returns a usage error of `command` if `--watch` is set and there
/// is no file to watch.
pub(crate) fn control(
    command: &'static str,
    program: &Program,
    args: &MouseArgs,
    viewer: &ViewerArgs,
    has_reset_button: bool,
) -> Result<Arc<MouseControl>, UsageError> {
    if args.watch && program.file.is_none() {
        let message = match program.missing_file() {
            Some(file) => {
                format!("--watch: {} does not exist (build the mouse first)", file.display())
            }
            None => format!(
                "--watch: the command names no file to watch (example: mmsim {command} --watch -- python3 mouse.py)"
            ),
        };
        return Err(UsageError::new(command, message));
    }
    let own = OwnMouse { name: program.name.clone(), has_reset_button };
    let control = MouseControl::new(args.pace(viewer), Some(own)).with_time_limit(args.time_limit);
    Ok(Arc::new(control))
}

/// Serves the selected maze and runs the mouse there. Its clients use `address`, or the address of the
/// server. `begin` returns the function that runs the mouse once. Returns the exit code.
pub(crate) fn serve<R: FnMut() -> Result<RunEnd, Box<dyn Error>>>(
    (program, control): (&Program, &Arc<MouseControl>),
    (ServerArgs { mazes, words, retention, viewer, .. }, repeat): (&ServerArgs, &MouseArgs),
    (port, address): (Option<u16>, Option<String>),
    begin: impl FnOnce(Monitor) -> Result<R, Box<dyn Error>>,
) -> Result<i32, Box<dyn Error>> {
    let collection = Collection::at(mazes.as_deref())?;
    let selected = collection.select(&words.join(" "))?;
    let config = ViewerConfig::default().with_mazes(collection.catalogue);
    let mouse = Some((Arc::clone(control), address.clone()));
    let ready = prepare(selected, config, (HOST, port), retention, Some(viewer), mouse)?;
    let monitor = ready.server.monitor();
    let server = ready.server.spawn(ready.simulation);
    let closing = Arc::clone(control);
    ready.interrupt.then(move || closing.close());
    let run_once = begin(monitor.clone())?;
    let runs = Runs {
        monitor: Some(&monitor),
        stays: repeat.stays(viewer),
        watched: program.file.as_deref().filter(|_| repeat.watch),
        has_page: !viewer.no_viewer,
        ..Runs::new(control, address.as_deref().unwrap_or(server.address()), |text| note(text))
    };
    let code = runs.run(run_once)?;
    server.stop()?;
    Ok(code)
}
