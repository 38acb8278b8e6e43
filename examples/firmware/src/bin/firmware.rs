//! Firmware that searches the maze of a simulator. It runs in QEMU, whose serial port is a TCP
//! connection to the simulator:
//!
//! ```text
//! qemu-system-arm -M mps2-an385 -icount shift=5 -semihosting -nographic -monitor none \
//!     -serial tcp:127.0.0.1:6574,nodelay=on -kernel target/thumbv7m-none-eabi/release/firmware
//! ```
//!
//! On a real mouse, `read_walls` reads the sensors instead, and `drive` drives the motors.
#![no_std]
#![no_main]

#[path = "../strategy.rs"]
mod strategy;
#[path = "../uart.rs"]
mod uart;
#[path = "../zmtp.rs"]
mod zmtp;

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use mmsim_maze::{MazeSize, Pose, Step, WallsAround};
use mmsim_protocol::{MapState, Order, Reply, Request, state_bytes};
use mmsim_solvers::Move;
use semihosting::println;
use strategy::{Mouse, NEW_MOUSE};
use uart::Uart;
use zmtp::Client;

/// The simulator, in place of the sensors and motors.
struct Simulator<'a> {
    client: Client<Uart>,
    message: &'a mut [u8; state_bytes(MazeSize::CLASSIC)],
}

impl Simulator<'_> {
    fn ask(&mut self, request: Request) -> Reply<'_> {
        let length = request.encode(self.message).expect("the buffer holds any request");
        let reply = self.client.ask(&mut *self.message, length);
        Reply::decode(reply).expect("a reply of the protocol")
    }

    fn read_walls(&mut self, pose: Pose) -> WallsAround {
        match self.ask(Request::Walls(pose)) {
            Reply::Walls(walls) => walls,
            reply => panic!("expected walls, found {reply:?}"),
        }
    }

    /// Shows the mouse in the simulator.
    fn show(&mut self, mouse: &Mouse) {
        let weight = |cell| mouse.weight(cell).unwrap_or(u16::MAX);
        let state = MapState::new(mouse.pose(), mouse.map(), weight, Order::F);
        let length = state.encode(&mut *self.message).expect("the buffer holds a state");
        match Reply::decode(self.client.ask(&mut *self.message, length)) {
            Ok(Reply::Ok) => {}
            reply => panic!("expected ok, found {reply:?}"),
        }
    }
}

#[entry]
fn main() -> ! {
    // Ready before the firmware starts. The attribute `entry` makes references of these variables.
    static mut MOUSE: Mouse = NEW_MOUSE;
    static mut MESSAGE: [u8; state_bytes(MazeSize::CLASSIC)] = [0; 518];
    let mut timer = Peripherals::take().expect("first use").SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(0x00ff_ffff);
    timer.clear_current();
    timer.enable_counter();

    let mut simulator = Simulator { client: Client::new(Uart::new()), message: MESSAGE };
    simulator.ask(Request::Reset);
    let (steps, ticks) = search(MOUSE, &mut simulator);
    println!("{steps} steps, the slowest in {ticks} ticks, {} bytes of stack", stack_bytes());
    semihosting::process::exit(0)
}

/// Searches the maze. Returns the number of steps, and the most ticks of the timer for a step.
fn search(mouse: &mut Mouse, simulator: &mut Simulator) -> (u32, u32) {
    let (mut steps, mut most_ticks) = (0, 0);
    let behind = mouse.turned_round();
    mouse.see_behind(simulator.read_walls(behind)).expect("the first reading");
    loop {
        let walls = simulator.read_walls(mouse.pose());
        // The timer counts down, in 24 bits.
        let before = SYST::get_current();
        let next = plan(mouse, walls);
        most_ticks = most_ticks.max(before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff);
        simulator.show(mouse);
        let Some(step) = next else { return (steps, most_ticks) };
        drive(mouse, step);
        steps += 1;
    }
}

/// Adds the walls around the mouse to its map, and returns the next step, or `None` at the end of
/// the search. An error of the sensors or an unreachable goal ends the search too.
#[inline(never)]
fn plan(mouse: &mut Mouse, walls: WallsAround) -> Option<Step> {
    mouse.see(walls).ok()?;
    match mouse.decide() {
        Ok(Move::Step(step)) => Some(step),
        _ => None,
    }
}

fn drive(mouse: &mut Mouse, step: Step) {
    mouse.go(step).expect("the strategy only chooses open sides");
}

/// Returns the number of bytes of the stack that have been used. `cortex-m-rt` paints the memory
/// before the program begins.
#[allow(unsafe_code)]
fn stack_bytes() -> usize {
    const PAINT: u32 = 0xcccc_cccc;
    unsafe extern "C" {
        static _stack_start: u32;
    }
    let (bottom, top) = (cortex_m_rt::heap_start(), &raw const _stack_start);
    // SAFETY: all words between the static variables and the top of the stack are memory.
    let unused = (0..).take_while(|&i| unsafe { bottom.add(i).read_volatile() } == PAINT).count();
    top as usize - bottom as usize - size_of::<u32>() * unused
}
