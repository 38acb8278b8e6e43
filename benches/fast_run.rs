//! Measures the planner of fast runs beside the flood of firmware and Dijkstra's algorithm, on
//! classic mazes in random order and on half-size mazes.

use std::cell::RefCell;
use std::hint::black_box;

use criterion::Criterion;
use mmsim_benches::{Nibbles, Row, classic_mazes, compare, large_mazes};
use mmsim_fastrun::{Planner, Vehicle, dijkstra};
use mmsim_maze::Maze;

/// A maze whose goal can be reached, and the same maze as firmware stores it.
struct Prepared {
    maze: Maze,
    nibbles: Nibbles,
}

impl Prepared {
    /// Prepares the mazes, and asserts that every plan is as fast as that of the naive twin.
    fn all(mazes: Vec<Maze>) -> Vec<Self> {
        let planners = &mut planners();
        let mut is_solved = |maze: &Maze| {
            planners.iter_mut().all(|planner| {
                let vehicle = planner.vehicle().clone();
                let (walls, start) = (maze.walls(), maze.start().cell);
                let twin = dijkstra(walls, start, maze.goals(), &vehicle);
                let run = planner.plan(walls, start, maze.goals()).ok();
                match (run.map(|run| run.time(&vehicle).unwrap()), twin) {
                    (Some(time), Some((_, twin))) => {
                        assert!((time - twin).abs() < 1e-5, "{time} s instead of {twin} s");
                        true
                    }
                    (time, twin) => {
                        assert_eq!(time.is_some(), twin.is_some());
                        false
                    }
                }
            })
        };
        let mazes = mazes.into_iter().filter(|maze| is_solved(maze));
        mazes.map(|maze| Self { nibbles: Nibbles::new(&maze), maze }).collect()
    }
}

fn planners() -> [Planner; 4] {
    Vehicle::PRESETS.map(|name| Planner::new(Vehicle::preset(name).unwrap()))
}

fn rows() -> Vec<Row<'static, Prepared>> {
    let flood = Row::new("array queue", |Prepared { maze, nibbles }: &Prepared| {
        if maze.size().area() == 256 {
            black_box(&nibbles.flood::<256, u8>());
        } else {
            black_box(&nibbles.flood::<1024, u16>());
        }
    });
    let plan = |planner: Planner| {
        let name = format!("mmsim, {}", planner.vehicle().name());
        let planner = RefCell::new(planner);
        Row::new(&name, move |Prepared { maze, .. }: &Prepared| {
            let planner = &mut planner.borrow_mut();
            black_box(planner.plan(maze.walls(), maze.start().cell, maze.goals()).is_ok());
        })
    };
    [flood].into_iter().chain(planners().map(plan)).collect()
}

/// Returns a row for each vehicle that plans with Dijkstra's algorithm.
fn naive() -> impl Iterator<Item = Row<'static, Prepared>> {
    ["ukmars", "expert"].into_iter().map(|name| {
        let vehicle = Vehicle::preset(name).unwrap();
        Row::new(&format!("dijkstra, {name}"), move |Prepared { maze, .. }: &Prepared| {
            black_box(dijkstra(maze.walls(), maze.start().cell, maze.goals(), &vehicle));
        })
    })
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let classic = Prepared::all(classic_mazes());
    let large = Prepared::all(large_mazes());
    let with_twins: Vec<_> = rows().into_iter().chain(naive()).collect();
    compare(&mut criterion, "fast-run/mixed", &classic, &with_twins);
    compare(&mut criterion, "fast-run/32x32", &large, &rows());
    criterion.final_summary();
}
