//! The attempt of a mouse in one maze: its search, its runs and its score.

use mmsim_fastrun::Planner;
use mmsim_maze::Maze;
use mmsim_run::{
    Ending, SearchFigures, fast_run_time, plan, return_time, tenth_of_ms, time_at_start,
};
use serde::Serialize;

use super::rules::Rules;

/// The maximum number of runs if the rules limit only the time.
const MAX_RUNS: u32 = 1000;

/// What determines the runs of a mouse: the times of its search and of its fast run, in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Performance {
    /// The time until the mouse first reaches the goal.
    search_run: Option<f64>,
    /// True if the mouse is touched before it first reaches the goal.
    is_touched_early: bool,
    /// The time until the mouse is back at the start.
    search: f64,
    /// True if the mouse is touched before its first fast run.
    is_touched: bool,
    fast_run: Option<FastRunTimes>,
}

/// The times of a fast run and of the return run after it, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FastRunTimes {
    gate_to_gate: f64,
    rest_to_rest: f64,
    return_run: f64,
}

/// The attempt of a mouse. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attempt {
    /// The score of the best run in s, or `None` if no run counts.
    pub score_s: Option<f64>,
    /// The time until the mouse is at the start for its first fast run, in s, or `None` if it never
    /// reaches the goal.
    pub search_time_s: Option<f64>,
    /// True if the mouse was touched before its first fast run.
    pub touched: bool,
    /// True if the mouse has reached the goal in its search.
    pub goal_reached: bool,
    /// How the search ended.
    pub ending: Ending,
    /// The reason why the mouse made no fast run.
    pub error: Option<String>,
    /// The runs in order.
    pub runs: Vec<ContestRun>,
}

/// A run from the start to the goal. The field names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContestRun {
    /// What the mouse does.
    pub kind: RunKind,
    /// The time of the contest at which the run begins, in s.
    pub start_s: f64,
    /// The time of the run as the contest measures it, in s.
    pub time_s: f64,
    /// The time from rest to rest, in s. `None` for the search run.
    pub rest_to_rest_s: Option<f64>,
    /// True if the mouse was touched before the end of the search run, or before a fast run.
    pub touched: bool,
    /// The score in s.
    pub score_s: f64,
}

/// What a mouse does on a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunKind {
    /// The first run, on which the mouse searches for the goal.
    Search,
    /// A run through known cells.
    Fast,
}

impl Attempt {
    /// Calculates the attempt of a mouse from its search.
    pub fn new(planner: &mut Planner, maze: &Maze, figures: &SearchFigures, rules: &Rules) -> Self {
        let performance = Performance::new(planner, maze, figures);
        let runs = performance.runs(rules);
        let has_fast_run = runs.iter().any(|run| run.kind == RunKind::Fast);
        let unfinished =
            || figures.unfinished().map(|error| format!("after reaching the goal: {error}"));
        let missing_run = || performance.missing_run(&runs, rules);
        let has_driven = figures.outcome.driven.is_some();
        let undrivable = || has_driven.then(|| "the vehicle cannot drive its slalom turns".into());
        let error = figures.failure().or_else(unfinished).or_else(missing_run).or_else(undrivable);
        let scores = runs.iter().map(|run| run.score_s);
        Self {
            score_s: scores.reduce(f64::min),
            search_time_s: performance.search_run.map(|_| tenth_of_ms(performance.search)),
            touched: performance.is_touched,
            goal_reached: figures.goal_reached,
            ending: figures.ending,
            error: error.filter(|_| !has_fast_run),
            runs,
        }
    }

    /// Returns the run that counts.
    pub fn best_run(&self) -> Option<&ContestRun> {
        self.runs.iter().min_by(|a, b| a.score_s.total_cmp(&b.score_s))
    }
}

impl Performance {
    fn new(planner: &mut Planner, maze: &Maze, figures: &SearchFigures) -> Self {
        let SearchFigures { steps_to_goal, outcome, .. } = figures;
        let start = maze.start().cell;
        let last_cell = outcome.last_cell.unwrap_or(start);
        let is_ready = figures.goal_reached && figures.is_complete;
        let run = if is_ready { plan(planner, maze, outcome) } else { None };
        let fast_run = run.and_then(|run| {
            let trajectory = run.drive(planner.vehicle()).ok()?;
            let rest_to_rest = fast_run_time(planner, maze, outcome, &run)?;
            let detours = rest_to_rest - trajectory.duration();
            Some(FastRunTimes {
                gate_to_gate: trajectory.gate_to_gate(maze.goals()) + detours,
                rest_to_rest,
                return_run: return_time(&run.cells(), planner.vehicle()),
            })
        });
        let vehicle = planner.vehicle();
        Self {
            search_run: steps_to_goal
                .map(|steps| vehicle.search_time(steps, outcome.turns_to_goal)),
            is_touched_early: outcome.touches_to_goal > 0,
            search: time_at_start(maze, figures, vehicle),
            is_touched: outcome.touches > 0 || last_cell != start,
            fast_run,
        }
    }

    /// Returns the runs that are complete within the time limit.
    fn runs(&self, rules: &Rules) -> Vec<ContestRun> {
        let mut runs = Vec::new();
        let mut clock = 0.0;
        let mut add = |kind, start: f64, time: f64, rest_to_rest: Option<f64>, touched| {
            runs.push(ContestRun {
                kind,
                start_s: tenth_of_ms(start),
                time_s: tenth_of_ms(time),
                rest_to_rest_s: rest_to_rest.map(tenth_of_ms),
                touched,
                score_s: tenth_of_ms(rules.score(time, start, touched)),
            });
            runs.len() < rules.max_runs.unwrap_or(MAX_RUNS) as usize
        };
        let Some(time) = self.search_run.filter(|time| *time <= rules.time_limit) else {
            return runs;
        };
        let mut may_continue = add(RunKind::Search, clock, time, None, self.is_touched_early);
        clock = self.search;
        while may_continue && let Some(fast) = self.fast_run {
            let end = clock + fast.rest_to_rest;
            if end > rules.time_limit {
                break;
            }
            let (time, rest_to_rest) = (fast.gate_to_gate, Some(fast.rest_to_rest));
            // A mouse that starts in the goal could run forever.
            may_continue = add(RunKind::Fast, clock, time, rest_to_rest, self.is_touched)
                && fast.rest_to_rest + fast.return_run > 0.0;
            clock = end + fast.return_run;
        }
        runs
    }

    /// Returns the reason why there is no fast run although the search succeeded.
    fn missing_run(&self, runs: &[ContestRun], rules: &Rules) -> Option<String> {
        let limit = rules.time_limit;
        match (self.search_run, self.fast_run) {
            (Some(time), _) if runs.is_empty() => {
                Some(format!("reaches the goal after {time:.1} s, the contest takes {limit} s"))
            }
            (_, Some(_)) if runs.len() == 1 && rules.max_runs != Some(1) => Some(format!(
                "no time for a fast run: back at the start after {:.1} s, the contest takes {limit} s",
                self.search
            )),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_fastrun::Vehicle;
    use mmsim_run::{Senses, search};
    use mmsim_solvers::{FloodFill, ShortestPathSearch, Strategy};

    use super::*;
    use crate::contest::rules::RuleSet;

    /// A mouse that reaches the goal after 30 s, is back at the start after 50 s, and then needs 10 s
    /// for a fast run and 20 s to return.
    const PERFORMANCE: Performance = Performance {
        search_run: Some(30.0),
        is_touched_early: false,
        search: 50.0,
        is_touched: false,
        fast_run: Some(FastRunTimes { gate_to_gate: 9.0, rest_to_rest: 10.0, return_run: 20.0 }),
    };

    fn scores(performance: Performance, rules: Rules) -> Vec<(f64, f64)> {
        performance.runs(&rules).iter().map(|run| (run.start_s, run.score_s)).collect()
    }

    #[test]
    fn the_best_of_five_runs_counts() {
        let rules = RuleSet::BestRun.rules();
        let expected = [(0.0, 30.0), (50.0, 9.0), (80.0, 9.0), (110.0, 9.0), (140.0, 9.0)];
        assert_eq!(scores(PERFORMANCE, rules), expected);
        assert_eq!(scores(PERFORMANCE, Rules { max_runs: Some(1), ..rules }), expected[..1]);
    }

    #[test]
    fn search_time_and_touches_cost_time() {
        let rules = Rules { max_runs: Some(3), ..RuleSet::Apec.rules() };
        let expected = [(0.0, 30.0), (50.0, 10.6667), (80.0, 11.6667)];
        assert_eq!(scores(PERFORMANCE, rules), expected);
        let touched = Performance { is_touched: true, ..PERFORMANCE };
        let expected = [(0.0, 30.0), (50.0, 12.6667), (80.0, 13.6667)];
        assert_eq!(scores(touched, rules), expected);
        let early = Performance { is_touched_early: true, ..touched };
        assert_eq!(scores(early, rules)[0], (0.0, 32.0));
    }

    #[test]
    fn runs_count_only_if_they_end_within_the_time_limit() {
        let runs = |time_limit| {
            let rules = Rules { time_limit, max_runs: None, ..RuleSet::BestRun.rules() };
            (
                scores(PERFORMANCE, rules).len(),
                PERFORMANCE.missing_run(&PERFORMANCE.runs(&rules), &rules),
            )
        };
        assert_eq!(runs(120.0), (4, None));
        assert_eq!(runs(119.0), (3, None));
        assert_eq!(runs(60.0), (2, None));
        let reason =
            "no time for a fast run: back at the start after 50.0 s, the contest takes 59 s";
        assert_eq!(runs(59.0), (1, Some(reason.into())));
        let reason = "reaches the goal after 30.0 s, the contest takes 29.5 s";
        assert_eq!(runs(29.5), (0, Some(reason.into())));
        let lost = Performance { search_run: None, fast_run: None, ..PERFORMANCE };
        assert_eq!(scores(lost, RuleSet::BestRun.rules()), []);
    }

    fn attempt(drawing: &str, strategy: impl Strategy, rules: RuleSet) -> Attempt {
        let maze: Maze = drawing.parse().unwrap();
        let figures = search(
            &maze,
            || strategy,
            1000,
            Senses::default(),
            || std::time::Duration::ZERO,
            || false,
        )
        .unwrap();
        // 1 s for each cell and 0.5 s for each quarter turn.
        let vehicle = "base = 'expert'\nsearch_speed = 180\nsearch_turn_time = 0.5";
        let mut planner = Planner::new(Vehicle::from_toml(vehicle, "slow").unwrap());
        Attempt::new(&mut planner, &maze, &figures, &rules.rules())
    }

    const CORRIDOR: &str = "o---o---o---o---o\n| S           G |\no---o---o---o---o\n";

    #[test]
    fn a_mouse_that_stops_in_the_goal_is_carried_back() {
        // One turn and 3 steps to the goal; then 3 steps and two U-turns back to the start.
        let attempt = attempt(CORRIDOR, FloodFill::new(), RuleSet::Apec);
        assert_eq!((attempt.search_time_s, attempt.touched), (Some(3.5 + 5.0), true));
        assert_eq!((attempt.runs.len(), attempt.runs[0].score_s), (5, 3.5));
        let ContestRun { start_s, time_s, rest_to_rest_s, score_s, .. } = attempt.runs[1];
        // The run is 630 mm long at 17 m/s² and 2.5 m/s. The gates are 135 mm from its ends.
        let rest_to_rest = 2.0 * 2500.0 / 17_000.0 + (630.0 - 2500.0 * 2500.0 / 17_000.0) / 2500.0;
        let gate_to_gate = rest_to_rest - 2.0 * (2.0 * 135.0_f64 / 17_000.0).sqrt();
        assert!((rest_to_rest_s.unwrap() - rest_to_rest).abs() < 1e-4);
        assert!((time_s - gate_to_gate).abs() < 1e-4);
        assert!((score_s - (time_s + 8.5 / 30.0 + 2.0)).abs() < 1.1e-4);
        assert!((start_s - 8.5).abs() < 1e-9);
        let again = attempt.runs[2].start_s;
        assert!((again - (8.5 + rest_to_rest + 5.0)).abs() < 1.1e-4);
        assert_eq!(attempt.score_s, Some(score_s.min(3.5)));
        assert_eq!(attempt.best_run(), Some(&attempt.runs[1]));
    }

    #[test]
    fn a_mouse_that_returns_is_not_touched() {
        let attempt = attempt(CORRIDOR, ShortestPathSearch::new(), RuleSet::Uk);
        assert!(!attempt.touched && attempt.runs.iter().all(|run| !run.touched));
        // One turn, 3 steps, a U-turn and 3 steps. The mouse turns in the start on its fast run.
        assert_eq!(attempt.search_time_s, Some(7.5));
    }

    #[test]
    fn a_mouse_that_never_reaches_the_goal_has_no_score() {
        let attempt = attempt("o---o---o\n| S | G |\no---o---o\n", FloodFill::new(), RuleSet::Uk);
        assert_eq!((attempt.score_s, attempt.search_time_s, attempt.runs.len()), (None, None, 0));
    }

    #[test]
    fn a_mouse_that_starts_in_the_goal_makes_one_fast_run() {
        let attempt = attempt("o---o\n|SG |\no---o\n", ShortestPathSearch::new(), RuleSet::Uk);
        assert_eq!((attempt.score_s, attempt.runs.len()), (Some(0.0), 2));
    }
}
