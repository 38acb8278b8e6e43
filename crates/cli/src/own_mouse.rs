//! The user's own mouse, in a maze that this process serves.

use std::error::Error;
use std::ffi::OsString;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use mmsim_maze::Misreadings;
use mmsim_mouse::{MouseControl, OwnMouse, Pace, Program, RunEnd, Runs};
use mmsim_server::Monitor;
use mmsim_viewer::ViewerConfig;

use crate::args::{ServerArgs, UsageError, WATCHED_PACE_MS, parse_seconds};
use crate::local_server::{HOST, prepare};
use crate::output::note;
use crate::selection::{DEFAULT_MAZES, MAZE_HELP, Selection};

/// The help for `--port` of commands that run a mouse.
const PORT_HELP: &str = "\
    Port to listen on; 0 picks a free port [default: 6574, or a free port if 6574 is in use]";

/// The help for `--viewer-port` of commands that run a mouse.
const VIEWER_PORT_HELP: &str = "\
    Port of the viewer page; 0 picks a free port [default: 6575, or a free port if 6575 is in use]";

/// Options for running the user's mouse in a maze that this process serves.
#[derive(Debug, Args)]
#[command(mut_arg("port", |port| port.help(PORT_HELP)))]
#[command(mut_arg("viewer_port", |port| port.help(VIEWER_PORT_HELP)))]
pub(crate) struct OwnMouseArgs {
    /// Wait MS milliseconds after each state; the viewer page can change this [default: 50 with
    /// --open, else 0]
    #[arg(long, value_name = "MS")]
    pace: Option<u64>,
    /// Stop the mouse after S seconds, not counting pauses
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    time_limit: Option<Duration>,
    /// Stop the mouse when it reaches the goal
    #[arg(long)]
    stop_at_goal: bool,
    /// Run the mouse again each time its file changes; implies --stay
    #[arg(long)]
    watch: bool,
    /// Keep serving after the mouse exits, until Ctrl-C; implied by --open
    #[arg(long)]
    stay: bool,
    #[arg(long, value_name = "MAZE", help = format!("{MAZE_HELP} [default: {DEFAULT_MAZES}]"))]
    maze: Option<OsString>,
    #[command(flatten)]
    pub(crate) server: ServerArgs,
    /// Program to run as the mouse, and its arguments
    #[arg(last = true, required = true, value_name = "COMMAND")]
    command: Vec<OsString>,
}

impl OwnMouseArgs {
    /// Returns the program to run as the mouse.
    pub(crate) fn program(&self) -> Program {
        Program::new(&self.command)
    }

    /// Returns the control of the mouse. Returns a usage error of `command` if `--watch` is set and
    /// there is no file to watch.
    pub(crate) fn control(
        &self,
        command: &'static str,
        program: &Program,
        has_reset_button: bool,
    ) -> Result<Arc<MouseControl>, UsageError> {
        if self.watch && program.file.is_none() {
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
        let control = MouseControl::new(self.pace(), Some(own))
            .with_time_limit(self.time_limit)
            .with_stop_at_goal(self.stop_at_goal);
        Ok(Arc::new(control))
    }

    /// Returns the initial pace. If the page opens in a browser, the default is slow enough to
    /// watch.
    fn pace(&self) -> Pace {
        let default = if self.server.viewer.open { WATCHED_PACE_MS } else { 0 };
        Pace::from_interval(Duration::from_millis(self.pace.unwrap_or(default)))
    }

    /// Serves the selected maze and runs the mouse there. Clients connect to `address`, or to the
    /// address of the server, and have these misreadings. `begin` returns the function that runs the
    /// mouse once. Returns the exit code.
    pub(crate) fn serve<R: FnMut() -> Result<RunEnd, Box<dyn Error>>>(
        &self,
        program: &Program,
        control: &Arc<MouseControl>,
        port: Option<u16>,
        address: Option<&str>,
        misreadings: Misreadings,
        begin: impl FnOnce(Monitor) -> Result<R, Box<dyn Error>>,
    ) -> Result<i32, Box<dyn Error>> {
        let ServerArgs { retention, viewer, .. } = &self.server;
        let selection = Selection::read(self.maze.as_deref().unwrap_or_default())?;
        let selected = selection.first()?;
        let config = ViewerConfig::default().with_mazes(selection.catalogue);
        let mouse = Some((Arc::clone(control), address.map(String::from)));
        let (port, page) = ((HOST, port), Some(viewer));
        let ready = prepare(selected, misreadings, config, port, retention, page, mouse)?;
        let monitor = ready.server.monitor();
        let server = ready.server.spawn(ready.simulation);
        let closing = Arc::clone(control);
        ready.interrupt.then(move || closing.close());
        let run_once = begin(monitor.clone())?;
        let runs = Runs {
            monitor: Some(&monitor),
            stays: self.stay || self.watch || viewer.open,
            watched: program.file.as_deref().filter(|_| self.watch),
            has_page: !viewer.no_viewer,
            ..Runs::new(control, address.unwrap_or(server.address()), |text| note(text))
        };
        let code = runs.run(run_once)?;
        server.stop()?;
        Ok(code)
    }
}
