//! Rules of micromouse contests.

use clap::builder::PossibleValue;

/// Rules under which mice are scored, selected by name. docs/contest.md names the sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RuleSet {
    BestRun,
    Apec,
    Uk,
}

/// The numbers of a rule set. The score of a run is its time, plus a share of the time before the
/// run, plus a penalty if the mouse was touched before the run. The best run counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rules {
    /// The time for all runs, in s.
    pub(crate) time_limit: f64,
    /// The maximum number of runs, including the search run, or `None` if only the time is limited.
    pub(crate) max_runs: Option<u32>,
    /// The share of the time before a run that is added to its time.
    pub(crate) search_share: f64,
    /// The time added to each run after a touch, in s.
    pub(crate) touch_penalty: f64,
}

impl RuleSet {
    pub(crate) const ALL: [Self; 3] = [Self::BestRun, Self::Apec, Self::Uk];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::BestRun => "best-run",
            Self::Apec => "apec",
            Self::Uk => "uk",
        }
    }

    /// Returns the rules with their default limits.
    pub(crate) const fn rules(self) -> Rules {
        match self {
            Self::BestRun => Rules {
                time_limit: 300.0,
                max_runs: Some(5),
                search_share: 0.0,
                touch_penalty: 0.0,
            },
            Self::Apec => Rules {
                time_limit: 420.0,
                max_runs: Some(5),
                search_share: 1.0 / 30.0,
                touch_penalty: 2.0,
            },
            Self::Uk => Rules {
                time_limit: 600.0,
                max_runs: None,
                search_share: 1.0 / 30.0,
                touch_penalty: 3.0,
            },
        }
    }

    /// Returns the value for the command line.
    pub(crate) fn value(self) -> PossibleValue {
        PossibleValue::new(self.name()).help(match self {
            Self::BestRun => "the time of the best of 5 runs in 300 s, as in Japan",
            Self::Apec => {
                "best of 5 runs in 420 s; 1/30 of the time before a run, and 2 s after a touch, are \
                 added to its time"
            }
            Self::Uk => {
                "best run in 600 s; 1/30 of the time before a run, and 3 s after a touch, are added \
                 to its time"
            }
        })
    }
}

impl Rules {
    /// Returns the score of a run in s.
    pub(crate) fn score(&self, time: f64, time_before: f64, is_touched: bool) -> f64 {
        let penalty = if is_touched { self.touch_penalty } else { 0.0 };
        time + time_before * self.search_share + penalty
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_add_search_time_and_penalty() {
        let score = |set: RuleSet, is_touched| set.rules().score(5.0, 60.0, is_touched);
        let close =
            |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}");
        close(score(RuleSet::BestRun, true), 5.0);
        close(score(RuleSet::Apec, false), 7.0);
        close(score(RuleSet::Apec, true), 9.0);
        close(score(RuleSet::Uk, true), 10.0);
    }
}
