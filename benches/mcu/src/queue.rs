//! The flood of a textbook, in Rust and in C: a queue of cells, with the walls of each cell in one
//! byte.

use mmsim_maze::Maze;

/// The cells of a maze, in rows of 16 cells.
type Cells = [u8; 256];

/// Returns the walls of each cell: 1 for north, 2 for east, 4 for south, 8 for west.
pub fn walls(maze: &Maze) -> Cells {
    let mut walls = [0; 256];
    for (byte, cell) in walls.iter_mut().zip(maze.size().cells()) {
        *byte = maze.walls().sides(cell).bits();
    }
    walls
}

/// Returns the indices of the goal cells, and their number.
pub fn targets(maze: &Maze) -> ([u8; 16], usize) {
    let mut targets = [0; 16];
    for (target, cell) in targets.iter_mut().zip(maze.goals()) {
        *target = 16 * cell.y + cell.x;
    }
    (targets, maze.goals().len())
}

pub fn flood(walls: &Cells, (targets, count): &([u8; 16], usize), distances: &mut Cells) {
    let (mut queue, mut head, mut tail) = ([0; 256], 0, 0);
    distances.fill(255);
    for &target in &targets[..*count] {
        distances[usize::from(target)] = 0;
        queue[tail] = target;
        tail += 1;
    }
    while head < tail {
        let cell = queue[head];
        head += 1;
        for (side, offset) in [16_u8, 1, 240, 255].into_iter().enumerate() {
            let next = cell.wrapping_add(offset);
            let is_open = walls[usize::from(cell)] >> side & 1 == 0;
            if is_open && distances[usize::from(next)] == 255 {
                distances[usize::from(next)] = distances[usize::from(cell)] + 1;
                queue[tail] = next;
                tail += 1;
            }
        }
    }
}

#[allow(unsafe_code)] // calls C
pub fn flood_in_c(walls: &Cells, (targets, count): &([u8; 16], usize), distances: &mut Cells) {
    unsafe extern "C" {
        fn queue_flood(walls: &Cells, targets: *const u8, count: u32, distances: &mut Cells) -> u8;
    }
    // SAFETY: `queue.c` reads `count` targets, of which there are at most 16, and puts each cell
    // into its queue at most once.
    unsafe { queue_flood(walls, targets.as_ptr(), *count as u32, distances) };
}
