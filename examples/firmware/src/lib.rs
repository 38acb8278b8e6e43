//! The brain of a flood-fill mouse as a static library, for firmware in C (`mouse.h`) or any
//! language that can call C.
//!
//! There is no `std`, no allocator and no static memory: the firmware gives the place where the
//! mouse lives. If one of the crates below came to need more, this library would not build.
//!
//! `no_mangle` keeps the names of the functions for C to find. It counts as unsafe, since two
//! functions of one name in a program are undefined behaviour; `mouse_` is for this library's
//! alone. There is no other unsafe code: the places that C hands over are plain references, and
//! what C must keep to so that they are valid is in `mouse.h`.
#![no_std]
#![allow(unsafe_code)] // for `no_mangle`, see above

use core::mem::MaybeUninit;

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Pose, Step, WallsAround};
use mmsim_protocol::{Order, encode_state, state_bytes};
use mmsim_solvers::{FloodFill, Move};

/// A mouse of yours has its own strategy here.
type Mouse = mmsim_solvers::Mouse<FloodFill>;

/// Length of a state of the 16×16 maze in bytes.
const STATE_BYTES: usize = state_bytes(MazeSize::CLASSIC);

// The numbers in `mouse.h`.
const _: () = assert!(STATE_BYTES == 518);
const _: () = assert!(size_of::<Mouse>() <= 4096 && align_of::<Mouse>() <= 8);

/// Puts a mouse that knows nothing yet at the start of a 16×16 maze, with the goal in the centre.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_new(place: &mut MaybeUninit<Mouse>) {
    let start = Pose::new(Cell::new(0, 0), Heading::North);
    let map = KnownMaze::new(MazeSize::CLASSIC, start.cell, MazeSize::CLASSIC.central_cells());
    place.write(Mouse::new(FloodFill::new(), map, start));
}

/// Notes what the wall sensors say; `false` if that contradicts what they said before.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_see(mouse: &mut Mouse, left: bool, front: bool, right: bool) -> bool {
    mouse.see(WallsAround { left, front, right }).is_ok()
}

/// The next step as its letter `F`, `L`, `R` or `B`; `G` in the goal, 0 if there is no way to it.
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

/// Tells the mouse that its motors have taken a step; `false` if it cannot have been that one.
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

/// Writes the message that reports the mouse's state to a simulator, for a viewer.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_encode_state(mouse: &Mouse, message: &mut [u8; STATE_BYTES]) {
    let weight = |cell| mouse.weight(cell).unwrap_or(u16::MAX);
    // The buffer has the length of the message, so there is no error.
    let _ = encode_state(message, mouse.pose(), mouse.map(), weight, Order::F);
}

/// What the mouse does when the program is wrong. A real one stops its motors first.
#[panic_handler]
fn halt(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
