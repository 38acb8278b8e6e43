//! What holds for the fastest runs of all mazes and vehicles.
// No run takes infinitely long, and equal speeds are copies of each other.
#![allow(clippy::float_cmp)]

use crate::cases::{Case, any_case, any_vehicle};
use mmsim_fastrun::{Arc, StraightLimits, TurnKind, Vehicle, VehicleParameters, dijkstra, fastest};
use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, Symmetry, Walls};
use proptest::prelude::*;

/// The planner counts in ticks of less than a microsecond, and rounds each straight and each arc.
const TOLERANCE: f64 = 1e-5;

fn time(Case { walls, start, goals }: &Case, vehicle: &Vehicle) -> f64 {
    let run = fastest(walls, *start, goals, vehicle);
    run.map_or(f64::INFINITY, |run| run.time(vehicle).unwrap())
}

fn is_close(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() < TOLERANCE
}

fn changed(vehicle: &Vehicle, change: impl FnOnce(&mut VehicleParameters)) -> Option<Vehicle> {
    let mut parameters = vehicle.parameters().clone();
    change(&mut parameters);
    Vehicle::new(parameters).ok()
}

/// Changes the limits along lines and on diagonals.
fn with_limits(vehicle: &Vehicle, change: impl Fn(&mut StraightLimits)) -> Option<Vehicle> {
    changed(vehicle, |parameters| {
        change(&mut parameters.along);
        parameters.diagonal.iter_mut().for_each(change);
    })
}

proptest! {
    #[test]
    fn plans_are_as_fast_as_those_of_dijkstra(
        case in prop_oneof![any_case(8), any_case(16), any_case(32)],
        vehicle in any_vehicle(),
    ) {
        let Case { walls, start, goals } = &case;
        let twin = dijkstra(walls, *start, goals, &vehicle);
        let run = fastest(walls, *start, goals, &vehicle);
        prop_assert_eq!(run.is_ok(), twin.is_some());
        let (Ok(run), Some((twin, least))) = (run, twin) else { return Ok(()) };
        prop_assert!(run.is_possible(walls, goals), "{}", run);
        let time = run.time(&vehicle).unwrap();
        prop_assert!(is_close(time, least), "{} s: {}\n{} s: {}", time, run, least, twin);
        prop_assert!(is_close(twin.time(&vehicle).unwrap(), least));
        prop_assert!((run.drive(&vehicle).unwrap().duration() - time).abs() < 1e-9);
    }

    #[test]
    fn mirror_images_and_quarter_turns_take_the_same_time(
        case in any_case(16),
        vehicle in any_vehicle(),
    ) {
        let expected = time(&case, &vehicle);
        let maze = Maze::new(case.walls, case.start, case.goals).unwrap();
        for symmetry in [Symmetry::MirrorEastWest, Symmetry::Anticlockwise] {
            let moved = maze.transformed(symmetry);
            let (walls, start, goals) = (moved.walls().clone(), moved.start().cell, *moved.goals());
            let moved = Case { walls, start, goals };
            prop_assert!(is_close(time(&moved, &vehicle), expected));
        }
    }

    #[test]
    fn opening_a_wall_never_makes_a_run_slower(
        mut case in any_case(16),
        vehicle in any_vehicle(),
        opened in prop::collection::vec((any::<u8>(), any::<u8>(), 0usize..4), 1..8),
    ) {
        let before = time(&case, &vehicle);
        let size = case.walls.size();
        for (x, y, heading) in opened {
            let cell = Cell::new(x % size.width(), y % size.height());
            case.walls.set(cell, Heading::ALL[heading], false);
        }
        prop_assert!(time(&case, &vehicle) < before + TOLERANCE || before == f64::INFINITY);
    }

    #[test]
    fn scaling_all_lengths_changes_nothing(
        case in any_case(16),
        vehicle in any_vehicle(),
        scale in 0.5..2.0,
    ) {
        let scaled = changed(&vehicle, |parameters| {
            let VehicleParameters { half_cell, start_offset, stop_offset, .. } = parameters;
            for length in [half_cell, start_offset, stop_offset] {
                *length *= scale;
            }
            for limits in [Some(&mut parameters.along), parameters.diagonal.as_mut()].into_iter().flatten() {
                limits.acceleration *= scale;
                limits.braking *= scale;
                limits.top_speed *= scale;
                limits.jerk *= scale;
            }
            for (_, arc) in &mut parameters.turns {
                arc.length *= scale;
                arc.speed *= scale;
            }
        });
        let Some(scaled) = scaled else { return Ok(()) };
        prop_assert!(is_close(time(&case, &scaled), time(&case, &vehicle)));
    }

    #[test]
    fn better_vehicles_are_never_slower(
        case in any_case(16),
        vehicle in any_vehicle(),
        factor in 1.0..2.0,
        removed in 1usize..9,
    ) {
        let expected = time(&case, &vehicle) + TOLERANCE;
        let better = [
            with_limits(&vehicle, |limits| limits.acceleration *= factor),
            with_limits(&vehicle, |limits| limits.braking *= factor),
            with_limits(&vehicle, |limits| limits.top_speed *= factor),
            with_limits(&vehicle, |limits| limits.jerk *= factor),
        ];
        for better in better.iter().flatten() {
            prop_assert!(time(&case, better) <= expected);
        }
        // Without one turn, but with the same speeds.
        let turns = &vehicle.parameters().turns;
        let Some(&(kind, arc)) = turns.get(removed) else { return Ok(()) };
        let is_same_speed = |&(other, other_arc): &(TurnKind, Arc)| other != kind && other_arc.speed == arc.speed;
        if turns.iter().any(is_same_speed) {
            let fewer = changed(&vehicle, |parameters| {
                parameters.turns.retain(|&(other, _)| other != kind);
            });
            if let Some(fewer) = fewer {
                prop_assert!(time(&case, &fewer) + TOLERANCE >= expected - TOLERANCE);
            }
        }
    }
}

#[test]
fn a_straight_of_14_cells_takes_the_calculated_time() {
    let case = Case {
        walls: Walls::open(MazeSize::new(1, 15).unwrap()),
        start: Cell::new(0, 0),
        goals: [Cell::new(0, 14)].into_iter().collect::<CellSet>(),
    };
    // 2.5 m/s is reached after 183.8 mm.
    let expected = 2.0 * 2500.0 / 17_000.0 + (2610.0 - 2500.0 * 2500.0 / 17_000.0) / 2500.0;
    assert!((time(&case, &Vehicle::expert()) - expected).abs() < 1e-9);
    assert!((expected - 1.1911).abs() < 5e-5);
}

#[test]
fn a_start_in_the_goal_takes_no_time() {
    let size = MazeSize::CLASSIC;
    let case =
        Case { walls: Walls::closed(size), start: Cell::new(7, 7), goals: size.central_cells() };
    for name in Vehicle::PRESETS {
        let vehicle = Vehicle::preset(name).unwrap();
        assert_eq!(time(&case, &vehicle), 0.0);
        let run = fastest(&case.walls, case.start, &case.goals, &vehicle).unwrap();
        let trajectory = run.drive(&vehicle).unwrap();
        assert_eq!((run.turns().len(), trajectory.length(), trajectory.duration()), (0, 0.0, 0.0));
    }
}
