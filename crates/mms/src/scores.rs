//! Scorekeeping: as mms 1.2 does it, and as the mms README specifies it.

use std::fmt;

use crate::response::Response;

/// The rules by which movements count. The rules differ in the unit of distance.
///
/// ```
/// use mmsim_mms::ScoreRules;
/// assert_eq!(ScoreRules::ALL.map(ScoreRules::name), ["mms-1.2", "cells"]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScoreRules {
    /// The rules of mms 1.2: the unit is the half step. A movement counts its requested distance,
    /// even if it ends in a crash.
    #[default]
    Mms12,
    /// The rules of the mms README: the unit is the cell. A movement counts the distance travelled.
    Cells,
}

impl ScoreRules {
    /// All rules.
    pub const ALL: [Self; 2] = [Self::Mms12, Self::Cells];

    /// Returns the name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mms12 => "mms-1.2",
            Self::Cells => "cells",
        }
    }
}

/// The distance and turns of a mouse, in total or in one run from the start to the goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TravelStats {
    /// The distance, counted in half units so that it is an integer.
    distance_halves: u64,
    /// The effective distance, counted in quarters of a unit so that it is an integer.
    effective_quarters: u64,
    turns: u64,
}

impl TravelStats {
    /// Returns the distance, in the unit of the [`ScoreRules`]. A diagonal half step counts as much
    /// as a straight one.
    #[expect(clippy::cast_precision_loss, reason = "a mouse moves fewer than 2^52 half steps")]
    pub fn distance(&self) -> f64 {
        self.distance_halves as f64 / 2.
    }

    /// Returns the effective distance, including penalties. In each movement, the distance beyond
    /// two units counts half.
    #[expect(clippy::cast_precision_loss, reason = "a mouse moves fewer than 2^50 cells")]
    pub fn effective_distance(&self) -> f64 {
        self.effective_quarters as f64 / 4.
    }

    /// Returns the number of turns. Each turn command counts as one turn, regardless of its angle.
    pub const fn turns(&self) -> u64 {
        self.turns
    }

    /// Returns the number of turns plus the effective distance. The run with the lowest cost is the
    /// best run.
    #[expect(clippy::cast_precision_loss, reason = "a mouse makes fewer than 2^52 turns")]
    pub fn cost(&self) -> f64 {
        self.turns as f64 + self.effective_distance()
    }

    /// Returns the distance, rounded up.
    const fn whole_distance(&self) -> u64 {
        self.distance_halves.div_ceil(2)
    }

    const fn cost_quarters(&self) -> u64 {
        4 * self.turns + self.effective_quarters
    }
}

/// Counts the movements and turns of a mouse, in total and for its current and best runs, and
/// computes its score.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scores {
    rules: ScoreRules,
    total: TravelStats,
    current_run: TravelStats,
    best_run: Option<TravelStats>,
    /// True if the current run is neither completed nor cancelled.
    is_running: bool,
    /// True if the next run starts with a penalty.
    has_penalty: bool,
}

impl Scores {
    /// The penalty for a reset, added to the effective distance.
    pub const PENALTY: u64 = 15;
    /// The score of a mouse that has not reached the goal.
    pub const UNSOLVED: f64 = 2000.;

    /// Creates the scores of a mouse that has not moved.
    pub(crate) fn new(rules: ScoreRules) -> Self {
        Self { rules, ..Self::default() }
    }

    /// Returns the rules by which the movements count.
    pub const fn rules(&self) -> ScoreRules {
        self.rules
    }

    /// Returns the stats of all movements and turns.
    pub const fn total(&self) -> &TravelStats {
        &self.total
    }

    /// Returns the stats of the most recent run, whether or not it has ended.
    pub const fn current_run(&self) -> &TravelStats {
        &self.current_run
    }

    /// Returns the stats of the completed run with the lowest [`cost`](TravelStats::cost), or
    /// `None` if no run is complete. If several runs have the lowest cost, returns the first of
    /// them.
    pub const fn best_run(&self) -> Option<&TravelStats> {
        self.best_run.as_ref()
    }

    /// Returns the competition score: the [`cost`](TravelStats::cost) of the best run plus a tenth
    /// of the total cost. A lower score is better.
    pub fn score(&self) -> f64 {
        self.best_run.map_or(Self::UNSOLVED, |best| (10. * best.cost() + self.total.cost()) / 10.)
    }

    /// Returns a statistic. Statistics of the best run are [`Response::NoValue`] until a run is
    /// complete.
    pub fn stat(&self, stat: Stat) -> Response {
        let distance = |run: &TravelStats| self.count(run.whole_distance());
        let effective = |run: &TravelStats| self.number(run.effective_distance());
        let turns = |run: &TravelStats| self.count(run.turns());
        let best_run = |stat: &dyn Fn(&TravelStats) -> Response| {
            self.best_run().map_or(Response::NoValue, stat)
        };
        match stat {
            Stat::TotalDistance => distance(self.total()),
            Stat::TotalTurns => turns(self.total()),
            Stat::BestRunDistance => best_run(&distance),
            Stat::BestRunTurns => best_run(&turns),
            Stat::CurrentRunDistance => distance(self.current_run()),
            Stat::CurrentRunTurns => turns(self.current_run()),
            Stat::TotalEffectiveDistance => effective(self.total()),
            Stat::BestRunEffectiveDistance => best_run(&effective),
            Stat::CurrentRunEffectiveDistance => effective(self.current_run()),
            Stat::Score => self.number(self.score()),
        }
    }

    /// Returns a whole number as a response. mms 1.2 has no whole number above 999,999: it formats
    /// a larger one as `1e+06` and fails to parse this text as an integer.
    const fn count(&self, count: u64) -> Response {
        match self.rules {
            ScoreRules::Mms12 if count > 999_999 => Response::NoValue,
            _ => Response::Count(count),
        }
    }

    /// Returns a number as a response. mms 1.2 stores numbers with single precision, which can
    /// change the sixth digit.
    #[expect(clippy::cast_possible_truncation, reason = "as in mms")]
    fn number(&self, number: f64) -> Response {
        Response::Number(match self.rules {
            ScoreRules::Mms12 => f64::from(number as f32),
            ScoreRules::Cells => number,
        })
    }

    /// Begins a run. The first run after a reset begins with a penalty. Call this method when a
    /// movement begins in the start cell.
    pub(crate) fn begin_run(&mut self) {
        self.current_run = TravelStats::default();
        self.is_running = true;
        if std::mem::take(&mut self.has_penalty) {
            let effective_quarters = 4 * Self::PENALTY;
            self.add(TravelStats { effective_quarters, ..TravelStats::default() });
        }
    }

    /// Adds a movement, given the requested and the travelled half steps.
    pub(crate) fn add_movement(&mut self, requested: u64, travelled: u64) {
        let distance_halves = match self.rules {
            // mms has no larger distances.
            ScoreRules::Mms12 => 2 * requested.min(i32::MAX.unsigned_abs().into()),
            ScoreRules::Cells => travelled,
        };
        // Beyond two units, each half unit counts as a quarter of a unit.
        let effective_quarters = (2 * distance_halves).min(distance_halves + 4);
        self.add(TravelStats { distance_halves, effective_quarters, turns: 0 });
    }

    /// Adds a turn.
    pub(crate) fn add_turn(&mut self) {
        self.add(TravelStats { turns: 1, ..TravelStats::default() });
    }

    /// Completes the current run, if there is one. In mms 1.2, a mouse that has begun no run, because
    /// it starts at a goal, completes an empty run.
    pub(crate) fn complete_run(&mut self) {
        let was_running = std::mem::take(&mut self.is_running);
        let is_better = |best: TravelStats| self.current_run.cost_quarters() < best.cost_quarters();
        let counts = was_running || self.rules == ScoreRules::Mms12;
        if counts && self.best_run.is_none_or(is_better) {
            self.best_run = Some(self.current_run);
        }
    }

    /// Cancels the current run.
    pub(crate) const fn cancel_run(&mut self) {
        self.is_running = false;
    }

    /// Cancels the current run and adds a penalty to the next run. Several resets before the next
    /// run count as one.
    pub(crate) const fn reset(&mut self) {
        self.has_penalty = true;
        self.cancel_run();
    }

    fn add(&mut self, more: TravelStats) {
        let current = self.is_running.then_some(&mut self.current_run);
        for stats in [Some(&mut self.total), current].into_iter().flatten() {
            stats.distance_halves += more.distance_halves;
            stats.effective_quarters += more.effective_quarters;
            stats.turns += more.turns;
        }
    }
}

/// A statistic that a mouse can query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stat {
    /// The total distance.
    TotalDistance,
    /// The total number of turns.
    TotalTurns,
    /// The distance of the best run.
    BestRunDistance,
    /// The number of turns of the best run.
    BestRunTurns,
    /// The distance of the current run.
    CurrentRunDistance,
    /// The number of turns of the current run.
    CurrentRunTurns,
    /// The total effective distance.
    TotalEffectiveDistance,
    /// The effective distance of the best run.
    BestRunEffectiveDistance,
    /// The effective distance of the current run.
    CurrentRunEffectiveDistance,
    /// The competition score.
    Score,
}

impl Stat {
    /// All statistics, in the order in which the mms README lists them.
    pub const ALL: [Self; 10] = [
        Self::TotalDistance,
        Self::TotalTurns,
        Self::BestRunDistance,
        Self::BestRunTurns,
        Self::CurrentRunDistance,
        Self::CurrentRunTurns,
        Self::TotalEffectiveDistance,
        Self::BestRunEffectiveDistance,
        Self::CurrentRunEffectiveDistance,
        Self::Score,
    ];

    /// The statistics that mms competitions record, in the order in which they are recorded.
    pub const COMPETITION: [Self; 7] = [
        Self::Score,
        Self::BestRunDistance,
        Self::BestRunEffectiveDistance,
        Self::BestRunTurns,
        Self::TotalDistance,
        Self::TotalEffectiveDistance,
        Self::TotalTurns,
    ];

    /// Returns the name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::TotalDistance => "total-distance",
            Self::TotalTurns => "total-turns",
            Self::BestRunDistance => "best-run-distance",
            Self::BestRunTurns => "best-run-turns",
            Self::CurrentRunDistance => "current-run-distance",
            Self::CurrentRunTurns => "current-run-turns",
            Self::TotalEffectiveDistance => "total-effective-distance",
            Self::BestRunEffectiveDistance => "best-run-effective-distance",
            Self::CurrentRunEffectiveDistance => "current-run-effective-distance",
            Self::Score => "score",
        }
    }

    /// Returns the statistic with this name.
    pub(crate) fn from_name(name: &[u8]) -> Option<Self> {
        Self::ALL.into_iter().find(|stat| stat.name().as_bytes() == name)
    }
}

impl fmt::Display for Stat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)] // halves and quarters are exact

    use super::*;

    fn cells() -> Scores {
        Scores::new(ScoreRules::Cells)
    }

    /// Records a run from the start to the goal.
    fn run(scores: &mut Scores, turns: u64, movements: &[u64]) {
        scores.begin_run();
        for _ in 0..turns {
            scores.add_turn();
        }
        for &half_steps in movements {
            scores.add_movement(half_steps, half_steps);
        }
        scores.complete_run();
    }

    #[test]
    fn distance_beyond_two_cells_counts_half() {
        for (half_steps, effective) in
            [(1, 0.5), (2, 1.), (3, 1.5), (4, 2.), (5, 2.25), (6, 2.5), (20, 6.)]
        {
            let mut scores = cells();
            scores.add_movement(100, half_steps);
            assert_eq!(scores.total().effective_distance(), effective, "{half_steps}");
        }
    }

    #[test]
    fn mms_counts_the_requested_half_steps() {
        for (half_steps, effective) in [(1, 1.), (2, 2.), (3, 2.5), (4, 3.), (20, 11.)] {
            let mut scores = Scores::new(ScoreRules::Mms12);
            scores.add_movement(half_steps, 1);
            assert_eq!(scores.total().effective_distance(), effective, "{half_steps}");
        }
        let mut scores = Scores::new(ScoreRules::Mms12);
        scores.add_movement(u64::MAX, 1);
        assert_eq!(scores.total().distance(), f64::from(i32::MAX));
    }

    #[test]
    fn mms_has_six_digits() {
        let mut scores = Scores::new(ScoreRules::Mms12);
        scores.add_movement(999_999, 1);
        assert_eq!(scores.stat(Stat::TotalDistance), Response::Count(999_999));
        scores.add_movement(1, 1);
        assert_eq!(scores.stat(Stat::TotalDistance), Response::NoValue);
        assert_eq!(scores.stat(Stat::TotalEffectiveDistance).to_string(), "500002");
        // The best run costs 8,998 turns + 2.5; the score is 9000.5 + 0.1 * 9996.5 = 10000.15. The
        // nearest number of single precision is 10000.150390625.
        let mut scores = Scores::new(ScoreRules::Mms12);
        run(&mut scores, 8998, &[3]);
        (0..996).for_each(|_| scores.add_turn());
        assert_eq!(scores.score(), 10000.15);
        assert_eq!(scores.stat(Stat::Score).to_string(), "10000.2");
    }

    #[test]
    fn the_best_run_has_the_lowest_cost() {
        let mut scores = cells();
        assert_eq!(scores.score(), 2000.);
        run(&mut scores, 3, &[2, 20]);
        // 3 turns, 1 cell and 10 cells: 3 + 1 + 6, plus a tenth of this sum.
        assert_eq!(scores.score(), 11.);
        run(&mut scores, 0, &[2; 20]);
        assert_eq!(scores.best_run().unwrap().turns(), 3, "a cost of 20 is higher than 10");
        // The total cost is 3 turns + 7 + 20.
        assert_eq!(scores.score(), 10. + 0.1 * 30.);
        run(&mut scores, 9, &[1]);
        assert_eq!(scores.best_run().unwrap().turns(), 9, "a cost of 9.5 is lower than 10");
        run(&mut scores, 9, &[1]);
        assert_eq!(scores.score(), 9.5 + 0.1 * (30. + 9.5 + 9.5));
    }

    #[test]
    fn an_ended_run_does_not_change() {
        let mut scores = cells();
        run(&mut scores, 1, &[4]);
        scores.add_turn();
        scores.add_movement(2, 2);
        scores.complete_run();
        assert_eq!((scores.current_run().turns(), scores.current_run().distance()), (1, 2.));
        assert_eq!((scores.total().turns(), scores.total().distance()), (2, 3.));
        scores.begin_run();
        scores.cancel_run();
        scores.add_movement(2, 2);
        assert_eq!(scores.current_run(), &TravelStats::default());
    }

    #[test]
    fn a_penalty_is_added_when_the_next_run_begins() {
        let mut scores = cells();
        scores.reset();
        scores.reset();
        assert_eq!(scores.total().effective_distance(), 0.);
        run(&mut scores, 0, &[2]);
        assert_eq!(scores.best_run().unwrap().effective_distance(), 16.);
        assert_eq!((scores.total().distance(), scores.total().effective_distance()), (1., 16.));
        run(&mut scores, 0, &[2]);
        assert_eq!(scores.best_run().unwrap().effective_distance(), 1.);
    }

    #[test]
    fn names_round_trip() {
        for stat in Stat::ALL {
            assert_eq!(Stat::from_name(stat.name().as_bytes()), Some(stat));
            assert_eq!(format!("{stat:32}").len(), 32);
        }
        assert_eq!(Stat::from_name(b"Score"), None);
        let scores = cells();
        let absent = Stat::ALL.into_iter().filter(|&stat| scores.stat(stat) == Response::NoValue);
        assert!(absent.map(Stat::name).all(|name| name.starts_with("best-run")));
    }
}
