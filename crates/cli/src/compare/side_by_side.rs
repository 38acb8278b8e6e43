//! The searches of several mice in one maze, side by side on the viewer page.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;
use std::{env, fs, io};

use mmsim_compare::{
    ComparedMouse, MazeColumns, MouseSummary, NamedMaze, Ranking, SearchComparison,
};
use mmsim_maze::Escaped;
use mmsim_viewer::ViewerConfig;
use unicode_width::UnicodeWidthStr as _;

use super::CompareArgs;
use crate::args::{CommandResult, ReadingArgs, UsageError, ViewerArgs};
use crate::interrupt::Interrupt;
use crate::local_server::HOST;
use crate::output::{note, warn};
use crate::recordings::{self, recording_budget};
use crate::searches::DEFAULT_TIME_LIMIT;
use crate::terminal::columns;
use crate::{exit, page, stderr};

/// The time between two checks whether a recorded mouse has ended.
const POLL: Duration = Duration::from_millis(20);

/// Returns the command that shows a mouse beside its best rival: in the first maze that only the rival
/// solved, or else where the mouse lost most. Without a rival, the command shows the mouse alone in the
/// first maze that it did not solve. Returns `None` if there is no such maze.
pub(super) fn command(
    report: &SearchComparison,
    args: &CompareArgs,
    mouse: &MouseSummary,
) -> Option<String> {
    let Ranking { worst_mazes, unsolved_mazes, .. } = &mouse.ranking;
    let unsolved = unsolved_mazes.iter().map(|it| (&it.maze, &it.rival));
    let worst = worst_mazes.iter().map(|it| (&it.maze, &it.rival)).take(1);
    let beside = unsolved.clone().chain(worst).find(|(_, rival)| rival.is_some());
    let (maze, rival) = beside.or_else(|| unsolved.clone().next())?;
    let rival = report.mice.iter().find(|it| rival.as_ref() == Some(&it.mouse));
    let quoted = |text: &str| {
        // On Windows, a backslash separates folders, and only double quotation marks quote.
        let is_plain = !text.contains([' ', '"', '\'', '&', '%']);
        let quoted = match (cfg!(windows), is_plain) {
            (true, true) => text.into(),
            (true, false) => format!("\"{text}\"").into(),
            (false, _) => shlex::try_quote(text).ok()?,
        };
        Some(Escaped(quoted).to_string())
    };
    let MazeColumns { path, maze: name, .. } = maze;
    // A bundled maze has a short name.
    let maze = if Path::new(path).exists() { path } else { name };
    let mut parts = vec![format!("mmsim compare --open {}", quoted(maze)?)];
    let (mut strategies, mice) = (Vec::new(), [Some(mouse), rival]);
    let mice = || mice.iter().flatten();
    for mouse in mice() {
        match &mouse.command {
            None => strategies.push(&*mouse.mouse),
            Some(command) => {
                let mouse = format!("{}={command}", mouse.mouse);
                parts.push(format!("--mouse {}", quoted(&mouse)?));
            }
        }
    }
    let strategies = if strategies.is_empty() { "none".into() } else { strategies.join(",") };
    parts.push(format!("--strategies {strategies}"));
    if let Some(vehicle) = &args.vehicle {
        parts.push(format!("--vehicle {}", quoted(&vehicle.argument)?));
    }
    if let Some(tolerance) = args.search.tolerance {
        parts.push(format!("--tolerance {tolerance}"));
    }
    if mice().any(|mouse| mouse.command.is_some()) {
        let limit = args.search.time_limit.as_secs_f64().to_string();
        parts.extend((limit != DEFAULT_TIME_LIMIT).then(|| format!("--time-limit {limit}")));
        parts.extend(args.stop_at_goal.then(|| "--stop-at-goal".into()));
    }
    let line = format!("  {}", parts.join(" "));
    let fits = line.width() <= columns() || cfg!(windows);
    Some(if fits { line } else { format!("  {}", parts.join(" \\\n    ")) })
}

/// Runs each mouse in the maze, and shows the recordings in a browser until Ctrl-C.
pub(super) fn open(
    args: &CompareArgs,
    mice: &[ComparedMouse],
    mazes: &[NamedMaze],
) -> CommandResult {
    let [maze] = mazes else {
        return Err(UsageError::not_one("compare", "--open", "maze", mazes.len()).into());
    };
    // Otherwise, an interrupt would end the process and leave the folder.
    let interrupt = Interrupt::catch()?;
    let (folder, mut recorded) = (tempfile::tempdir()?, 0);
    let budget = recording_budget(&ReadingArgs::default());
    let mut config = ViewerConfig::default().with_budget(Arc::clone(&budget));
    for (index, mouse) in mice.iter().enumerate() {
        let recordings = folder.path().join(index.to_string());
        note(format_args!("recording {}", Escaped(mouse.name())));
        if !run(&mut recording(args, mouse, maze, &recordings)?, &interrupt)? {
            drop(folder);
            exit(Interrupt::CODE);
        }
        match first_recording(&recordings)? {
            Some(file) => {
                recorded += 1;
                config = config.with_recording(mouse.name(), recordings::open(&file, &budget)?);
            }
            None => warn(format_args!("{} has reported no state", Escaped(mouse.name()))),
        }
    }
    if recorded == 0 {
        return Err("there is nothing to show".into());
    }
    let vehicle = args.vehicle.iter().map(|given| given.vehicle.clone()).collect();
    let viewer_args =
        ViewerArgs { viewer_port: args.viewer_port, open: true, vehicle, ..ViewerArgs::default() };
    let viewer = page::bind(&viewer_args, HOST, true)?;
    stderr::write_in_background();
    page::serve(viewer, config, &viewer_args)?;
    interrupt.wait();
    Ok(true)
}

/// Returns the command `mmsim run` that runs a mouse in the maze and records it to the folder.
fn recording(
    args: &CompareArgs,
    mouse: &ComparedMouse,
    maze: &NamedMaze,
    folder: &Path,
) -> io::Result<Command> {
    let mmsim = env::current_exe()?;
    let mut command = Command::new(&mmsim);
    command.args(["run", "-q", "--no-viewer", "--port", "0", "--maze"]).arg(&maze.path);
    command.arg("--record").arg(folder);
    match mouse {
        ComparedMouse::Bundled(strategy) => {
            command.arg(&mmsim).args(["solve", strategy.name(), "--goal", "server"]);
            if strategy.uses_vehicle() {
                let vehicle = args.vehicle.iter().map(|given| &given.argument);
                command.args(vehicle.flat_map(|vehicle| ["--vehicle", vehicle]));
                let tolerance = args.search.tolerance.map(|tolerance| tolerance.to_string());
                command.args(tolerance.iter().flat_map(|tolerance| ["--tolerance", tolerance]));
            }
        }
        ComparedMouse::Own(mouse) => {
            let program = mouse.program.command();
            command.arg("--time-limit").arg(args.search.time_limit.as_secs_f64().to_string());
            command.args(args.stop_at_goal.then_some("--stop-at-goal"));
            command.arg(program.get_program()).args(program.get_args());
        }
    }
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    Ok(command)
}

/// Runs a command. Returns false if an interrupt has stopped it.
fn run(command: &mut Command, interrupt: &Interrupt) -> io::Result<bool> {
    let mut child = command.spawn()?;
    while child.try_wait()?.is_none() {
        if interrupt.wait_for(POLL) {
            child.kill()?;
            child.wait()?;
            return Ok(false);
        }
    }
    Ok(true)
}

/// Returns the recording of the first run in a folder, or `None` if the mouse has reported no state.
fn first_recording(folder: &Path) -> io::Result<Option<PathBuf>> {
    let files = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let files = files.collect::<io::Result<Vec<_>>>()?;
    Ok(files.into_iter().filter(|file| file.extension().is_some_and(|it| it == "mcap")).min())
}
