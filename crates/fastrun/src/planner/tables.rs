//! The costs of straights and turns as whole numbers, computed once for each vehicle.

use alloc::vec::Vec;

use super::classes::{Class, ClassRange, STRAIGHTS, classes};
use crate::turn::TurnKind;
use crate::vehicle::Vehicle;

/// The cost of a straight that is too short for its change of speed. Any sum of this cost and a
/// time is greater than every time.
pub(super) const IMPOSSIBLE: u32 = 1 << 30;
const IMPOSSIBLE_LOSS: i32 = 1 << 30;

/// The classes of a vehicle and the costs between them, in ticks.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    pub(super) classes: Vec<Class>,
    /// The classes of each turn, in the order of [`ORDER`].
    pub(super) ranges: [ClassRange; 9],
    /// The first class that can follow, along a line and on a diagonal.
    pub(super) first: [usize; 2],
    /// True if the mouse can only turn within a cell.
    pub(super) only_s90: bool,
    /// The number of classes of turns that begin along a line.
    along: usize,
    /// For each class, each number of lattice steps, and each class of the next turn: the time of
    /// the straight and the arc. There is room for `1 << row_bits` classes of next turns.
    costs: Vec<u32>,
    row_bits: u32,
    /// For each class and each number of lattice steps: the time of the last straight.
    finish: Vec<u32>,
    /// `losses[a][b]` is the greatest difference between the costs of everything that may follow a
    /// turn of class a, and the costs of the same after a turn of class b. There is room for
    /// `1 << loss_bits` classes b.
    losses: Vec<i32>,
    loss_bits: u32,
    /// The same for a mouse that has driven some lattice steps straight on after the turn of class
    /// b, to the centre of a cell. There is room for [`STRAIGHTS`] numbers of steps.
    losses_after: Vec<i32>,
    /// The binary logarithm of the time, in ticks, that every turn takes at least.
    pub(super) bucket_bits: u32,
    /// The number of buckets that the costs of one straight and one turn span.
    pub(super) buckets: usize,
}

impl Tables {
    pub(super) fn new(vehicle: &Vehicle) -> Self {
        let (classes, ranges) = classes(vehicle);
        let along = ranges[..5].iter().map(|range| usize::from(range.high - range.low)).sum();
        let diagonal = classes.len() - 1 - along;
        let bits = |count: usize| count.next_power_of_two().ilog2();
        let ticks = ticks_per_second(vehicle);
        let mut tables = Self {
            only_s90: ranges[1..].iter().all(|range| range.low == range.high),
            along,
            ranges,
            first: [1, 1 + along],
            costs: Vec::new(),
            row_bits: bits(along.max(diagonal)),
            finish: Vec::new(),
            losses: Vec::new(),
            losses_after: Vec::new(),
            loss_bits: bits(classes.len()),
            bucket_bits: 0,
            buckets: 0,
            classes,
        };
        tables.add_costs(vehicle, ticks);
        tables.add_losses();
        let arcs = tables.classes[1..]
            .iter()
            .filter_map(|class| Some(ticks * vehicle.arc(class.kind?)?.arc.length / class.speed));
        let quickest = to_ticks(arcs.fold(f64::INFINITY, libm::fmin));
        tables.bucket_bits = quickest.max(1).ilog2();
        let possible = tables.costs.iter().filter(|&&cost| cost < IMPOSSIBLE);
        let longest = possible.max().copied().unwrap_or(0) >> tables.bucket_bits;
        tables.buckets = (longest as usize + 2).next_power_of_two();
        tables
    }

    /// Returns true if the mouse can do a turn, given by its index in [`ORDER`].
    #[inline(always)]
    pub(super) fn has(&self, turn: usize) -> bool {
        self.ranges[turn].low < self.ranges[turn].high
    }

    /// Returns the costs from a class to the next turns.
    #[inline(always)]
    pub(super) fn costs(&self, class: u8) -> Costs<'_> {
        let each = STRAIGHTS << self.row_bits;
        Costs { costs: &self.costs[usize::from(class) * each..][..each], row_bits: self.row_bits }
    }

    #[inline(always)]
    pub(super) fn finish(&self, class: u8, steps: usize) -> u32 {
        self.finish[usize::from(class) * STRAIGHTS + steps % STRAIGHTS]
    }

    #[inline(always)]
    pub(super) fn loss(&self, instead: u16, of: u16) -> i32 {
        self.losses[usize::from(instead) << self.loss_bits | usize::from(of)]
    }

    /// Returns the greatest loss of a mouse that ends a turn at the centre of a cell, instead of
    /// reaching it after some lattice steps straight on after another turn. To stop in this cell
    /// does not count.
    #[inline(always)]
    pub(super) fn loss_after(&self, instead: u16, of: u16, steps: u32) -> i32 {
        let pair = usize::from(instead) << self.loss_bits | usize::from(of);
        self.losses_after[pair * STRAIGHTS + steps as usize % STRAIGHTS]
    }

    fn add_costs(&mut self, vehicle: &Vehicle, ticks: f64) {
        let parameters = vehicle.parameters();
        for index in 0..self.classes.len() {
            let class = &self.classes[index];
            let limits = vehicle.limits(class.ends_diagonal);
            let next = self.following(class.ends_diagonal);
            for steps in 0..STRAIGHTS {
                #[allow(clippy::cast_possible_truncation)]
                let straight = class.after + vehicle.straight(steps as u8, class.ends_diagonal);
                let last = straight + parameters.stop_offset;
                let finish =
                    if class.ends_diagonal { None } else { limits.time(last, class.speed, 0.0) };
                self.finish.push(finish.map_or(IMPOSSIBLE, |time| to_ticks(time * ticks)));
                let row = self.costs.len();
                for next in &self.classes[next.clone()] {
                    let arc = next.kind.and_then(|kind| vehicle.arc(kind));
                    let cost = arc.and_then(|fitted| {
                        let time =
                            limits.time(straight + fitted.before, class.speed, next.speed)?;
                        Some(
                            to_ticks(time * ticks)
                                + to_ticks(fitted.arc.length / next.speed * ticks),
                        )
                    });
                    self.costs.push(cost.unwrap_or(IMPOSSIBLE));
                }
                self.costs.resize(row + (1 << self.row_bits), IMPOSSIBLE);
            }
        }
    }

    /// Returns the classes of turns that begin on a diagonal, or along a line.
    fn following(&self, is_diagonal: bool) -> core::ops::Range<usize> {
        let all = self.classes.len();
        if is_diagonal { 1 + self.along..all } else { 1..1 + self.along }
    }

    fn add_losses(&mut self) {
        let all = self.classes.len();
        self.losses = alloc::vec![IMPOSSIBLE_LOSS; all << self.loss_bits];
        self.losses_after = alloc::vec![IMPOSSIBLE_LOSS; (all << self.loss_bits) * STRAIGHTS];
        let place = |class: &Class| (class.ends_diagonal, class.kind == Some(TurnKind::S90));
        for instead in 0..all {
            for of in 0..all {
                let pair = instead << self.loss_bits | of;
                let [to, from] = [instead, of].map(|class| place(&self.classes[class]));
                if to == from {
                    self.losses[pair] = self.greatest_loss(instead, of, 0);
                }
                if to == (false, false) && !from.0 {
                    for steps in (usize::from(from.1)..STRAIGHTS).step_by(2) {
                        let loss = self.greatest_loss(instead, of, steps);
                        self.losses_after[pair * STRAIGHTS + steps] = loss;
                    }
                }
            }
        }
    }

    /// Returns the greatest difference of the costs of all that may follow at a place where a turn
    /// of one class has ended, and which the mouse otherwise reaches some lattice steps after a turn
    /// of another class. To stop at this place does not count. Returns [`IMPOSSIBLE`] if something
    /// can only follow the other turn.
    fn greatest_loss(&self, instead: usize, of: usize, steps: usize) -> i32 {
        let Class { kind, ends_diagonal, .. } = self.classes[instead];
        let s90 = self.ranges[0].low..self.ranges[0].high;
        let next = self.following(ends_diagonal);
        let cost = |class: usize, steps: usize, column: usize| {
            self.costs[(class * STRAIGHTS + steps) << self.row_bits | column]
        };
        let mut greatest = i64::MIN;
        for further in 0..STRAIGHTS - steps {
            // Along a line, only the turn s90 begins at a wall.
            let is_at_wall = (further % 2 == 1) != (kind == Some(TurnKind::S90));
            let turns = next.clone().filter(|&next| {
                #[allow(clippy::cast_possible_truncation)]
                let is_s90 = s90.contains(&(next as u8));
                ends_diagonal || is_s90 == is_at_wall
            });
            let turns = turns.map(|class| {
                let column = class - next.start;
                (cost(instead, further, column), cost(of, steps + further, column))
            });
            let can_stop = !ends_diagonal && !is_at_wall && further > 0;
            let finish = |class: usize, steps: usize| self.finish[class * STRAIGHTS + steps];
            let stop = can_stop.then(|| (finish(instead, further), finish(of, steps + further)));
            for (instead, of) in turns.chain(stop).filter(|&(_, of)| of < IMPOSSIBLE) {
                if instead >= IMPOSSIBLE {
                    return IMPOSSIBLE_LOSS;
                }
                greatest = greatest.max(i64::from(instead) - i64::from(of));
            }
        }
        // Costs have at most 30 bits.
        i32::try_from(greatest).unwrap_or(IMPOSSIBLE_LOSS)
    }
}

/// The costs from a class to the next turns.
#[derive(Clone, Copy)]
pub(super) struct Costs<'a> {
    costs: &'a [u32],
    row_bits: u32,
}

impl Costs<'_> {
    /// Returns the time of a straight and the arc of the next turn. `column` is the number of the
    /// class of the next turn among those that begin in the same way.
    #[inline(always)]
    pub(super) fn at(&self, steps: u32, column: usize) -> u32 {
        self.costs[(steps as usize) << self.row_bits | column]
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn to_ticks(ticks: f64) -> u32 {
    // The time of a straight is at most that of the slowest crossing of a maze.
    (ticks + 0.5) as u32
}

/// Returns the number of ticks per second. The slowest run has less than [`IMPOSSIBLE`] ticks: the
/// mouse crosses each of 1,024 cells at the speed of its slowest turn.
fn ticks_per_second(vehicle: &Vehicle) -> f64 {
    let speeds = TurnKind::ALL.into_iter().flat_map(|kind| vehicle.speeds(kind));
    let slowest = speeds.fold(f64::INFINITY, |slowest, &speed| libm::fmin(slowest, speed));
    let slowest_run = 1100.0 * 2.0 * vehicle.half_cell() / slowest;
    f64::from(IMPOSSIBLE) / slowest_run
}
