//! What the judge says about a run of the user's mouse.

use std::cell::RefCell;

use mmsim_fastrun::{Planner, Vehicle};
use mmsim_mouse::JudgedRun;
use mmsim_protocol::{Annotation, AnnotationWriter};
use mmsim_recording::Block;
use mmsim_run::{
    DRIVEN_RUN, Divergence, EndFacts, FastestRun, Judge, MouseClock, MovementRules, PhaseReport,
    Phases, RunIndex, SearchFigures, Verdict, parse_driven_run,
};
use mmsim_server::{Monitor, Served};

use super::RunArgs;
use crate::output::note;
use crate::phase_table;

/// Judges the current run of a simulation, or returns `None` if another maze was loaded after these phases.
pub(super) fn judge(monitor: &Monitor, phases: &Phases) -> Option<Judge> {
    let Served { run, maze, .. } = monitor.served().ok()?;
    let blocks = (0..).map_while(|index| monitor.block(run, index).ok()??.unpack());
    let judge = Judge::from_blocks(&maze, blocks, &[], false);
    (judge.phases().states > 0 || phases.states == 0).then_some(judge)
}

/// Returns the times of the run that the judge has seen, or `None` without states. Without a vehicle, the
/// default one of the maze times the run.
fn times(
    monitor: &Monitor,
    judge: &Judge,
    vehicle: Option<&Vehicle>,
) -> Option<(PhaseReport, FastestRun)> {
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
    Some((phases, fastest_run))
}

/// Logs how a run ended, so that its recording shows why the mouse failed.
fn log_end(monitor: &Monitor, facts: &EndFacts) {
    let (line, mut buffer) = (facts.to_log_line(), [0; 256]);
    let mut writer = AnnotationWriter::new(&mut buffer);
    if writer.push(Annotation::Log(&line)).is_ok()
        && let Some(request) = writer.finish()
    {
        // A server that has stopped records nothing.
        let _ = monitor.answer(None, request, 1);
    }
}

/// Prints what the judge says about a mouse that has moved to stderr.
pub(super) fn note_judged(judged: &JudgedRun) {
    if judged.phases.total.steps > 0 {
        phase_table::table(judged.phases.rows()).lines().for_each(note);
        note(&judged.fastest_run);
    }
}

/// Judges the runs of a mouse in a row, which show whether it is random.
pub(super) struct Judgements<'a> {
    args: &'a RunArgs,
    name: &'a str,
    /// The number of judged runs, and the figures of the first one.
    judged: RefCell<(u16, Option<SearchFigures>)>,
}

impl<'a> Judgements<'a> {
    pub(super) fn new(args: &'a RunArgs, name: &'a str) -> Self {
        Self { args, name, judged: RefCell::default() }
    }

    /// Returns what the judge says about a run that has ended, or `None` without states, and logs the end
    /// of a run without the goal.
    pub(super) fn add(
        &self,
        monitor: &Monitor,
        judge: &mut Judge,
        verdict: &Verdict,
        facts: &EndFacts,
    ) -> Option<JudgedRun> {
        let random = self.compare(judge, verdict);
        if !verdict.goal_reached {
            log_end(monitor, facts);
        }
        let vehicle = self.args.server.viewer.vehicle.first();
        let (phases, fastest_run) = times(monitor, judge, vehicle)?;
        Some(JudgedRun { phases, fastest_run, random })
    }

    /// Compares a run with the first one, and notes the result.
    fn compare(&self, judge: &mut Judge, verdict: &Verdict) -> Option<Divergence> {
        let (run, first) = &mut *self.judged.borrow_mut();
        *run = run.saturating_add(1);
        // Further runs may be those of a changed mouse.
        if *run > self.args.repeat {
            return None;
        }
        let figures = judge.figures().with_verdict(verdict.clone());
        let Some(first) = first else {
            *first = Some(figures);
            return None;
        };
        first.random = None;
        first.compare_repetition(*run, &figures);
        match first.random {
            Some(random) => note(format_args!("{} is random: {random}", self.name)),
            None => note(format_args!("runs 1 and {run} do not differ")),
        }
        first.random
    }
}
