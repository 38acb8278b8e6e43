//! The report on a run of the user's own mouse.

use std::collections::BTreeMap;

use mmsim_fastrun::FastRun;
use mmsim_maze::counted;
use mmsim_mms::{ScoreRules, Scores, SimulatedMouse, TravelStats};
use mmsim_run::{
    Divergence, EndFacts, FastestRun, Judge, Messages, PhaseReport, Verdict, tenth_of_ms,
};
use serde::Serialize;

use crate::ENDPOINT_VARIABLE;
use crate::gateway::Progress;
use crate::kind::MouseKind;
use crate::process::{ExitCause, RunEnd, signal};

/// The report on a run, which is printed as JSON.
#[derive(Serialize)]
pub struct MouseReport<'m> {
    maze: Option<&'m str>,
    mouse: &'m str,
    /// `None` if the mouse was not recognized.
    kind: Option<MouseKind>,
    #[serde(flatten)]
    verdict: Verdict,
    states: u32,
    crashes: u64,
    /// The number of invalid lines or refused requests.
    refused_requests: u64,
    exit_code: Option<i32>,
    signal: Option<i32>,
    /// What the judge says about the run, unless the simulator is another process.
    #[serde(flatten)]
    judged: Option<JudgedRun>,
    /// The report on a mouse for mms.
    #[serde(flatten)]
    mms: Option<MmsReport>,
}

/// What the judge says about a run. The field names are JSON keys.
#[derive(Serialize)]
pub struct JudgedRun {
    /// The steps, turns and times of the phases.
    pub phases: PhaseReport,
    /// What the known walls prove about the fastest run.
    #[serde(flatten)]
    pub fastest_run: FastestRun,
    /// Where the run differs from the first one of several in a row.
    pub random: Option<Divergence>,
}

/// What is reported only on a mouse for mms.
#[derive(Serialize)]
struct MmsReport {
    /// The name of the chosen rules.
    scores: &'static str,
    #[serde(flatten)]
    chosen: ScoreReport,
    scores_by: BTreeMap<&'static str, ScoreReport>,
    visited_cells: usize,
    moves: Option<String>,
    fast_run_time_s: Option<f64>,
}

/// The scores by some rules.
#[derive(Serialize)]
struct ScoreReport {
    score: f64,
    best_run_distance: Option<f64>,
    best_run_effective_distance: Option<f64>,
    best_run_turns: Option<u64>,
    total_distance: f64,
    total_effective_distance: f64,
    total_turns: u64,
}

impl<'m> MouseReport<'m> {
    /// Returns the report on a run with these numbers of states, crashes, and invalid lines or refused
    /// requests.
    pub(crate) fn new(
        maze: Option<&'m str>,
        mouse: &'m str,
        kind: Option<MouseKind>,
        end: &RunEnd,
        cause: &ExitCause,
        (states, crashes, refused_requests): (u32, u64, u64),
    ) -> Self {
        let (exit_code, signal) = match cause {
            ExitCause::Exited(exit) => (exit.code(), signal(*exit)),
            _ => (None, None),
        };
        let verdict = end.outcome.verdict.clone();
        Self {
            maze,
            mouse,
            kind,
            verdict,
            states,
            crashes,
            refused_requests,
            exit_code,
            signal,
            judged: None,
            mms: None,
        }
    }

    /// Adds what the judge says.
    #[must_use]
    pub fn with_judged(self, judged: Option<JudgedRun>) -> Self {
        Self { judged, ..self }
    }

    /// Adds the scores of a mouse for mms, and the fast run that took the least time in s.
    pub(crate) fn with_scores(self, mouse: &SimulatedMouse, run: Option<&(FastRun, f64)>) -> Self {
        let by = |rules: ScoreRules| (rules.name(), ScoreReport::new(mouse.scores_by(rules)));
        let mms = MmsReport {
            scores: mouse.scores().rules().name(),
            chosen: ScoreReport::new(mouse.scores()),
            scores_by: ScoreRules::ALL.map(by).into(),
            visited_cells: mouse.map().visited().len(),
            moves: run.map(|(run, _)| run.to_string()),
            fast_run_time_s: run.map(|&(_, time)| tenth_of_ms(time)),
        };
        Self { mms: Some(mms), ..self }
    }
}

impl ScoreReport {
    fn new(scores: &Scores) -> Self {
        let (total, best) = (scores.total(), scores.best_run());
        Self {
            score: scores.score(),
            best_run_distance: best.map(TravelStats::distance),
            best_run_effective_distance: best.map(TravelStats::effective_distance),
            best_run_turns: best.map(TravelStats::turns),
            total_distance: total.distance(),
            total_effective_distance: total.effective_distance(),
            total_turns: total.turns(),
        }
    }
}

/// The end of a run of a mouse that is a client, or that was not recognized.
#[derive(Debug)]
pub struct ClientExit {
    /// The reason why the mouse is not running.
    pub cause: ExitCause,
    /// How the mouse communicates, if it was recognized.
    pub kind: Option<MouseKind>,
    /// What the mouse has sent and done.
    pub progress: Progress,
    /// The judge of the states since the last reset, if it is known.
    pub judge: Option<Judge>,
}

impl ClientExit {
    /// Returns how the run ended.
    pub fn facts(&self) -> EndFacts {
        let Progress { requests, is_refused, blocked, .. } = self.progress;
        let messages = (requests > 0).then_some(Messages::Requests(requests));
        self.cause.add_to(EndFacts { messages, is_refused, blocked, ..EndFacts::default() })
    }

    /// Returns the outcome for the viewer page and the exit code.
    pub fn end(&self) -> RunEnd {
        let Progress { requests, refused, crashes, phases, .. } = &self.progress;
        let details = match (requests, phases.states) {
            // The exit code says more than the hint.
            (0, _) if self.kind.is_none() && self.facts().exit.is_some() => {
                ", no command of mms and no request".into()
            }
            (0, _) if self.kind.is_none() => format!(
                ", no command of mms and no request (a mouse for mms writes commands to stdout, a \
                 client connects to {ENDPOINT_VARIABLE}, a robot needs --as robot)"
            ),
            (0, _) => format!(
                ", no request (does it connect to {ENDPOINT_VARIABLE}? if it is a mouse for mms, \
                 leave out --as client)"
            ),
            (_, 0) => ", no states reported".into(),
            (_, states) => format!(", {}", counted(states, "state")),
        };
        let count = |count, noun, end| match count {
            0 => String::new(),
            count => format!(", {}{end}", counted(count, noun)),
        };
        let crashes = count(*crashes, "crashed movement", "");
        let refused = count(*refused, "request", " refused");
        let details = details + &crashes + &refused;
        self.cause.end(phases, &details, self.judge.as_ref(), &self.facts())
    }

    /// Returns the report on the run. `maze` is the name of the maze.
    pub fn report<'m>(&self, maze: Option<&'m str>, mouse: &'m str) -> MouseReport<'m> {
        let Progress { refused, crashes, phases, .. } = &self.progress;
        let counts = (phases.states, *crashes, *refused);
        MouseReport::new(maze, mouse, self.kind, &self.end(), &self.cause, counts)
    }
}
