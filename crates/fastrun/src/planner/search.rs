//! The search for the fastest run.

use alloc::vec::Vec;

use mmsim_maze::{Cell, CellSet, Walls};

use crate::lattice::Direction;

use super::openings::{AlongTurns, DiagonalTurns, Frame, Openings};
use super::rows::{Four, Line};
use super::tables::{IMPOSSIBLE, Tables};

/// A state: a turn has ended at a place, or the mouse stands in the start cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    time: u32,
    /// The state before the turn.
    pub(super) parent: u32,
    /// The next state in the same bucket.
    next: u32,
    node: u16,
    pub(super) class: u8,
    /// The number of lattice steps of the straight before the turn.
    pub(super) steps: u8,
}

const NO_STATE: u32 = u32::MAX;

impl State {
    /// Returns the direction of the mouse and the cell of its node in a maze of up to N×N cells.
    pub(super) fn place<const N: usize>(&self) -> (Direction, usize) {
        let (kind, cell) = (usize::from(self.node) / (N * N), usize::from(self.node) % (N * N));
        let eighths = if kind < DIAGONALS { 2 * kind } else { [1, 3, 7, 5][kind / 2 - 4] };
        (Direction::ALL[eighths % 8], cell)
    }
}

/// The best way to the goal found so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finish {
    time: u32,
    pub(super) state: u32,
    /// The number of lattice steps of the last straight.
    pub(super) steps: u8,
}

/// A state that is neither the quickest one at its node nor worse than another one there.
#[derive(Clone, Copy, Debug)]
struct Other {
    time: u32,
    class: u8,
    next: u32,
}

/// Marks the class of a node that has other states.
const HAS_OTHERS: u8 = 1 << 7;

/// The memory of the search, which the planner keeps.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    pub(super) states: Vec<State>,
    /// The time and the class of the quickest state at each node.
    times: Vec<u32>,
    classes: Vec<u8>,
    /// For each node that is marked with [`HAS_OTHERS`]: the index of the first of the other states
    /// that may be better for what follows.
    others: Vec<u32>,
    other_states: Vec<Other>,
    /// The first state of each bucket. Bucket i contains the states of a range of times; it also
    /// serves for later ranges.
    buckets: Vec<u32>,
}

/// A direction of a frame: north, east, south or west.
const DIRECTIONS: usize = 4;

/// The nodes at centres come first, one for each direction and cell, then those at the walls ahead
/// of the cells, then those on diagonals: the walls ahead of the cells and those between the cells
/// and their northern neighbours, for each of the four diagonal directions.
const CENTRES: usize = 0;
const WALLS: usize = 4;
const DIAGONALS: usize = 8;
const KINDS_OF_NODES: usize = 16;

struct Search<'a, L, const N: usize> {
    tables: &'a Tables,
    memory: &'a mut Memory,
    frames: [Frame<L, N>; DIRECTIONS],
    along: [AlongTurns<L, N>; DIRECTIONS],
    /// For each direction along a row (east, west), and each vertical direction (north, south): the
    /// turns from the walls ahead of the cells, and from those between the cells and their northern
    /// neighbours.
    diagonals: [[[DiagonalTurns<L, N>; 2]; 2]; 2],
    best: Finish,
}

pub(super) fn search<L: Line, const N: usize>(
    tables: &Tables,
    memory: &mut Memory,
    walls: &Walls,
    start: Cell,
    goals: &CellSet,
) -> Option<Finish> {
    let openings = Openings::<L, N>::new(walls, goals).without_dead_ends(start);
    let frames = openings.frames();
    let along = frames.map(|frame| frame.along_turns());
    let [_, east, _, west] = &frames;
    let diagonals = [east, west].map(|frame| [frame.diagonals_up(), frame.diagonals_down()]);
    memory.states.clear();
    memory.times.clear();
    memory.times.resize(KINDS_OF_NODES * N * N, IMPOSSIBLE);
    memory.classes.clear();
    memory.classes.resize(KINDS_OF_NODES * N * N, 0);
    memory.others.resize(KINDS_OF_NODES * N * N, 0);
    memory.other_states.clear();
    memory.buckets.clear();
    memory.buckets.resize(tables.buckets, NO_STATE);
    let best = Finish { time: IMPOSSIBLE, state: NO_STATE, steps: 0 };
    let mut search = Search { tables, memory, frames, along, diagonals, best };
    search.run(start);
    (search.best.state != NO_STATE).then_some(search.best)
}

/// The change of a cell's index for a step north, east, south or west.
const fn step(n: usize, direction: usize) -> isize {
    match direction {
        0 => n as isize,
        1 => 1,
        2 => -(n as isize),
        _ => -1,
    }
}

/// Returns the line of a cell and its position in the line, as seen in a direction.
#[inline(always)]
fn place<L: Line>(direction: usize, x: u32, y: u32) -> (usize, u32) {
    let last = L::BITS - 1;
    match direction {
        0 => (x as usize, y),
        1 => (y as usize, x),
        2 => (x as usize, last - y),
        _ => (y as usize, last - x),
    }
}

impl<L: Line, const N: usize> Search<'_, L, N> {
    fn run(&mut self, start: Cell) {
        let cell = usize::from(start.y) * N + usize::from(start.x);
        for direction in 0..DIRECTIONS {
            let state = self.memory.states.len() as u32;
            let node = (CENTRES + direction) * N * N + cell;
            self.memory.states.push(State {
                time: 0,
                parent: NO_STATE,
                next: NO_STATE,
                node: node as u16,
                class: 0,
                steps: 0,
            });
            self.expand(state);
        }
        let mask = self.tables.buckets - 1;
        let mut bucket = 0_u32;
        let mut empty = 0;
        // All states lie within one turn of the buckets.
        while empty <= mask {
            if u64::from(bucket) << self.tables.bucket_bits >= self.best.time.into() {
                break;
            }
            empty += 1;
            let head = &mut self.memory.buckets[bucket as usize & mask];
            let mut index = core::mem::replace(head, NO_STATE);
            while index != NO_STATE {
                empty = 0;
                let state = self.memory.states[index as usize];
                let node = usize::from(state.node);
                let (time, class) = (self.memory.times[node], self.memory.classes[node]);
                let is_quickest = time == state.time && class & !HAS_OTHERS == state.class;
                if is_quickest || !self.is_worse_than_any(node, state.time, state.class) {
                    self.expand(index);
                }
                index = state.next;
            }
            bucket += 1;
        }
    }

    /// Returns true if a state is no better than another one for anything that may follow.
    #[inline(always)]
    fn is_worse(&self, time: u32, class: u8, other: u32, other_class: u8) -> bool {
        i64::from(other) + i64::from(self.tables.loss(other_class, class)) <= i64::from(time)
    }

    /// Returns true if a state is worse than one of the known states at its node, apart from
    /// itself.
    #[inline(always)]
    fn is_worse_than_any(&self, node: usize, time: u32, class: u8) -> bool {
        let quickest = self.memory.classes[node];
        self.is_worse(time, class, self.memory.times[node], quickest & !HAS_OTHERS)
            || quickest & HAS_OTHERS != 0 && self.is_worse_than_other(node, time, class)
    }

    fn is_worse_than_other(&self, node: usize, time: u32, class: u8) -> bool {
        let mut index = self.memory.others[node];
        while let Some(&Other { time: other, class: other_class, next }) =
            self.memory.other_states.get(index as usize)
        {
            let is_same = (time, class) == (other, other_class);
            if !is_same && self.is_worse(time, class, other, other_class) {
                return true;
            }
            index = next;
        }
        false
    }

    /// Adds a state to those at its node that are not worse than another one.
    fn add(&mut self, node: usize, mut time: u32, mut class: u8) {
        let memory = &mut *self.memory;
        let (known, marked) = (memory.times[node], memory.classes[node]);
        let known_class = marked & !HAS_OTHERS;
        let mark = marked & HAS_OTHERS;
        let replaces = known >= IMPOSSIBLE
            || i64::from(time) + i64::from(self.tables.loss(class, known_class))
                <= i64::from(known);
        if replaces || time < known {
            (memory.times[node], memory.classes[node]) = (time, class | mark);
            (time, class) = (known, known_class);
        }
        if !replaces {
            let next = if mark == 0 { NO_STATE } else { memory.others[node] };
            memory.others[node] = memory.other_states.len() as u32;
            memory.classes[node] |= HAS_OTHERS;
            memory.other_states.push(Other { time, class, next });
        }
    }

    #[inline(always)]
    fn expand(&mut self, index: u32) {
        let state = self.memory.states[index as usize];
        let node = usize::from(state.node);
        let (kind, cell) = (node / (N * N), node % (N * N));
        if kind < WALLS {
            self.expand_along(index, state, kind - CENTRES, cell, false);
        } else if kind < DIAGONALS {
            self.expand_along(index, state, kind - WALLS, cell, true);
        } else {
            self.expand_diagonal(index, state, kind - DIAGONALS, cell);
        }
    }

    fn expand_along(
        &mut self,
        index: u32,
        state: State,
        direction: usize,
        cell: usize,
        is_at_wall: bool,
    ) {
        let tables = self.tables;
        let ahead = step(N, direction);
        let (line, position) = place::<L>(direction, (cell % N) as u32, (cell / N) as u32);
        // The first cell whose centre lies ahead, and the lattice steps to it.
        let first = position + u32::from(is_at_wall);
        let (to_wall, to_centre) = if is_at_wall { (0, 1) } else { (1, 0) };
        let frame = &self.frames[direction];
        let open =
            (!frame.forward.0[line]).shr(first).to_bits().trailing_zeros().min(L::BITS - 1 - first);
        let goals = frame.goals.0[line].shr(first).to_bits() & (u32::MAX >> (31 - open));
        if goals != 0 {
            self.finish(index, state, to_centre, goals);
        }
        let along = &self.along[direction];
        let s90 = [along.s90[0].0[line], along.s90[1].0[line], L::NONE, L::NONE];
        let easy = [&along.l90, &along.in45].map(|turns| turns.each_ref().map(|turn| turn.0[line]));
        let round =
            [&along.l180, &along.in135].map(|turns| turns.each_ref().map(|turn| turn.0[line]));
        let costs = tables.costs(state.class);
        let width = tables.along;
        // To the next line, and to the line before.
        let sides = if direction % 2 == 0 { [1, 3] } else { [0, 2] };
        let back = (direction + 2) % 4;
        let mut exits = L::cut(s90, position, open + u32::from(is_at_wall));
        while let Some((side, at)) = exits.pop() {
            let begin = cell as isize + at as isize * ahead;
            let side = sides[side];
            let node = (WALLS + side) as isize * (N * N) as isize + begin + ahead;
            let steps = 2 * at + to_wall;
            self.relax(index, state, costs, width, steps, 0, node as usize);
        }
        let begin = cell as isize + if is_at_wall { ahead } else { 0 };
        let nodes = (N * N) as isize;
        let mut exits = L::cut([easy[0][0], easy[0][1], easy[1][0], easy[1][1]], first, open);
        while let Some((lane, at)) = exits.pop() {
            let begin = begin + at as isize * ahead;
            let side = sides[lane % 2];
            let aside = step(N, side);
            let corner = begin + ahead;
            let steps = 2 * at + to_centre;
            let (turn, node) = if lane < 2 {
                (1, (CENTRES + side) as isize * nodes + corner + aside)
            } else {
                (2, in45::<N>(direction, side, corner))
            };
            self.relax(index, state, costs, width, steps, turn, node as usize);
        }
        let mut exits = L::cut([round[0][0], round[0][1], round[1][0], round[1][1]], first, open);
        while let Some((lane, at)) = exits.pop() {
            let begin = begin + at as isize * ahead;
            let side = sides[lane % 2];
            let aside = step(N, side);
            let steps = 2 * at + to_centre;
            let (turn, node) = if lane < 2 {
                (3, (CENTRES + back) as isize * nodes + begin + aside)
            } else {
                (4, in135::<N>(direction, side, begin))
            };
            self.relax(index, state, costs, width, steps, turn, node as usize);
        }
    }

    fn expand_diagonal(&mut self, index: u32, state: State, kind: usize, cell: usize) {
        let tables = self.tables;
        // kind = 0..8: (horizontal, vertical, wall) as bits 2, 1 and 0.
        let (horizontal, vertical) = (kind / 4, kind / 2 % 2);
        let (forward, upward) = (1 + 2 * horizontal, 2 * vertical);
        let (ahead, aside) = (step(N, forward), step(N, upward));
        let costs = tables.costs(state.class);
        let width = tables.diagonal;
        let (mut line, mut position) = place::<L>(forward, (cell % N) as u32, (cell / N) as u32);
        let (mut cell, mut is_aside) = (cell as isize, kind % 2 == 1);
        let nodes = (N * N) as isize;
        let (back_forward, back_upward) = ((forward + 2) % 4, 2 - upward);
        let mut steps = 0;
        loop {
            let turns = &self.diagonals[horizontal][vertical][usize::from(is_aside)];
            let bit =
                |rows: &super::rows::Rows<L, N>| rows.0[line].shr(position).to_bits() & 1 == 1;
            if !bit(&turns.next) {
                return;
            }
            let (out45, out135, v90, k90) =
                (bit(&turns.out45), bit(&turns.out135), bit(&turns.v90), bit(&turns.k90));
            if out45 {
                let (direction, end) = if is_aside {
                    let ahead_cell = if vertical == 0 { cell + aside } else { cell };
                    (forward, ahead_cell + ahead)
                } else {
                    (upward, cell + ahead + aside)
                };
                let node = (CENTRES + direction) as isize * nodes + end;
                self.relax(index, state, costs, width, steps, 5, node as usize);
            }
            if out135 {
                let (direction, end) = if is_aside {
                    let behind = if vertical == 0 { cell } else { cell - aside };
                    (back_upward, behind + ahead)
                } else {
                    (back_forward, cell + aside)
                };
                let node = (CENTRES + direction) as isize * nodes + end;
                self.relax(index, state, costs, width, steps, 6, node as usize);
            }
            if v90 {
                let node = if is_aside {
                    diagonal::<N>(forward, back_upward, true, cell + ahead)
                } else {
                    diagonal::<N>(back_forward, upward, false, cell + ahead + aside)
                };
                self.relax(index, state, costs, width, steps, 7, node as usize);
            }
            if k90 {
                let node = if is_aside {
                    diagonal::<N>(forward, back_upward, true, cell + 2 * ahead)
                } else {
                    diagonal::<N>(back_forward, upward, false, cell + ahead + 2 * aside)
                };
                self.relax(index, state, costs, width, steps, 8, node as usize);
            }
            // To the next wall of the diagonal.
            if is_aside {
                if vertical == 0 {
                    cell += aside;
                    line += 1;
                }
            } else {
                cell += ahead;
                position += 1;
                if vertical == 1 {
                    cell += aside;
                    line -= 1;
                }
            }
            is_aside = !is_aside;
            steps += 1;
        }
    }

    fn finish(&mut self, index: u32, state: State, to_first: u32, mut goals: u32) {
        while goals != 0 {
            let steps = 2 * goals.trailing_zeros() + to_first;
            goals &= goals - 1;
            let time = state.time + self.tables.finish(state.class, steps as usize);
            if time < self.best.time {
                self.best = Finish { time, state: index, steps: steps as u8 };
            }
        }
    }

    /// Drives a turn at each of its speeds.
    #[inline(always)]
    fn relax(
        &mut self,
        parent: u32,
        state: State,
        costs: &[u32],
        width: usize,
        steps: u32,
        turn: usize,
        node: usize,
    ) {
        let (low, high) = self.tables.ranges[turn];
        let first = if turn < 5 { 1 } else { 1 + self.tables.along };
        for class in low..high {
            let cost = costs[steps as usize * width + usize::from(class) - first];
            let time = state.time + cost;
            if time >= self.best.time || self.is_worse_than_any(node, time, class) {
                continue;
            }
            self.add(node, time, class);
            let bucket = (time >> self.tables.bucket_bits) as usize & (self.tables.buckets - 1);
            let next = core::mem::replace(
                &mut self.memory.buckets[bucket],
                self.memory.states.len() as u32,
            );
            let state = State { time, parent, next, node: node as u16, class, steps: steps as u8 };
            self.memory.states.push(state);
        }
    }
}

/// Returns the node at a wall of a diagonal that leads to `forward` (east or west) and `upward`
/// (north or south). `cell` is the cell behind the wall as seen to `forward`, or the cell south of
/// the wall.
#[inline(always)]
fn diagonal<const N: usize>(forward: usize, upward: usize, is_aside: bool, cell: isize) -> isize {
    let kind = DIAGONALS + 4 * (forward / 2) + upward + usize::from(is_aside);
    kind as isize * (N * N) as isize + cell
}

/// Returns the southern one of a cell and its neighbour to the north or south.
#[inline(always)]
fn southern<const N: usize>(cell: isize, direction: usize) -> isize {
    if direction == 2 { cell - N as isize } else { cell }
}

/// Returns the node in which the turn by 45° ends that goes round the corner cell.
#[inline(always)]
fn in45<const N: usize>(direction: usize, side: usize, corner: isize) -> isize {
    if direction % 2 == 1 {
        diagonal::<N>(direction, side, true, southern::<N>(corner, side))
    } else {
        diagonal::<N>(side, direction, false, corner)
    }
}

/// Returns the node in which the turn by 135° ends that begins in a cell.
#[inline(always)]
fn in135<const N: usize>(direction: usize, side: usize, begin: isize) -> isize {
    let back = (direction + 2) % 4;
    let (ahead, aside) = (step(N, direction), step(N, side));
    if direction % 2 == 1 {
        diagonal::<N>(back, side, false, begin + ahead + aside)
    } else {
        diagonal::<N>(side, back, true, southern::<N>(begin + ahead + aside, back))
    }
}
