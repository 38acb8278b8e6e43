//! The turns of a vehicle and the speeds at which a fastest run can need them.

use alloc::vec::Vec;

use crate::turn::TurnKind;
use crate::vehicle::Vehicle;

/// The number of lattice steps of the longest straight, and one more.
pub(super) const STRAIGHTS: usize = 64;

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
    pub(super) after: f64,
    pub(super) ends_diagonal: bool,
}

/// The classes of a turn, fastest first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClassRange {
    pub(super) low: u8,
    /// The classes from here on are only needed to stop in a goal right after the turn.
    pub(super) slow: u8,
    pub(super) high: u8,
}

/// Returns the classes, in the order of [`ORDER`] and fastest first, and the range of each turn.
pub(super) fn classes(vehicle: &Vehicle) -> (Vec<Class>, [ClassRange; 9]) {
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
    let has_jerk = |is_diagonal| vehicle.limits(is_diagonal).jerk < f64::INFINITY;
    if has_jerk(false) || has_jerk(true) {
        return TurnKind::ALL.map(|kind| [(1 << vehicle.speeds(kind).len()) - 1, 0]);
    }
    let parameters = vehicle.parameters();
    let mut needed = TurnKind::ALL.map(|kind| [u32::from(vehicle.arc(kind).is_some()), 0]);
    for kind in TurnKind::ALL {
        let Some(fitted) = vehicle.arc(kind) else { continue };
        let speeds = vehicle.speeds(kind);
        let limits = vehicle.limits(false);
        for steps in 0..STRAIGHTS {
            let straight = straight(vehicle, steps, false);
            let (to, from) = (
                parameters.start_offset + straight + fitted.before,
                fitted.after + straight + parameters.stop_offset,
            );
            let reachable = speeds.iter().position(|&speed| limits.time(to, 0.0, speed).is_some());
            let stoppable =
                speeds.iter().position(|&speed| limits.time(from, speed, 0.0).is_some());
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
            vehicle.limits(is_diagonal).time(distance, speed, next).is_some()
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

#[cfg(test)]
mod tests {
    use core::fmt::Write;

    use super::*;
    use crate::vehicle::VehicleParameters;

    /// Lists the classes of a vehicle. Those that are only needed to stop follow a bar.
    fn list(vehicle: &Vehicle) -> alloc::string::String {
        let (classes, ranges) = classes(vehicle);
        let turn = |(kind, range): (TurnKind, ClassRange)| {
            let mut text = alloc::format!("{kind}");
            for class in range.low..range.high {
                let bar = if class == range.slow { " |" } else { "" };
                write!(text, "{bar} {}", classes[usize::from(class)].speed).unwrap();
            }
            text
        };
        let turns = ORDER.into_iter().zip(ranges).filter(|(_, range)| range.low < range.high);
        turns.map(turn).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn turns_have_lower_speeds_only_where_needed() {
        insta::assert_snapshot!(list(&Vehicle::ukmars()), @"s90 500");
        insta::assert_snapshot!(list(&Vehicle::ares()), @"s90 500, l90 909, 45in 850, 180 886, 135in 800, 45out 850, 135out 650, v90 600");
        insta::assert_snapshot!(list(&Vehicle::expert()), @"s90 1050, l90 1600 1400, 45in 1400, 180 1400, 135in 1400, 45out 1700 1400 | 1300, 135out 1400, v90 1300");
        insta::assert_snapshot!(list(&Vehicle::kerise()), @"s90 266, l90 423, 45in 412 354 290, 180 412, 135in 354, 45out 412 354 290, 135out 354, v90 290, k90 755 423");
        let mut limited: VehicleParameters = Vehicle::ares().parameters().clone();
        limited.along.jerk = 1e6;
        let limited = Vehicle::new(limited).unwrap();
        let (classes, _) = classes(&limited);
        let speeds = TurnKind::ALL.map(|kind| limited.speeds(kind).len());
        assert_eq!(classes.len(), 1 + speeds.iter().sum::<usize>());
    }
}
