//! Generators of mazes and vehicles.

use mmsim_fastrun::{Arc, StraightLimits, TurnKind, Vehicle, VehicleParameters};
use mmsim_maze::{Cell, CellSet, MazeSize, Walls};
use proptest::prelude::*;

/// A maze with a start and goals.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) walls: Walls,
    pub(crate) start: Cell,
    pub(crate) goals: CellSet,
}

/// Generates mazes of up to `max_side`×`max_side` cells, with four densities of walls.
pub(crate) fn any_case(max_side: usize) -> impl Strategy<Value = Case> {
    let bits = || prop::collection::vec(any::<[u32; 3]>(), 32);
    let cells = prop::collection::vec(any::<(u8, u8)>(), 2..6);
    ((1..=max_side, 1..=max_side), bits(), bits(), 0..4, cells).prop_map(
        |((width, height), north, east, density, cells)| {
            let size = MazeSize::new(width, height).unwrap();
            let rows = |rows: Vec<[u32; 3]>| {
                let row = |&[a, b, c]: &[u32; 3]| match density {
                    0 => a & b & c,
                    1 => a & b,
                    2 => a & (b | c),
                    _ => a,
                };
                std::array::from_fn(|y| row(&rows[y]))
            };
            let cell = |&(x, y): &(u8, u8)| Cell::new(x % size.width(), y % size.height());
            let walls = Walls::from_rows(size, rows(north), rows(east));
            Case { walls, start: cell(&cells[0]), goals: cells[1..].iter().map(cell).collect() }
        },
    )
}

/// Generates vehicles: presets, some with other limits, fewer turns, shorter and slower arcs.
pub(crate) fn any_vehicle() -> impl Strategy<Value = Vehicle> {
    let limits =
        (0.5..2.0, 0.5..2.0, 1.0..2.0, prop_oneof![3 => Just(f64::INFINITY), 1 => 1e5..1e7]);
    let turns = prop::collection::vec((any::<bool>(), 0.6..1.0, 0.4..1.0), 9);
    (0usize..4, any::<bool>(), limits, turns).prop_filter_map(
        "the vehicle must be possible",
        |(preset, is_changed, (acceleration, braking, top_speed, jerk), turns)| {
            let vehicle = Vehicle::preset(Vehicle::PRESETS[preset]).unwrap();
            if !is_changed {
                return Some(vehicle);
            }
            let VehicleParameters { start_offset, .. } = *vehicle.parameters();
            let change = |limits: &StraightLimits| StraightLimits {
                acceleration: acceleration * limits.acceleration,
                braking: braking * limits.braking,
                top_speed: top_speed * limits.top_speed,
                jerk,
            };
            let arcs = vehicle.parameters().turns.iter().zip(turns);
            let turns = arcs.filter_map(
                |(&(kind, arc), (is_kept, length, speed)): (&(TurnKind, Arc), (bool, f64, f64))| {
                    let length = if kind == TurnKind::L180 { 1.0 } else { length };
                    let arc =
                        Arc { length: arc.length * length, speed: (arc.speed * speed).round() };
                    (is_kept || kind == TurnKind::S90).then_some((kind, arc))
                },
            );
            Vehicle::new(VehicleParameters {
                name: "changed".into(),
                along: change(&vehicle.parameters().along),
                diagonal: vehicle.parameters().diagonal.as_ref().map(change),
                turns: turns.collect(),
                start_offset: start_offset / 2.0,
                ..vehicle.parameters().clone()
            })
            .ok()
        },
    )
}
