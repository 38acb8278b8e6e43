//! The costs of straights and turns as whole numbers, computed once for each vehicle.

use alloc::vec::Vec;

use crate::turn::TurnKind;
use crate::vehicle::Vehicle;

/// The number of lattice steps of the longest straight, and one more.
pub(super) const STRAIGHTS: usize = 64;

/// The cost of a straight that is too short for its change of speed. Any sum of this cost and a
/// time is greater than every time.
pub(super) const IMPOSSIBLE: u32 = 1 << 30;
const IMPOSSIBLE_LOSS: i32 = 1 << 30;

/// The turns in the order of their classes: those that begin along a line come first.
pub(super) const ORDER: [TurnKind; 9] = [
    TurnKind::S90,
    TurnKind::L90,
    TurnKind::In45,
    TurnKind::L180,
    TurnKind::In135,
    TurnKind::Out45,
    TurnKind::Out135,
    TurnKind::V90,
    TurnKind::K90,
];

/// A turn at one speed. Class 0 is the mouse at rest in the start cell.
#[derive(Clone, Debug)]
pub(super) struct Class {
    /// `None` at rest.
    pub(super) kind: Option<TurnKind>,
    pub(super) speed: f64,
    /// The straight part of the turn after its arc, in mm.
    after: f64,
    ends_diagonal: bool,
}

/// The classes of a turn, fastest first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClassRange {
    pub(super) low: u8,
    /// The classes from here on are only needed to stop in a goal right after the turn.
    pub(super) slow: u8,
    pub(super) high: u8,
}

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
    /// `losses[a][b]`, with room for `1 << loss_bits` classes b, is the greatest difference between the costs of everything that may follow a
    /// turn of class a, and the costs of the same after a turn of class b.
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
            let line = vehicle.line(class.ends_diagonal);
            let next = self.following(class.ends_diagonal);
            for steps in 0..STRAIGHTS {
                #[allow(clippy::cast_possible_truncation)]
                let straight = class.after + vehicle.straight(steps as u8, class.ends_diagonal);
                let last = straight + parameters.stop_offset;
                let finish =
                    if class.ends_diagonal { None } else { line.time(last, class.speed, 0.0) };
                self.finish.push(finish.map_or(IMPOSSIBLE, |time| to_ticks(time * ticks)));
                let row = self.costs.len();
                for next in &self.classes[next.clone()] {
                    let arc = next.kind.and_then(|kind| vehicle.arc(kind));
                    let cost = arc.and_then(|fitted| {
                        let time = line.time(straight + fitted.before, class.speed, next.speed)?;
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

/// Returns the classes, in the order of [`ORDER`] and fastest first, and the range of each turn.
fn classes(vehicle: &Vehicle) -> (Vec<Class>, [ClassRange; 9]) {
    let rest = Class {
        kind: None,
        speed: 0.0,
        after: vehicle.parameters().start_offset,
        ends_diagonal: false,
    };
    let mut classes = alloc::vec![rest];
    let mut ranges = [ClassRange::default(); 9];
    let needed = needed_speeds(vehicle);
    #[allow(clippy::cast_possible_truncation)]
    for (kind, range) in ORDER.into_iter().zip(&mut ranges) {
        range.low = classes.len() as u8;
        let mut add = |speeds: u32| {
            if let Some(fitted) = vehicle.arc(kind) {
                let (after, ends_diagonal) = (fitted.after, kind.ends_diagonal());
                let class = |&speed| Class { kind: Some(kind), speed, after, ends_diagonal };
                let all = vehicle.speeds(kind).iter().enumerate();
                let added = all.filter(|&(index, _)| speeds >> index & 1 == 1);
                classes.extend(added.map(|(_, speed)| class(speed)));
            }
            classes.len() as u8
        };
        let [to_go_on, to_stop] = needed[kind as usize];
        range.slow = add(to_go_on);
        range.high = add(to_stop & !to_go_on);
    }
    (classes, ranges)
}

/// Returns for each turn the speeds that a fastest run can need, as bits in the order of
/// [`Vehicle::speeds`]: the speeds to go on after the turn, and those to stop right after it.
///
/// In a fastest run, no turn can be driven at its next higher speed. So each turn has its greatest
/// speed, or the greatest speed that what comes before or after it allows. A turn that does so is
/// slower. With limited jerk, a higher speed at one end of a straight may cost time, so all speeds
/// are needed.
fn needed_speeds(vehicle: &Vehicle) -> [[u32; 2]; 9] {
    let has_jerk = |is_diagonal| vehicle.line(is_diagonal).jerk < f64::INFINITY;
    if has_jerk(false) || has_jerk(true) {
        return TurnKind::ALL.map(|kind| [(1 << vehicle.speeds(kind).len()) - 1, 0]);
    }
    let parameters = vehicle.parameters();
    let mut needed = TurnKind::ALL.map(|kind| [u32::from(vehicle.arc(kind).is_some()), 0]);
    for kind in TurnKind::ALL {
        let Some(fitted) = vehicle.arc(kind) else { continue };
        let speeds = vehicle.speeds(kind);
        let line = vehicle.line(false);
        for steps in 0..STRAIGHTS {
            let straight = straight(vehicle, steps, false);
            let (to, from) = (
                parameters.start_offset + straight + fitted.before,
                fitted.after + straight + parameters.stop_offset,
            );
            let reachable = speeds.iter().position(|&speed| line.time(to, 0.0, speed).is_some());
            let stoppable = speeds.iter().position(|&speed| line.time(from, speed, 0.0).is_some());
            if !kind.begins_diagonal() {
                needed[kind as usize][0] |= bit(reachable);
            }
            if !kind.ends_diagonal() {
                needed[kind as usize][usize::from(steps == 0)] |= bit(stoppable);
            }
        }
    }
    loop {
        let before = needed;
        for first in TurnKind::ALL {
            for next in TurnKind::ALL {
                add_needed(vehicle, first, next, &mut needed);
            }
        }
        if needed == before {
            return needed;
        }
    }
}

/// Adds the speeds of two turns that follow each other which are needed because of the other turn.
fn add_needed(vehicle: &Vehicle, first: TurnKind, next: TurnKind, needed: &mut [[u32; 2]; 9]) {
    let is_diagonal = first.ends_diagonal();
    let (Some(from), Some(to)) = (vehicle.arc(first), vehicle.arc(next)) else { return };
    if next.begins_diagonal() != is_diagonal {
        return;
    }
    let (speeds, next_speeds) = (vehicle.speeds(first), vehicle.speeds(next));
    let is_needed = |speeds: [u32; 2], index: usize| (speeds[0] | speeds[1]) >> index & 1 == 1;
    for steps in 0..STRAIGHTS {
        let distance = from.after + straight(vehicle, steps, is_diagonal) + to.before;
        let can = |&speed: &f64, &next: &f64| {
            vehicle.line(is_diagonal).time(distance, speed, next).is_some()
        };
        for (index, speed) in speeds.iter().enumerate() {
            if is_needed(needed[first as usize], index) {
                let reachable = next_speeds.iter().position(|next| can(speed, next));
                needed[next as usize][0] |= bit(reachable);
            }
        }
        for (index, next_speed) in next_speeds.iter().enumerate() {
            if is_needed(needed[next as usize], index) {
                let fastest = speeds.iter().position(|speed| can(speed, next_speed));
                needed[first as usize][0] |= bit(fastest);
            }
        }
    }
}

fn bit(index: Option<usize>) -> u32 {
    index.map_or(0, |index| 1 << index)
}

#[allow(clippy::cast_possible_truncation)]
fn straight(vehicle: &Vehicle, steps: usize, is_diagonal: bool) -> f64 {
    vehicle.straight(steps as u8, is_diagonal)
}
