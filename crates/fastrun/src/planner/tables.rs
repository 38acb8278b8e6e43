//! The costs of straights and turns as whole numbers, computed once for each vehicle.

use alloc::vec::Vec;

use crate::turn::TurnKind;
use crate::vehicle::Vehicle;

/// The number of lattice steps of the longest straight, and one more.
pub(super) const STRAIGHTS: usize = 64;

/// The cost of a straight that is too short for its change of speed. Any sum of this cost and a
/// time is greater than every time.
pub(super) const IMPOSSIBLE: u32 = 1 << 30;

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

/// The classes of a vehicle and the costs between them, in ticks.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    pub(super) classes: Vec<Class>,
    /// The range of classes of each turn, in the order of [`ORDER`].
    pub(super) ranges: [(u8, u8); 9],
    /// The first class that can follow, along a line and on a diagonal.
    pub(super) first: [usize; 2],
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
    /// The binary logarithm of the time, in ticks, that every turn takes at least.
    pub(super) bucket_bits: u32,
    /// The number of buckets that the costs of one straight and one turn span.
    pub(super) buckets: usize,
}

impl Tables {
    pub(super) fn new(vehicle: &Vehicle) -> Self {
        let (classes, ranges) = classes(vehicle);
        let along = ranges[..5].iter().map(|&(low, high)| usize::from(high - low)).sum();
        let diagonal = classes.len() - 1 - along;
        let bits = |count: usize| count.next_power_of_two().ilog2();
        let ticks = ticks_per_second(vehicle);
        let mut tables = Self {
            along,
            ranges,
            first: [1, 1 + along],
            costs: Vec::new(),
            row_bits: bits(along.max(diagonal)),
            finish: Vec::new(),
            losses: Vec::new(),
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
        self.ranges[turn].0 < self.ranges[turn].1
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
    pub(super) fn loss(&self, instead: u8, of: u8) -> i32 {
        self.losses[usize::from(instead) << self.loss_bits | usize::from(of)]
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
        self.losses = alloc::vec![IMPOSSIBLE.cast_signed(); all << self.loss_bits];
        for instead in 0..all {
            for of in 0..all {
                if let Some(loss) = self.greatest_loss(instead, of) {
                    self.losses[instead << self.loss_bits | of] = loss;
                }
            }
        }
    }

    /// Returns the greatest difference of costs, or `None` if something is possible only after the
    /// other class, or if the two never end at the same place in the same direction.
    fn greatest_loss(&self, instead: usize, of: usize) -> Option<i32> {
        let [(a, a_is_wall), (b, b_is_wall)] = [instead, of].map(|class| {
            let class = &self.classes[class];
            (class.ends_diagonal, class.kind == Some(TurnKind::S90))
        });
        if (a, a_is_wall) != (b, b_is_wall) {
            return None;
        }
        let s90 = self.ranges[0].0..self.ranges[0].1;
        let mut greatest = i32::MIN;
        let mut compare = |instead: u32, of: u32| {
            if of < IMPOSSIBLE {
                greatest = greatest.max(instead.cast_signed() - of.cast_signed());
            }
            instead < IMPOSSIBLE || of >= IMPOSSIBLE
        };
        for steps in 0..STRAIGHTS {
            let is_at_wall = (steps % 2 == 1) != a_is_wall;
            for next in self.following(a) {
                // Along a line, only the turn s90 begins at a wall.
                let is_s90 = s90.contains(&(next as u8));
                if a || is_s90 == is_at_wall {
                    let column = next - self.following(a).start;
                    let cost = |class: usize| {
                        self.costs[(class * STRAIGHTS + steps) << self.row_bits | column]
                    };
                    if !compare(cost(instead), cost(of)) {
                        return None;
                    }
                }
            }
            if !a && !is_at_wall {
                let finish = |class: usize| self.finish[class * STRAIGHTS + steps];
                if !compare(finish(instead), finish(of)) {
                    return None;
                }
            }
        }
        Some(greatest)
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
fn classes(vehicle: &Vehicle) -> (Vec<Class>, [(u8, u8); 9]) {
    let rest = Class {
        kind: None,
        speed: 0.0,
        after: vehicle.parameters().start_offset,
        ends_diagonal: false,
    };
    let mut classes = alloc::vec![rest];
    let mut ranges = [(0, 0); 9];
    let needed = needed_speeds(vehicle);
    for (kind, range) in ORDER.into_iter().zip(&mut ranges) {
        range.0 = classes.len();
        if let Some(fitted) = vehicle.arc(kind) {
            let (after, ends_diagonal) = (fitted.after, kind.ends_diagonal());
            let class = |&speed| Class { kind: Some(kind), speed, after, ends_diagonal };
            let speeds = vehicle.speeds(kind).iter().enumerate();
            let needed = speeds.filter(|&(index, _)| needed[kind as usize] >> index & 1 == 1);
            classes.extend(needed.map(|(_, speed)| speed).map(class));
        }
        range.1 = classes.len();
    }
    #[allow(clippy::cast_possible_truncation)]
    let ranges = ranges.map(|(low, high): (usize, usize)| (low as u8, high as u8));
    (classes, ranges)
}

/// Returns for each turn the speeds that a fastest run can need, as bits in the order of
/// [`Vehicle::speeds`].
///
/// In a fastest run, no turn can be driven at its next higher speed. So each turn has its greatest
/// speed, or the greatest speed that the turn before or the turn after it allows, and this turn is
/// slower.
fn needed_speeds(vehicle: &Vehicle) -> [u32; 9] {
    let mut needed = TurnKind::ALL.map(|kind| u32::from(vehicle.arc(kind).is_some()));
    let lines = [false, true].map(|is_diagonal| vehicle.line(is_diagonal));
    if lines.iter().any(|line| line.jerk < f64::INFINITY) {
        // With limited jerk, a higher speed at one end may cost time.
        return TurnKind::ALL.map(|kind| (1 << vehicle.speeds(kind).len()) - 1);
    }
    loop {
        let before = needed;
        for first in TurnKind::ALL {
            let is_diagonal = first.ends_diagonal();
            for next in
                TurnKind::ALL.into_iter().filter(|next| next.begins_diagonal() == is_diagonal)
            {
                let (Some(from), Some(to)) = (vehicle.arc(first), vehicle.arc(next)) else {
                    continue;
                };
                for steps in 0..STRAIGHTS {
                    #[allow(clippy::cast_possible_truncation)]
                    let straight = vehicle.straight(steps as u8, is_diagonal);
                    let distance = from.after + straight + to.before;
                    let can = |from, to| {
                        lines[usize::from(is_diagonal)].time(distance, from, to).is_some()
                    };
                    for (turn, other, is_next) in [(first, next, true), (next, first, false)] {
                        for (index, &speed) in vehicle.speeds(other).iter().enumerate() {
                            if needed[other as usize] >> index & 1 == 0 {
                                continue;
                            }
                            let fits = |&turn: &f64| {
                                if is_next { can(turn, speed) } else { can(speed, turn) }
                            };
                            let fastest = vehicle.speeds(turn).iter().position(fits);
                            needed[turn as usize] |= fastest.map_or(0, |index| 1 << index);
                        }
                    }
                }
            }
        }
        let parameters = vehicle.parameters();
        for kind in TurnKind::ALL {
            let Some(fitted) = vehicle.arc(kind) else { continue };
            let speeds = vehicle.speeds(kind);
            for steps in 0..STRAIGHTS {
                #[allow(clippy::cast_possible_truncation)]
                let straight = vehicle.straight(steps as u8, false);
                let mut add = |distance: f64, is_first: bool| {
                    let fits = |&speed: &f64| {
                        let (from, to) = if is_first { (0.0, speed) } else { (speed, 0.0) };
                        lines[0].time(distance, from, to).is_some()
                    };
                    let fastest = speeds.iter().position(fits);
                    needed[kind as usize] |= fastest.map_or(0, |index| 1 << index);
                };
                if !kind.begins_diagonal() {
                    add(parameters.start_offset + straight + fitted.before, true);
                }
                if !kind.ends_diagonal() {
                    add(fitted.after + straight + parameters.stop_offset, false);
                }
            }
        }
        if needed == before {
            return needed;
        }
    }
}
