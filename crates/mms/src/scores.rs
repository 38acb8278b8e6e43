//! How a mouse is scored, as the README of mms lays down under "Scorekeeping".

use std::fmt;
use std::str::FromStr;

use crate::reply::{Decimal, Reply};

/// What a mouse went: in all, or in one run from the start to the goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Run {
    half_steps: u64,
    /// The effective distance, in quarters of a cell, so that it is exact.
    effective_quarters: u64,
    turns: u64,
}

impl Run {
    /// Cells that it went; half ones count halves, straight on as on a diagonal.
    #[expect(clippy::cast_precision_loss, reason = "a mouse goes no 2^52 half steps")]
    pub fn distance(&self) -> f64 {
        self.half_steps as f64 / 2.
    }

    /// The distance, but of each movement what goes beyond two cells counts half. Penalties are
    /// part of it.
    #[expect(clippy::cast_precision_loss, reason = "a mouse goes no 2^50 cells")]
    pub fn effective_distance(&self) -> f64 {
        self.effective_quarters as f64 / 4.
    }

    /// Commands that turned it, by whatever angle.
    pub const fn turns(&self) -> u64 {
        self.turns
    }

    /// Turns and effective distance: what makes a run better than another, and what a limit is put
    /// on.
    #[expect(clippy::cast_precision_loss, reason = "a mouse makes no 2^52 turns")]
    pub fn cost(&self) -> f64 {
        self.turns as f64 + self.effective_distance()
    }

    /// The distance in whole cells, half ones rounded up.
    const fn whole_distance(&self) -> u64 {
        self.half_steps.div_ceil(2)
    }

    const fn cost_quarters(&self) -> u64 {
        4 * self.turns + self.effective_quarters
    }
}

/// All that is counted of a mouse.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scores {
    total: Run,
    current: Run,
    best: Option<Run>,
    /// Whether the current run has begun and not ended.
    runs: bool,
    /// Whether the next run begins with a penalty.
    is_penalised: bool,
}

impl Scores {
    /// What a reset costs, in cells of effective distance.
    pub const PENALTY: u64 = 15;
    /// The score of a mouse that has not reached the goal.
    pub const UNSOLVED: f64 = 2000.;

    /// All that the mouse went.
    pub const fn total(&self) -> &Run {
        &self.total
    }

    /// The run that has begun last, whether it has ended or not.
    pub const fn current(&self) -> &Run {
        &self.current
    }

    /// The run to the goal with the least turns and effective distance, the first of several.
    pub const fn best(&self) -> Option<&Run> {
        self.best.as_ref()
    }

    /// The competition's score, the less the better: turns and effective distance of the best run,
    /// and a tenth of all.
    pub fn score(&self) -> f64 {
        self.best.map_or(Self::UNSOLVED, |best| (10. * best.cost() + self.total.cost()) / 10.)
    }

    /// A number by its name; `None` for those of a best run that is not there yet.
    pub fn stat(&self, stat: Stat) -> Option<Reply> {
        let (total, current, best) = (Some(&self.total), Some(&self.current), self.best());
        let distance = |run: &Run| Reply::Whole(run.whole_distance());
        let effective = |run: &Run| Reply::Decimal(Decimal(run.effective_distance()));
        let turns = |run: &Run| Reply::Whole(run.turns());
        match stat {
            Stat::TotalDistance => total.map(distance),
            Stat::TotalTurns => total.map(turns),
            Stat::BestRunDistance => best.map(distance),
            Stat::BestRunTurns => best.map(turns),
            Stat::CurrentRunDistance => current.map(distance),
            Stat::CurrentRunTurns => current.map(turns),
            Stat::TotalEffectiveDistance => total.map(effective),
            Stat::BestRunEffectiveDistance => best.map(effective),
            Stat::CurrentRunEffectiveDistance => current.map(effective),
            Stat::Score => Some(Reply::Decimal(Decimal(self.score()))),
        }
    }

    /// A movement begins in the start cell, and with it a run.
    pub(crate) fn begin_run(&mut self) {
        self.current = Run::default();
        self.runs = true;
        if std::mem::take(&mut self.is_penalised) {
            self.add(Run { effective_quarters: 4 * Self::PENALTY, ..Run::default() });
        }
    }

    /// The mouse went so many half steps in one movement.
    pub(crate) fn go(&mut self, half_steps: u64) {
        // Beyond two cells, each counts half.
        let effective_quarters = (2 * half_steps).min(half_steps + 4);
        self.add(Run { half_steps, effective_quarters, turns: 0 });
    }

    /// The mouse turned once.
    pub(crate) fn turn(&mut self) {
        self.add(Run { turns: 1, ..Run::default() });
    }

    /// A movement or turn ended in a goal cell.
    pub(crate) fn reach_goal(&mut self) {
        let is_better = |best: Run| self.current.cost_quarters() < best.cost_quarters();
        if std::mem::take(&mut self.runs) && self.best.is_none_or(is_better) {
            self.best = Some(self.current);
        }
    }

    /// A movement or turn ended in the start cell, so that what has begun comes to nothing.
    pub(crate) const fn give_up_run(&mut self) {
        self.runs = false;
    }

    /// The mouse was put back. Several times before the next run count once.
    pub(crate) const fn reset(&mut self) {
        self.is_penalised = true;
        self.runs = false;
    }

    fn add(&mut self, more: Run) {
        let current = self.runs.then_some(&mut self.current);
        for run in [Some(&mut self.total), current].into_iter().flatten() {
            run.half_steps += more.half_steps;
            run.effective_quarters += more.effective_quarters;
            run.turns += more.turns;
        }
    }
}

/// A number that a mouse may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stat {
    /// Cells that it went in all.
    TotalDistance,
    /// Turns in all.
    TotalTurns,
    /// Cells of the best run.
    BestRunDistance,
    /// Turns of the best run.
    BestRunTurns,
    /// Cells of the current run.
    CurrentRunDistance,
    /// Turns of the current run.
    CurrentRunTurns,
    /// Effective distance in all.
    TotalEffectiveDistance,
    /// Effective distance of the best run.
    BestRunEffectiveDistance,
    /// Effective distance of the current run.
    CurrentRunEffectiveDistance,
    /// The competition's score.
    Score,
}

impl Stat {
    /// All of them, in the order of the README of mms.
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

    /// Those that the program which runs mms's competitions writes down, in its order.
    pub const COMPETITION: [Self; 7] = [
        Self::Score,
        Self::BestRunDistance,
        Self::BestRunEffectiveDistance,
        Self::BestRunTurns,
        Self::TotalDistance,
        Self::TotalEffectiveDistance,
        Self::TotalTurns,
    ];

    /// Its name.
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
}

impl FromStr for Stat {
    type Err = UnknownStat;

    fn from_str(name: &str) -> Result<Self, UnknownStat> {
        Self::ALL.into_iter().find(|stat| stat.name() == name).ok_or(UnknownStat)
    }
}

impl fmt::Display for Stat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name of no [`Stat`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected the name of a number, such as score or total-distance")]
pub struct UnknownStat;

#[cfg(test)]
#[allow(clippy::float_cmp)] // halves and quarters are exact
mod tests {
    use super::*;

    /// Turns, half steps of movements, and what ends the run.
    fn run(scores: &mut Scores, turns: u64, movements: &[u64]) {
        scores.begin_run();
        for _ in 0..turns {
            scores.turn();
        }
        for &half_steps in movements {
            scores.go(half_steps);
        }
        scores.reach_goal();
    }

    #[test]
    fn beyond_two_cells_a_movement_counts_half() {
        for (half_steps, effective) in
            [(1, 0.5), (2, 1.), (3, 1.5), (4, 2.), (5, 2.25), (6, 2.5), (20, 6.)]
        {
            let mut scores = Scores::default();
            scores.go(half_steps);
            assert_eq!(scores.total().effective_distance(), effective, "{half_steps}");
        }
    }

    #[test]
    fn the_best_run_is_the_one_that_costs_least() {
        let mut scores = Scores::default();
        assert_eq!(scores.score(), 2000.);
        run(&mut scores, 3, &[2, 20]);
        // 3 turns, 1 cell and 10 cells: 3 + 1 + 6, and a tenth of that again.
        assert_eq!(scores.score(), 11.);
        run(&mut scores, 0, &[2; 20]);
        assert_eq!(scores.best().unwrap().turns(), 3, "20 cells one by one cost more");
        // The total is 3 turns, 7 and 20.
        assert_eq!(scores.score(), 10. + 0.1 * 30.);
        run(&mut scores, 9, &[1]);
        assert_eq!(scores.best().unwrap().turns(), 9, "9.5 is less than 10");
        run(&mut scores, 9, &[1]);
        assert_eq!(scores.score(), 9.5 + 0.1 * (30. + 9.5 + 9.5));
    }

    #[test]
    fn after_a_run_nothing_is_added_to_it() {
        let mut scores = Scores::default();
        run(&mut scores, 1, &[4]);
        scores.turn();
        scores.go(2);
        scores.reach_goal();
        assert_eq!((scores.current().turns(), scores.current().distance()), (1, 2.));
        assert_eq!((scores.total().turns(), scores.total().distance()), (2, 3.));
        scores.begin_run();
        scores.give_up_run();
        scores.go(2);
        assert_eq!(scores.current(), &Run::default());
    }

    #[test]
    fn a_penalty_is_paid_when_the_next_run_begins() {
        let mut scores = Scores::default();
        scores.reset();
        scores.reset();
        assert_eq!(scores.total().effective_distance(), 0.);
        run(&mut scores, 0, &[2]);
        assert_eq!(scores.best().unwrap().effective_distance(), 16.);
        assert_eq!((scores.total().distance(), scores.total().effective_distance()), (1., 16.));
        run(&mut scores, 0, &[2]);
        assert_eq!(scores.best().unwrap().effective_distance(), 1.);
    }

    #[test]
    fn names_are_read_back() {
        for stat in Stat::ALL {
            assert_eq!(stat.name().parse(), Ok(stat));
            assert_eq!(format!("{stat:32}").len(), 32);
        }
        assert_eq!("Score".parse::<Stat>(), Err(UnknownStat));
        let scores = Scores::default();
        let absent = Stat::ALL.into_iter().filter(|&stat| scores.stat(stat).is_none());
        assert!(absent.map(Stat::name).all(|name| name.starts_with("best-run")));
    }
}
