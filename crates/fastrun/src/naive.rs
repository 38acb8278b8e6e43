//! Dijkstra's algorithm over every state of a mouse, the slow twin of the planner.

use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Reverse;

use mmsim_maze::{Cell, CellSet, Direction, Point, Walls};

use crate::run::{FastRun, Turn};
use crate::turn::{Side, TurnKind};
use crate::vehicle::Vehicle;

/// A state of the mouse: the start, or the end of a turn.
struct NaiveState {
    point: Point,
    direction: Direction,
    /// The turn that ends here and its speed, or `None` at the start.
    turn: Option<Turn>,
    parent: usize,
    time: f64,
}

/// Finds the fastest run by Dijkstra's algorithm: the time from the start to the end of every turn
/// at every speed, and from there to the next ones. Returns `None` if no goal can be reached.
///
/// Tests and benchmarks compare this function with [`Planner`](crate::Planner), which is much
/// faster.
pub fn dijkstra(
    walls: &Walls,
    start: Cell,
    goals: &CellSet,
    vehicle: &Vehicle,
) -> Option<(FastRun, f64)> {
    let size = walls.size();
    if !size.contains(start) {
        return None;
    }
    if goals.contains(start) {
        return Some((FastRun::new(start, Direction::North, Vec::new(), 0), 0.0));
    }
    let mut search = NaiveSearch {
        vehicle,
        states: Vec::new(),
        queue: BinaryHeap::new(),
        known: alloc::vec![f64::INFINITY; 65 * 65 * 8 * CLASSES],
        best: None,
    };
    for direction in Direction::ALL.into_iter().filter(|direction| !direction.is_diagonal()) {
        let point = Point::centre(start);
        let index = search.states.len();
        search.states.push(NaiveState { point, direction, turn: None, parent: index, time: 0.0 });
        search.expand(index, walls, goals);
    }
    while let Some(Reverse((time, index))) = search.queue.pop() {
        if search.best.is_some_and(|(best, _, _)| best <= f64::from_bits(time)) {
            break;
        }
        if f64::from_bits(time) <= search.known[search.key(index)] {
            search.expand(index, walls, goals);
        }
    }
    let (time, last, steps) = search.best?;
    let (mut turns, mut at) = (Vec::new(), last);
    while let Some(turn) = search.states[at].turn {
        turns.push(turn);
        at = search.states[at].parent;
    }
    turns.reverse();
    Some((FastRun::new(start, search.states[at].direction, turns, steps), time))
}

/// The maximum number of turns and speeds: nine turns at up to nine speeds.
const CLASSES: usize = 81;

struct NaiveSearch<'a> {
    vehicle: &'a Vehicle,
    states: Vec<NaiveState>,
    /// Times as bits, which have the same order as positive numbers, and indices of states.
    queue: BinaryHeap<Reverse<(u64, usize)>>,
    /// The least known time of each state.
    known: Vec<f64>,
    /// The least time to a goal, the state before it, and the lattice steps from there.
    best: Option<(f64, usize, u8)>,
}

impl NaiveSearch<'_> {
    fn key(&self, index: usize) -> usize {
        let NaiveState { point, direction, turn, .. } = &self.states[index];
        let class = turn.map_or(0, |turn| {
            let speeds = self.vehicle.speeds(turn.kind);
            let speed = speeds.partition_point(|&speed| speed > turn.speed);
            turn.kind as usize * 9 + speed
        });
        let place = usize::from(point.i) * 65 + usize::from(point.j);
        (place * 8 + *direction as usize) * CLASSES + class
    }

    /// Follows the straight from a state, and every turn from each of its points.
    fn expand(&mut self, index: usize, walls: &Walls, goals: &CellSet) {
        let NaiveState { mut point, direction, turn, time, .. } = self.states[index];
        let fitted = turn.and_then(|turn| self.vehicle.arc(turn.kind));
        let parameters = self.vehicle.parameters();
        let after = fitted.map_or(parameters.start_offset, |fitted| fitted.after);
        let speed = turn.map_or(0.0, |turn| turn.speed);
        let is_diagonal = direction.is_diagonal();
        let limits = *self.vehicle.limits(is_diagonal);
        for steps in 0..=u8::MAX {
            let distance = after + self.vehicle.straight(steps, is_diagonal);
            let is_goal = !is_diagonal && point.cell().is_some_and(|cell| goals.contains(cell));
            if is_goal {
                let last = limits.time(distance + parameters.stop_offset, speed, 0.0);
                let total = last.map(|last| time + last);
                if let Some(total) =
                    total.filter(|&total| self.best.is_none_or(|(best, _, _)| total < best))
                {
                    self.best = Some((total, index, steps));
                }
            }
            for kind in TurnKind::ALL {
                for side in Side::ALL {
                    if self.vehicle.arc(kind).is_none() || !kind.begins_at(point, direction, side) {
                        continue;
                    }
                    let mut passed = kind.walls(point, direction, side);
                    if !passed.all(|wall| wall.is_some_and(|wall| wall.is_free(walls))) {
                        continue;
                    }
                    self.turn(index, (point, direction), (steps, distance), (kind, side));
                }
            }
            match point.advanced(direction, 1) {
                Some(next) if next.is_free(walls) => point = next,
                _ => break,
            }
        }
    }

    /// Adds the states after a straight and a turn, one for each speed of the turn.
    fn turn(
        &mut self,
        parent: usize,
        (from, heading): (Point, Direction),
        (straight, distance): (u8, f64),
        (kind, side): (TurnKind, Side),
    ) {
        let NaiveState { turn: before, time, .. } = self.states[parent];
        let vehicle = self.vehicle;
        let Some(fitted) = vehicle.arc(kind) else { return };
        let Some((point, direction)) = kind.end(from, heading, side) else { return };
        let entry_speed = before.map_or(0.0, |turn| turn.speed);
        let limits = vehicle.limits(heading.is_diagonal());
        for &speed in vehicle.speeds(kind) {
            let before = limits.time(distance + fitted.before, entry_speed, speed);
            let Some(before) = before else { continue };
            let time = time + before + fitted.arc.length / speed;
            let index = self.states.len();
            let turn = Some(Turn { straight, kind, side, speed });
            self.states.push(NaiveState { point, direction, turn, parent, time });
            let key = self.key(index);
            if time < self.known[key] {
                self.known[key] = time;
                self.queue.push(Reverse((time.to_bits(), index)));
            } else {
                self.states.pop();
            }
        }
    }
}
