//! A mouse as a static library, for firmware in C (`mouse.h`) or any language that can call C.
//!
//! The library does not use `std`, an allocator or variable static memory; the firmware provides the memory
//! for the mouse. If a dependency used `std` or an allocator, this library would not build.
//!
//! The `no_mangle` attribute keeps the function names visible to C. `no_mangle` is unsafe because
//! two functions with the same name in one program cause undefined behaviour. Other code must
//! therefore not define functions whose names start with `mouse_`. The library contains no other
//! unsafe code: pointers from C arrive as references, and `mouse.h` states the rules that keep the
//! references valid.
#![no_std]
#![allow(unsafe_code)] // for `no_mangle`, see above

mod strategy;

use core::mem::MaybeUninit;

use mmsim_maze::{MazeSize, Step, WallsAround};
use mmsim_protocol::{MapState, Order, state_bytes};
use mmsim_solvers::Move;
use strategy::{Mouse, NEW_MOUSE};

/// The length in bytes of a state for a 16×16 maze.
const STATE_BYTES: usize = state_bytes(MazeSize::CLASSIC);

// The constants in `mouse.h` must match.
const _: () = assert!(STATE_BYTES == 518);
const MOUSE_BYTES: usize = if cfg!(feature = "shortest-path-search") { 1120 } else { 472 };
const _: () = assert!(size_of::<Mouse>() == MOUSE_BYTES && align_of::<Mouse>() <= 4);

/// Initializes a mouse at the start of an unknown 16×16 maze with the goal in the centre.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_new(place: &mut MaybeUninit<Mouse>) {
    place.write(NEW_MOUSE);
}

/// Records a reading of the wall sensors. Returns `false` if the reading contradicts earlier
/// readings.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_see(mouse: &mut Mouse, left: bool, front: bool, right: bool) -> bool {
    mouse.see(WallsAround { left, front, right }).is_ok()
}

/// Returns the next step as `F`, `L`, `R` or `B`. Returns `G` if the mouse is in the goal, and 0 if
/// the goal is unreachable.
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

/// Records that the mouse has taken a step. Returns `false` if this step is impossible.
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

/// Encodes the state of the mouse as a request to a simulator.
#[unsafe(no_mangle)]
pub extern "C" fn mouse_encode_state(mouse: &Mouse, message: &mut [u8; STATE_BYTES]) {
    let weight = |cell| mouse.weight(cell).unwrap_or(u16::MAX);
    // Encoding cannot fail, because the buffer has the length of the message.
    let _ = MapState::new(mouse.pose(), mouse.map(), weight, Order::F).encode(message);
}

/// Halts after a panic. On a real mouse, stop the motors before halting.
#[panic_handler]
fn halt(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
