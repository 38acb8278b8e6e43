//! `mmsim trial --compare`: print tables that compare robots and their settings.

use std::io::{self, IsTerminal};

use mmsim_compare::{NamedMaze, RunContext, TrialTable, TrialTables};
use mmsim_maze::counted;

use super::args::TrialArgs;
use crate::args::CommandResult;
use crate::grid::stacked;
use crate::interrupt::StopFlag;
use crate::output::{note, print, print_pretty_json, replace, write_charts};
use crate::searches::explain_shortage;

/// Runs all trials and prints the tables. Robots without a score still appear in the tables and
/// do not count as errors.
pub(super) fn run(args: &TrialArgs, mazes: &[NamedMaze]) -> CommandResult {
    let tables = TrialTable::all(args.settings(), args.own_robots()?);
    let robots = TrialTables::robots(&tables);
    if io::stderr().is_terminal() {
        note(format_args!("running {}", counted(robots.len() * mazes.len(), "trial")));
    }
    let stop = StopFlag::catch_if(robots.iter().any(|robot| robot.is_own()))?;
    let context = RunContext { must_stop: stop.check(), shows_stderr: false };
    let trials = TrialTables::run(&tables, mazes, &context);
    stop.end();
    let Some(trials) = trials.map_err(|shortage| explain_shortage(&shortage))? else {
        return Ok(false);
    };
    if args.json {
        print_pretty_json(&trials.rows())?;
    } else if !mazes.is_empty() {
        let texts = tables.iter().map(|table| stacked(&trials.cells(table)));
        print(&texts.collect::<Vec<_>>().join("\n"))?;
    }
    // The last table contains all robots.
    let Some(robots) = tables.last().filter(|_| !mazes.is_empty()) else { return Ok(true) };
    if let Some(folder) = &args.charts {
        write_charts(folder, &trials.comparison(robots))?;
    }
    if let Some(file) = &args.html {
        replace(file, trials.html(robots).as_bytes())?;
    }
    Ok(true)
}
