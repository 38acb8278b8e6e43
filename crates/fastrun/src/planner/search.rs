//! The search for the fastest run: Dijkstra's algorithm over the ends of turns.
//!
//! - States wait in buckets as wide as the quickest turn, so the states of a bucket can be handled
//!   in any order (Dial, 1969).
//! - A state is dropped if another state at its node is better for everything that may follow.
//! - Driving straight on ends at a centre where a better state is known.
// Nodes (below 16,384), steps (below 64), positions and lines (below 32) fit into their types, and
// the states of a search into 32 bits.
#![allow(clippy::cast_possible_truncation)]

use alloc::vec::Vec;

use mmsim_maze::{Cell, CellSet, Walls};

use super::classes::ClassRange;
use super::openings::{AlongTurns, DiagonalTurns, Frame, Openings};
use super::rows::{Eight, Four, Line, Rows};
use super::tables::{Costs, IMPOSSIBLE, Tables};
use super::targets::{DIAGONALS, KINDS, Targets, WALLS, centre_node};

/// A state: a turn has ended at a place, or the mouse stands in the start cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    time: u32,
    /// The state before the turn.
    pub(super) parent: u32,
    /// The next state in the same bucket.
    next: u32,
    pub(super) node: u16,
    pub(super) class: u8,
    /// The number of lattice steps of the straight before the turn.
    pub(super) steps: u8,
}

const NO_STATE: u32 = u32::MAX;

/// The end of the fastest run found so far.
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
    class: u16,
    next: u32,
}

/// Marks the class of a node that has other states.
const HAS_OTHERS: u16 = 1 << 15;
/// Marks the class of a node at the centre of a goal.
const IS_GOAL: u16 = 1 << 14;
const CLASS: u16 = IS_GOAL - 1;

/// The memory of the search, which the planner keeps.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    pub(super) states: Vec<State>,
    /// The time and the class of the quickest state at each node.
    times: Vec<u32>,
    classes: Vec<u16>,
    /// For each node that is marked with [`HAS_OTHERS`]: the index of the first of the other states
    /// that may be better for what follows.
    others: Vec<u32>,
    other_states: Vec<Other>,
    /// For each direction and line, the cells at whose centres states are known, as bits.
    reached: Vec<u32>,
    /// The first state of each bucket. Bucket i contains the states of a range of times; it also
    /// serves for later ranges.
    buckets: Vec<u32>,
}

/// Where a straight begins: the state, its time, and the costs of what follows.
#[derive(Clone, Copy)]
struct Origin<'a> {
    state: u32,
    time: u32,
    costs: Costs<'a>,
}

impl Memory {
    /// Prepares the memory for a maze with lines of `n` cells.
    fn clear(&mut self, n: usize, kinds: usize, buckets: usize) {
        let nodes = kinds * n * n;
        self.reached.clear();
        self.reached.resize(4 * n, 0);
        self.states.clear();
        self.times.clear();
        self.times.resize(nodes, IMPOSSIBLE);
        self.classes.clear();
        self.classes.resize(nodes, 0);
        self.others.resize(nodes, 0);
        self.other_states.clear();
        self.buckets.clear();
        self.buckets.resize(buckets, NO_STATE);
    }
}

struct Search<'a, L, const N: usize> {
    tables: &'a Tables,
    targets: &'a Targets,
    memory: &'a mut Memory,
    /// For each direction, the openings and goals, and the turns.
    frames: [Frame<L, N>; 4],
    along: [AlongTurns<L, N>; 4],
    /// For each kind of nodes on diagonals, the turns.
    diagonals: [DiagonalTurns<L, N>; 8],
    best: Finish,
}

/// Finds the fastest run. No goal lies outside of the maze, and the start is no goal.
pub(super) fn search<L: Line, const N: usize>(
    tables: &Tables,
    targets: &Targets,
    memory: &mut Memory,
    walls: &Walls,
    start: Cell,
    goals: &CellSet,
) -> Option<Finish> {
    let openings = Openings::<L, N>::new(walls, goals).without_dead_ends(start);
    let frames = openings.frames();
    let along = frames.map(|frame| frame.along_turns(tables));
    let diagonals = if tables.only_s90 {
        [DiagonalTurns::NONE; 8]
    } else {
        let [_, east, _, west] = &frames;
        let [a, b] = [east, west].map(|frame| frame.diagonals_up(tables));
        let [c, d] = [east, west].map(|frame| frame.diagonals_down(tables));
        [a[0], a[1], c[0], c[1], b[0], b[1], d[0], d[1]]
    };
    memory.clear(N, if tables.only_s90 { DIAGONALS } else { KINDS }, tables.buckets);
    for goal in goals {
        for direction in 0..4 {
            memory.classes[centre_node(direction, goal, N)] |= IS_GOAL;
        }
    }
    let best = Finish { time: IMPOSSIBLE, state: NO_STATE, steps: 0 };
    let mut search = Search { tables, targets, memory, frames, along, diagonals, best };
    search.run(start);
    (search.best.state != NO_STATE).then_some(search.best)
}

impl<L: Line, const N: usize> Search<'_, L, N> {
    fn run(&mut self, start: Cell) {
        for direction in 0..4 {
            let node = centre_node(direction, start, N) as u16;
            let index = self.memory.states.len() as u32;
            let (parent, next) = (NO_STATE, NO_STATE);
            self.memory.states.push(State { time: 0, parent, next, node, class: 0, steps: 0 });
            self.expand(index);
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
                let is_quickest = time == state.time && class & CLASS == state.class.into();
                if is_quickest || !self.is_worse_than_any(node, state.time, state.class.into()) {
                    self.expand(index);
                }
                index = state.next;
            }
            bucket += 1;
        }
    }

    /// Returns true if a state is no better than another one for anything that may follow.
    #[inline(always)]
    fn is_worse(&self, time: u32, class: u16, other: u32, other_class: u16) -> bool {
        other.wrapping_add_signed(self.tables.loss(other_class, class)) <= time
    }

    /// Returns true if a state is worse than one of the known states at its node, apart from
    /// itself.
    #[inline(always)]
    fn is_worse_than_any(&self, node: usize, time: u32, class: u16) -> bool {
        let quickest = self.memory.classes[node];
        self.is_worse(time, class, self.memory.times[node], quickest & CLASS)
            || quickest & HAS_OTHERS != 0 && self.is_worse_than_other(node, time, class)
    }

    fn is_worse_than_other(&self, node: usize, time: u32, class: u16) -> bool {
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
    fn add(&mut self, node: usize, mut time: u32, mut class: u16) {
        let memory = &mut *self.memory;
        let (known, marked) = (memory.times[node], memory.classes[node]);
        let (known_class, marks) = (marked & CLASS, marked & !CLASS);
        let is_first = known >= IMPOSSIBLE;
        let loss = self.tables.loss(class, known_class);
        let replaces = is_first || time.wrapping_add_signed(loss) <= known;
        if is_first && node < WALLS * N * N {
            memory.reached[node / N] |= 1 << (node % N);
        }
        if replaces || time < known {
            (memory.times[node], memory.classes[node]) = (time, class | marks);
            (time, class) = (known, known_class);
        }
        if !replaces {
            let next = if marks & HAS_OTHERS == 0 { NO_STATE } else { memory.others[node] };
            memory.others[node] = memory.other_states.len() as u32;
            memory.classes[node] |= HAS_OTHERS;
            memory.other_states.push(Other { time, class, next });
        }
    }

    #[inline(always)]
    fn expand(&mut self, index: u32) {
        let state = self.memory.states[index as usize];
        let node = usize::from(state.node);
        let (kind, line, position) = (node / (N * N), node / N % N, node % N);
        if kind < DIAGONALS {
            self.expand_along(index, state, kind, line, position as u32);
        } else {
            self.expand_diagonal(index, state, kind - DIAGONALS, line, position as u32);
        }
    }

    /// Drives straight on along a line, and every turn that begins there.
    fn expand_along(&mut self, index: u32, state: State, kind: usize, line: usize, position: u32) {
        let (tables, direction) = (self.tables, kind % 4);
        let is_at_wall = u32::from(kind >= WALLS);
        // The position of the first centre ahead.
        let first = position + is_at_wall;
        let frame = &self.frames[direction];
        // The number of centres after the first one.
        let mut open = frame.forward.0[line].shr(first).trailing_ones();
        let goals = frame.goals.0[line].shr(first).to_bits() & (u32::MAX >> (31 - open));
        if goals != 0 {
            self.finish(index, state, is_at_wall, goals);
        } else {
            open = self.until_better(state, direction * N + line, first, is_at_wall, open);
        }
        let origin = Origin { state: index, time: state.time, costs: tables.costs(state.class) };
        let turns = |lane: usize| self.along[direction].0[lane].0[line];
        let mut s90 = L::cut([turns(0), turns(1), L::NONE, L::NONE], position, open + is_at_wall);
        let others = (!tables.only_s90).then(|| {
            let easy = [turns(2), turns(3), turns(4), turns(5)];
            let round = [turns(6), turns(7), turns(8), turns(9)];
            Eight(L::cut(easy, first, open), L::cut(round, first, open))
        });
        let targets = &self.targets.along[direction];
        while let Some((side, at)) = s90.pop() {
            let node = targets[side].node(line, position + at);
            self.relax(origin, 2 * at + 1 - is_at_wall, 0, node);
        }
        let Some(mut others) = others else { return };
        while let Some((lane, at)) = others.pop() {
            let node = targets[2 + lane].node(line, first + at);
            self.relax(origin, 2 * at + is_at_wall, 1 + lane / 2, node);
        }
    }

    /// Returns the number of centres after the first one, up to a centre where a better state is
    /// known. There are `open` centres before the next wall.
    #[inline(always)]
    fn until_better(&self, state: State, line: usize, first: u32, to_first: u32, open: u32) -> u32 {
        let mut known = self.memory.reached[line] >> first & (u32::MAX >> (31 - open));
        // Apart from the state itself.
        known &= !(1 - to_first);
        while known != 0 {
            let cells = known.trailing_zeros();
            let node = line * N + (first + cells) as usize;
            let (time, class) = (self.memory.times[node], self.memory.classes[node] & CLASS);
            let steps = 2 * cells + to_first;
            let loss = self.tables.loss_after(class, state.class.into(), steps);
            if time.wrapping_add_signed(loss) <= state.time {
                return cells;
            }
            known &= known - 1;
        }
        open
    }

    /// Drives straight on along a diagonal, and every turn that begins there.
    fn expand_diagonal(
        &mut self,
        index: u32,
        state: State,
        mut kind: usize,
        mut line: usize,
        mut position: u32,
    ) {
        let costs = self.tables.costs(state.class);
        let origin = Origin { state: index, time: state.time, costs };
        let targets = &self.targets.diagonal;
        let is_down = kind / 2 % 2;
        let mut steps = 0;
        loop {
            let turns = &self.diagonals[kind];
            let bit = |rows: &Rows<L, N>| rows.0[line % N].shr(position).to_bits() & 1;
            if bit(&turns.next) == 0 {
                return;
            }
            let mut exits = bit(&turns.turns[0])
                | bit(&turns.turns[1]) << 1
                | bit(&turns.turns[2]) << 2
                | bit(&turns.turns[3]) << 3;
            while exits != 0 {
                let turn = exits.trailing_zeros() as usize;
                exits &= exits - 1;
                let node = targets[kind][turn].node(line, position);
                self.relax(origin, steps, 5 + turn, node);
            }
            // The next wall of the diagonal belongs to the cell ahead or to its southern neighbour.
            let is_aside = kind % 2;
            position += 1 - is_aside as u32;
            line = line + (is_aside & !is_down) - (is_down & !is_aside & 1);
            kind ^= 1;
            steps += 1;
        }
    }

    /// Stops in each of the goals, whose bits are counted from the first centre ahead.
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

    /// Drives a straight and a turn, at each of its speeds.
    #[inline(always)]
    fn relax(&mut self, origin: Origin<'_>, steps: u32, turn: usize, node: usize) {
        if self.memory.classes[node] & IS_GOAL != 0 {
            self.stop_after(origin, steps, turn, node);
        }
        let ClassRange { low, slow, .. } = self.tables.ranges[turn];
        let first = self.tables.first[usize::from(turn >= 5)];
        for class in low..slow {
            let time = origin.time + origin.costs.at(steps, usize::from(class) - first);
            if time >= self.best.time || self.is_worse_than_any(node, time, class.into()) {
                continue;
            }
            self.add(node, time, class.into());
            let bucket = (time >> self.tables.bucket_bits) as usize & (self.tables.buckets - 1);
            let (index, parent) = (self.memory.states.len() as u32, origin.state);
            let next = core::mem::replace(&mut self.memory.buckets[bucket], index);
            let (node, steps) = (node as u16, steps as u8);
            self.memory.states.push(State { time, parent, next, node, class, steps });
        }
    }

    /// Drives a straight and a turn into a goal, and stops right after it.
    #[cold]
    fn stop_after(&mut self, origin: Origin<'_>, steps: u32, turn: usize, node: usize) {
        let ClassRange { low, high, .. } = self.tables.ranges[turn];
        let first = self.tables.first[usize::from(turn >= 5)];
        for class in low..high {
            let time = origin.time + origin.costs.at(steps, usize::from(class) - first);
            let end = time + self.tables.finish(class, 0);
            if end < self.best.time {
                self.best = Finish { time: end, state: self.memory.states.len() as u32, steps: 0 };
                let (parent, next) = (origin.state, NO_STATE);
                let (node, steps) = (node as u16, steps as u8);
                self.memory.states.push(State { time, parent, next, node, class, steps });
            }
        }
    }
}
