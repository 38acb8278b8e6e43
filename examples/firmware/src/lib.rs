//! A flood-fill mouse as a static library, for firmware in C (`mouse.h`) or any language that can
//! call C.
//!
//! The library uses no `std`, no allocator and no static memory: the firmware provides the memory
//! for the mouse. If one of the crates below needed more, this library would not build.
//!
//! `no_mangle` keeps the function names visible to C. It is unsafe because two functions with the
//! same name in a program are undefined behaviour; only this library may use the prefix `mouse_`.
//! There is no other unsafe code: pointers from C arrive as references, and `mouse.h` states the
//! rules that keep them valid.
#![no_std]
#![allow(unsafe_code)] // for `no_mangle`, see above

use core::mem::MaybeUninit;

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Pose, Step, WallsAround};
use mmsim_protocol::{MapState, Order, state_bytes};
use mmsim_solvers::{FloodFill, Move};

/// Put your own strategy here.
type Mouse = mmsim_solvers::Mouse<FloodFill>;

/// Length of a state of a 16×16 maze, in bytes.
const STATE_BYTES: usize = state_bytes(MazeSize::CLASSIC);

// The constants in `mouse.h` must match.
const _: () = assert!(STATE_BYTES == 518);
const _: () = assert!(size_of::<Mouse>() <= 4096 && align_of::<Mouse>() <= 8);

/// Initializes a mouse at the start of an unknown 16×16 maze with the goal in the centre.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_new(place: &mut MaybeUninit<Mouse>) {
    let start = Pose::new(Cell::new(0, 0), Heading::North);
    let map = KnownMaze::new(MazeSize::CLASSIC, start.cell, MazeSize::CLASSIC.central_cells());
    place.write(Mouse::new(FloodFill::new(), map, start));
}

/// Records a reading of the wall sensors. Returns `false` if it contradicts earlier readings.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_see(mouse: &mut Mouse, left: bool, front: bool, right: bool) -> bool {
    mouse.see(WallsAround { left, front, right }).is_ok()
}

/// Returns the next step as `F`, `L`, `R` or `B`, `G` in the goal, or 0 if it is unreachable.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_next_step(mouse: &mut Mouse) -> u8 {
    match mouse.decide() {
        Ok(Move::Step(Step::Front)) => b'F',
        Ok(Move::Step(Step::Left)) => b'L',
        Ok(Move::Step(Step::Right)) => b'R',
        Ok(Move::Step(Step::Back)) => b'B',
        Ok(Move::Stop) => b'G',
        _ => 0,
    }
}

/// Records that the motors have taken a step. Returns `false` if the mouse cannot have taken it.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_stepped(mouse: &mut Mouse, step: u8) -> bool {
    let step = match step {
        b'F' => Step::Front,
        b'L' => Step::Left,
        b'R' => Step::Right,
        b'B' => Step::Back,
        _ => return false,
    };
    mouse.go(step).is_ok()
}

/// Writes the message that reports the mouse's state to a simulator, for its viewer.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_encode_state(mouse: &Mouse, message: &mut [u8; STATE_BYTES]) {
    let weight = |cell| mouse.weight(cell).unwrap_or(u16::MAX);
    // Cannot fail: the buffer has the length of the message.
    let _ = MapState::new(mouse.pose(), mouse.map(), weight, Order::F).encode(message);
}

/// Halts after a panic. A real mouse stops its motors first.
#[panic_handler]
fn halt(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
