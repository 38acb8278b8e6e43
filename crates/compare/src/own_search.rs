//! The figures of one search by a mouse in another process.

use mmsim_maze::{Maze, counted};
use mmsim_mouse::{
    ENDPOINT_VARIABLE, MAX_INVALID_BYTES, MouseKind, Program, SearchEnd, SearchLimits,
    SearchReport, exit_text,
};
use mmsim_run::{Ending, Judge, SearchFigures, Verdict};

use crate::parallel::Slot;

/// Runs the mouse in the maze until it exits or reaches a limit. If the mouse needs no processor,
/// releases the slot, so that another search can use it.
pub(crate) fn search(
    program: &Program,
    maze: &Maze,
    limits: SearchLimits,
    slot: &mut Slot,
    must_stop: &dyn Fn() -> bool,
) -> SearchFigures {
    let mut report = mmsim_mouse::search(program, maze, limits, &mut || slot.release(), must_stop);
    let verdict = verdict(&report, limits);
    let figures = own_figures(&mut report.judge, verdict);
    SearchFigures {
        crashes: figures.crashes.filter(|_| report.kind != Some(MouseKind::Client)),
        // A program that does nothing does not know that the goal is unreachable.
        is_rightly_given_up: figures.is_rightly_given_up && report.kind.is_some(),
        ..figures
    }
}

/// Returns the figures of a mouse of the user from what a judge has seen of its search.
pub fn own_figures(judge: &mut Judge, verdict: Verdict) -> SearchFigures {
    let ending = verdict.ending;
    let figures = judge.figures().with_verdict(verdict);
    SearchFigures {
        is_rightly_given_up: figures.shortest_path.is_none() && ending == Ending::GaveUp,
        is_complete: figures.is_complete || ending == Ending::Finished,
        ..figures
    }
}

/// Returns the verdict on the mouse.
fn verdict(report: &SearchReport, limits: SearchLimits) -> Verdict {
    let SearchReport { judge, end, kind, fault } = report;
    let unheard =
        format!(" (it has neither written mms commands nor connected to {ENDPOINT_VARIABLE})");
    let unheard = if kind.is_none() { unheard } else { String::new() };
    let fault = fault.as_ref().filter(|_| !judge.phases().is_goal_reached());
    let hint = unheard + &fault.map(|fault| format!("; {fault}")).unwrap_or_default();
    let (ending, error) = match end {
        SearchEnd::Exited(status, line) if !status.success() => {
            let line = if line.is_empty() { hint } else { format!(": {line}") };
            (Ending::Failed, format!("{}{line}", exit_text(*status)))
        }
        SearchEnd::Exited(..) | SearchEnd::Idle => (Ending::Finished, hint),
        SearchEnd::TimeLimit => {
            let seconds = limits.time.as_secs_f64();
            (Ending::TimeLimit, format!("stopped after {seconds} s{hint}"))
        }
        SearchEnd::StepLimit => {
            let limit = counted(judge.phases().states, "state");
            (Ending::StepLimit, format!("stopped after {limit}"))
        }
        SearchEnd::Flood => {
            let limit = MAX_INVALID_BYTES >> 20;
            (Ending::Failed, format!("wrote {limit} MiB without a valid command{hint}"))
        }
        SearchEnd::Failed(reason) => (Ending::Failed, reason.clone()),
        SearchEnd::Interrupted => (Ending::Stopped, "interrupted".into()),
    };
    Verdict::new(judge.phases(), ending, Some(error))
}
