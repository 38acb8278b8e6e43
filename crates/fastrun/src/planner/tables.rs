//! The costs of straights and turns as whole numbers, computed once for each vehicle.

use alloc::vec::Vec;

use crate::lattice::Direction;
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
    /// The number of classes of turns that begin along a line.
    pub(super) along: usize,
    /// The number of classes of turns that begin on a diagonal.
    pub(super) diagonal: usize,
    /// For each class, each number of lattice steps, and each class of the next turn that begins in
    /// the direction in which the first turn ends: the time of the straight and the arc.
    costs: Vec<u32>,
    /// For each class and each number of lattice steps: the time of the last straight.
    finish: Vec<u32>,
    /// `losses[a][b]` is the greatest difference between the costs of everything that may follow a
    /// turn of class a, and the costs of the same after a turn of class b.
    losses: Vec<i32>,
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
        let ticks = ticks_per_second(vehicle);
        let mut tables = Self {
            along,
            diagonal,
            ranges,
            costs: Vec::new(),
            finish: Vec::new(),
            losses: Vec::new(),
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

    /// Returns the number of classes of turns that can follow a turn of this class.
    pub(super) fn width(&self, class: u8) -> usize {
        if self.classes[usize::from(class)].ends_diagonal { self.diagonal } else { self.along }
    }

    /// Returns the costs from a class to the next turns: for each number of lattice steps, one cost
    /// for each class of the next turn.
    #[inline(always)]
    pub(super) fn costs(&self, class: u8) -> &[u32] {
        let each = STRAIGHTS * self.along.max(self.diagonal);
        &self.costs[usize::from(class) * each..][..each]
    }

    #[inline(always)]
    pub(super) fn finish(&self, class: u8, steps: usize) -> u32 {
        self.finish[usize::from(class) * STRAIGHTS + steps % STRAIGHTS]
    }

    #[inline(always)]
    pub(super) fn loss(&self, instead: u8, of: u8) -> i32 {
        self.losses[usize::from(instead) * self.classes.len() + usize::from(of)]
    }

    fn add_costs(&mut self, vehicle: &Vehicle, ticks: f64) {
        let parameters = vehicle.parameters();
        for index in 0..self.classes.len() {
            let class = &self.classes[index];
            let line = vehicle.line(class.ends_diagonal);
            let next = self.following(class.ends_diagonal);
            let room = STRAIGHTS * self.along.max(self.diagonal);
            let start = self.costs.len();
            for steps in 0..STRAIGHTS {
                #[allow(clippy::cast_possible_truncation)]
                let straight = class.after + vehicle.straight(steps as u8, class.ends_diagonal);
                let last = straight + parameters.stop_offset;
                let finish =
                    if class.ends_diagonal { None } else { line.time(last, class.speed, 0.0) };
                self.finish.push(finish.map_or(IMPOSSIBLE, |time| to_ticks(time * ticks)));
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
            }
            self.costs.resize(start + room, IMPOSSIBLE);
        }
    }

    /// Returns the classes of turns that begin on a diagonal, or along a line.
    fn following(&self, is_diagonal: bool) -> core::ops::Range<usize> {
        let all = self.classes.len();
        if is_diagonal { 1 + self.along..all } else { 1..1 + self.along }
    }

    fn add_losses(&mut self) {
        let all = self.classes.len();
        let mut losses = alloc::vec![i32::MAX / 2; all * all];
        for instead in 0..all {
            for of in 0..all {
                if let Some(loss) = self.greatest_loss(instead, of) {
                    losses[instead * all + of] = loss;
                }
            }
        }
        self.losses = losses;
    }

    /// Returns the greatest difference of costs, or `None` if what follows is possible only after
    /// the other class, or if the two never end at the same place in the same direction.
    fn greatest_loss(&self, instead: usize, of: usize) -> Option<i32> {
        let place = |class: &Class| (class.ends_diagonal, class.kind == Some(TurnKind::S90));
        if place(&self.classes[instead]) != place(&self.classes[of]) {
            return None;
        }
        let width = self.width(u8::try_from(of).ok()?);
        let [instead_index, of_index] = [instead, of].map(|class| u8::try_from(class).unwrap_or(0));
        let rows = |class| self.costs(class)[..STRAIGHTS * width].iter();
        let finish = |class: usize| self.finish[class * STRAIGHTS..][..STRAIGHTS].iter();
        let pairs = rows(instead_index).zip(rows(of_index)).chain(finish(instead).zip(finish(of)));
        let mut greatest = i32::MIN;
        for (&instead, &of) in pairs.filter(|&(_, &of)| of < IMPOSSIBLE) {
            if instead >= IMPOSSIBLE {
                return None;
            }
            greatest = greatest.max(instead.cast_signed() - of.cast_signed());
        }
        Some(greatest)
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
    for (kind, range) in ORDER.into_iter().zip(&mut ranges) {
        range.0 = classes.len();
        if let Some(fitted) = vehicle.arc(kind) {
            let (after, ends_diagonal) = (fitted.after, kind.ends_diagonal());
            let class = |&speed| Class { kind: Some(kind), speed, after, ends_diagonal };
            classes.extend(needed_speeds(vehicle, kind).iter().map(class));
        }
        range.1 = classes.len();
    }
    #[allow(clippy::cast_possible_truncation)]
    let ranges = ranges.map(|(low, high): (usize, usize)| (low as u8, high as u8));
    (classes, ranges)
}

fn needed_speeds(vehicle: &Vehicle, kind: TurnKind) -> &[f64] {
    vehicle.speeds(kind)
}

/// Returns true if a turn of the first kind can end where one of the second kind begins, after some
/// straight.
#[allow(dead_code)]
fn can_follow(first: TurnKind, next: TurnKind) -> bool {
    let _ = Direction::North;
    first.ends_diagonal() == next.begins_diagonal()
}
