//! Rules of micromouse contests.

use serde::Serialize;

/// Rules under which mice are scored, selected by name. docs/contest.md names the sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RuleSet {
    /// The best of 5 runs in 300 s, as in Japan.
    BestRun,
    /// The rules of the APEC contest in the United States.
    Apec,
    /// The rules of contests in the United Kingdom.
    Uk,
}

/// A rule set and its numbers. The score of a run is its time, plus a share of the time before the
/// run, plus a penalty if the mouse was touched before the run. The best run counts. The field names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rules {
    /// The name of the rule set.
    #[serde(rename = "rules")]
    pub name: &'static str,
    /// The time for all runs, in s.
    #[serde(rename = "time_limit_s")]
    pub time_limit: f64,
    /// The maximum number of runs, including the search run, or `None` if only the time is limited.
    pub max_runs: Option<u32>,
    /// The share of the time before a run that is added to its time.
    pub search_share: f64,
    /// The time added to each run after a touch, in s.
    #[serde(rename = "touch_penalty_s")]
    pub touch_penalty: f64,
}

impl RuleSet {
    /// All rule sets.
    pub const ALL: [Self; 3] = [Self::BestRun, Self::Apec, Self::Uk];

    /// Returns the name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BestRun => "best-run",
            Self::Apec => "apec",
            Self::Uk => "uk",
        }
    }

    /// Returns the rules with their default limits.
    pub const fn rules(self) -> Rules {
        let (time_limit, max_runs, search_share, touch_penalty) = match self {
            Self::BestRun => (300.0, Some(5), 0.0, 0.0),
            Self::Apec => (420.0, Some(5), 1.0 / 30.0, 2.0),
            Self::Uk => (600.0, None, 1.0 / 30.0, 3.0),
        };
        Rules { name: self.name(), time_limit, max_runs, search_share, touch_penalty }
    }

    /// Describes the rules.
    pub const fn about(self) -> &'static str {
        match self {
            Self::BestRun => "the time of the best of 5 runs in 300 s, as in Japan",
            Self::Apec => {
                "best of 5 runs in 420 s; 1/30 of the time before a run, and 2 s after a touch, are \
                 added to its time"
            }
            Self::Uk => {
                "best run in 600 s; 1/30 of the time before a run, and 3 s after a touch, are added \
                 to its time"
            }
        }
    }
}

impl Rules {
    /// Returns the score of a run in s.
    pub fn score(&self, time: f64, time_before: f64, is_touched: bool) -> f64 {
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
