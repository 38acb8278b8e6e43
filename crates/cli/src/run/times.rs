//! The times of a run of the user's mouse.

use mmsim_fastrun::{Planner, Vehicle};
use mmsim_mouse::RunTimes;
use mmsim_recording::Block;
use mmsim_run::{
    DRIVEN_RUN, FastestRun, Judge, MouseClock, MovementRules, PhaseReport, RunIndex,
    parse_driven_run,
};
use mmsim_server::{Monitor, Served};

use crate::output::note;
use crate::phase_table;

/// Returns the times of the current run of a simulation, or `None` without states. The judge has seen this
/// run. Without a vehicle, the default one of the maze times the run.
pub(super) fn of_run(
    monitor: &Monitor,
    judge: &Judge,
    vehicle: Option<&Vehicle>,
) -> Option<RunTimes> {
    let Served { run, maze, .. } = monitor.served().ok()?;
    let last = monitor.status().states.checked_sub(1)?;
    let block = |state: usize| {
        let block = monitor.block(run, state / Block::STATES).ok().flatten();
        block.and_then(Block::unpack).ok_or(())
    };
    let index = RunIndex::new(maze.size(), MovementRules::from_maze(&maze));
    let (phases, _) = index.at(last, block).ok()?;
    let default = || Vehicle::default_for(maze.size());
    let mut planner = Planner::new(vehicle.cloned().unwrap_or_else(default));
    let fastest_run = FastestRun::new(judge.known(), &mut planner);
    let is_driven = |line: &str| line.starts_with(DRIVEN_RUN);
    let trailing = monitor.trailing(run, last + 1).ok()?;
    let line = trailing.log_lines(last + 1).filter(|line| is_driven(&line.text)).last();
    let line = line.or_else(|| monitor.log(run, last, 1, is_driven).ok()?.pop());
    let driven = line.and_then(|line| parse_driven_run(&line.text, maze.start().cell)?.ok());
    let clock = MouseClock::new(&mut planner, maze.size()).with_driven(driven);
    let (times, cells) = (monitor.times(run).ok()?, |run| index.cells(run, block));
    let phases = PhaseReport::new(
        &phases,
        Some(clock),
        |run| cells(run).unwrap_or_default(),
        |first, last| times.seconds(first, last),
    );
    Some(RunTimes { phases, fastest_run })
}

/// Prints the times of a mouse that has moved to stderr.
pub(super) fn note_times(times: &RunTimes) {
    if times.phases.total.steps > 0 {
        phase_table::table(times.phases.rows()).lines().for_each(note);
        note(&times.fastest_run);
    }
}
