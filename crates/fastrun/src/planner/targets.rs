//! Nodes of the search, and where turns lead from one to another.

use core::array::from_fn;

use mmsim_maze::Direction;

/// The nodes at centres come first, one for each direction and cell, then those at the walls ahead
/// of the cells.
pub(super) const WALLS: usize = 4;
/// After them come the nodes on diagonals: see [`diagonal`].
pub(super) const DIAGONALS: usize = 8;
pub(super) const KINDS: usize = 16;

/// The end of a turn, as a linear function of the line and the position where it begins. All
/// numbers are modulo 2^64.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    origin: usize,
    line: usize,
    position: usize,
}

impl Target {
    #[inline(always)]
    pub(super) fn node(&self, line: usize, position: u32) -> usize {
        let line = line.wrapping_mul(self.line);
        let position = (position as usize).wrapping_mul(self.position);
        self.origin.wrapping_add(line).wrapping_add(position)
    }
}

/// The ends of all turns in mazes with lines of `n` cells.
#[derive(Clone, Debug)]
pub(super) struct Targets {
    /// For each direction, the turns `s90`, `l90`, `45in`, `180` and `135in`, each first towards
    /// the next line and then towards the line before.
    pub(super) along: [[Target; 10]; 4],
    /// For each kind of node on diagonals, the turns `45out`, `135out`, `v90` and `k90`.
    pub(super) diagonal: [[Target; 4]; 8],
}

/// North, east, south and west, as steps of x and y.
const STEPS: [(usize, usize); 4] = [(0, 1), (1, 0), (0, usize::MAX), (usize::MAX, 0)];

type Cell = (usize, usize);

fn shifted((x, y): Cell, direction: usize) -> Cell {
    (x.wrapping_add(STEPS[direction].0), y.wrapping_add(STEPS[direction].1))
}

/// Returns the cell at a position of a line.
fn cell(direction: usize, line: usize, position: usize, n: usize) -> Cell {
    match direction {
        0 => (line, position),
        1 => (position, line),
        2 => (line, n - 1 - position),
        _ => (n - 1 - position, line),
    }
}

fn node(kind: usize, direction: usize, (x, y): Cell, n: usize) -> usize {
    let (line, position) = match direction {
        0 => (x, y),
        1 => (y, x),
        2 => (x, n - 1 - y),
        _ => (y, n - 1 - x),
    };
    (kind * n + line) * n + position
}

/// Returns the node at the centre of a cell.
fn centre(direction: usize, cell: Cell, n: usize) -> usize {
    node(direction, direction, cell, n)
}

/// Returns the node at the wall ahead of a cell.
fn wall(direction: usize, cell: Cell, n: usize) -> usize {
    node(WALLS + direction, direction, cell, n)
}

/// Returns the node at the wall between two neighbouring cells, on a diagonal that leads from the
/// first to the second cell.
///
/// There is one kind of nodes for each horizontal direction (east, west), each vertical direction
/// (north, south), and each orientation of the wall: ahead of a cell as seen in the horizontal
/// direction, or between a cell and its northern neighbour. The node belongs to this cell.
fn diagonal(directions: [usize; 2], from: Cell, to: Cell, n: usize) -> usize {
    let [horizontal, vertical] =
        if directions[0] % 2 == 1 { directions } else { [directions[1], directions[0]] };
    let is_aside = from.0 == to.0;
    let cell = if is_aside { (from.0, from.1.min(to.1)) } else { from };
    let kind = DIAGONALS + horizontal / 2 * 4 + vertical + usize::from(is_aside);
    node(kind, horizontal, cell, n)
}

impl Targets {
    pub(super) fn new(n: usize) -> Self {
        // All cells in question lie within the smallest maze.
        const SAMPLE: usize = 5;
        let target = |end: &dyn Fn(usize, usize) -> usize| {
            let sample = end(SAMPLE, SAMPLE);
            let line = end(SAMPLE + 1, SAMPLE).wrapping_sub(sample);
            let position = end(SAMPLE, SAMPLE + 1).wrapping_sub(sample);
            let origin = sample.wrapping_sub(SAMPLE.wrapping_mul(line.wrapping_add(position)));
            Target { origin, line, position }
        };
        let along = from_fn(|ahead| {
            from_fn(|lane| {
                let side = [[1, 3], [0, 2]][ahead % 2][lane % 2];
                let back = (ahead + 2) % 4;
                target(&|line, position| {
                    let begin = cell(ahead, line, position, n);
                    let (corner, beside) = (shifted(begin, ahead), shifted(begin, side));
                    let across = shifted(corner, side);
                    match lane / 2 {
                        0 => wall(side, corner, n),
                        1 => centre(side, across, n),
                        2 => diagonal([ahead, side], corner, across, n),
                        3 => centre(back, beside, n),
                        _ => diagonal([back, side], across, beside, n),
                    }
                })
            })
        });
        let diagonal = from_fn(|kind| {
            let (horizontal, vertical, is_aside) =
                (1 + kind / 4 * 2, kind / 2 % 2 * 2, kind % 2 == 1);
            // The direction across the wall, and the other one.
            let (ahead, aside) =
                if is_aside { (vertical, horizontal) } else { (horizontal, vertical) };
            from_fn(|turn| {
                target(&|line, position| {
                    let at = cell(horizontal, line, position, n);
                    let behind = if is_aside && vertical == 2 { shifted(at, 0) } else { at };
                    let next = shifted(behind, ahead);
                    let (far, near) = (shifted(next, aside), shifted(behind, aside));
                    let back = (ahead + 2) % 4;
                    match turn {
                        0 => centre(aside, far, n),
                        1 => centre(back, near, n),
                        2 => diagonal([back, aside], far, near, n),
                        _ => diagonal([back, aside], shifted(far, aside), shifted(near, aside), n),
                    }
                })
            })
        });
        Self { along, diagonal }
    }
}

/// Returns the node of a mouse at the centre of a cell.
pub(super) fn centre_node(direction: usize, cell: mmsim_maze::Cell, n: usize) -> usize {
    centre(direction, (cell.x.into(), cell.y.into()), n)
}

/// Returns the direction of the mouse at a node, and its cell.
pub(super) fn place(node: usize, n: usize) -> (Direction, Cell) {
    let (kind, line, position) = (node / (n * n), node / n % n, node % n);
    let (ahead, eighths) = if kind < DIAGONALS {
        (kind % 4, kind % 4 * 2)
    } else {
        (1 + (kind - DIAGONALS) / 4 * 2, [1, 3, 7, 5][kind / 2 - 4])
    };
    (Direction::ALL[eighths], cell(ahead, line, position, n))
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Point;

    use super::*;
    use crate::planner::classes::ORDER;
    use crate::turn::Side;

    /// Returns the lattice point of a node.
    fn point(node: usize, n: usize) -> Point {
        let kind = node / (n * n);
        let (direction, (x, y)) = place(node, n);
        let centre =
            Point::centre(mmsim_maze::Cell::new(x.try_into().unwrap(), y.try_into().unwrap()));
        let to_wall = match kind {
            0..WALLS => return centre,
            WALLS..DIAGONALS => direction,
            _ if kind % 2 == 1 => Direction::North,
            _ => Direction::ALL[2 + (kind - DIAGONALS) / 4 * 4],
        };
        centre.advanced(to_wall, 1).unwrap()
    }

    #[test]
    fn targets_are_the_ends_of_turns() {
        for n in [16, 32] {
            let targets = Targets::new(n);
            for kind in 0..KINDS {
                for (line, position) in [(5, 7), (8, 3)] {
                    let from = (kind * n + line) * n + position;
                    let (begin, (direction, _)) = (point(from, n), place(from, n));
                    let check = |turn: usize, target: &Target| {
                        let kind = ORDER[turn];
                        let ends = Side::ALL.into_iter().filter_map(|side| {
                            let begins = kind.begins_at(begin, direction, side);
                            kind.end(begin, direction, side).filter(|_| begins)
                        });
                        let node = target.node(line, position.try_into().unwrap());
                        let end = (point(node, n), place(node, n).0);
                        assert!(
                            ends.into_iter().any(|found| found == end),
                            "{kind} {begin:?} {direction}"
                        );
                        end
                    };
                    match kind {
                        0..WALLS => {
                            for (lane, target) in targets.along[kind].iter().enumerate().skip(2) {
                                let other = check(lane / 2, &targets.along[kind][lane ^ 1]);
                                assert_ne!(check(lane / 2, target), other);
                            }
                        }
                        WALLS..DIAGONALS => {
                            let [left, right, ..] = &targets.along[kind - WALLS];
                            assert_ne!(check(0, left), check(0, right));
                        }
                        _ => {
                            for (turn, target) in
                                targets.diagonal[kind - DIAGONALS].iter().enumerate()
                            {
                                check(5 + turn, target);
                            }
                        }
                    }
                }
            }
        }
    }
}
