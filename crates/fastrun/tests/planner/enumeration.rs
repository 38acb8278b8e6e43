//! Tries every run in small mazes, and finds none that is faster than the planned one.

use mmsim_fastrun::{Direction, Planner, Point, Side, TurnKind, Vehicle};
use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Walls, WyRand};

/// A generator of pseudorandom mazes.
struct MazeNoise(WyRand);

impl MazeNoise {
    /// Returns a maze in which every cell is reachable, with some loops.
    fn walls(&mut self) -> Walls {
        let size = MazeSize::new(1 + self.0.index(7), 1 + self.0.index(7)).unwrap();
        let mut walls = Walls::closed(size);
        let mut path = vec![Cell::new(0, 0)];
        let mut visited: CellSet = path.iter().copied().collect();
        while let Some(&cell) = path.last() {
            let headings = Heading::ALL.into_iter().filter_map(|heading| {
                let next = size.neighbour(cell, heading).filter(|&next| !visited.contains(next))?;
                Some((heading, next))
            });
            let headings: Vec<_> = headings.collect();
            if headings.is_empty() {
                path.pop();
                continue;
            }
            let (heading, next) = headings[self.0.index(headings.len())];
            walls.set(cell, heading, false);
            visited.insert(next);
            path.push(next);
        }
        for _ in 0..self.0.index(1 + size.area() / 4) {
            let cell = Cell::new(
                self.0.index(size.width().into()).try_into().unwrap(),
                self.0.index(size.height().into()).try_into().unwrap(),
            );
            walls.set(cell, Heading::ALL[self.0.index(4)], false);
        }
        walls
    }
}

/// All runs that may be faster than the fastest one found so far.
struct Runs<'a> {
    vehicle: &'a Vehicle,
    walls: &'a Walls,
    goal: Cell,
    top_speed: f64,
    best: f64,
    count: usize,
}

impl Runs<'_> {
    /// Follows a straight and every turn from it, beginning `after` mm behind a point.
    fn follow(&mut self, mut at: Point, direction: Direction, after: f64, speed: f64, time: f64) {
        self.count += 1;
        let is_diagonal = direction.is_diagonal();
        let limits = *self.vehicle.limits(is_diagonal);
        for steps in 0.. {
            let distance = after + self.vehicle.straight(steps, is_diagonal);
            if at.cell() == Some(self.goal) && !is_diagonal {
                let last =
                    limits.time(distance + self.vehicle.parameters().stop_offset, speed, 0.0);
                self.best = last.map_or(self.best, |last| self.best.min(time + last));
            }
            // The mouse has to come here and to the goal, at its top speed at best.
            let goal = Point::centre(self.goal);
            let (east, north) =
                (f64::from(goal.i) - f64::from(at.i), f64::from(goal.j) - f64::from(at.j));
            let least = (distance + east.hypot(north) * self.vehicle.half_cell()) / self.top_speed;
            if time + least < self.best {
                self.turn(at, direction, distance, speed, time);
            }
            match at.advanced(direction, 1).filter(|next| next.is_free(self.walls)) {
                Some(next) => at = next,
                None => return,
            }
        }
    }

    fn turn(&mut self, at: Point, direction: Direction, distance: f64, speed: f64, time: f64) {
        let vehicle = self.vehicle;
        for kind in TurnKind::ALL {
            let Some(fitted) = vehicle.arc(kind) else { continue };
            for side in Side::ALL.into_iter().filter(|&side| kind.begins_at(at, direction, side)) {
                let mut passed = kind.walls(at, direction, side);
                if !passed.all(|wall| wall.is_some_and(|wall| wall.is_free(self.walls))) {
                    continue;
                }
                let Some((end, next)) = kind.end(at, direction, side) else { continue };
                for &turn_speed in vehicle.speeds(kind) {
                    let limits = vehicle.limits(direction.is_diagonal());
                    let straight = limits.time(distance + fitted.before, speed, turn_speed);
                    let Some(straight) = straight else { continue };
                    let time = time + straight + fitted.arc.length / turn_speed;
                    if time < self.best {
                        self.follow(end, next, fitted.after, turn_speed, time);
                    }
                }
            }
        }
    }
}

#[test]
fn no_run_in_2000_small_mazes_is_faster_than_the_planned_one() {
    let mut planners = Vehicle::PRESETS.map(|name| Planner::new(Vehicle::preset(name).unwrap()));
    let mut noise = MazeNoise(WyRand::new(1));
    let mut count = 0;
    for index in 0..2000 {
        let walls = noise.walls();
        let cells: Vec<_> = walls.size().cells().collect();
        let (start, goal) = (cells[noise.0.index(cells.len())], cells[noise.0.index(cells.len())]);
        let planner = &mut planners[index % 4];
        let vehicle = planner.vehicle().clone();
        let run = planner.plan(&walls, start, &[goal].into_iter().collect()).unwrap();
        let expected = run.time(&vehicle).unwrap();
        let lines = [false, true].map(|is_diagonal| vehicle.limits(is_diagonal).top_speed);
        let top_speed = lines[0].max(lines[1]);
        let mut runs = Runs {
            vehicle: &vehicle,
            walls: &walls,
            goal,
            top_speed,
            best: expected + 1e-5,
            count: 0,
        };
        for heading in Heading::ALL.into_iter().filter(|_| start != goal) {
            let offset = vehicle.parameters().start_offset;
            runs.follow(Point::centre(start), heading.into(), offset, 0.0, 0.0);
        }
        count += runs.count;
        assert!(
            runs.best > expected - 1e-5,
            "maze {index}: {} s is faster than {run}, {expected} s",
            runs.best
        );
        // The enumeration finds the planned run, or one that is as fast.
        assert!(start == goal || runs.best < expected + 1e-5, "maze {index}: {run}");
    }
    assert!(count > 100_000, "{count} runs were tried");
}
